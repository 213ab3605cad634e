"""Every fault of a spec: its place, its key path, its words; all of them at once."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from roughbench.errors import SpecError
from roughbench.spec import load_spec
from roughbench.spec.pressures import MAX_POINTS
from roughbench.spec.sweep import MAX_EXPERIMENTS
from roughbench.spec.tree import MAX_DEPTH, MAX_NODES

FaultsOf = Callable[..., list[str]]

HERE = Path(__file__).parent
VALID = (HERE / "valid.yaml").read_text(encoding="utf-8")
FILE = """\
surface: {kind: file, path: heights.npy, length: 1.0}
pressures: [0.1]
models:
  - kind: bem
"""
SWEEP = """\
sweep:
  surface.qr: [1, 8]
  models.persson.gamma: [0.33, 0.45]
"""
BASES = {"spec": VALID, "file": FILE, "sweep": VALID + SWEEP}


def cases(heading: str) -> list[tuple[str, str, list[str]]]:
    """Return the blocks of ``faults.txt`` below a heading: out, in, faults."""
    text = (HERE / "faults.txt").read_text(encoding="utf-8")
    [section] = re.findall(rf"^=== {heading}\n(.*?)(?=^===|\Z)", text, re.DOTALL | re.MULTILINE)

    def lines(block: str, sign: str) -> list[str]:
        return [line[2:] for line in block.splitlines() if line.startswith(f"{sign} ")]

    return [
        ("\n".join(lines(block, "-")), "\n".join(lines(block, "+")), lines(block, "!"))
        for block in section.strip().split("\n\n")
    ]


@pytest.mark.parametrize(
    ("base", "taken", "put", "faults"),
    [(base, *case) for heading, base in BASES.items() for case in cases(heading)],
)
def test_faults_are_told_with_their_places(
    tmp_path: Path, faults_of: FaultsOf, base: str, taken: str, put: str, faults: list[str]
) -> None:
    np.save(tmp_path / "heights.npy", np.zeros((4, 4)))
    assert base.count(taken) == 1 or base.count(f"{taken}\n") >= 1
    assert faults_of(base.replace(taken, put, 1)) == [f"bad.yaml:{fault}" for fault in faults]


@pytest.mark.parametrize(("override", "faults"), [case[1:] for case in cases("override")])
def test_faults_of_an_override_name_it(
    valid: str, faults_of: FaultsOf, override: str, faults: list[str]
) -> None:
    assert faults_of(valid, override) == [f"--set {override}: error: {f}" for f in faults]


@pytest.mark.parametrize("base", BASES.values())
def test_the_specs_have_no_faults_before_they_are_spoilt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, base: str
) -> None:
    monkeypatch.chdir(tmp_path)
    np.save(tmp_path / "heights.npy", np.zeros((4, 4)))
    assert load_spec(base).experiments()


def test_lengths_are_capped(valid: str, faults_of: FaultsOf) -> None:
    assert faults_of(valid.replace("rolloff8", "a" * 101)) == [
        "bad.yaml:1:7: error: name: must have at most 100 characters"
    ]
    pressures = "{min: 1.0e-5, max: 0.2, points: 20, spacing: log}"
    many = str([n + 1 for n in range(MAX_POINTS + 1)])
    assert faults_of(valid.replace(pressures, many)) == [
        f"bad.yaml:8:12: error: pressures: must have at most {MAX_POINTS} entries"
    ]
    seeds = list(range(MAX_EXPERIMENTS + 1))
    assert faults_of(f"{valid}sweep: {{seed: {seeds}}}\n") == [
        (
            f"bad.yaml:21:1: error: sweep: makes {MAX_EXPERIMENTS + 1} experiments, at most "
            f"{MAX_EXPERIMENTS} are allowed"
        )
    ]


def test_all_kinds_of_faults_are_told_at_once(valid: str, faults_of: FaultsOf) -> None:
    text = (
        valid.replace("  H: 0.7", "  H: 0.7\n  H: 0.8")  # the text: a duplicate
        .replace("  qr: 8.0", "  qr: 0.5")  # between keys
        .replace("slope: 0.1", "slpoe: 0.1")  # an unknown key, which is not missing then
        .replace("points: 20", "points: *n")  # an alias, and nothing more of it
        .replace("seed: 2013", "seed: x")  # a type
        .replace("kind: foundation", "kind: foundation\n    label: bem")  # between models
        .replace("gamma: 0.45", "gamma: -1")  # a range
    )
    assert faults_of(text) == [
        "bad.yaml:4:3: error: surface.H: duplicate key (first on line 3)",
        "bad.yaml:6:7: error: surface.qr: must be at least q0 = 1.0, got 0.5",
        "bad.yaml:8:3: error: surface.slpoe: unknown key (did you mean 'slope'?)",
        (
            "bad.yaml:9:44: error: pressures.points: aliases are not supported; "
            "write the value of *n again"
        ),
        "bad.yaml:11:7: error: seed: must be an integer, got 'x'",
        (
            "bad.yaml:17:12: error: models[1].label: models[0] is named 'bem' too; "
            "give each its own label"
        ),
        "bad.yaml:21:12: error: models[2].gamma: must be greater than 0, got -1",
    ]


def test_models_are_checked_against_the_surface_while_other_parts_are_faulty(
    valid: str, faults_of: FaultsOf
) -> None:
    text = valid.replace("seed: 2013", "seed: x").replace("springs: 8192", "springs: 100")
    text = text.replace("gamma: 0.45", "gamma: 0")
    seed, springs, gamma = faults_of(text)
    assert seed == "bad.yaml:10:7: error: seed: must be an integer, got 'x'"
    assert springs.startswith(
        "bad.yaml:16:14: error: models[1].springs: 100 points per side are"
    )
    assert gamma == "bad.yaml:19:12: error: models[2].gamma: must be greater than 0, got 0"


def test_a_default_that_does_not_fit_is_told_at_its_model(
    valid: str, faults_of: FaultsOf
) -> None:
    text = valid.replace("    springs: 8192\n", "").replace("q1: 128.0", "q1: 8192")
    text = text.replace("grid: 512", "grid: 16384")
    [fault] = faults_of(text)
    assert fault.startswith(
        "bad.yaml:15:5: error: models[1]: 8192 points per side are too coarse"
    )
    assert "at least 16384 points" in fault
    assert "undersampled: truncate or alias" in fault


def test_too_many_waves_for_any_grid(valid: str, faults_of: FaultsOf) -> None:
    rest = "over 1e+09 waves per side are too many for any grid; lower q1 or length"
    assert faults_of(valid.replace("q1: 128.0", "q1: 1e300")) == [
        f"bad.yaml:12:5: error: models[0]: {rest}",
        f"bad.yaml:15:5: error: models[1]: {rest}",
    ]


def test_undersampled_springs_are_accepted_when_asked_for(valid: str) -> None:
    text = valid.replace("q1: 128.0", "q1: 8192").replace("grid: 512", "grid: 16384")
    for choice in ("truncate", "alias"):
        chosen = text.replace("springs: 8192", f"springs: 8192\n    undersampled: {choice}")
        assert load_spec(chosen).models[1].name == "foundation"


def test_an_empty_spec_and_no_mapping(faults_of: FaultsOf) -> None:
    rest = "a spec has at least surface, pressures and models"
    assert faults_of("") == [f"bad.yaml: error: is empty; {rest}"]
    assert faults_of("# only a comment\n") == [f"bad.yaml: error: is empty; {rest}"]
    assert faults_of("- a\n") == [f"bad.yaml:1:1: error: must be a mapping; {rest}"]
    assert faults_of("{}") == [
        "bad.yaml:1:1: error: surface: is missing (The roughness)",
        "bad.yaml:1:1: error: pressures: is missing (Pressures p/E*: a range, or a list)",
        "bad.yaml:1:1: error: models: is missing (The contenders)",
    ]


def test_a_text_that_breaks_off_tells_only_where(valid: str, faults_of: FaultsOf) -> None:
    [fault] = faults_of(valid.replace("log}", "log"))
    assert fault.startswith("bad.yaml:9:13: error: is no valid YAML: expected ',' or '}'")


def test_values_are_shown_short_and_on_one_line(valid: str, faults_of: FaultsOf) -> None:
    [fault] = faults_of(valid.replace("H: 0.7", f'H: "{"x" * 500}"'))
    assert fault == f"bad.yaml:3:6: error: surface.H: must be a number, got '{'x' * 56}..."
    [fault] = faults_of(valid.replace("H: 0.7", r'H: "a\u200bb"'))
    assert fault == r"bad.yaml:3:6: error: surface.H: must be a number, got 'a\u200bb'"
    [fault] = faults_of(valid.replace("  H: 0.7", '  H: 0.7\n  "a\\u200bb": 1'))
    assert fault.startswith(
        r"bad.yaml:4:3: error: surface.'a\u200bb': unknown key; known here: kind"
    )


@pytest.mark.parametrize("letter", ["\x1b", "\x85", "\u2028", "\u202e", "\u2066"])
def test_not_even_a_comment_rewrites_the_terminal(
    valid: str, faults_of: FaultsOf, letter: str
) -> None:
    """The text of a spec stands in its results, in reports, and in what `show` prints."""
    [fault] = faults_of(valid.replace("seed: 2013", f"seed: 2013  # a{letter}b"))
    assert fault.startswith("bad.yaml:10:16: error: holds the ")
    assert fault.endswith(f"U+{ord(letter):04X}; remove it")
    assert faults_of(valid.replace("seed: 2013", "seed: x  # grüße\u00a0ξ\u200d\t"))[0] == (
        "bad.yaml:10:7: error: seed: must be an integer, got 'x'"
    )


def test_a_sweep_that_is_no_mapping(valid: str, faults_of: FaultsOf) -> None:
    assert faults_of(valid + "sweep: [1]\n") == [
        "bad.yaml:21:8: error: sweep: must map key paths to lists of values, got a list"
    ]


def test_a_fault_of_the_base_is_not_repeated_for_every_experiment(
    valid: str, faults_of: FaultsOf
) -> None:
    assert faults_of(valid.replace("H: 0.7", "H: 2") + SWEEP) == [
        "bad.yaml:3:6: error: surface.H: must be less than 1, got 2"
    ]


def test_an_override_of_what_the_sweep_varies_is_refused(
    valid: str, faults_of: FaultsOf
) -> None:
    assert faults_of(valid + SWEEP, "models[2].gamma=0.4") == [
        (
            "--set models[2].gamma=0.4: error: models[2].gamma: the sweep varies this; "
            "set sweep.models.persson.gamma=[...] or sweep={} instead"
        )
    ]
    assert faults_of(valid + "sweep: 3\n", "sweep.seed=[1]")[-1] == (
        "--set sweep.seed=[1]: error: sweep must map key paths to lists of values"
    )


def test_an_override_and_a_faulty_sweep(valid: str, faults_of: FaultsOf) -> None:
    assert faults_of(valid + "sweep: {zzz.y: [1]}\n", "seed=3") == [
        (
            "bad.yaml:21:9: error: sweep.zzz.y: the spec has no key 'zzz'; known here: name, "
            "surface, pressures, realizations, seed, models, sweep"
        )
    ]


def test_a_file_name_that_no_system_takes(faults_of: FaultsOf) -> None:
    [fault] = faults_of(FILE.replace("heights", "h" * 5000))
    assert fault.startswith("bad.yaml:1:29: error: surface.path: cannot read hhh")
    assert fault.endswith("hhh.npy: File name too long; choose a shorter name")


def test_faults_of_file_and_overrides_come_together(valid: str, faults_of: FaultsOf) -> None:
    assert faults_of(valid.replace("H: 0.7", "H: 2"), "seed=x", "zzz.y=1") == [
        "bad.yaml:3:6: error: surface.H: must be less than 1, got 2",
        "--set seed=x: error: seed: must be an integer, got 'x'",
        (
            "--set zzz.y=1: error: the spec has no key 'zzz'; known here: name, surface, "
            "pressures, realizations, seed, models"
        ),
    ]


class TestFilesThatCannotBeRead:
    def told(self, source: object) -> list[str]:
        with pytest.raises(SpecError) as caught:
            load_spec(source)  # type: ignore[arg-type]
        return [str(fault) for fault in caught.value.faults]

    def test_missing(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "quick.yaml").touch()
        assert self.told("quik.yaml") == [
            "quik.yaml: error: no such file (did you mean 'quick.yaml'?)"
        ]
        (tmp_path / "quick.h5").touch()
        assert "did you mean 'quick.yaml'?" in self.told("quick")[0]
        (tmp_path / "unit1.yaml").touch()  # whose ending alone is that of nofile.yaml
        assert self.told("nofile.yaml") == ["nofile.yaml: error: no such file"]
        assert self.told(Path("else.yaml")) == ["else.yaml: error: no such file"]
        assert self.told("nowhere/x.yaml") == ["nowhere/x.yaml: error: no such file"]

    def test_folder(self, tmp_path: Path) -> None:
        assert self.told(tmp_path) == [f"{tmp_path}: error: cannot be read: Is a directory"]

    def test_no_file_name(self) -> None:
        assert self.told("a\0b") == [r"a\x00b: error: cannot be read: embedded null byte"]
        [fault] = self.told("a" * 5000)
        assert fault.endswith("cannot be read: File name too long; choose a shorter name")

    def test_no_utf8(self, tmp_path: Path) -> None:
        path = tmp_path / "latin1.yaml"
        path.write_bytes("name: a\n# grün\n".encode("latin-1"))
        assert self.told(path) == [f"{path}:2:5: error: is not UTF-8 text; save it as UTF-8"]

    def test_endless(self, tmp_path: Path) -> None:
        path = tmp_path / "long.yaml"
        path.write_text("#" * 2_000_000)
        [fault] = self.told(path)
        assert fault.startswith(f"{path}:1:1: error: is longer than")


class TestFaultsOfMappings:
    def told(self, source: object) -> list[str]:
        with pytest.raises(SpecError) as caught:
            load_spec(source)  # type: ignore[arg-type]
        return [str(fault) for fault in caught.value.faults]

    def test_values_that_yaml_does_not_know(self) -> None:
        assert self.told(
            {
                "surface": {"H": float("nan"), "q0": object()},
                "pressures": [10**30, np.inf],
                "models": {1: "\ud800", "a\nb": "\u202e"},
            }
        ) == [
            "spec: error: surface.H: must be a finite number, got nan",
            "spec: error: surface.q0: a spec cannot hold a Python object",
            "spec: error: pressures[0]: must be an integer below 2**63",
            "spec: error: pressures[1]: must be a finite number, got inf",
            "spec: error: models: keys must be text that prints, got 1",
            "spec: error: models: keys must be text that prints, got 'a\\nb'",
            "spec: error: models.1: holds the half character U+D800; remove it",
            "spec: error: models.'a\\nb': holds the bidirectional mark U+202E; remove it",
        ]

    def test_a_mapping_without_end(self) -> None:
        endless: dict[str, object] = {}
        endless["surface"] = endless
        message = f"spec: error: nested too deep, or over {MAX_NODES} entries"
        assert self.told(endless) == [message]
        doubled: object = 1
        for _ in range(MAX_DEPTH - 1):
            doubled = [doubled, doubled, doubled]
        assert self.told({"surface": doubled}) == [message]

    def test_no_place_is_made_up(self) -> None:
        faults = self.told({"surface": {"H": 0.7}, "pressures": [1], "models": []})
        assert faults[0].startswith("spec: error: surface.q0: is missing (Smallest wavevector")
        assert faults[-1] == "spec: error: models: must not be empty"
