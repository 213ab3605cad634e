"""The commands that read: show, export, validate, schema, plot; help and start-up."""

from __future__ import annotations

import csv
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import Result

import roughbench as rb
from roughbench.cli import COMMANDS
from roughbench.cli.results_json import to_json
from roughbench.cli.tables import as_text
from roughbench.figures import available
from roughbench.results import ModelResult, Results
from roughbench.store import write_results

Invoke = Callable[..., Result]
Popen = subprocess.Popen[str]


def refuse_constant(name: str) -> float:
    raise AssertionError(f"{name} is no JSON")


def with_gaps() -> Results:
    """Return results with an infinite stiffness and a pressure where nothing converged."""
    nan, inf = math.nan, math.inf
    variables: dict[str, Any] = {
        "pressure": np.array([0.1, 0.2, 0.3]),
        "area": np.array([[0.5, 1.0, nan], [0.7, 1.0, nan]]),
        "status": np.array([[0, 0, 2], [0, 0, 1]], np.int32),
        "n_converged": np.array([2, 2, 0]),
        "area_mean": np.array([0.6, 1.0, nan]),
        "area_sem": np.array([0.1, 0.0, nan]),
        "separation_mean": np.array([3.0, 0.0, nan]),
        "separation_sem": np.array([0.25, nan, nan]),
        "stiffness_mean": np.array([1.0 / 3.0, inf, nan]),
        "stiffness_sem": np.array([0.01, nan, nan]),
    }
    attributes: dict[str, Any] = {"rms_height": 0.5, "surface": "file", "grid": 64, "x": -inf}
    model = ModelResult("bem", "bem", "Exact (BEM)", attributes, variables)
    return Results({"main": {"bem": model}}, "text", "abc", "gaps")


# -- show ----------------------------------------------------------------------------------


def test_show_prints_every_curve(results: Path, invoke: Invoke) -> None:
    done = invoke("show", results)
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    loaded = rb.load(results)
    foundation = loaded["main"]["foundation"]
    height = foundation.attributes["rms_height"]
    assert lines[0] == f"{results}: small (spec sha256 {loaded.spec_sha256[:12]})"
    assert f"h_rms = {height:.6g} (of the spectrum, continuum)" in lines
    assert "foundation: Popov (1D foundation), 20 realizations" in lines
    assert "persson: Persson, 1 realization" in lines
    rows = [line.split() for line in lines if line.lstrip().startswith("1.000e-0")]
    assert len(rows) == 6
    assert float(rows[0][1]) == pytest.approx(foundation["area_mean"][0], rel=1e-4)
    assert float(rows[0][4]) == pytest.approx(foundation["separation_mean"][0] / height, 1e-4)
    assert float(rows[0][9]) == pytest.approx(foundation["stiffness_sem"][0] * height, rel=0.05)
    assert rows[0][-1] == "20"
    assert "inf" in rows[2]
    assert max(len(line) for line in lines[1:]) <= 100


def test_show_marks_what_is_infinite_or_unknown() -> None:
    lines = as_text(with_gaps(), "gaps.h5").splitlines()
    assert "h_rms = 0.5 (of the heights)" in lines
    table = [" ".join(line.split()) for line in lines[-4:-1]]
    assert table == [
        "1.000e-01 6.0000e-01 ± 1.0e-01 6.0000e+00 ± 5.0e-01 1.6667e-01 ± 5.0e-03 2",
        "2.000e-01 1.0000e+00 ± 0.0e+00 0.0000e+00 inf 2",
        "3.000e-01 - - - 0",
    ]
    assert lines[-1].startswith("2 of 6 states did not converge; they are left out")


def test_show_json_is_strict_and_complete(results: Path, invoke: Invoke) -> None:
    done = invoke("show", results, "--json")
    content = json.loads(done.stdout, parse_constant=refuse_constant)
    loaded = rb.load(results)
    assert content["spec"] == loaded.spec_text
    for experiment, model in loaded.models():
        found = content["experiments"][experiment][model.label]
        assert found["n_unconverged"] == 0
        assert found["units"]["separation_mean"] == "length"
        assert list(found["variables"]) == list(model)
        for name, values in found["variables"].items():
            numbers = [math.nan if v is None else float(v) for v in np.ravel(values)]
            np.testing.assert_array_equal(numbers, np.ravel(model[name]))


def test_json_of_infinities_and_gaps() -> None:
    content = json.loads("".join(to_json(with_gaps())), parse_constant=refuse_constant)
    found = content["experiments"]["main"]["bem"]
    assert found["variables"]["stiffness_mean"] == [1.0 / 3.0, "inf", None]
    assert found["attributes"]["x"] == "-inf"
    assert found["n_unconverged"] == 2


def test_show_refuses_other_files(folder: Path, invoke: Invoke) -> None:
    for name, message in (("missing.h5", "no such file"), ("small.yaml", "not an HDF5 file")):
        done = invoke("show", name)
        assert done.exit_code == 1
        assert done.stdout == ""
        assert done.stderr.startswith(f"error: {name}: {message}")
    with h5py.File(folder / "other.h5", "w"):
        pass
    assert "not written by roughbench" in invoke("show", "other.h5").stderr


