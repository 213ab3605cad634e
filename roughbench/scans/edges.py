"""A scan made into one cell of a periodic surface; and how well its borders meet.

The models take heights as one cell of a periodic surface. A scan is none: its opposite borders
do not meet, and what stands there as a cliff counts as roughness. What can be done about it:

`mirror`
    The scan and its three reflections. Nothing is lost and nothing is made but a crease at the
    border; heights and slopes keep their distribution exactly. Four times the points.
`taper`
    The last eighth of the rows is faded into the first eighth, and the same for columns; the
    cell is smaller by the eighth. Only that strip changes.
`crop`
    The part of the scan whose opposite borders meet best. No height is changed, and what jump
    is left stays.
`periodic`
    The scan as it is.

A window (Hann's and its like), as for spectra, has no place here: it presses the heights to
their mean towards the borders, so that the contact gathers in the middle.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Edges = Literal["periodic", "mirror", "taper", "crop"]
EDGES: tuple[Edges, ...] = get_args(Edges)

STRIP = 1 / 8
"""Of each side: what `taper` blends, and what `crop` may cut at either border."""

_MOST_MISSING = 0.5
"""Share of a row or column at the border from which on `crop` cuts it off."""


def border_jump(heights: FloatArray, axis: int) -> tuple[float, float]:
    """Return the rms step across the border of the cell, and that between neighbours.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        Without missing points.
    axis : int
        Along which the cell is repeated.

    Examples
    --------
    >>> border_jump(np.array([0.0, 1.0, 2.0, 3.0]), 0)
    (3.0, 1.0)
    """
    h = np.moveaxis(heights, axis, 0)
    jump = math.sqrt(float(np.mean(np.square(h[0] - h[-1]))))
    squares, step = 0.0, 64
    for first in range(0, h.shape[0] - 1, step):
        squares += float(np.square(np.diff(h[first : first + step + 1], axis=0)).sum())
    pairs = (h.shape[0] - 1) * h[0].size
    return jump, math.sqrt(squares / pairs) if pairs else 0.0


def mirror(heights: FloatArray) -> FloatArray:
    """Return the scan and its three reflections, with every border point twice.

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)

    Returns
    -------
    ndarray of float64, shape (2n, 2m)

    Examples
    --------
    >>> mirror(np.array([[1.0, 2.0, 3.0]])).tolist()
    [[1.0, 2.0, 3.0, 3.0, 2.0, 1.0], [1.0, 2.0, 3.0, 3.0, 2.0, 1.0]]
    """
    rows, columns = heights.shape
    cell = np.empty((2 * rows, 2 * columns))
    cell[:rows, :columns] = heights
    cell[:rows, columns:] = heights[:, ::-1]
    cell[rows:] = cell[rows - 1 :: -1]
    return cell


def taper(heights: FloatArray) -> FloatArray:
    r"""Return a periodic cell: the last strip of each direction faded into the first.

    In a strip of w points, :math:`h_k = (a_k h_{n-w+k} + b_k h_k)/s_k` with
    :math:`a_k = \cos t_k, b_k = \sin t_k, t_k = π(k + ½)/2w`, so that it goes on from the
    last point of the cell at its one end and into the scan at the other. The scale
    :math:`s_k^2 = 1 + 2 a_k b_k ρ`, with the correlation ρ of the two strips, keeps the
    rms height across the strip (with a + b = 1 it would lose 30 % in the middle).

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)
        With zero mean.

    Returns
    -------
    ndarray of float64, shape (n - w, m - v)
        w and v are an eighth of n and m, at least 1.
    """
    for _ in range(2):  # rows, then columns: each turn ends transposed
        heights = _fade(heights).T
    return np.ascontiguousarray(heights)


def _fade(heights: FloatArray) -> FloatArray:
    rows = heights.shape[0]
    width = max(1, int(rows * STRIP))
    first, last = heights[:width], heights[rows - width :]
    power = float(np.vdot(first, first)) * float(np.vdot(last, last))
    correlation = float(np.vdot(first, last)) / math.sqrt(power) if power > 0.0 else 0.0
    t = 0.5 * math.pi * (np.arange(width) + 0.5)[:, None] / width
    a, b = np.cos(t), np.sin(t)
    scale = np.sqrt(np.maximum(1.0 + 2.0 * a * b * correlation, _LEAST_SCALE))
    cell = heights[: rows - width].copy()
    cell[:width] = (a * last + b * first) / scale
    return cell


_LEAST_SCALE = 0.25
"""Where the strips are each other's opposite, their mean is not blown up beyond twofold."""


def crop(heights: FloatArray) -> tuple[slice, slice]:
    """Find the part of the scan whose opposite borders meet best.

    Of all parts that leave out at most an eighth of the rows at either border: the one with
    the smallest rms step from its last row to its first. Then the same for the columns.

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)
        Without missing points.

    Returns
    -------
    (slice, slice)
        Rows and columns to keep.
    """
    rows = _best_part(heights)
    return rows, _best_part(np.ascontiguousarray(heights[rows].T))


def _best_part(heights: FloatArray) -> slice:
    count = heights.shape[0]
    most = int(count * STRIP) + 1
    low, high = heights[:most], heights[count - most :]
    steps = np.add.outer(np.square(low).sum(axis=1), np.square(high).sum(axis=1))
    steps -= 2.0 * low @ high.T
    first, last = np.unravel_index(int(np.argmin(steps)), steps.shape)
    return slice(int(first), count - most + int(last) + 1)


def without_missing_border(heights: FloatArray) -> tuple[slice, slice]:
    """Find the part that is left when rows and columns at the border are cut off.

    One after the other, the one with most missing points first, as long as it misses more
    than half of them.

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)
        nan where missing.

    Examples
    --------
    >>> heights = np.zeros((4, 6))
    >>> heights[:, 5] = heights[0] = np.nan
    >>> without_missing_border(heights)
    (slice(1, 4, None), slice(0, 5, None))
    """
    missing = np.isnan(heights)
    counts = [missing.sum(axis=1), missing.sum(axis=0)]
    ends = [[0, missing.shape[0]], [0, missing.shape[1]]]
    while all(low < high for low, high in ends):
        shares = {
            (axis, side): counts[axis][ends[axis][0] if side == 0 else ends[axis][1] - 1]
            / (ends[1 - axis][1] - ends[1 - axis][0])
            for axis in (0, 1)
            for side in (0, 1)
        }
        axis, side = max(shares, key=lambda place: float(shares[place]))
        if shares[axis, side] <= _MOST_MISSING:
            break
        line = ends[axis][0] if side == 0 else ends[axis][1] - 1
        counts[1 - axis] = counts[1 - axis] - (missing[line] if axis == 0 else missing[:, line])
        ends[axis][side] += 1 if side == 0 else -1
    return slice(*ends[0]), slice(*ends[1])
