"""Widest ranges against the obvious search, and straight lines against NumPy's."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughbench.fits.windows import (
    part_between,
    straight_line,
    widest_between,
    widest_flat,
    widest_run,
)

values = st.lists(
    st.one_of(st.floats(-2, 2), st.just(math.nan), st.just(math.inf)), min_size=2, max_size=9
)


def obvious(y: np.ndarray, low: float, high: float) -> float:
    """Width of the longest run of a fine grid of the interpolated curve."""
    fine = np.linspace(0, y.size - 1, 2000 * (y.size - 1) + 1)
    k = np.minimum(fine.astype(int), y.size - 2)
    with np.errstate(invalid="ignore"):
        curve = y[k] + (fine - k) * (y[k + 1] - y[k])
        inside = np.isfinite(y[k] + y[k + 1]) & (curve >= low) & (curve <= high)
    best = run = 0
    for is_in in inside:
        run = run + 1 if is_in else 0
        best = max(best, run)
    return (best - 1) / 2000


@given(values, st.floats(-2, 1), st.floats(0.1, 2))
def test_widest_between_is_what_a_search_finds(
    y: list[float], low: float, height: float
) -> None:
    curve, x = np.array(y), np.arange(float(len(y)))
    start, end = widest_between(x, curve[None, :], np.array([low]), np.array([low + height]))
    width = 0.0 if np.isnan(start[0]) else float(end[0] - start[0])
    # A run is cut to the grid at both ends; one that touches a level in a point has none.
    assert width == pytest.approx(max(obvious(curve, low, low + height), 0.0), abs=2e-3)
    if width:
        assert 0 <= start[0] < end[0] <= len(y) - 1


def test_curves_do_not_disturb_each_other() -> None:
    x = np.arange(4.0)
    y = np.array([[0.0, 2.0, 2.0, 4.0], [5.0, 5.0, 5.0, 5.0], [1.0, math.nan, 1.0, 1.0]])
    start, end = widest_between(x, y, np.full(3, 1.0), np.full(3, 3.0))
    np.testing.assert_array_equal(start, [0.5, math.nan, 2.0])
    np.testing.assert_array_equal(end, [2.5, math.nan, 3.0])


LEVELS = st.sampled_from([-1.0, 0.0, 0.25, 0.5, 1.0, 2.0, math.nan, math.inf])


@given(
    st.lists(st.lists(LEVELS, min_size=5, max_size=5), min_size=1, max_size=4),
    st.tuples(st.floats(-1, 1), st.sampled_from([-1.0, 0.0, 0.25])),
)
def test_many_curves_at_many_levels_are_each_walked_alone(
    curves: list[list[float]], lows: tuple[float, float]
) -> None:
    """To the last bit: step by step, part after part."""
    x, y = np.array([0.0, 0.1, 0.4, 0.6, 1.3]), np.array(curves)
    low = np.array(lows)[:, None] + np.zeros(len(curves))
    starts, ends = widest_between(x, y, low, low + 1.0)
    for level, curve in np.ndindex(low.shape):
        bottom = low[level, curve, None]
        steps = itertools.pairwise(y[curve, :, None])
        parts = (part_between(a, b, bottom, bottom + 1.0) for a, b in steps)
        found = starts[level, curve], ends[level, curve]
        np.testing.assert_array_equal(found, widest_run(x, parts))


def test_without_pressures_there_is_no_range() -> None:
    start, end = widest_between(np.zeros(0), np.zeros((2, 0)), np.zeros(2), np.ones(2))
    assert np.isnan([*start, *end]).all()


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=8), st.floats(0.05, 0.5))
def test_widest_flat_beats_every_other_band(y: list[float], tolerance: float) -> None:
    curve, x = np.array([y]), np.arange(float(len(y)))
    start, end = widest_flat(x, curve, tolerance)
    band = math.log((1 + tolerance) / (1 - tolerance))
    for low in np.linspace(-1.5, 1, 41):
        a, b = widest_between(x, curve, np.array([low]), np.array([low + band]))
        assert np.isnan(a[0]) or b[0] - a[0] <= end[0] - start[0] + 1e-9


def test_widest_flat_of_a_bent_line() -> None:
    """ln y = |x - 5|/10: within ± 10 % where |x - 5| ≤ 10 ln(1.1/0.9)."""
    x = np.arange(11.0)
    start, end = widest_flat(x, np.abs(x - 5)[None, :] / 10, 0.1)
    half = 10 * math.log(1.1 / 0.9)
    assert start[0] == pytest.approx(5 - half, abs=1e-9)
    assert end[0] == pytest.approx(5 + half, abs=1e-9)


def test_nothing_is_found_where_nothing_is_finite() -> None:
    x = np.arange(3.0)
    start, end = widest_flat(x, np.full((2, 3), math.nan), 0.1)
    assert np.isnan(start).all()
    assert np.isnan(end).all()
    start, _ = widest_flat(x, np.array([[0.0, math.nan, 0.0]]), 0.1)
    assert np.isnan(start).all()


def test_straight_lines_are_those_of_least_squares(rng: np.random.Generator) -> None:
    x, y = np.arange(6.0), rng.normal(size=(3, 6))
    chosen = np.array([[1, 1, 1, 1, 1, 1], [0, 1, 0, 1, 1, 0], [0, 0, 1, 0, 0, 0]], bool)
    slope, at_zero = straight_line(x, y, chosen)
    for i in range(2):
        expected = np.polyfit(x[chosen[i]], y[i, chosen[i]], 1)
        np.testing.assert_allclose([slope[i], at_zero[i]], expected, rtol=1e-12)
    assert np.isnan(slope[2])
