"""The report on results with units: the same numbers, in MPa, nm and MPa/nm."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from roughbench.report.curves import pressure_charts
from roughbench.report.sources import ReportSource
from roughbench.report.styles import page_styles
from roughbench.report.warnings import at_pressures
from roughbench.results import Results
from roughbench.verdict import fit_experiments, trust_of
from tests.figures.test_figures_units import MODULUS, in_si
from tests.report.conftest import EXPERIMENTS, Page, page_of


@pytest.fixture(scope="module")
def plate(small: Results) -> Results:
    return in_si(small)


def charts(results: Results) -> dict[str, dict[str, Any]]:
    source = ReportSource("plate.h5", results)
    return {one.key: one.data for one in pressure_charts(source, page_styles([source]))}


def test_axes_and_hints_have_units(plate: Results, small: Results) -> None:
    found = charts(plate)
    assert {one["x"]["title"] for one in found.values()} == {"pressure p (MPa)"}
    assert found["area"]["y"]["title"] == "A/A<sub>0</sub>"
    assert re.fullmatch(r"ū \(.?m\)", found["separation"]["y"]["title"])
    assert re.fullmatch(r"K \(.*Pa/.?m\)", found["stiffness"]["y"]["title"])
    hint = found["separation"]["curves"][0]["text"][0]
    assert re.match(r"p = 2 MPa<br>ū = \(?[\d.]+ ± [\d.]+\)? .?m$", hint)
    assert {one["x"]["title"] for one in charts(small).values()} == {"pressure p/E*"}


def test_dimensionless_charts_stay_what_they_are(plate: Results, small: Results) -> None:
    for key in ("kappa", "stiffness-by-pressure"):
        bare, found = charts(small)[key], charts(plate)[key]
        assert found["y"] == bare["y"]
        for one, other in zip(bare["curves"], found["curves"], strict=True):
            np.testing.assert_allclose(
                np.array(one["y"], float), np.array(other["y"], float), rtol=1e-6
            )


def test_a_sentence_has_pressures_in_pascal(plate: Results, small: Results) -> None:
    found = [trust_of(fit_experiments([("r.h5", r)], None, 10)) for r in (small, plate)]
    for bare, other in zip(*found, strict=True):
        for one, same in zip(bare.quantities, other.quantities, strict=True):
            assert "E*" in one.sentence
            assert "E*" not in same.sentence
            assert "MPa" in same.sentence
            assert same.found is not None
            assert one.found is not None
            np.testing.assert_allclose(same.found.start.value, one.found.start.value)
    first = found[1][0].quantities[0].deviations[0]
    assert first.place == "2 MPa"


def test_the_page_says_no_pressure_in_the_modulus_but_in_the_fits(plate: Results) -> None:
    text = " ".join(Page(page_of(plate)).text.split())
    before, _, _ = text.partition("What the curves say in numbers")
    assert "p/E*" not in before
    assert "The laws are between dimensionless numbers" in text
    assert f"E* = {MODULUS * 1e-9:g} GPa" in text
    assert len(EXPERIMENTS) == 2


def test_pressures_of_warnings_have_one_unit() -> None:
    pressure, chosen = np.array([1e-5, 1e-3, 1e-2]), np.array([True, True, False])
    assert at_pressures(pressure, chosen, MODULUS) == "at p = 20 and 2000 kPa"
