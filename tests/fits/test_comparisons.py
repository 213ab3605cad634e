"""Made-up contenders whose deviations are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.fits import PERCENTS, comparisons, fit
from roughbench.fits.comparisons import interpolate_falling
from roughbench.fits.tables import departure_tables, law_tables
from roughbench.results import ModelResult
from tests.fits.lawful import HEIGHT, P0, SLOPE, U0, P, collect, make

FloatArray = NDArray[np.float64]
SCATTER = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
NONE = np.zeros(2)
PLACE = 1e-5


def exact_curves(p: FloatArray = P, scatter: FloatArray = NONE) -> dict[str, FloatArray]:
    """Return A ∼ p, ū = u0 ln(p0/p), K = p/u0: ln A and ln K are linear in ū."""
    factor = 1.0 + scatter[:, None]
    return {
        "area": 0.4 * p / SLOPE * factor,
        "separation": U0 * np.log(10 * P0 / p) * np.ones_like(factor),
        "stiffness": p / U0 * factor,
    }


def ratio(per_decade: float) -> FloatArray:
    """Return r with (r − 1)/(r + 1) linear in ln p, as the fits take it; 1 at PLACE."""
    s = per_decade * np.log10(P / PLACE)
    return np.asarray((1 + s) / (1 - s))


def where_it_is(wanted: float, per_decade: float) -> float:
    """Return the pressure at which that ratio has a value."""
    return float(PLACE * 10 ** ((wanted - 1) / (wanted + 1) / per_decade))


@pytest.mark.parametrize("comparison", ["area", "area_at_separation"])
def test_a_known_deviation_of_the_area_is_found(comparison: str) -> None:
    """area = exact × (1 + ε(p)) at the same ū: the ranges end where |ε| is 10 % and 50 %."""
    values = exact_curves(scatter=SCATTER)
    other = dict(exact_curves(scatter=SCATTER))
    other["area"] = other["area"] * ratio(0.15)
    found = fit(collect(make(values), make(other, "erf09")), resamples=50)["main"]["erf09"]
    for percent in PERCENTS:
        low, high = (found[f"{comparison}_agrees_{end}_{percent}"] for end in ("from", "to"))
        part = percent / 100
        assert low.value == pytest.approx(where_it_is(1 - part, 0.15), rel=1e-9)
        assert high.value == pytest.approx(where_it_is(1 + part, 0.15), rel=1e-9)
        # The scatter is common to both and leaves no error.
        assert low.error < 1e-9 * low.value
        assert not low.is_bound


def test_a_scatter_of_the_contender_is_an_error_of_its_ranges(rng: np.random.Generator) -> None:
    """A = A_exact r(p) f, f = 1 ± 5 % of a realization: r f = 1.1 is reached elsewhere."""
    scatter = rng.normal(scale=0.05, size=30)
    scatter -= scatter.mean()
    values = exact_curves(scatter=np.zeros(30))
    other = exact_curves(scatter=scatter)
    other["area"] = other["area"] * ratio(0.15)
    found = fit(collect(make(values), make(other, "erf09")), resamples=800)["main"]["erf09"]
    # s = 0.15 log10(p/PLACE), and r = 1.1 there: d ln p = d ln r / (0.15/ln 10 · (1 + r)²/2r).
    of_mean = float(np.std(scatter, ddof=1)) / math.sqrt(30)
    slope = 0.15 / math.log(10) * 2.1**2 / 2.2
    for name in ("area", "area_at_separation"):
        end = found[f"{name}_agrees_to_10"]
        expected = end.value * of_mean / slope
        # Student's t for 30 realizations widens it by 2 %; 800 draws leave some 4 %.
        assert end.error == pytest.approx(1.02 * expected, rel=0.12)
        factor = found[f"{name}_factor"]
        assert 0 < factor.error < 3 * of_mean * factor.value


def test_a_shift_in_pressure_is_none_at_equal_separation() -> None:
    """A contender whose pressures are all off by 1.7: the same A and K at the same ū."""
    exact, shifted = make(exact_curves()), make(exact_curves(1.7 * P), "erf09")
    found = fit(collect(exact, shifted), resamples=10)["main"]["erf09"]
    for quantity in ("area", "stiffness"):
        assert found[f"{quantity}_factor"].value == pytest.approx(1.7)
        assert found[f"{quantity}_at_separation_factor"].value == pytest.approx(1.0)
        assert math.isnan(found[f"{quantity}_agrees_from_50"].value)
        start = found[f"{quantity}_at_separation_agrees_from_10"]
        # Its first ū is that of the exact solution at 1.7 times the first pressure: the
        # state before is not compared, and says nothing of where the agreement begins.
        assert start.value == pytest.approx(P[1.7 * P[0] < P][0])
        assert start.is_bound


def test_a_factor_at_equal_separation_is_found_at_other_pressures() -> None:
    values = exact_curves(P * 1.01)
    values["area"], values["stiffness"] = 1.3 * values["area"], values["stiffness"] / 1.4
    other = make(values, "erf09")
    other.variables["pressure"] = P * 1.01  # type: ignore[index]
    found = fit(collect(make(exact_curves()), other), resamples=10)["main"]["erf09"]
    assert found["area_at_separation_factor"].value == pytest.approx(1.3)
    assert found["stiffness_at_separation_factor"].value == pytest.approx(1.4)
    assert "area_factor" not in found
    assert "area_agrees_to_10" not in found


def test_separations_are_compared_in_units_of_the_realized_heights() -> None:
    values = exact_curves()
    taller = {"area": values["area"], "separation": 1.4 * values["separation"]}
    taller["stiffness"] = values["stiffness"] / 1.4
    other = make(taller, "erf09")
    other.variables["rms_height"][:] = 1.4 * HEIGHT
    found = fit(collect(make(values), other), resamples=10)["main"]["erf09"]
    assert found["area_at_separation_factor"].value == pytest.approx(1.0)
    assert found["stiffness_at_separation_factor"].value == pytest.approx(1.0)


def without(result: ModelResult, *names: str) -> ModelResult:
    kept = {key: v for key, v in result.variables.items() if not key.startswith(names)}
    return ModelResult(result.label, result.kind, result.title, result.attributes, kept)


def test_what_a_model_does_not_give_is_not_given() -> None:
    """A model with an area only, beside one that gives all."""
    values = exact_curves()
    bare = without(make(values, "erf09"), "separation", "stiffness")
    models = fit(collect(make(values), bare), resamples=10)["main"]
    found, exact = models["erf09"], models["bem"]
    assert found["kappa"].value == pytest.approx(exact["kappa"].value)
    assert found["area_factor"].value == pytest.approx(1.0)
    for comparison in comparisons():
        names = [f"{comparison.name}_factor"]
        names += [end for percent in PERCENTS for end in comparison.ends(percent)]
        for name in names:
            assert found[name].is_given is (comparison.name == "area"), name
    for name in ("u0", "alpha", "beta", "log_decades", "plateau_decades", "exponent", "theta"):
        assert not found[name].is_given, name
        assert math.isnan(found[name].value)
        assert exact[name].is_given
    rows = [
        table.rows["erf09"]
        for table in (*law_tables(models), *departure_tables(models, ["erf09"]))
    ]
    assert [row[0].is_given for row in rows[:2]] == [True, False]
    assert sum(row[0].is_given for row in rows) == 4  # κ, the factor, 10 % and 50 % of the area


def test_a_model_without_a_separation_has_no_quantity_at_it() -> None:
    bare = without(make(exact_curves(), "erf09"), "separation")
    found = fit(collect(make(exact_curves()), bare), resamples=10)["main"]["erf09"]
    assert found["stiffness_factor"].value == pytest.approx(1.0)
    assert found["log_decades"].is_given
    assert not found["stiffness_at_separation_factor"].is_given
    assert not found["u0"].is_given


def test_a_separation_that_does_not_fall_is_passed_over() -> None:
    x, y = np.array([3.0, 3.0, 3.5, 1.0]), np.array([1.0, 50.0, 70.0, math.e])
    at = np.array([3.0, 2.0, 1.0, 0.9, math.nan])
    expected = [1.0, math.exp(0.5), math.e, math.nan, math.nan]
    np.testing.assert_allclose(interpolate_falling(x, y, at), expected)
    assert np.isnan(interpolate_falling(x, np.full(4, math.nan), at)).all()
