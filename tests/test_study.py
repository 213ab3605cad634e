"""Every number of docs/study.md comes from a line that the script wrote, of kept results."""

from __future__ import annotations

import importlib
import math
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import roughbench as rb
from roughbench.results import ModelResult

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "docs" / "study"
QUICK = "slope-32-coarse"
"""Kept results that are read in a second or two."""
SETTINGS = {"0.1", "0.3", "0.33", "0.45", "0.5", "0.7", "0.9", "1.5", "13.5"}
"""Decimals of specs and rules that the page may name without a line."""


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """Return scripts/study_figures.py, whose parts lie beside it."""
    folder = str(ROOT / "scripts")
    sys.path.insert(0, folder)
    try:
        return importlib.import_module("study_figures")
    finally:
        sys.path.remove(folder)


def part(name: str) -> ModuleType:
    return sys.modules[name]


def kept(name: str) -> str:
    return (KEPT / name).read_text(encoding="utf-8")


def test_the_page_is_its_template_with_kept_numbers(script: ModuleType) -> None:
    numbers = script.numbers_of(kept("numbers.txt"))
    page = script.page_of(kept("page.txt"), numbers, kept("claims.txt").rstrip("\n"))
    assert page == (ROOT / "docs" / "study.md").read_text(encoding="utf-8")


def test_the_template_measures_nothing_itself() -> None:
    text = re.sub(r"\{[a-z][^{}]*\}|`[^`]*`|\]\([^)]*\)", "", kept("page.txt"))
    assert re.findall(r"± ?\d", text) == []
    decimals = set(re.findall(r"(?<![\d.])\d+\.\d+", text))
    assert decimals <= SETTINGS, decimals - SETTINGS
    assert re.findall(r"\d ?%", text) == []
    assert re.findall(r"(?:factors?(?: of)?|by|times) \d", text) == []


def test_kept_lines_follow_from_kept_results(script: ModuleType) -> None:
    lines = dict(line.split(" ", 1) for line in kept("numbers.txt").splitlines())
    runs = script.load(KEPT, [QUICK])
    found = dict(part("_study_numbers").slopes(runs))
    assert len(found) > 50
    for line in script.lines_of(found).splitlines():
        name, rest = line.split(" ", 1)
        ours, theirs = (list(map(float, one.split())) for one in (rest, lines[name]))
        assert ours == pytest.approx(theirs, rel=1e-5, nan_ok=True), name


def test_a_run_says_how_many_surfaces_it_has_and_should_have(script: ModuleType) -> None:
    found = dict(part("_study_numbers").ensembles(script.load(KEPT, [QUICK])))
    spec = rb.load_spec(ROOT / "configs" / "study" / f"{QUICK}.yaml")
    assert found[f"run.{QUICK}.asked"].value == spec.realizations
    assert found[f"run.{QUICK}.computed"].value == found[f"run.{QUICK}.asked"].value == 16


@pytest.mark.slow
def test_all_lines_follow_from_kept_results(script: ModuleType) -> None:
    numbers = script.everything(script.load(KEPT))
    again = script.numbers_of(script.lines_of(numbers))
    lines = script.numbers_of(kept("numbers.txt"))
    assert set(again) == set(lines)
    for name, one in again.items():
        assert one.value == pytest.approx(lines[name].value, rel=1e-4, nan_ok=True), name
        assert one.count == lines[name].count


def test_kept_results_are_small_and_whole(script: ModuleType) -> None:
    paths = sorted(KEPT.glob("*.h5.xz"))
    assert sum(path.stat().st_size for path in paths) < 20e6
    assert {path.name.removesuffix(".h5.xz") for path in paths} <= set(script.RUNS)


def test_a_name_without_a_number_is_an_error(script: ModuleType) -> None:
    numbers = script.numbers_of("a.b 2 0.1 16\nc.d nan nan 0\n")
    text = "{a.b}, {a.b:v}, {a.b:n}, {a.b:p}: {claims}"
    assert script.page_of(text, numbers, "table") == "2.0 ± 0.1, 2, 16, 100 %: table"
    with pytest.raises(KeyError):
        script.page_of("{none.such}", numbers, "")
    with pytest.raises(ValueError, match=r"c\.d has no value"):
        script.page_of("{c.d}", numbers, "")


