"""Drift of what should be constant, on laws whose drift is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.fits import Estimate, fit
from roughbench.fits.drift import least_drift
from roughbench.fits.resampling import draw_counts, estimate
from roughbench.verdict.rules import Outcome, at_most
from tests.fits.lawful import HEIGHT, U0, P, collect, make

H, F, U = Outcome.HOLDS, Outcome.FAILS, Outcome.UNDECIDED
TOLERATED = at_most(1.2, of_ratio=True)
"""The rule of the claims on K ∼ p."""
X = np.log(P)
DECADE = math.log(10.0)


RANGE = X[20:42]
"""Four decades, of which the drift is measured over three."""


def drifting(drift: float, n: int, own: float, common: float, seed: int = 0) -> Estimate:
    """Return the drift over three decades that is found of a law with a drift and scatter.

    Parameters
    ----------
    drift : float
        K/p after three decades, over that before.
    n : int
        Surfaces.
    own, common : float
        Relative scatter of each pressure alone, and of a whole curve.
    """
    rng = np.random.default_rng(seed)
    scatter = 1 + own * rng.normal(size=(n, RANGE.size)) + common * rng.normal(size=(n, 1))
    rate = drift ** ((RANGE - RANGE[0]) / (3 * DECADE)) * scatter
    means = draw_counts(n, 200, 0) @ rate / n
    return estimate(least_drift(RANGE, np.log(means), 3.0), count=n)


@pytest.mark.parametrize("decades", [1, 2, 3])
@pytest.mark.parametrize("drift", [1.0, 1.1, 1.2, 1.5, 2.0])
def test_a_trend_is_its_drift(drift: float, decades: int) -> None:
    y = (math.log(drift) / (3 * DECADE) * X)[None, :]
    assert least_drift(X, y, decades)[0] == pytest.approx(drift ** (decades / 3), rel=1e-9)
    assert least_drift(X, -y, decades)[0] == pytest.approx(drift ** (decades / 3), rel=1e-9)


def test_a_bend_drifts_where_its_slope_is_one() -> None:
    """ln(K/p) = c (ln p)²: the best window is centred, and falls and rises by c (W/2)²."""
    c = 0.05
    found = least_drift(X, (c * (X - X[20]) ** 2)[None, :], 2.0)
    assert found[0] == pytest.approx(math.exp(c * DECADE**2), rel=0.02)


def test_the_least_drift_is_that_of_the_region() -> None:
    """A law over two decades between two others: no drift over two, and some over three."""
    y = np.where(
        (X[10] < X) & (X[20] > X), 0.0, 1.0 * np.minimum(abs(X - X[10]), abs(X - X[20]))
    )
    found = [least_drift(X, y[None, :], decades)[0] for decades in (1, 2, 3)]
    assert found[0] == pytest.approx(1.0, abs=1e-9)
    assert found[1] == pytest.approx(1.0, abs=1e-9)
    assert found[2] > 1.5


def test_what_is_too_narrow_or_missing_has_no_drift() -> None:
    y = np.zeros((2, P.size))
    assert np.isnan(least_drift(X, y, 10.0)).all()
    assert np.isnan(least_drift(X[:3], y[:, :3], 0.3)).all()  # three points lie on a parabola
    y[1, ::3] = math.nan
    found = least_drift(X, y, 3.0)
    assert found[0] == 1.0
    assert math.isnan(found[1])


@pytest.mark.parametrize(("drift", "expected"), [(1.0, H), (1.1, H), (1.5, F), (2.0, F)])
@pytest.mark.parametrize(("n", "own", "common"), [(4, 0.03, 0.05), (16, 0.1, 0.1)])
def test_surfaces_of_the_usual_scatter_see_the_drift(
    drift: float, expected: Outcome, n: int, own: float, common: float
) -> None:
    """10 % passes for a law, 50 % does not, whatever the surfaces."""
    for seed in range(5):
        assert TOLERATED.decide(drifting(drift, n, own, common, seed)) == expected


def test_twenty_percent_is_on_the_edge() -> None:
    found = [TOLERATED.decide(drifting(1.2, 16, 0.03, 0.05, seed)) for seed in range(20)]
    assert F not in found
    assert found.count(U) >= 10


def test_surfaces_that_scatter_too_much_say_nothing_wrong() -> None:
    """30 % on 4 surfaces, as at the lowest pressures: neither wrong verdict is given."""
    law = [TOLERATED.decide(drifting(1.0, 4, 0.3, 0.0, seed)) for seed in range(10)]
    half = [TOLERATED.decide(drifting(1.5, 4, 0.3, 0.0, seed)) for seed in range(10)]
    assert F not in law
    assert H not in half
    assert half.count(U) > 5


def test_slope_one_never_saw_it() -> None:
    """What the drift replaces: springs of which K/p doubles passed with all decades."""
    stiffness = (P / U0 * 2.0 ** ((X - X[0]) / (3 * DECADE)))[None, :]
    values = {"area": stiffness * 0.0 + 0.1, "stiffness": stiffness}
    values["separation"] = (U0 * np.log(1.0 / P))[None, :]
    found = fit(collect(make(values)))["main"]["bem"]
    decades = (X[-2] - X[1]) / DECADE
    assert found["plateau_decades"].value == pytest.approx(decades, rel=1e-6)
    assert found["drift_3"].value == pytest.approx(2.0, rel=0.01)


def shifted(factor: float) -> dict[str, NDArray[np.float64]]:
    separation = np.maximum(U0 * np.log(0.04 / (P * factor)), 1e-6 * HEIGHT)
    stiffness = P / U0 * (1 + (P / 3e-3) ** 4)  # the region ends before ū does
    values = {"area": 0.1 * P, "separation": separation, "stiffness": stiffness}
    return {name: np.stack([one, one]) for name, one in values.items()}


@pytest.mark.parametrize("factor", [0.4, 1.0, 1.7, 7.0])
def test_pressures_at_equal_separation(factor: float) -> None:
    """ū = u0 ln(p0/(c p)): 1/c of the pressure for the same ū, whatever ū at equal p is."""
    found = fit(collect(make(shifted(1.0)), make(shifted(1 / factor), "winkler")))["main"]
    other = found["winkler"]
    assert other["pressure_at_separation_factor"].value == pytest.approx(
        max(factor, 1 / factor), rel=1e-3
    )
    for name in ("pressure_at_1h", "pressure_at_2h", "pressure_at_3h"):
        assert other[name].value == pytest.approx(factor, rel=1e-3)
