r"""Holes of a scan, filled by the smoothest surface that meets their rims.

A filled height is the mean of its neighbours, the discrete Laplace equation

.. math:: \sum_j w_{ij} (h_j - h_i) = 0,

with the weights dx/dy towards neighbouring rows and dy/dx towards neighbouring columns. At the
border of the scan nothing is known beyond it, and neighbours there are left out: no slope
across the border (Neumann), which is also what the mirrored scan has there. A cell that is
periodic goes on at its other side instead. No filled height is above or below all of its rim,
so that a hole never makes a new summit, and the slope within is too small: a filled hole is
smoother than what was lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.linalg import splu

from roughbench.errors import SurfaceError

FloatArray = NDArray[np.float64]

RESIDUAL = 1e-11
"""Most that a filled height may differ from the mean of its neighbours, over the range (highest
minus lowest) of the heights at the rims. Across a hole of n points the height itself may then
be off by n²/8 times as much, 3e-7 of the range for n = 500."""

_COARSEST = 1000
_DAMPING = 2.0 / 3.0
_MOST_ITERATIONS = 500


@dataclass(frozen=True, slots=True)
class Holes:
    """The missing points of a scan, in holes whose points are neighbours by their sides.

    Attributes
    ----------
    points : int
        Missing points.
    count : int
        Holes.
    largest : int
        Points of the largest one.
    place : (float, float)
        Row and column of the middle of the largest one.
    """

    points: int
    count: int
    largest: int
    place: tuple[float, float]


def find_holes(missing: NDArray[np.bool_]) -> Holes:
    """Count holes and find the largest.

    Examples
    --------
    >>> missing = np.zeros((4, 6), bool)
    >>> missing[0, 0] = missing[1:3, 3:6] = True
    >>> find_holes(missing)
    Holes(points=7, count=2, largest=6, place=(1.5, 4.0))
    """
    labels, count = ndimage.label(missing)
    if not count:
        return Holes(0, 0, 0, (0.0, 0.0))
    points = np.bincount(labels[missing])
    largest = int(points.argmax())
    rows, columns = np.nonzero(labels == largest)
    place = float(rows.mean()), float(columns.mean())
    return Holes(int(points.sum()), int(count), int(points[largest]), place)


def fill_holes(
    heights: FloatArray, spacing: tuple[float, float], *, periodic: bool = False
) -> None:
    """Fill what is missing, in place; see the head of this module.

    The equations are solved by conjugate gradients, preconditioned by one cycle of algebraic
    multigrid (smoothed aggregation of 3 × 3 points; P. Vaněk, J. Mandel and M. Brezina,
    Computing 56 (1996) 179), until :data:`RESIDUAL` is met.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        nan where missing; finite everywhere afterwards.
    spacing : (float, float)
        Distance between points along (y, x).
    periodic : bool
        Whether the scan goes on at its other side.

    Raises
    ------
    SurfaceError
        If every point is missing.

    Examples
    --------
    >>> heights = np.add.outer(np.arange(5.0), np.arange(5.0))
    >>> heights[1:4, 2] = np.nan
    >>> fill_holes(heights, (1.0, 1.0))
    >>> heights[1:4, 2].round(9).tolist()
    [3.0, 4.0, 5.0]
    """
    missing = np.isnan(heights)
    if missing.all():
        raise SurfaceError("every point of the scan is missing")
    if missing.any():
        matrix, rim, middle, spread = _equations(heights, missing, spacing, periodic=periodic)
        heights[missing] = middle + _solve(matrix, rim, missing, RESIDUAL * spread)


def _equations(
    heights: FloatArray,
    missing: NDArray[np.bool_],
    spacing: tuple[float, float],
    *,
    periodic: bool,
) -> tuple[Any, FloatArray, float, float]:
    """Return matrix and right-hand side, and middle and range of the heights at the rims.

    The right-hand side counts the heights from their middle, for the digits' sake.
    """
    rows, columns = heights.shape
    place = np.nonzero(missing)
    count = place[0].size
    number = np.full(heights.shape, -1, np.int32)
    number[missing] = np.arange(count, dtype=np.int32)
    diagonal, known, weights_known = np.zeros(count), np.zeros(count), np.zeros(count)
    low, high = np.inf, -np.inf
    entries: list[tuple[FloatArray, NDArray[Any], NDArray[Any]]] = []
    dy, dx = spacing
    for step, weight in (
        ((-1, 0), dx / dy),
        ((1, 0), dx / dy),
        ((0, -1), dy / dx),
        ((0, 1), dy / dx),
    ):
        row, column = place[0] + step[0], place[1] + step[1]
        there = np.ones(count, bool)
        if not periodic:
            there = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        row %= rows
        column %= columns
        other = number[row, column]
        diagonal += weight * there
        rim = np.flatnonzero(there & (other < 0))
        found = heights[row[rim], column[rim]]
        if found.size:
            low, high = min(low, float(found.min())), max(high, float(found.max()))
        known[rim] += weight * found
        weights_known[rim] += weight
        inner = np.flatnonzero(there & (other >= 0))
        entries.append((np.full(inner.size, -weight), inner.astype(np.int32), other[inner]))
    middle = 0.5 * (low + high)
    own = np.arange(count, dtype=np.int32)
    values, i, j = (
        np.concatenate(parts) for parts in zip((diagonal, own, own), *entries, strict=True)
    )
    matrix = sparse.csr_matrix((values, (i, j)), shape=(count, count))
    return matrix, known - weights_known * middle, middle, high - low


def _solve(
    matrix: Any, rim: FloatArray, missing: NDArray[np.bool_], tolerance: float
) -> FloatArray:
    """Solve by preconditioned conjugate gradients until |r_i| ≤ tolerance · a_ii everywhere."""
    diagonal = matrix.diagonal()
    precondition = _multigrid(matrix, *np.nonzero(missing))
    x = np.zeros_like(rim)
    for _ in range(_MOST_ITERATIONS):
        residual = rim - matrix @ x  # the true one: that of the recursion drifts from it
        if np.abs(residual / diagonal).max() <= tolerance:
            return x
        direction = z = precondition(residual)
        product = float(residual @ z)
        for _ in range(_MOST_ITERATIONS):
            image = matrix @ direction
            length = product / float(direction @ image)
            x += length * direction
            residual -= length * image
            if np.abs(residual / diagonal).max() <= 0.5 * tolerance:
                break
            z = precondition(residual)
            product, former = float(residual @ z), product
            direction = z + (product / former) * direction
    raise SurfaceError("the holes could not be filled: the equations do not converge")


def _multigrid(
    matrix: Any, rows: NDArray[Any], columns: NDArray[Any]
) -> Callable[[FloatArray], FloatArray]:
    """Return one symmetric V-cycle for the matrix, whose unknowns lie at rows and columns."""
    count = matrix.shape[0]
    if count <= _COARSEST:
        factors = splu(matrix.tocsc())
        return lambda right: factors.solve(right)
    damped = _DAMPING / matrix.diagonal()
    rows, columns = rows // 3, columns // 3
    blocks, block = np.unique(rows * (int(columns.max()) + 1) + columns, return_inverse=True)
    first = np.empty(blocks.size, np.int64)
    first[block] = np.arange(count)
    constant = sparse.csr_matrix(
        (np.ones(count), (np.arange(count, dtype=np.int32), block.astype(np.int32))),
        shape=(count, blocks.size),
    )
    prolong = (constant - sparse.diags(damped) @ (matrix @ constant)).tocsr()
    restrict = prolong.T.tocsr()
    coarse = _multigrid((restrict @ matrix @ prolong).tocsr(), rows[first], columns[first])

    def cycle(right: FloatArray) -> FloatArray:
        x = damped * right
        x += damped * (right - matrix @ x)
        x += prolong @ coarse(restrict @ (right - matrix @ x))
        x += damped * (right - matrix @ x)
        x += damped * (right - matrix @ x)
        return x

    return cycle
