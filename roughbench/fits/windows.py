"""Ranges of pressure on which a curve keeps to something, for many curves at once."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Part = tuple[FloatArray, FloatArray, NDArray[np.bool_]]
"""Where a part of a step begins and ends, from 0 to 1, and whether there is one."""

_SLACK = 1e-12
"""A band forgives its own rounding."""


def widest_between(
    x: FloatArray, y: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the widest interval on which each curve lies between two levels.

    Between its points a curve is linear; where it is not finite it lies outside.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        Ascending.
    y : ndarray of float64, shape (B, P)
        One curve a row.
    low, high : ndarray of float64, shape (…, B)
        The levels of each curve; several for each, along the axes before the last.

    Returns
    -------
    (ndarray of float64, ndarray of float64), shape (…, B)
        Both ends; nan where a curve is nowhere between them.

    Examples
    --------
    >>> x, y = np.array([0.0, 1.0, 2.0, 3.0]), np.array([[0.0, 2.0, 2.0, 4.0]])
    >>> start, end = widest_between(x, y, np.array([1.0]), np.array([3.0]))
    >>> float(start[0]), float(end[0])
    (0.5, 2.5)
    """
    if not x.size:
        return np.full(low.shape, math.nan), np.full(low.shape, math.nan)
    columns = np.ascontiguousarray(y.T)
    levels = [np.ascontiguousarray(level).reshape(-1, len(y)) for level in (low, high)]
    longest = _Longest(low.size)
    running, start, end = np.zeros(low.size, bool), np.zeros(low.size), 0.0
    side = _Sides(columns[0], *levels)
    for k, (left, right) in enumerate(itertools.pairwise(x)):
        before, side = side, _Sides(columns[k + 1], *levels)
        touched = ~((before.below & side.below) | (before.above & side.above))
        touched &= before.finite & side.finite
        whole = touched & before.inside & side.inside
        part, whole = np.flatnonzero(touched & ~whole), whole.reshape(-1)
        over = np.flatnonzero(running & ~whole)
        longest.offer(over, start[over], end)
        # Arithmetic only where a curve passes a level; most steps are all inside or outside.
        row = part % len(y)
        low_here, high_here = (level.reshape(-1)[part] for level in levels)
        first, last, exists = part_between(
            columns[k, row], columns[k + 1, row], low_here, high_here
        )
        part, first, last = part[exists], first[exists], last[exists]
        begin = left + first * (right - left)
        begin = np.where(running[part] & (first == 0.0), start[part], begin)
        longest.offer(part, begin, left + last * (right - left))
        start[whole & ~running] = left
        start[part] = begin
        running, end = whole, left + 1.0 * (right - left)
        running[part] = last == 1.0
    over = np.flatnonzero(running)
    longest.offer(over, start[over], end)
    return longest.start.reshape(low.shape), longest.end.reshape(low.shape)


class _Sides:
    """On which side of its levels each curve is at one place."""

    def __init__(self, y: FloatArray, low: FloatArray, high: FloatArray) -> None:
        self.finite = np.isfinite(y)
        with np.errstate(invalid="ignore"):
            self.below, self.above = y < low, y > high
        self.inside = ~(self.below | self.above)


class _Longest:
    """The longest of the intervals that were offered for each curve; nan before the first."""

    def __init__(self, size: int) -> None:
        self.start, self.end = np.full(size, math.nan), np.full(size, math.nan)
        self._width = np.full(size, -1.0)

    def offer(self, at: NDArray[np.intp], start: FloatArray, end: FloatArray | float) -> None:
        """Take the intervals, of these curves, that are longer."""
        width = end - start
        longer = width > self._width[at]
        at = at[longer]
        self._width[at], self.start[at] = width[longer], start[longer]
        self.end[at] = np.broadcast_to(end, width.shape)[longer]


def widest_run(x: FloatArray, parts: Iterable[Part]) -> tuple[float, float]:
    """Return the widest interval that consists of parts of neighbouring steps of a curve.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        Ascending.
    parts : iterable of Part
        One for each of the P - 1 steps between them.

    Returns
    -------
    (float, float)
        Both ends; nan where there is no such part.
    """
    best, best_start, best_end = -1.0, math.nan, math.nan
    start, running = 0.0, False
    for (left, right), (first, last, exists) in zip(itertools.pairwise(x), parts, strict=True):
        if not (running and first == 0.0):
            start = left + first.item() * (right - left)
        end = left + last.item() * (right - left)
        if exists and end - start > best:
            best, best_start, best_end = end - start, start, end
        running = bool(exists and last == 1.0)
    return best_start, best_end


def part_between(a: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray) -> Part:
    """Return the part of the straight way from a to b that lies between two levels."""
    known = np.isfinite(a) & np.isfinite(b)
    a, b = np.where(known, a, 0.0), np.where(known, b, 0.0)
    rise = np.where(a == b, 1.0, b - a)
    with np.errstate(over="ignore"):
        at_low, at_high = (low - a) / rise, (high - a) / rise
    first = np.maximum(np.minimum(at_low, at_high), 0.0)
    last = np.minimum(np.maximum(at_low, at_high), 1.0)
    flat = a == b
    first, last = np.where(flat, 0.0, first), np.where(flat, 1.0, last)
    between = np.where(flat, (low <= a) & (a <= high), first < last)
    return first, last, known & between


def widest_flat(
    x: FloatArray, y: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Return the widest interval on which e^y stays within ± ``tolerance`` of one value.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        Ascending.
    y : ndarray of float64, shape (B, P)
        Logarithms; one curve a row.
    tolerance : float
        0 < tolerance < 1.

    Returns
    -------
    (ndarray of float64, ndarray of float64), shape (B,)
        Both ends; nan where a curve is finite at no two neighbouring points.

    Notes
    -----
    The best band touches the curve at one of its corners at least, from above or from
    below, so trying all of them finds it.
    """
    band = math.log((1.0 + tolerance) / (1.0 - tolerance))
    corner = np.where(np.isfinite(y), y, math.inf).T
    with np.errstate(invalid="ignore"):
        low = np.stack([corner, corner - band], axis=1).reshape(-1, y.shape[0])
        starts, ends = widest_between(x, y, low - _SLACK, low + band + _SLACK)
        best_start, best_end = np.full(y.shape[0], math.nan), np.full(y.shape[0], math.nan)
        best = np.full(y.shape[0], -1.0)
        for start, end in zip(starts, ends, strict=True):
            better = end - start > best * (1.0 + 1e-12)  # by rounding alone none is longer
            best = np.where(better, end - start, best)
            best_start = np.where(better, start, best_start)
            best_end = np.where(better, end, best_end)
    return best_start, best_end


def straight_line(
    x: FloatArray, y: FloatArray, chosen: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return slope and value at x = 0 of the least-squares line through chosen points.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
    y : ndarray of float64, shape (B, P)
    chosen : ndarray of bool, shape (B, P)

    Returns
    -------
    (ndarray of float64, ndarray of float64), shape (B,)
        nan where fewer than two points are chosen.
    """
    weight = chosen.astype(float)
    value = np.where(chosen, y, 0.0)
    number = weight.sum(axis=1)
    enough = number >= 2
    number = np.where(enough, number, math.nan)
    mean_x, mean_y = weight @ x / number, value.sum(axis=1) / number
    dx = np.where(chosen, x - mean_x[:, None], 0.0)
    spread = np.where(enough, (dx * dx).sum(axis=1), math.nan)
    slope = (dx * value).sum(axis=1) / spread
    return slope, mean_y - slope * mean_x