def test_show_into_a_closed_pipe(results: Path, start: Callable[..., Popen]) -> None:
    process = start("show", results, "--json")
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == ""
    assert process.wait(timeout=60) in (0, 1)
    process.stderr.close()


# -- export --------------------------------------------------------------------------------


def test_export_writes_one_file_a_model(results: Path, folder: Path, invoke: Invoke) -> None:
    done = invoke("export", results, "--csv", "a/b", "--states")
    assert done.exit_code == 0
    paths = [folder / line for line in done.stdout.splitlines()]
    assert [path.name for path in paths] == [
        "main-foundation.csv",
        "main-foundation-states.csv",
        "main-persson.csv",
        "main-persson-states.csv",
    ]
    model = rb.load(results)["main"]["foundation"]
    with paths[0].open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3
    for name in ("pressure", "area_mean", "separation_sem", "stiffness_mean"):
        column = [float(row[f"{name} [{model.units(name)}]"]) for row in rows]
        np.testing.assert_array_equal(column, model[name])
    with paths[1].open(newline="") as file:
        states = list(csv.DictReader(file))
    assert len(states) == 60
    assert (states[4]["realization [1]"], states[4]["pressure [1]"]) == ("1", "0.001")
    assert float(states[4]["area [1]"]) == model["area"][1, 1]


def test_every_table_has_its_own_file_in_the_folder(folder: Path, invoke: Invoke) -> None:
    """Whatever the names in a results file are, which may be another one's."""
    model = with_gaps()["main"]["bem"]
    pairs = [
        ("a", "b-c"),
        ("a-b", "c"),  # the same to the eye
        ("A", "B-C"),  # the same to some disks
        ("a", "b-c-states"),
        (".a", "b"),
        ("..", "x"),
        ("größe", "a b%"),
        ("x" * 300, "one"),
        ("x" * 300, "two"),
    ]
    experiments: dict[str, dict[str, ModelResult]] = {}
    for number, (experiment, label) in enumerate(pairs):
        pressure = model["pressure"] + number
        variables = {**model.variables, "pressure": pressure}
        own = ModelResult(label, "bem", "T", model.attributes, variables)
        experiments.setdefault(experiment, {})[label] = own
    write_results(Results(experiments, "", "", "n"), folder / "n.h5")
    inside = {*folder.iterdir()}
    done = invoke("export", "n.h5", "--csv", "tables", "--states")
    assert done.exit_code == 0, done.stderr
    assert {*folder.iterdir()} - inside == {folder / "tables"}
    names = [Path(line).name for line in done.stdout.splitlines()]
    assert len({name.casefold() for name in names}) == 2 * len(pairs)
    assert {*names} == {path.name for path in (folder / "tables").iterdir()}
    assert names[:2] == ["a-b-c.csv", "a-b-c-states.csv"]
    assert "gr%C3%B6%C3%9Fe-a%20b%25.csv" in names
    assert not any(name.startswith(".") or len(name) > 210 for name in names)
    assert len({(folder / "tables" / name).read_text() for name in names}) == len(names)


def test_observables_are_exported_and_drawn(folder: Path, invoke: Invoke) -> None:
    more = "observables: [clusters, pressure_pdf, energy]\nsave_fields: {pressures: [1.0e-3]}\n"
    (folder / "small.yaml").write_text((folder / "small.yaml").read_text() + more)
    rb.run(folder / "small.yaml", output=folder / "seen.h5")
    result = rb.load(folder / "seen.h5")["main"]["foundation"]
    done = invoke("export", "seen.h5", "--csv", "tables", "--states")
    assert done.exit_code == 0, done.stderr
    texts = {path.name: path.read_text().splitlines() for path in (folder / "tables").iterdir()}
    assert set(texts) == {
        *(
            f"main-{model}{s}.csv"
            for model in ("foundation", "persson")
            for s in ("", "-states")
        ),
        "main-foundation-clusters.csv",
        "main-foundation-energy_spectrum.csv",
        "main-foundation-pressure_pdf.csv",
    }
    rows = list(csv.DictReader(texts["main-foundation-pressure_pdf.csv"]))
    assert len(rows) == 3 * 120
    for name in ("pressure_pdf_mean", "pressure_pdf_sem", "pressure_pdf_persson"):
        column = np.array([float(row[f"{name} [1]"]) for row in rows])
        np.testing.assert_array_equal(column, result[name].ravel())
    assert [rows[120][f"{axis} [1]"] for axis in ("pressure", "pressure_pdf_bin")] == [
        "0.001",
        "0.0125",
    ]
    averages = list(csv.DictReader(texts["main-foundation.csv"]))
    assert float(averages[2]["clusters_number_mean [1]"]) == result["clusters_number_mean"][2]
    states = list(csv.DictReader(texts["main-foundation-states.csv"]))
    assert float(states[5]["clusters_number [1]"]) == result["clusters_number"][1, 2]
    assert not {"clusters [1]", "field_gap [length]"} & set(states[0])
    done = invoke("plot", "seen.h5", "--figure", "clusters", "--figure", "contact")
    assert done.exit_code == 0, done.stderr
    drawn = {path.stem for path in (folder / "figures").iterdir()}
    assert drawn == {"clusters", "contact"}
    shown = invoke("show", "seen.h5")
    assert shown.exit_code == 0
    assert "dimension" not in shown.stdout
    content = json.loads(invoke("show", "seen.h5", "--json").stdout)
    found = content["experiments"]["main"]["foundation"]["variables"]
    assert len(found["field_gap"][0]) == 128
    assert len(found["clusters"][19][2]) == 40


