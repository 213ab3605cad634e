"""Points that stand out of their neighbourhood, such as spikes of optical instruments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.scans.filling import fill_holes

FloatArray = NDArray[np.float64]

_REACH = 2
"""Points to either side that count as the neighbourhood, 5 × 5 points. At least nine of them
must stand out together before their median does."""

_ROWS = 64
_TO_SIGMA = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""


def find_outliers(heights: FloatArray, limit: float) -> tuple[NDArray[np.bool_], float]:
    """Find points further from the median of their neighbours than the others are.

    The neighbourhood is 5 × 5 points without the middle one; its median is taken as that of the
    medians of its five columns (P. M. Narendra, IEEE Trans. PAMI 3 (1981) 20). The distance is
    compared with 1.4826 times the median of all distances (MAD), which the outliers themselves
    hardly move. A slope does not count: neighbourhoods are symmetric about their point, as the
    heights go on beyond the border, turned about the last point but one, and those filled from
    the rim stand for what is missing. Outliers move the medians of their neighbours too:
    points that are as near as this to heights filled in for all suspects are left alone.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        nan where missing.
    limit : float
        In robust deviations. Without outliers the largest distance is 5 to 6 of them on white
        noise, and up to 11 on self-affine surfaces with 16 points per shortest wave (measured,
        512² points).

    Returns
    -------
    outliers : ndarray of bool, shape of heights
    deviation : float
        The robust one, in the unit of the heights.

    Raises
    ------
    SurfaceError
        If more than half of the points equal the median of their neighbours, as on coarse
        steps of height: then nothing tells what an outlier is. If there are fewer than five
        points along a side.

    Examples
    --------
    >>> heights = np.random.default_rng(1).normal(size=(16, 16))
    >>> heights[3, 5] = 40.0
    >>> np.argwhere(find_outliers(heights, 10.0)[0]).tolist()
    [[3, 5]]
    """
    if min(heights.shape) < 2 * _REACH + 1:
        raise SurfaceError(
            f"outliers: a neighbourhood has 5 × 5 points, and the scan {heights.shape[0]} × "
            f"{heights.shape[1]}; remove outliers: from the spec"
        )
    missing = np.isnan(heights)
    filled = heights
    if missing.any():
        filled = heights.copy()
        fill_holes(filled, (1.0, 1.0))
    distance = _distance_from_neighbours(filled)
    distance[missing] = np.nan
    known = distance[~missing]
    known.partition(known.size // 2)
    deviation = _TO_SIGMA * float(known[known.size // 2]) if known.size else 0.0
    if deviation == 0.0:
        raise SurfaceError(
            "outliers: more than half of the points are as high as the median of their "
            "neighbours, so that no deviation tells what stands out (are the heights in "
            "coarse steps?); remove outliers: from the spec"
        )
    limit *= deviation
    with np.errstate(invalid="ignore"):
        suspects = distance > limit
    if suspects.any():
        np.copyto(distance, heights)
        distance[suspects] = np.nan
        fill_holes(distance, (1.0, 1.0))
        suspects[suspects] = np.abs(heights[suspects] - distance[suspects]) > limit
    return suspects, deviation


def _distance_from_neighbours(heights: FloatArray) -> FloatArray:
    """|h − median of the neighbourhood|."""
    rows, columns = heights.shape
    side = 2 * _REACH + 1
    around = np.pad(heights, _REACH)
    for wide in (around[:, _REACH:-_REACH], around.T):
        for k in range(_REACH):
            wide[k] = 2.0 * wide[_REACH + 1] - wide[2 * _REACH + 2 - k]
            wide[-1 - k] = 2.0 * wide[-_REACH - 2] - wide[-2 * _REACH - 3 + k]
    distance = np.empty_like(heights)
    for first in range(0, rows, _ROWS):
        last = min(first + _ROWS, rows)
        lines = [around[first + k : last + k] for k in range(side)]
        of_columns = _median_of_five(lines)
        near = [of_columns[:, k : k + columns] for k in range(side)]
        del lines[_REACH]  # a point is no neighbour of its own
        near[_REACH] = _median_of_four([line[:, _REACH:-_REACH] for line in lines])
        median = _median_of_five(near)
        distance[first:last] = np.abs(heights[first:last] - median)
    return distance


def _median_of_four(values: list[FloatArray]) -> FloatArray:
    a, b, c, d = values
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    median: FloatArray = 0.5 * (low + high)
    return median


def _median_of_five(values: list[FloatArray]) -> FloatArray:
    a, b, c, d, e = values
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    median: FloatArray = np.maximum(np.minimum(low, high), np.minimum(np.maximum(low, high), e))
    return median
