"""Estimates made of others: ratios, differences and powers, with both sides of their intervals.

The errors of the parts are taken as independent, and each side of an interval comes from the
sides of the parts that lead there. A part that is a bound makes a bound of the whole; parts
that bound it on both sides leave nothing known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from roughbench.fits import MISSING, Estimate

_OTHER = {"≥": "≤", "≤": "≥", "": ""}


def ratio_of(a: Estimate, b: Estimate) -> Estimate:
    """Return a/b of two positive estimates.

    Examples
    --------
    >>> half = Estimate(1.0, 0.1, 0.9, 1.1, 1.0, count=4)
    >>> third = Estimate(3.0, math.nan, math.nan, math.nan, 1.0, "≤")
    >>> found = ratio_of(half, third)
    >>> round(found.value, 3), found.bound, found.count
    (0.333, '≥', 4)
    """
    return _exponential(_sum([1.0, -1.0], [_logarithm(a), _logarithm(b)]))


def difference_of(a: Estimate, b: Estimate) -> Estimate:
    """Return a - b of two estimates."""
    return _sum([1.0, -1.0], [a, b])


def power_of(x: Sequence[float], y: Sequence[Estimate]) -> Estimate:
    """Return the slope of ln y over ln x by least squares.

    Examples
    --------
    >>> exact = [Estimate(v, math.nan, math.nan, math.nan, 1.0) for v in (1.0, 4.0, 16.0)]
    >>> round(power_of([1.0, 2.0, 4.0], exact).value, 9)
    2.0
    """
    offset = np.log(x) - np.mean(np.log(x))
    weights = offset / (offset @ offset)
    return _sum(weights.tolist(), [_logarithm(one) for one in y])


def _sum(weights: Sequence[float], parts: Sequence[Estimate]) -> Estimate:
    """Return a weighted sum."""
    if not all(math.isfinite(one.value) for one in parts):
        return MISSING
    turned = [
        (abs(w), one if w > 0 else _negative(one))
        for w, one in zip(weights, parts, strict=True)
    ]
    bounds = {one.bound for w, one in turned if w and one.bound}
    if len(bounds) > 1:
        return MISSING
    value = sum(w * one.value for w, one in turned)
    count = min((one.count for one in parts if one.count), default=0)
    down = up = math.nan
    if count:
        random = [(w, one) for w, one in turned if one.count]
        down = math.hypot(*(w * max(one.value - one.low, 0.0) for w, one in random))
        up = math.hypot(*(w * max(one.high - one.value, 0.0) for w, one in random))
    share = min(one.share for one in parts)
    return Estimate(
        value, 0.5 * (down + up), value - down, value + up, share, next(iter(bounds), ""), count
    )


def _negative(one: Estimate) -> Estimate:
    return Estimate(
        -one.value, one.error, -one.high, -one.low, one.share, _OTHER[one.bound], one.count
    )


def _logarithm(one: Estimate) -> Estimate:
    if not (one.value > 0.0 and math.isfinite(one.value)):
        return MISSING
    value = math.log(one.value)
    low = math.log(one.low) if one.low > 0.0 else -math.inf
    low = math.nan if math.isnan(one.low) else low
    high = math.nan if math.isnan(one.high) else math.log(max(one.high, one.value))
    return Estimate(value, one.error / one.value, low, high, one.share, one.bound, one.count)


def _exponential(one: Estimate) -> Estimate:
    if math.isnan(one.value):
        return one
    value, low, high = (math.exp(x) for x in (one.value, one.low, one.high))
    return Estimate(value, 0.5 * (high - low), low, high, one.share, one.bound, one.count)
