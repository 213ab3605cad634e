"""Ranges of pressure on which a curve keeps to something, for many curves at once."""

from __future__ import annotations

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
    steps = zip(y[:, :-1].T, y[:, 1:].T, strict=True)
    return widest_run(x, (part_between(a, b, low, high) for a, b in steps), low.shape)


def widest_run(
    x: FloatArray, parts: Iterable[Part], shape: tuple[int, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return the widest interval that consists of parts of neighbouring steps.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        Ascending.
    parts : iterable of Part
        One for each of the P - 1 steps between them.
    shape : tuple of int
        Of the arrays in a part.

    Returns
    -------
    (ndarray of float64, ndarray of float64)
        Both ends, of this shape; nan where there is no such part.
    """
    best_start, best_end = np.full(shape, math.nan), np.full(shape, math.nan)
    best = np.full(shape, -1.0)
    start, running = np.zeros(shape), np.zeros(shape, bool)
    for left, right, (first, last, exists) in zip(x[:-1], x[1:], parts, strict=True):
        start = np.where(running & (first == 0.0), start, left + first * (right - left))
        end = left + last * (right - left)
        better = exists & (end - start > best)
        best = np.where(better, end - start, best)
        best_start = np.where(better, start, best_start)
        best_end = np.where(better, end, best_end)
        running = exists & (last == 1.0)
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
