r"""The displacement of a half-space by a uniform pressure on one rectangle (Love, 1929).

A pressure p on a rectangle of the spacings Δ × aΔ around the origin makes the displacement

.. math:: u(x, y) = \frac{p}{\pi E^*}\int\!\!\int \frac{dx'\,dy'}{|r - r'|} .
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NEAR = 32.0
"""Distance, in the longer spacing, from which on the rectangle is integrated by Gauss's rule
with 3 × 3 points, good to 1e-11 there, instead of Love's difference of large numbers."""


def love_influence(size: tuple[int, int], aspect: float) -> FloatArray:
    r"""Displacement by a unit pressure on one rectangle, at offsets 0 … size − 1.

    Parameters
    ----------
    size : (int, int)
        Points along both axes.
    aspect : float
        Spacing along the second axis in that along the first, Δ.

    Returns
    -------
    ndarray of float64, shape ``size``
        u E*/(pΔ): 1/π times the integral of 1/r over the rectangle.
    """
    y, x = np.arange(size[0])[:, None], aspect * np.arange(size[1])
    nodes, weights = np.polynomial.legendre.leggauss(3)
    influence = np.zeros(size)
    for dy, wy in zip(nodes / 2, weights / 2, strict=True):
        for dx, wx in zip(aspect * nodes / 2, aspect * weights / 2, strict=True):
            influence += wy * wx / np.hypot(y + dy, x + dx) if dy or dx else 0.0
    centre = np.hypot(y, x)
    centre[0, 0] = 1.0
    influence += (weights[1] / 2) ** 2 * aspect / centre
    reach = NEAR * max(1.0, aspect)
    rows = min(math.ceil(reach), size[0])
    columns = min(math.ceil(reach / aspect), size[1])
    edges = np.arange(-0.5, rows)[:, None], aspect * np.arange(-0.5, columns)
    corners = _potential(*edges)
    influence[:rows, :columns] = np.diff(np.diff(corners, axis=0), axis=1)
    influence /= math.pi
    return influence


def _potential(y: FloatArray, x: FloatArray) -> FloatArray:
    """x asinh(y/|x|) + y asinh(x/|y|), whose mixed derivative is 1/r."""
    value: FloatArray = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    return value