def test_gaps_in_theory_are_shares_of_all_points(
    script: ModuleType,  # noqa: ARG001 - its parts are imported
) -> None:
    """All of them together are what does not touch; an equal density has the ratio one."""
    numbers = part("_study_numbers")
    spec = {
        "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 8.0, "slope": 0.1},
        "pressures": [0.01],
        "models": [{"kind": "persson"}],
    }
    theory = rb.run(spec)["main"]["persson"]
    edges = np.array([0.0, 0.5, 2.0, 100.0])
    exact = replace(
        theory,
        kind="bem",
        attributes={**theory.attributes, "grid_points": 32},
        variables={
            "pressure": theory["pressure"],
            "gap_pdf_edges": edges,
            "gap_pdf": np.array([[[0.5, 0.25, 0.0]], [[0.25, 0.0, 0.0]]]),
        },
    )
    density = numbers.gap_density(theory, exact, 0)
    share = float(np.sum(density * np.diff(edges)))
    assert share == pytest.approx(1.0 - float(theory["area_mean"][0]), rel=1e-3)
    both = np.array([0, 1])
    over = numbers._gap_share(density, exact, 0, 0.0, 0.5, both)
    assert over == pytest.approx(density[0] / 0.375)
    own = numbers.gap_density(exact, exact, 0)
    assert numbers._gap_share(own, exact, 0, 0.0, 2.0, both) == 1.0


# -- reading curves ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def lawful(script: ModuleType) -> ModelResult:  # noqa: ARG001 - its parts are imported
    """Return surfaces that follow ū = u₀ ln(p₀/p) with u₀ from 0.38 to 0.42 h and A = 2p/ξ."""
    spec = {
        "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
        "pressures": {"min": 1e-5, "max": 1e-3, "points": 9},
        "realizations": 5,
        "models": [{"kind": "winkler"}],
    }
    model = rb.run(spec)["main"]["winkler"]
    p = np.asarray(model["pressure"])
    height = np.asarray(model["rms_height"])[:, None]
    u0 = np.linspace(0.38, 0.42, 5)[:, None] * height
    values = {
        "separation": u0 * np.log(0.02 / p),
        "stiffness": p / u0,
        "area": np.broadcast_to(20.0 * p, (5, 9)),
        "status": np.zeros((5, 9), np.int32),
    }
    return replace(model, variables={**model.variables, **values})


def test_a_law_is_read_as_it_is(lawful: ModelResult) -> None:
    curves = part("_study_curves")
    slope = curves.number_of(lawful, curves.at_separation("slope", 2.0))
    assert slope.value == pytest.approx(0.4)
    assert slope.error == pytest.approx(np.std(np.linspace(0.38, 0.42, 5), ddof=1) / 5**0.5)
    assert slope.count == 5
    pressure = curves.number_of(lawful, curves.at_separation("pressure", 2.0)).value
    assert pressure == pytest.approx(0.02 * math.exp(-2.0 / 0.4))
    area = curves.number_of(lawful, curves.at_pressure("area", 2e-4)).value
    assert area == pytest.approx(4e-3)
    assert curves.curve_of(lawful).exponent(2e-5, 5e-4) == pytest.approx(1.0)
    assert math.isnan(curves.curve_of(lawful).pressure_at(9.0))


def test_a_ratio_takes_what_is_common_out(lawful: ModelResult) -> None:
    curves = part("_study_curves")
    ratio = curves.ratio_of(lawful, lawful, curves.at_separation("pressure", 2.0), 3.0)
    assert ratio.value == pytest.approx(3.0)
    assert ratio.error == pytest.approx(0.0, abs=1e-12)
    # Of other surfaces: another number of them, whose errors add up.
    few = replace(
        lawful,
        variables={
            name: array[1:4] if array.shape[:1] == (5,) else array
            for name, array in lawful.variables.items()
        },
    )
    ratio = curves.ratio_of(few, lawful, curves.at_separation("pressure", 2.0), 3.0)
    assert ratio.value == pytest.approx(3.0)
    assert ratio.error > 0.1


def test_a_closed_line_has_an_area_alone(lawful: ModelResult) -> None:
    curves = part("_study_curves")
    values = {name: np.array(lawful[name]) for name in ("separation", "stiffness")}
    values["separation"][0, -2:] = 0.0
    values["stiffness"][0, -2:] = math.inf
    curve = curves.curve_of(replace(lawful, variables={**lawful.variables, **values}))
    assert curve.n_open == 7
    last = float(lawful["pressure"][-1])
    assert curve.at_pressure("area", last) == pytest.approx(20.0 * last)
    assert math.isnan(curve.at_pressure("separation", last))


def test_springs_are_the_last_rung(script: ModuleType) -> None:  # noqa: ARG001
    numbers = part("_study_numbers")
    spec = {
        "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
        "pressures": [1e-3],
        "realizations": 1,
        "models": [{"kind": "winkler"}],
    }
    model = rb.run(spec)["main"]["winkler"]
    assert numbers.stiffening(model, 0.0) == pytest.approx(1.0)
    mean = numbers.stiffening(model, 1e9) / 1e9  # half of it is E*/k_w
    exact = rb.run({**spec, "models": [{"kind": "winkler", "modulus": 1.0 / (2.0 * mean)}]})
    for name in ("area", "separation", "stiffness"):
        ours = exact["main"]["winkler"][name]
        np.testing.assert_allclose(ours, model[name], rtol=1e-6)
