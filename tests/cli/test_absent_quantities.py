"""A model that gives the area alone, through every command: the rest is not given."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import roughbench as rb
from roughbench import figures
from roughbench.cli import main
from roughbench.fits import NOT_GIVEN, fit
from roughbench.planning.cells import Cell
from roughbench.planning.plan import plan
from roughbench.runner import preparation
from tests.engines.fakes import AtOnce

GIVEN = {f"area_{kind}" for kind in ("mean", "sem", "median", "q16", "q84")} | {
    *("pressure", "area", "status", "n_converged", "rms_height", "rms_slope")
}

SPEC = """\
surface: {H: 0.7, q0: 1.0, qr: 4.0, q1: 16.0, slope: 0.1}
pressures: [1.0e-4, 1.0e-3, 2.0e-3, 5.0e-3, 1.0e-2]
realizations: 2
models: [{kind: bem, grid: 64}, {kind: persson}]
"""


def run(*arguments: object) -> str:
    """Run the command line; returns what it prints."""
    found = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert found.exit_code == 0, found.output
    return found.output


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a results file of the exact solution, Persson's theory and the area-only model."""

    def with_area_only(spec: rb.Spec) -> list[Cell]:
        cells = plan(spec)
        return [*cells, replace(cells[0], model=AtOnce(), n_realizations=3)]

    folder = tmp_path_factory.mktemp("absent")
    (folder / "s.yaml").write_text(SPEC)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(preparation, "plan", with_area_only)
        printed = run("run", folder / "s.yaml", "-o", folder / "r.h5", "-j", 1, "--threads", 1)
    assert "converge" not in printed
    return folder / "r.h5"


def test_what_is_not_given_is_no_variable_of_the_results(file: Path) -> None:
    result = rb.load(file)["main"]["at_once"]
    assert set(result) == GIVEN
    assert result.n_unconverged == 0
    assert result["area"].shape == (3, 5)
    np.testing.assert_allclose(result["area_mean"], result["area"].mean(axis=0))
    for name in ("stiffness", "stiffness_mean", "stiffness_harmonic", "separation_q16"):
        assert name not in result
        message = rf"Area only \(at_once\) does not give {name}: it knows no (contact|mean) st?"
        with pytest.raises(KeyError, match=message.replace("st?", "s")):
            result[name]


def test_show_says_so_where_a_number_would_be(file: Path) -> None:
    lines = run("show", file).split("at_once: Area only")[1].splitlines()
    rows = [line for line in lines if line.startswith(" ") and "e-0" in line[:12]]
    assert len(rows) == 5
    assert all(row.count("not given") == 2 for row in rows)
    assert "not converge" not in "\n".join(lines)
    found = json.loads(run("show", file, "--json"))["experiments"]["main"]["at_once"]
    assert set(found["variables"]) == GIVEN


def test_export_leaves_it_out(file: Path, tmp_path: Path) -> None:
    run("export", file, "--csv", tmp_path / "csv")
    with (tmp_path / "csv" / "main-at_once.csv").open() as table:
        headings = {name.split(" ")[0] for name in next(csv.reader(table))}
    assert {"pressure", "area_mean", "n_converged"} <= headings <= GIVEN


def test_fits_are_not_given(file: Path) -> None:
    fitted = fit(rb.load(file), resamples=20)["main"]["at_once"]
    lacking = {name for name, estimate in fitted.items() if not estimate.is_given}
    assert {"u0", "theta", "log_from", "stiffness_factor", "separation_agrees_to_10"} <= lacking
    of_area = {name for name in lacking if name.startswith(("area", "kappa", "half"))}
    assert all("at_separation" in name for name in of_area)  # which is not given
    assert all(fitted[name] == NOT_GIVEN for name in lacking)
    table = run("fit", file, "--resamples", 20)
    laws = [line for line in table.splitlines() if line.startswith("at_once")]
    assert any(line.count("not given") == 8 for line in laws)  # K ~ p
    shown = json.loads(run("fit", file, "--resamples", 20, "--json"))
    assert lacking.isdisjoint(shown["experiments"]["main"]["at_once"])


def test_figures_leave_it_out(file: Path, tmp_path: Path) -> None:
    results = rb.load(file)
    for name in ("area", "separation", "stiffness", "fig3"):
        figure = figures.FIGURES[name].draw(results)
        drawn = {line.get_gid() for axes in figure.axes for line in axes.lines}
        words = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
        given = name in ("area", "fig3")
        assert ("main/at_once/area" in drawn) == given
        assert f"main/at_once/{name}" not in drawn or given
        assert any("Area only" in text for text in words) == given
    alone = rb.Results({"main": {"at_once": results["main"]["at_once"]}}, "", "")
    assert figures.available(alone) == ["area"]
    for name in figures.available(results):
        figures.FIGURES[name].draw(results)
    run("plot", file, "-o", tmp_path / "figures", "--figure", "stiffness")
    assert (tmp_path / "figures" / "stiffness.pdf").is_file()


def test_the_report_says_so(file: Path, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    run("report", file, "-o", page, "--resamples", 20)
    text = page.read_text(encoding="utf-8")
    assert "Area only" in text
    # What it means; where the model can be trusted, ū and K; the verdict on the model, where
    # one line stands for K; of K ~ p, with its drifts; factors, and agreement within 10 % and
    # 50 %, in ū and K at equal pressure and in A and K at equal ū.
    assert text.count(">not given<") == 1 + 2 + 3 + 8 + 5 + 2 * 4
    assert "states did not converge" not in text
