"""Sq and Sdq of a scan at any stage of its preparation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROWS = 64
"""That are worked on at once: what is made on the way stays small."""


def rms_height_and_gradient(
    heights: FloatArray, spacing: tuple[float, float], *, periodic: bool
) -> tuple[float, float]:
    r"""Return Sq and Sdq (ISO 25178-2), by differences of neighbouring points.

    .. math:: S_q^2 = \langle (h - \langle h\rangle)^2\rangle,\quad
              S_{dq}^2 = \Big\langle \frac{(h_{i+1,j} - h_{ij})^2}{d_y^2}
                                   + \frac{(h_{i,j+1} - h_{ij})^2}{d_x^2} \Big\rangle

    over the points, in Sdq those whose two neighbours are there as well; with the
    neighbours at the other side of the cell if it is periodic.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        nan where missing.
    spacing : (float, float)
        Between points along (y, x), in the unit of the heights.
    periodic : bool

    Returns
    -------
    (float, float)
        In the unit of the heights, and a number; nan where no point is left.

    Examples
    --------
    >>> rms_height_and_gradient(np.array([[0.0, 3.0], [4.0, 7.0]]), (1.0, 1.0), periodic=False)
    (2.5, 5.0)
    """
    rows = heights.shape[0]
    total = squares = slopes = 0.0
    count = pairs = 0
    middle = 0.0
    for first in range(0, rows, _ROWS):
        block = heights[first : first + _ROWS + 1]
        if periodic and first + _ROWS >= rows:
            block = np.concatenate([heights[first:], heights[:1]])
        dy = np.diff(block, axis=0) / spacing[0]
        dx = _differences(block[: dy.shape[0]], periodic=periodic) / spacing[1]
        gradient = np.square(dx, out=dx)
        gradient += np.square(dy, out=dy)[:, : dx.shape[1]]
        own = heights[first : first + _ROWS]
        known, number = _sum_of_known(gradient)
        slopes, pairs = slopes + known, pairs + number
        if not middle:  # any height: the digits that a large mean takes
            there = own[np.isfinite(own)]
            middle = float(there[0]) if there.size else 0.0
        rest = own - middle
        known, number = _sum_of_known(rest)
        total, count = total + known, count + number
        squares += _sum_of_known(np.square(rest, out=rest))[0]
    if not count or not pairs:
        return math.nan, math.nan
    variance = squares / count - (total / count) ** 2
    return math.sqrt(max(variance, 0.0)), math.sqrt(slopes / pairs)


def _differences(block: FloatArray, *, periodic: bool) -> FloatArray:
    """To the next column; of the last one to the first, or not at all."""
    if not periodic:
        return np.diff(block, axis=1)
    found = np.empty_like(block)
    np.subtract(block[:, 1:], block[:, :-1], out=found[:, :-1])
    np.subtract(block[:, 0], block[:, -1], out=found[:, -1])
    return found


def _sum_of_known(values: FloatArray) -> tuple[float, int]:
    """Sum and number of what is not nan."""
    total = float(values.sum())
    if not math.isnan(total):
        return total, values.size
    known = np.isfinite(values)
    return float(values[known].sum()), int(np.count_nonzero(known))
