"""The commands on results with units: as a person would write them, and in SI for programs."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from roughbench.cli import main

SPEC = """\
name: plate
surface: {H: 0.8, longest: 10 um, shortest: 625 nm, rms_height: 12 nm}
modulus: {E: 2.5 GPa, nu: 0.5}
pressures: {min: 1 kPa, max: 100 MPa, points: 6}
realizations: 3
models:
  - {kind: bem, grid: 64}
  - {kind: foundation, springs: 64}
  - kind: persson
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("units")
    (folder / "plate.yaml").write_text(SPEC)
    path = folder / "plate.h5"
    told("run", folder / "plate.yaml", "-o", path, "-q")
    return path


def told(*arguments: object) -> str:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.output


def test_tables_have_prefixes_one_for_each_column(results: Path) -> None:
    text = told("show", results)
    assert "length 10 µm, hurst 0.8, q_min 628.319 / mm" in text
    assert "h_rms = 12 nm (of the spectrum, continuum)\nE* = 3.33333 GPa\n" in text
    headings = re.findall(r"^ *p \[.*$", text, re.MULTILINE)
    assert len(headings) == 3
    assert len(set(headings)) == 1
    assert re.split(r"\s{2,}", headings[0].strip())[:3] == ["p [kPa]", "A/A0", "ū [nm]"]
    assert re.search(r"K \[[kM]?Pa/[nµ]m\]", headings[0])
    rows = [line.split() for line in text.split("persson: ")[1].splitlines()[3:9]]
    assert [row[0] for row in rows] == ["1", "10", "100", "1000", "10000", "100000"]
    assert 1.0 < float(rows[0][2]) < 100.0  # nm
    assert "inf" in text.split("foundation: ")[1].split("persson: ")[0]


def test_json_is_in_si_with_units(results: Path) -> None:
    bem = json.loads(told("show", results, "--json"))["experiments"]["main"]["bem"]
    assert bem["variables"]["pressure"] == pytest.approx([1e3, 1e4, 1e5, 1e6, 1e7, 1e8])
    assert bem["units"]["pressure"] == "Pa"
    assert bem["units"]["stiffness_mean"] == "Pa/m"
    assert bem["attributes"]["contact_modulus"] == pytest.approx(2.5e9 / 0.75)


def test_csv_is_in_si_with_units_in_its_header(results: Path, tmp_path: Path) -> None:
    told("export", results, "--csv", tmp_path / "csv", "--states")
    with (tmp_path / "csv" / "main-bem.csv").open() as file:
        rows = [*csv.reader(file)]
    assert rows[0][0] == "pressure [Pa]"
    assert {"separation_mean [m]", "stiffness_sem [Pa/m]", "energy_q16 [J/m^2]"} <= {*rows[0]}
    assert [float(row[0]) for row in rows[1:]] == pytest.approx([1e3, 1e4, 1e5, 1e6, 1e7, 1e8])
    told("export", results, "--csv", tmp_path / "csv", "--states")  # over its own files


def test_fits_are_told_at_pressures_with_units(results: Path) -> None:
    text = told("fit", results, "--resamples", 20)
    assert re.search(r"κ +from p \[[kM]Pa\] +to p \[[kM]Pa\]", text)
    assert re.search(r"^p \[[kM]Pa\] between which a model agrees", text, re.MULTILINE)
    table = text.split("K ~ p")[0]
    assert re.search(r"persson +1\.\d+ +≤ 1 +", table)  # kPa, the lowest
    found = json.loads(told("fit", results, "--resamples", 20, "--json"))
    assert found["contact_modulus"] == {"main": pytest.approx(2.5e9 / 0.75)}
    kappa_from = found["experiments"]["main"]["persson"]["kappa_from"]["value"]
    assert kappa_from == pytest.approx(3e-7)


def test_validate_says_modulus_and_pressures(results: Path) -> None:
    assert told("validate", results.with_suffix(".yaml")).endswith(
        "valid; 1 experiment, bem, foundation, persson, 42 states; E* = 3.33 GPa, "
        "p = 1 kPa … 100 MPa\n"
    )


def test_set_takes_values_with_units(results: Path, tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    spec = results.with_suffix(".yaml")
    told("run", spec, "-o", path, "-q", "--set", "surface.rolloff=5 um")
    assert "q_rolloff 1.25664 / µm" in " ".join(told("show", path).split())
    failed = CliRunner().invoke(
        main, ["run", str(spec), "-o", str(path), "--set", "surface.rolloff=5"]
    )
    assert failed.exit_code == 2
    assert "surface.rolloff: has no unit, but modulus.E has one, got 5" in failed.output


def test_figures_and_report_are_drawn(results: Path, tmp_path: Path) -> None:
    told("plot", results, "-o", tmp_path, "--figure", "separation")
    assert (tmp_path / "separation.png").stat().st_size > 0
    told("report", results, "-o", tmp_path / "page.html", "--resamples", 20)
    assert 'id="claim-' in (tmp_path / "page.html").read_text(encoding="utf-8")
