"""Where Popov leaves Persson: the criterion on curves whose crossings are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.figures import departures
from roughbench.figures.agreement import agreement
from roughbench.results import ModelResult, Results

Make = Callable[..., ModelResult]
FloatArray = NDArray[np.float64]


@pytest.mark.parametrize("factor", [1.5, 2.0, 10.0])
@pytest.mark.parametrize("exponent", [0.5, -1.0, 3.0])
@pytest.mark.parametrize("n_points", [5, 41, 200])
def test_power_laws_part_where_their_ratio_is_the_factor(
    factor: float, exponent: float, n_points: int
) -> None:
    pressure = np.logspace(-6, 2, n_points)
    persson = 0.3 * pressure**0.7
    popov = persson * (pressure / 1e-2) ** exponent
    found = agreement(pressure, popov, persson, factor)
    away = factor ** (1.0 / abs(exponent))
    assert found.found
    assert found.pressures == pytest.approx((1e-2 / away, 1e-2 * away), rel=1e-12)


def test_the_range_may_lie_between_two_pressures() -> None:
    found = agreement([1.0, 100.0], [1.0, 100.0], [10.0, 10.0], 2.0)
    assert found.pressures == pytest.approx((5.0, 20.0), rel=1e-14)


def test_agreement_everywhere_and_nowhere_has_no_departure() -> None:
    pressure = np.logspace(-5, -1, 9)
    everywhere = agreement(pressure, 1.9 * pressure, pressure, 2.0)
    nowhere = agreement(pressure, 2.1 * pressure, pressure, 2.0)
    assert (everywhere.found, everywhere.pressures) == (True, ())
    assert (nowhere.found, nowhere.pressures) == (False, ())
    assert not agreement(pressure, pressure / 2.1, pressure, 2.0).found


def test_one_end_may_be_that_of_the_data() -> None:
    pressure = np.logspace(-4, 0, 17)
    found = agreement(pressure, pressure * np.maximum(1.0, pressure / 1e-2), pressure, 2.0)
    assert found.lower is None
    # Linear in ln p between 1e-2 and the next pressures: exact, as the ratio is.
    assert found.upper == pytest.approx(2e-2, rel=1e-12)


def test_the_widest_of_several_ranges_counts() -> None:
    log_ratio = np.array([9.0, 0.0, 9.0, 9.0, 0.0, 0.0, 9.0])
    pressure = np.exp(np.arange(7.0))
    found = agreement(pressure, np.exp(log_ratio), np.ones(7), math.e**0.9)
    assert found.pressures == pytest.approx((math.exp(3.9), math.exp(5.1)), rel=1e-13)


def test_towards_full_contact_the_inverse_ratio_is_linear() -> None:
    # 1/ratio falls from 1 to 0 over one unit of ln p, and is 1/4 after three quarters.
    found = agreement([1.0, math.e, math.e**2], [1.0, 1.0, math.inf], [1.0, 1.0, 1.0], 4.0)
    assert found.lower is None
    assert found.upper == pytest.approx(math.exp(1.75), rel=1e-14)


def test_from_below_the_factor_straight_to_full_contact() -> None:
    # 1/ratio falls from 8 to 0: it is 4 halfway and 1/4 after 31/32.
    found = agreement([1.0, math.e], [1.0, math.inf], [8.0, 8.0], 4.0)
    assert found.pressures == pytest.approx((math.exp(0.5), math.exp(31 / 32)), rel=1e-14)


def test_states_without_a_number_are_passed_over() -> None:
    pressure = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    popov = np.array([1.0, math.nan, 4.0, math.inf, math.inf])
    persson = np.array([1.0, 1.0, 1.0, math.nan, math.inf])
    whole = agreement(pressure, popov, persson, 2.0)
    known = agreement([1.0, 4.0], [1.0, 4.0], [1.0, 1.0], 2.0)
    assert whole.pressures == known.pressures == pytest.approx((2.0,))
    assert not agreement([1.0, 2.0], [math.nan] * 2, [1.0, 1.0], 2.0).found


def test_a_factor_must_exceed_one() -> None:
    with pytest.raises(ValueError, match="greater than 1, got 1"):
        agreement([1.0, 2.0], [1.0, 1.0], [1.0, 1.0], 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_as_a_search_on_a_fine_grid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 10.0, 12))
    y = np.cumsum(rng.normal(0.0, 0.8, 12))
    found = agreement(np.exp(x), np.exp(y), np.ones(12), math.e)
    fine = np.linspace(x[0], x[-1], 400_001)
    inside = np.abs(np.interp(fine, x, y)) < 1.0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
    starts, stops = fine[edges[::2]], fine[edges[1::2] - 1]
    assert found.found == (starts.size > 0)
    if found.found:
        widest = int(np.argmax(stops - starts))
        lower = x[0] if found.lower is None else math.log(found.lower)
        upper = x[-1] if found.upper is None else math.log(found.upper)
        assert (lower, upper) == pytest.approx((starts[widest], stops[widest]), abs=1e-4)


def test_departures_of_results(make: Make, collect: Callable[..., Results]) -> None:
    pressure = np.logspace(-5, -1, 9)
    popov = make(stiffness=pressure**0.5, pressure=pressure)
    persson = make("persson", n=1, stiffness=0.1 * pressure**0.0, pressure=pressure)
    results = collect(
        experiments={
            "both": [popov, persson],
            "popov": [popov],
            "others": [popov, make("persson", n=1)],
        }
    )
    found = departures(results)
    assert found["popov"] is None
    assert found["others"] is None
    assert found["both"] is not None
    # √p = 0.1·2^±1
    assert found["both"].pressures == pytest.approx((0.05**2, 0.2**2), rel=1e-12)
    wider = departures(results, factor=3.0)["both"]
    assert wider is not None
    assert wider.pressures == pytest.approx((0.01 / 9.0, 0.09), rel=1e-12)
