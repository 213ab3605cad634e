"""Ratios, differences and powers of estimates: both sides of their intervals, and bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.fits import MISSING, Estimate
from roughbench.verdict.combined import difference_of, power_of, ratio_of


def interval(value: float, low: float, high: float, bound: str = "", n: int = 8) -> Estimate:
    return Estimate(value, (high - low) / 2, low, high, 1.0, bound, n)


def bare(value: float, bound: str = "") -> Estimate:
    return Estimate(value, math.nan, math.nan, math.nan, 1.0, bound)


def test_each_side_comes_from_the_sides_that_lead_there() -> None:
    """2 (×1.5/1.1) over 4 (×2/1.05): up by 1.5 and 1.05, down by 1.1 and 2."""
    found = ratio_of(interval(2.0, 2.0 / 1.1, 3.0), interval(4.0, 4.0 / 1.05, 8.0, n=4))
    assert found.value == pytest.approx(0.5)
    assert found.high / 0.5 == pytest.approx(math.exp(math.hypot(*np.log([1.5, 1.05]))))
    assert 0.5 / found.low == pytest.approx(math.exp(math.hypot(*np.log([1.1, 2.0]))))
    assert found.count == 4
    less = difference_of(interval(5.0, 4.9, 7.0), interval(1.0, 0.5, 1.3))
    assert less.value == 4.0
    assert less.high == pytest.approx(4.0 + math.hypot(2.0, 0.5))
    assert less.low == pytest.approx(4.0 - math.hypot(0.1, 0.3))
    power = power_of([1.0, math.e], [interval(1.0, 1.0 / 1.2, 1.1), interval(1.0, 0.9, 2.0)])
    assert power.value == 0.0
    assert power.high == pytest.approx(math.hypot(*np.log([2.0, 1.2])))
    assert power.low == pytest.approx(-math.hypot(*np.log([1.0 / 0.9, 1.1])))


def test_what_has_no_error_adds_none() -> None:
    assert math.isnan(ratio_of(bare(2.0), bare(4.0)).error)
    found = ratio_of(interval(2.0, 1.0, 4.0), bare(4.0))
    assert [found.low, found.high] == pytest.approx([0.25, 1.0])
    unknown = Estimate(1.0, math.nan, math.nan, math.nan, 0.3, count=8)  # rarely exists
    assert math.isnan(ratio_of(interval(2.0, 1.0, 4.0), unknown).low)
    assert ratio_of(interval(0.5, -0.1, 1.0), bare(1.0)).low == 0.0


@pytest.mark.parametrize(
    ("above", "below", "bound"),
    [
        ("≥", "", "≥"),
        ("≤", "", "≤"),
        ("", "≥", "≤"),
        ("", "≤", "≥"),
        ("≥", "≤", "≥"),
        ("≤", "≥", "≤"),
    ],
)
def test_bounds_stay_bounds(above: str, below: str, bound: str) -> None:
    a, b = interval(2.0, 1.9, 2.1, above), interval(4.0, 3.9, 4.1, below)
    assert ratio_of(a, b).bound == bound
    assert difference_of(a, b).bound == bound
    assert power_of([1.0, 2.0], [b, a]).bound == bound


@pytest.mark.parametrize("bound", ["≤", "≥"])
def test_bounds_on_both_sides_leave_nothing(bound: str) -> None:
    a, b = interval(2.0, 1.9, 2.1, bound), interval(4.0, 3.9, 4.1, bound)
    for found in (ratio_of(a, b), difference_of(a, b), power_of([1.0, 2.0], [a, b])):
        assert math.isnan(found.value)


@pytest.mark.parametrize("other", [MISSING, bare(0.0), bare(math.inf), bare(-1.0)])
def test_what_is_not_there_has_no_ratio(other: Estimate) -> None:
    for pair in ((bare(1.0), other), (other, bare(1.0))):
        assert math.isnan(ratio_of(*pair).value)
        assert math.isnan(power_of([1.0, 2.0], pair).value)
