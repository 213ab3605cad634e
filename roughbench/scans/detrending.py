r"""The plane or paraboloid through the heights of a scan, by least squares.

.. math:: \min_c \sum_{ij} \Big(h_{ij} - \sum_{a+b\le d} c_{ab} P_a(y_i) P_b(x_j)\Big)^2

over the points that are there, with Legendre's polynomials P of the coordinates from -1 to 1
between the outermost points: on a full scan the six of degree 2 (1, x, y, x², xy, y²) are
almost orthogonal, so that nothing is lost in the normal equations. Distances are measured along
z, as usual (the F-operation of ISO 25178-2).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError

FloatArray = NDArray[np.float64]
Detrend = Literal["none", "mean", "plane", "quadratic"]
DETREND: tuple[Detrend, ...] = get_args(Detrend)

_DEGREE = {"mean": 0, "plane": 1, "quadratic": 2}
_ROWS = 128
"""That are worked on at once: what is made on the way stays small."""


@dataclass(frozen=True, slots=True)
class Trend:
    """A polynomial of degree 0, 1 or 2 in y and x.

    Attributes
    ----------
    coefficients : ndarray of float64, shape (3, 3)
        c_ab of the head of this module, in the unit of the heights.
    shape : (int, int)
        Points along (y, x).
    spacing : (float, float)
        Between them along (y, x).
    """

    coefficients: FloatArray
    shape: tuple[int, int]
    spacing: tuple[float, float]

    @property
    def tilt(self) -> tuple[float, float]:
        """Slope along (y, x) in the middle of the scan."""
        half = [0.5 * (n - 1) * d for n, d in zip(self.shape, self.spacing, strict=True)]
        c = self.coefficients
        return float(c[1, 0] / half[0]), float(c[0, 1] / half[1])

    @property
    def sag(self) -> tuple[float, float]:
        """How far the border lies above the middle by the curvature along (y, x)."""
        return float(1.5 * self.coefficients[2, 0]), float(1.5 * self.coefficients[0, 2])

    def subtract_from(self, heights: FloatArray) -> None:
        """Subtract it, in place."""
        y, x = (_legendre(n) for n in self.shape)
        for rows in _blocks(self.shape[0]):
            heights[rows] -= (y[rows] @ self.coefficients) @ x.T


def fit_trend(
    heights: FloatArray,
    spacing: tuple[float, float],
    kind: Literal["mean", "plane", "quadratic"],
) -> Trend:
    """Fit a trend to the points that are there.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        nan where missing.
    spacing : (float, float)
        Between points along (y, x), in the unit of the heights.
    kind : {"mean", "plane", "quadratic"}

    Raises
    ------
    SurfaceError
        If too few points are there, or all of them on one line.

    Examples
    --------
    >>> y, x = np.mgrid[:5, :7]
    >>> tilt = fit_trend(4.0 + 0.1 * y - 0.2 * x, (0.5, 0.5), "plane").tilt
    >>> [round(slope, 12) for slope in tilt]
    [0.2, -0.4]
    """
    shape = heights.shape
    y, x = _legendre(shape[0]), _legendre(shape[1])
    degree = _DEGREE[kind]
    terms = [(a, b) for a in range(3) for b in range(3) if a + b <= degree]
    gram, middle = _gram(heights, y, x, terms)
    if not gram[0, 0] or np.linalg.cond(gram / gram[0, 0]) > _WORST_CONDITION:
        raise SurfaceError(
            f"a {kind} cannot be fitted to {int(gram[0, 0])} points that are there of "
            f"{heights.size}; say detrend: none, or crop the scan"
        )
    coefficients = np.zeros((3, 3))
    coefficients[0, 0] = middle
    for _ in range(2):  # the second time for the digits that a large mean or tilt takes
        moments = np.zeros((3, 3))
        for rows in _blocks(shape[0]):
            rest = heights[rows] - (y[rows] @ coefficients) @ x.T
            if np.isnan(rest.sum()):
                rest[np.isnan(rest)] = 0.0
            moments += (y[rows].T @ rest) @ x
        found = np.linalg.solve(gram, np.array([moments[term] for term in terms]))
        for term, value in zip(terms, found, strict=True):
            coefficients[term] += value
    return Trend(coefficients, (shape[0], shape[1]), spacing)


_WORST_CONDITION = 1e8
"""Of the normal equations: half of the digits are left, and the second fit brings the rest."""


def _gram(
    heights: FloatArray, y: FloatArray, x: FloatArray, terms: list[tuple[int, int]]
) -> tuple[FloatArray, float]:
    """Return the matrix of the normal equations, and any height that is there."""
    products_y = (y[:, :, None] * y[:, None, :]).reshape(-1, 9)
    products_x = (x[:, :, None] * x[:, None, :]).reshape(-1, 9)
    sums = np.zeros((9, 9))
    middle = 0.0
    for rows in _blocks(heights.shape[0]):
        missing = np.isnan(heights[rows])
        sums += np.outer(products_y[rows].sum(axis=0), products_x.sum(axis=0))
        if missing.any():
            sums -= (products_y[rows].T @ missing.astype(np.float64)) @ products_x
        if not middle and not missing.all():
            middle = float(heights[rows][~missing][0])
    gram = np.array([[sums[3 * a + c, 3 * b + d] for c, d in terms] for a, b in terms])
    return gram, middle


def _legendre(points: int) -> FloatArray:
    """P_0, P_1 and P_2 at equidistant points from -1 to 1; shape (points, 3)."""
    t = np.linspace(-1.0, 1.0, points) if points > 1 else np.zeros(1)
    return np.stack([np.ones(points), t, 1.5 * t * t - 0.5], axis=1)


def _blocks(rows: int) -> Iterator[slice]:
    return (slice(first, first + _ROWS) for first in range(0, rows, _ROWS))