def test_export_needs_a_folder(results: Path, folder: Path, invoke: Invoke) -> None:
    assert invoke("export", results).exit_code == 2
    assert invoke("export", results, "--csv", "small.yaml").exit_code == 2
    (folder / "tables").mkdir()
    assert invoke("export", results, "--csv", "tables").exit_code == 0
    assert len(list((folder / "tables").iterdir())) == 2


# -- validate, schema ----------------------------------------------------------------------


def test_validate_says_what_a_spec_computes(folder: Path, invoke: Invoke) -> None:
    done = invoke("validate", "small.yaml")
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout == "small.yaml: valid; 1 experiment, foundation, persson, 63 states\n"
    assert [entry.name for entry in folder.iterdir()] == ["small.yaml"]


def test_validate_checks_all_of_several(folder: Path, invoke: Invoke) -> None:
    text = (folder / "small.yaml").read_text()
    (folder / "bad.yaml").write_text(text.replace("slope: 0.1", "slpoe: -0.1"))
    (folder / "sweep.yaml").write_text(text + "sweep: {surface.qr: [1.0, 8.0]}\n")
    done = invoke("validate", "bad.yaml", "small.yaml", "sweep.yaml")
    assert done.exit_code == 2
    assert "small.yaml: valid" in done.stdout
    assert "2 experiments, foundation, persson, 126 states" in done.stdout
    assert "bad.yaml:2:" in done.stderr
    assert "did you mean 'slope'" in done.stderr
    assert invoke("validate").exit_code == 2


def test_schema_is_json(invoke: Invoke) -> None:
    schema = json.loads(invoke("schema").stdout)
    assert {"surface", "pressures", "models"} <= set(schema["properties"])


# -- plot ----------------------------------------------------------------------------------


def test_plot_draws_what_the_results_allow(results: Path, folder: Path, invoke: Invoke) -> None:
    done = invoke("plot", results, "-o", "pictures", "--figure", "area")
    assert done.exit_code == 0, done.stderr
    paths = [folder / line for line in done.stdout.splitlines()]
    assert {path.suffix for path in paths} == {".pdf", ".png"}
    assert all(path.stat().st_size > 1000 for path in paths)
    assert sorted(paths) == sorted((folder / "pictures").iterdir())


@pytest.mark.usefixtures("blank_figures")
def test_plot_draws_all_that_it_can(results: Path, folder: Path, invoke: Invoke) -> None:
    done = invoke("plot", results)
    assert done.exit_code == 0, done.stderr
    paths = [folder / line for line in done.stdout.splitlines()]
    names = {path.stem for path in paths}
    assert {"area", "separation", "stiffness"} <= names == set(available(rb.load(results)))
    assert sorted(paths) == sorted((folder / "figures").iterdir())


def test_plot_refuses_unknown_figures(results: Path, folder: Path, invoke: Invoke) -> None:
    done = invoke("plot", results, "--figure", "portrait")
    assert done.exit_code == 2
    assert "there is no figure 'portrait'; choose among" in " ".join(done.stderr.split())
    assert not (folder / "figures").exists()


# -- help and start-up ---------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_an_example(invoke: Invoke, name: str) -> None:
    done = invoke(name, "--help")
    assert done.exit_code == 0
    assert f"  Example:\n    roughbench {name}" in done.stdout
    assert "--debug" in done.stdout
    summary = invoke("--help").stdout
    assert name in summary
    assert "..." not in summary.partition("Commands:")[2]


def test_usage(invoke: Invoke) -> None:
    assert invoke("--help").exit_code == 0
    assert invoke("--version").stdout == f"roughbench {rb.__version__}\n"
    done = invoke("walk")
    assert done.exit_code == 2
    assert "No such command 'walk'" in done.stderr


def imported(*arguments: str) -> set[str]:
    """Return the top-level modules that a command imports."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "roughbench", *arguments],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])},
    )
    names = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    return {name.partition(".")[0] for name in names}


def test_help_and_validate_import_nothing_heavy(folder: Path) -> None:
    heavy = {"numba", "scipy", "matplotlib", "pyfftw"}
    helped = imported("--help")
    assert "click" in helped  # the listing works
    assert not helped & (heavy | {"h5py", "numpy", "pydantic", "yaml", "tqdm"})
    validated = imported("validate", str(folder / "small.yaml"))
    assert "pydantic" in validated
    assert not validated & (heavy | {"tqdm"})
