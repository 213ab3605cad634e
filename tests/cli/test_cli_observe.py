"""``roughbench observe``: files, figures, warnings, refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Invoke = Callable[..., Result]

SPEC = """\
name: seen
surface: {H: 0.7, q0: 1.0, qr: 2.0, q1: 16.0, slope: 0.1}
pressures: [1.0e-3, 1.0e-2]
realizations: 2
models:
  - kind: foundation
    springs: 128
  - kind: winkler
  - kind: persson
observables: [pressure_pdf, stress_spectrum, clusters]
save_fields: {pressures: [1.0e-2]}
"""


@pytest.fixture
def spec(folder: Path) -> Path:
    """Return the spec above, on disk in the current folder."""
    (folder / "seen.yaml").write_text(SPEC)
    return folder / "seen.yaml"


def test_writes_numbers_fields_and_figures(spec: Path, folder: Path, invoke: Invoke) -> None:
    done = invoke("observe", spec)
    assert done.exit_code == 0
    assert done.stderr == "note: without fields: main/persson\n"
    paths = [Path(line) for line in done.stdout.splitlines()]
    assert {path.name for path in paths} == {
        "observables.json",
        "main-foundation-realization0-p0.01.npz",
        "main-winkler-realization0-p0.01.npz",
        *(
            f"main-{name}.{suffix}"
            for name in ("pressure_pdf", "stress_spectrum", "clusters")
            for suffix in ("pdf", "png")
        ),
        "main-contact-realization0-p0.01.pdf",
        "main-contact-realization0-p0.01.png",
    }
    assert all((folder / path).stat().st_size > 0 for path in paths)
    assert {path.parent for path in paths} == {Path("seen-fields")}
    content = json.loads((folder / "seen-fields/observables.json").read_text())
    assert set(content["experiments"]["main"]) == {"foundation", "winkler"}


def test_options_choose_folder_and_content(spec: Path, folder: Path, invoke: Invoke) -> None:
    choice = ("--set", "observables=[clusters]")
    done = invoke("observe", spec, "-o", "here", "--no-figures", "--quiet", *choice)
    assert done.exit_code == 0
    names = sorted(path.name for path in (folder / "here").iterdir())
    assert names == [
        "main-foundation-realization0-p0.01.npz",
        "main-winkler-realization0-p0.01.npz",
        "observables.json",
    ]
    content = json.loads((folder / "here/observables.json").read_text())
    assert list(content["experiments"]["main"]["winkler"]["observables"]) == ["clusters"]


def test_the_same_spec_gives_the_same_bytes(spec: Path, folder: Path, invoke: Invoke) -> None:
    for name in ("one", "other"):
        assert invoke("observe", spec, "-o", name, "-q").exit_code == 0
    for path in (folder / "one").iterdir():
        if path.suffix != ".npz":  # a zip archive holds the time
            assert path.read_bytes() == (folder / "other" / path.name).read_bytes(), path.name


def test_a_spec_that_asks_for_nothing_is_refused(folder: Path, invoke: Invoke) -> None:
    done = invoke("observe", folder / "small.yaml")
    assert done.exit_code == 2
    assert "asks for nothing of the fields" in done.stderr
