"""Hints: commands that can be typed as they stand, and what was probably meant."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

import roughbench as rb
from roughbench import figures, program

Invoke = Callable[..., Result]
ROOT = str(Path(rb.__file__).parents[1])
SCRIPT = f"#!{sys.executable}\nfrom roughbench.cli import main\nmain()\n"
"""What an installer makes of the entry point."""


def shell(line: str, folder: Path, path: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PATH": path, "PYTHONPATH": ROOT}
    return subprocess.run(
        ["/bin/sh", "-c", line],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("call", ["venv/bin/roughbench", "roughbench", "module"])
def test_the_last_lines_of_a_run_can_be_typed(folder: Path, call: str) -> None:
    """As ``make demo`` calls it: from a folder that is not on the PATH."""
    script = folder / "venv" / "bin" / "roughbench"
    script.parent.mkdir(parents=True)
    script.write_text(SCRIPT)
    script.chmod(0o755)
    path = f"{script.parent}:/usr/bin:/bin" if call == "roughbench" else "/usr/bin:/bin"
    if call == "module":
        call = f"{shlex.quote(sys.executable)} -m roughbench"
    done = shell(f"{call} run small.yaml -o 'a b.h5' --only main/persson", folder, path)
    assert done.returncode == 3
    resume = done.stderr.partition("resume: ")[2].strip()
    assert resume.startswith(f"{call} run small.yaml")
    done = shell(resume.removesuffix(" --only main/persson"), folder, path)
    assert done.returncode == 0
    [show] = [line for line in done.stderr.splitlines() if line.startswith("show it: ")]
    line = show.removeprefix("show it: ")
    assert line == f"{call} show 'a b.h5'"
    assert "foundation" in shell(line, folder, path).stdout
    usage = shell(f"{call} run --nonsense", folder, path).stderr
    assert re.search(rf"Try '{re.escape(call)} run (-h|--help)'", " ".join(usage.split()))


def test_another_program_of_that_name_is_not_meant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "roughbench").write_text("#!/bin/sh\n")
    (tmp_path / "roughbench").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "argv", ["py env/bin/roughbench", "run"])
    assert program.command("show", "r.h5") == "'py env/bin/roughbench' show r.h5"
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "roughbench")])
    assert program.program() == "roughbench"
    monkeypatch.setattr(sys, "argv", ["script.py"])
    assert program.program() == "roughbench"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["rnu", "small.yaml"], "Did you mean 'run'?"),
        (["Show", "x.h5"], "Did you mean 'show'?"),
        (["small.yaml", "-j", "2"], "To compute a spec: roughbench run small.yaml -j 2"),
        (["walk"], "There are init, characterize, run,"),
    ],
)
def test_what_is_no_command(invoke: Invoke, words: list[str], hint: str) -> None:
    done = invoke(*words)
    assert done.exit_code == 2
    message = " ".join(done.stderr.replace("│", " ").split())
    assert f"No such command '{words[0]}'. {hint}" in message


def test_run_of_results_and_show_of_a_spec(results: Path, invoke: Invoke) -> None:
    assert results.exists()
    done = invoke("run", "small.h5")
    assert (done.exit_code, done.stderr) == (
        2,
        (
            "small.h5: error: is an HDF5 file, not a spec; if it has results, see them with: "
            "roughbench show small.h5\n"
        ),
    )
    done = invoke("show", "small.yaml")
    assert done.exit_code == 1
    assert "if it is a spec, compute it with: roughbench run small.yaml" in done.stderr


def test_status_of_results_without_a_run_directory(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    assert invoke("clean", results).exit_code == 0
    (folder / "notes.txt").write_text("mine")
    for word in ("status", "verify", "clean"):
        done = invoke(word, "small.h5")
        assert done.exit_code == 1
        assert done.stderr == (
            "error: small.h5 has results, but the run directory that they came from, "
            "small.h5.rbrun, is not there; see them with: roughbench show small.h5\n"
        )
        done = invoke(word, "notes.txt")
        assert "notes.txt is no results file, run directory or spec; give" in done.stderr


def test_a_label_alone_means_every_experiments(folder: Path, invoke: Invoke) -> None:
    with (folder / "small.yaml").open("a") as file:
        file.write("sweep: {surface.H: [0.6, 0.8]}\n")
    done = invoke("run", "small.yaml", "--only", "persson")
    assert done.exit_code == 3
    assert "6 of 126 states are kept" in done.stderr
    done = invoke("run", "small.yaml", "--only", "foundation:2-3", "-n")
    assert done.stdout.splitlines()[-1].startswith("2 tasks to compute")
    done = invoke("run", "small.yaml", "--only", "person")
    assert done.exit_code == 1
    assert "no such model here; did you mean persson? There are surface.H=0.6/" in done.stderr


@pytest.mark.parametrize(
    ("stem", "name"),
    [("my spec ξ", "my_spec_xi"), ("größe", "grosse"), ("Ωσς", "omegasigmasigma")],
)
def test_the_results_keep_a_recognizable_name(
    folder: Path, invoke: Invoke, stem: str, name: str
) -> None:
    text = (folder / "small.yaml").read_text().replace("name: small\n", "")
    (folder / f"{stem}.yaml").write_text(text)
    done = invoke("run", f"{stem}.yaml", "-q")
    assert (done.exit_code, done.stdout) == (0, f"{name}.h5\n")


@pytest.mark.usefixtures("blank_figures")
def test_figures_of_two_results_do_not_mix_unasked(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    other = folder / "a (1) ξ.h5"
    other.write_bytes(results.read_bytes())
    one = ("--figure", "area")
    for _ in range(2):
        assert invoke("plot", "small.h5", *one).exit_code == 0
    assert figures.drawn_of("figures") == {"small.h5"}
    before = {path: path.read_bytes() for path in (folder / "figures").iterdir()}
    refused = invoke("plot", other.name, "--figure", "stiffness")
    assert refused.exit_code == 1
    assert refused.stderr == (
        "error: figures has the figures of small.h5; draw these elsewhere: roughbench plot "
        "'a (1) ξ.h5' -o 'figures/a (1) ξ', or over those: -o figures\n"
    )
    assert before == {path: path.read_bytes() for path in (folder / "figures").iterdir()}
    assert invoke("plot", other.name, *one, "-o", "figures").exit_code == 0
    assert figures.drawn_of("figures") == {other.name}


@pytest.mark.usefixtures("blank_figures")
def test_several_results_have_a_folder_each(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    (folder / "sub").mkdir()
    for name in ("sub/small.h5", "h0.8.h5"):
        (folder / name).write_bytes(results.read_bytes())
    done = invoke("plot", "small.h5", "sub/small.h5", "h0.8.h5", "--figure", "area", "-o", "f")
    assert done.exit_code == 0, done.stderr
    drawn = [str(path.relative_to(folder)) for path in sorted((folder / "f").rglob("*.png"))]
    top = folder.name
    assert drawn == sorted(
        [f"f/{top}/small/area.png", "f/sub/small/area.png", "f/h0.8/area.png"]
    )
