"""Sq and Sdq, at any stage of a scan's preparation: one rule, with missing points too."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_BLOCK = 1 << 18
"""Points worked on at once: what is made on the way stays small."""

NO_SLOPE = "so many points are missing that nowhere enough neighbours are left for a slope"


@dataclass(frozen=True, slots=True)
class Spread:
    """How heights lie, wherever they stand; nan where no point is left.

    Attributes
    ----------
    count : int
        Points that are not missing.
    mean, lowest, highest, rms : float
        The last about the mean: Sq.
    """

    count: int
    mean: float
    lowest: float
    highest: float
    rms: float


def blocks(rows: int, columns: int) -> Iterator[tuple[int, int]]:
    """Cut rows into blocks that stay in the cache."""
    step = max(1, _BLOCK // columns)
    for start in range(0, rows, step):
        yield start, min(start + step, rows)


def spread(heights: FloatArray) -> Spread:
    r"""Return :math:`S_q = \sqrt{\langle(h - \langle h\rangle)^2\rangle}` and what it takes.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        nan where missing.
    """
    count, total, highest, lowest = 0, 0.0, -math.inf, math.inf
    for start, stop in blocks(*heights.shape):
        z = _measured(heights[start:stop])
        if z.size:
            count += z.size
            total += float(z.sum())
            highest, lowest = max(highest, float(z.max())), min(lowest, float(z.min()))
    if not count:
        return Spread(0, *(math.nan,) * 4)
    mean, width = total / count, highest - lowest
    if not width:
        return Spread(count, mean, lowest, highest, 0.0)
    first = second = 0.0
    for start, stop in blocks(*heights.shape):
        z = (_measured(heights[start:stop]) - mean) / width  # so that no square overflows
        first += float(z.sum())
        second += float((z * z).sum())
    rest = first / count  # of the mean, which was rounded
    variance = max(second / count - rest**2, 0.0)
    return Spread(count, mean + rest * width, lowest, highest, math.sqrt(variance) * width)


def mean_square_slopes(
    heights: FloatArray, spacing: tuple[float, float], *, periodic: bool
) -> tuple[float, float]:
    r"""Return the parts of Sdq² along (y, x), by differences of neighbouring points.

    .. math:: S_{dq}^2 = \Big\langle \frac{(h_{i+1,j} - h_{ij})^2}{d_y^2}\Big\rangle
                       + \Big\langle \frac{(h_{i,j+1} - h_{ij})^2}{d_x^2} \Big\rangle

    over the places that have both neighbours, with those at the other side of the cell if it
    is periodic; and, where points are missing, none within two steps along either axis,
    counted around the border: what stands at the rim of a hole is measured worst. This is
    the rule of SurfaceTopography's ``rms_gradient``, up to its rounding.

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
        nan where no place is left.
    """
    rows, columns = heights.shape
    dy, dx = spacing
    whole = bool(np.isfinite(heights).all())
    places = 0
    square_y = square_x = 0.0
    for start, stop in blocks(rows if periodic else rows - 1, columns):
        part = heights[start : stop + 1]
        if periodic and stop == rows:
            part = np.concatenate([part, heights[:1]])
        y, x = np.diff(part, axis=0) / dy, _along_x(part[:-1], periodic=periodic) / dx
        if not periodic:
            y = y[:, :-1]
        if not whole:
            clear = _clear_of_holes(heights, start, stop)[:, : y.shape[1]]
            y, x = y[clear], x[clear]
        places += y.size
        square_y += float(np.sum(y * y))
        square_x += float(np.sum(x * x))
    if not places:
        return math.nan, math.nan
    return square_y / places, square_x / places


def rms_height_and_gradient(
    heights: FloatArray, spacing: tuple[float, float], *, periodic: bool
) -> tuple[float, float]:
    """Return Sq and Sdq (ISO 25178-2); for the arguments see :func:`mean_square_slopes`.

    Returns
    -------
    (float, float)
        In the unit of the heights, and a number; nan where no point, or no place for a slope,
        is left.

    Examples
    --------
    >>> rms_height_and_gradient(np.array([[0.0, 3.0], [4.0, 7.0]]), (1.0, 1.0), periodic=False)
    (2.5, 5.0)
    """
    return (
        spread(heights).rms,
        math.sqrt(sum(mean_square_slopes(heights, spacing, periodic=periodic))),
    )


def _measured(z: FloatArray) -> FloatArray:
    return z[np.isfinite(z)]


def _along_x(block: FloatArray, *, periodic: bool) -> FloatArray:
    """To the next column; of the last one to the first, or not at all."""
    if not periodic:
        return np.diff(block, axis=1)
    found = np.empty_like(block)
    np.subtract(block[:, 1:], block[:, :-1], out=found[:, :-1])
    np.subtract(block[:, 0], block[:, -1], out=found[:, -1])
    return found


def _clear_of_holes(h: FloatArray, start: int, stop: int) -> NDArray[np.bool_]:
    """Return the places of these rows whose differences count."""
    rows = np.arange(start, stop + 2) % h.shape[0]
    measured = np.isfinite(h[rows])
    clear = measured[:-2].copy()
    for down, right in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
        shifted = measured[down : down + stop - start]
        clear &= np.roll(shifted, -right, axis=1) if right else shifted
    return clear
