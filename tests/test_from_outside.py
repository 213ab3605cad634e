"""What a package of somebody else declares: from the run to the figure, by its name alone."""

from __future__ import annotations

import csv
import importlib.util
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

import roughbench
from roughbench import registry
from roughbench.cli.results_csv import states_csv, summary_csv
from roughbench.errors import RoughbenchError
from roughbench.observables import clusters
from roughbench.quantities import QUANTITIES
from roughbench.registry import Registry
from roughbench.rundir import identity
from roughbench.store import load, write_results

ROOT = Path(roughbench.__file__).parents[1]
PAGE = (ROOT / "docs" / "adding-an-observable.md").read_text(encoding="utf-8")
MODEL = '''
from dataclasses import replace
from typing import Literal

import numpy as np

from roughbench.models.persson import Persson


class Working(Persson):
    """Persson's theory, with the work of the load beside it."""

    kind: Literal["working"] = "working"

    def curve(self, sample, pressures, **options):
        curve = super().curve(sample, pressures, **options)
        work = 2.0 * curve.pressure * sample.spectrum.rms_height
        return replace(curve, diagnostics={**curve.diagnostics, "work": work})
'''
PROGRAM = """
from roughbench.models import MODELS

if isinstance(MODELS, dict):
    from theory import Working

    MODELS["working"] = Working

from roughbench.cli import main

main()
"""
SPEC = """
name: outside
surface: {H: 0.7, q0: 1.0, q1: 8.0, slope: 0.1}
pressures: [1.0e-4, 1.0e-3, 1.0e-2]
realizations: 2
models:
  - kind: working
  - {kind: working, label: other}
  - kind: winkler
observables: [gap_histogram, clusters]
"""
Command = Callable[..., str]


def blocks(language: str) -> str:
    return "\n".join(re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the package of the page, as installers leave it."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "tour.py").write_text(blocks("python"), encoding="utf-8")
    (folder / "theory.py").write_text(MODEL, encoding="utf-8")
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    groups = tomllib.loads(blocks("toml"))["project"]["entry-points"]
    groups["roughbench.models"] = {"working": "theory:Working"}
    lines = []
    for group, entries in groups.items():
        lines += [f"[{group}]", *(f"{name} = {place}" for name, place in entries.items())]
    info = folder / "tour-1.0.dist-info"
    info.mkdir()
    (info / "entry_points.txt").write_text("\n".join(lines), encoding="utf-8")
    (info / "METADATA").write_text("Name: tour\nVersion: 1.0\n", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def command(folder: Path) -> Command:
    """Return a function that runs a command of roughbench beside that package."""

    def run(*words: str) -> str:
        path = os.pathsep.join([str(folder), str(ROOT), os.environ.get("PYTHONPATH", "")])
        done = subprocess.run(
            [sys.executable, "program.py", *words],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    run("run", "spec.yaml", "-o", "outside.h5", "--quiet")
    return run


def test_a_quantity_goes_all_the_way(folder: Path, command: Command) -> None:
    table = command("show", "outside.h5")
    assert table.count("W/(A0 h_rms E*)") == 2  # of the models that give it
    content = json.loads(command("show", "outside.h5", "--json"))
    model = content["experiments"]["main"]["working"]
    height = model["attributes"]["rms_height"]
    expected = [2.0 * p * height for p in (1e-4, 1e-3, 1e-2)]
    assert model["variables"]["work_mean"] == pytest.approx(expected, rel=1e-12)
    assert model["units"]["work_q84"] == "length"
    assert "work" not in content["experiments"]["main"]["winkler"]["variables"]
    command("export", "outside.h5", "--csv", "tables")
    with (folder / "tables" / "main-working.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["work_mean [length]"]) for row in rows] == pytest.approx(expected)
    fits = command("fit", "outside.h5", "--reference", "other", "--resamples", "2")
    assert "W/A0 within 10 %: from" in fits


def test_an_observable_goes_all_the_way(folder: Path, command: Command) -> None:
    content = json.loads(command("show", "outside.h5", "--json"))
    model = content["experiments"]["main"]["winkler"]
    variables, units = model["variables"], model["units"]
    assert units["gap_histogram_average_sem"] == "length"
    for shares, mean in zip(
        variables["gap_histogram_mean"], variables["gap_histogram_average_mean"], strict=True
    ):
        assert len(shares) == 40
        places = variables["gap_histogram_bin"]
        held = sum(share * place for share, place in zip(shares, places, strict=True))
        height = model["attributes"]["rms_height"]
        # Each gap is off by at most half a bin of 0.2 h_rms.
        assert held / sum(shares) * height == pytest.approx(mean, abs=0.1 * height)
    command("export", "outside.h5", "--csv", "tables")
    assert (folder / "tables" / "main-winkler-gap_histogram.csv").is_file()


def test_each_has_its_figure(folder: Path, command: Command) -> None:
    names = ("work", "gap_histogram", "proportionality", "area")
    asked = [word for name in names for word in ("--figure", name)]
    command("plot", "outside.h5", "-o", "figures", *asked)
    for name in names:
        assert (folder / "figures" / f"{name}.png").stat().st_size > 10_000


def test_a_report_shows_both(folder: Path, command: Command) -> None:
    command("report", "outside.h5", "-o", "report.html", "--resamples", "2")
    page = (folder / "report.html").read_text(encoding="utf-8")
    for title in ("Work of the load", "Histogram of the gap"):
        assert title in page


def test_a_file_needs_no_package(folder: Path, command: Command) -> None:
    """What the package described is read from the file, and written again."""
    command("show", "outside.h5")
    results = load(folder / "outside.h5")
    model, springs = results["main"]["working"], results["main"]["winkler"]
    assert "work" not in QUANTITIES
    assert model.units("work_mean") == "length"
    assert model.long_name("work") == "work of the load W/(A0 E*)"
    assert springs["gap_histogram"].shape == (2, 3, 40)
    assert springs.units("gap_histogram_average") == "length"
    again = load(write_results(results, folder / "again.h5"))["main"]["winkler"]
    assert list(again) == list(springs)
    for name in springs:
        np.testing.assert_array_equal(again[name], springs[name])
        assert again.units(name) == springs.units(name)
    assert "work_mean [length]" in summary_csv(model)
    assert "gap_histogram" not in states_csv(springs).partition("\n")[0].split(",")


# -- what is refused -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (("area", "tour:work"), "both declare 'area'"),
        (("new", "no_such_module:x"), "cannot be loaded"),
        (
            ("new", "roughbench.observables:clusters"),
            "has the name 'clusters'; give both one name",
        ),
    ],
)
def test_a_bad_declaration_is_named(
    entry: tuple[str, str], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    declared = EntryPoint(*entry, "roughbench.test")
    monkeypatch.setattr(registry, "entry_points", lambda **_: [declared, declared])
    with pytest.raises(RoughbenchError, match=re.escape(words)):
        dict(Registry("roughbench.test", {"area": object()}))


def test_the_source_of_an_observable_is_part_of_the_identity(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "tour_of_test.py"
    text = blocks("python")

    def digest(source: str) -> str:
        file.write_text(source, encoding="utf-8")
        spec = importlib.util.spec_from_file_location("tour_of_test", file)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "tour_of_test", module)
        spec.loader.exec_module(module)
        return identity.observing_digest((module.gap_histogram, clusters))

    first = digest(text)
    assert digest(f"{text}\n# a word\n") == first
    assert digest(text.replace("8.0, 41", "9.0, 41")) != first
    assert identity.observing_digest((clusters,)) == identity.observing_digest()
