"""What programs read and write: specs on standard input, JSON on standard output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from roughbench.cli import main
from tests.cli.conftest import SPEC, Invoke


def piped(text: str | bytes, *arguments: str) -> tuple[int, str, str]:
    found = CliRunner().invoke(main, arguments, input=text)
    return found.exit_code, found.stdout, found.stderr


def test_a_spec_comes_on_standard_input(folder: Path, invoke: Invoke) -> None:
    code, out, err = piped(SPEC, "run", "-", "-o", "x.h5", "-q", "--json", "-j", "1")
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["results"] == "x.h5"
    assert [model["name"] for model in found["models"]] == ["main/foundation", "main/persson"]
    invoke("run", "small.yaml", "-o", "y.h5", "-q", "-j", 1)
    assert (folder / "x.h5").read_bytes() == (folder / "y.h5").read_bytes()
    code, out, _ = piped(SPEC, "run", "-", "-o", "x.h5", "-n", "--json", "-q")
    assert [part["reason"] for part in json.loads(out)] == ["done", "done"]
    one_line = "{surface: {H: 0.7, q0: 1, q1: 8, slope: 0.1}, pressures: [1e-3], models: []}"
    code, _, err = piped(one_line, "run", "-")
    assert (code, "models: " in err) == (2, True)
    code, _, err = piped(b"\xff\xfe", "run", "-")
    assert (code, "standard input: error: is not UTF-8 text" in err) == (2, True)
    assert piped("", "validate", "-")[0] == 2


def test_what_is_wrong_with_specs_is_data(folder: Path, invoke: Invoke) -> None:
    (folder / "bad.yaml").write_text(SPEC.replace("slope", "slpoe"))
    done = invoke("validate", "small.yaml", "bad.yaml", "--json")
    assert (done.exit_code, done.stderr) == (2, "")
    good, bad = json.loads(done.stdout)
    assert (good["valid"], good["faults"]) == (True, [])
    assert [model["states"] for model in good["models"]] == [60, 3]
    assert (bad["valid"], bad["models"]) == (False, [])
    places = [(fault["path"], fault["line"], fault["source"]) for fault in bad["faults"]]
    assert ("surface.slpoe", 2, "bad.yaml") in places


def test_files_that_were_checked_and_removed_are_data(results: Path, invoke: Invoke) -> None:
    found = json.loads(invoke("verify", results, "--json").stdout)
    assert (found["sound"] > 1, found["damaged"]) == (True, [])
    shard = next(results.with_name("small.h5.rbrun").glob("shards/*/*.npz"))
    shard.write_bytes(b"damaged")
    done = invoke("verify", results, "--json")
    assert done.exit_code == 1
    assert [shard.name in text for text in json.loads(done.stdout)["damaged"]] == [True]
    assert json.loads(invoke("clean", results, "--json").stdout)["freed"] > 1000


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["show", "small.h5"]])
def test_nothing_is_coloured(results: Path, words: list[str]) -> None:
    assert results.is_file()
    found = CliRunner().invoke(main, words, color=True)
    assert found.exit_code == 0
    assert "\x1b" not in found.output


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_words_are_completed(shell: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_ROUGHBENCH_COMPLETE", f"{shell}_source")
    found = CliRunner().invoke(main, [], prog_name="roughbench")
    assert "_ROUGHBENCH_COMPLETE" in found.output
    monkeypatch.setenv("_ROUGHBENCH_COMPLETE", f"{shell}_complete")
    monkeypatch.setenv("COMP_WORDS", "roughbench repr")
    monkeypatch.setenv("COMP_CWORD", "repr" if shell == "fish" else "1")
    found = CliRunner().invoke(main, [], prog_name="roughbench")
    assert "reproduce" in found.output
