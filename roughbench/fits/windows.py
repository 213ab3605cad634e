"""Ranges of pressure on which a curve keeps to something, for many curves at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

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
    best_start, best_end = np.full(low.shape, math.nan), np.full(low.shape, math.nan)
    best = np.full(low.shape, -1.0)
    start, running = np.zeros(low.shape), np.zeros(low.shape, bool)
    for k in range(x.size - 1):
        first, last, known = _inside(y[:, k], y[:, k + 1], low, high)
        width = x[k + 1] - x[k]
        start = np.where(running & (first == 0.0), start, x[k] + first * width)
        end = x[k] + last * width
        better = known & (end - start > best)
        best = np.where(better, end - start, best)
        best_start = np.where(better, start, best_start)
        best_end = np.where(better, end, best_end)
        running = known & (last == 1.0)
    return best_start, best_end


def _inside(
    a: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Part of the way from a to b that lies between the levels, within 0 … 1."""
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
