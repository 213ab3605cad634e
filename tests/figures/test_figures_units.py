"""Axes of results with units: SI with one prefix each, the same curves; none without units."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pint
import pytest
from matplotlib.figure import Figure

from roughbench.figures import available
from roughbench.figures.agreement import departures
from roughbench.figures.axes import axes_of
from roughbench.figures.curves import curve_of
from roughbench.results import Results
from tests.figures.conftest import Draw, Make

Collect = Callable[..., Results]
MODULUS = 2e9


def in_si(results: Results) -> Results:
    """Return results whose lengths are m, with units."""
    return Results(
        {
            name: {label: one.in_si(MODULUS) for label, one in models.items()}
            for name, models in results.items()
        },
        results.spec_text,
        results.spec_sha256,
        results.name,
    )


@pytest.fixture
def bare(make: Make, collect: Collect) -> Results:
    return collect(make("bem", height=5e-8), make("persson", height=5e-8, n=1))


def axis_words(figure: Figure) -> list[tuple[str, str]]:
    return [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes if axes.get_ylabel()]


@pytest.mark.parametrize(
    ("name", "without", "unit"),
    [
        ("area", r"contact area $A/A_0$", ""),
        ("separation", r"mean separation $\bar u/h_\mathrm{rms}$", "m)"),
        ("stiffness", r"stiffness $K h_\mathrm{rms}/E\!^*$", "m)"),
    ],
)
def test_an_axis_has_its_unit_and_bare_results_keep_theirs(
    bare: Results, draw: Draw, name: str, without: str, unit: str
) -> None:
    assert axis_words(draw(bare, name))[0] == (r"pressure $p/E\!^*$", without)
    x, y = axis_words(draw(in_si(bare), name))[0]
    assert x == "pressure $p$ (MPa)"
    assert y.endswith(unit)
    assert ("h_" in y) is False
    assert axes_of(bare)[name].unit == ""


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_the_curves_are_the_results_in_the_unit_of_the_axis(bare: Results, name: str) -> None:
    results = in_si(bare)
    shown = axes_of(results)
    axis = shown[name]
    assert axis.factor is not None
    result = results["main"]["bem"]
    curve = curve_of(result, name, shown)
    np.testing.assert_allclose(curve.pressure, result["pressure"] * 1e-6)
    np.testing.assert_allclose(curve.value, result[f"{name}_mean"] * axis.factor)
    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    in_unit = registry.Quantity(1.0, result.units(name)).to(axis.unit or "1").magnitude
    assert axis.factor == pytest.approx(in_unit)


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_what_is_cut_off_at_first_is_the_same(bare: Results, name: str) -> None:
    """In h_rms and E*: the limits only change their unit."""
    results, shown = in_si(bare), axes_of(in_si(bare))
    one, other = bare["main"]["bem"], results["main"]["bem"]
    for without, limit in zip(
        axes_of(bare)[name].limits(one), shown[name].limits(other), strict=True
    ):
        ratio = curve_of(other, name, shown).value / curve_of(one, name).value
        np.testing.assert_allclose(limit, without * ratio[0], rtol=1e-9)


def test_titles_and_heights_of_the_springs_have_units(computed: Results, draw: Draw) -> None:
    figure = draw(in_si(computed), "foundation")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "$p$ = " in titles[0]
    assert r"E\!^*" not in titles[0]
    assert figure.get_supylabel().startswith("height (")
    assert figure.get_supxlabel() == ""


def test_agreement_is_said_without_units(computed: Results) -> None:
    found, other = departures(computed), departures(in_si(computed))
    for name, one in found.items():
        same = other[name]
        assert one is not None
        assert same is not None
        assert same.pressures == pytest.approx(one.pressures)


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_units_reach_the_files(bare: Results, draw: Draw, tmp_path: Path, name: str) -> None:
    assert available(in_si(bare)) == available(bare)
    pictures = []
    for results in (bare, in_si(bare), in_si(bare).reduced()):
        draw(results, name).savefig(tmp_path / "one.png", dpi=100)
        pictures.append((tmp_path / "one.png").read_bytes())
    one, other, reduced = pictures
    assert one != other
    assert other != reduced
