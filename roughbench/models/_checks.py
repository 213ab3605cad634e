"""What the contenders check before they compute."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SolverError

FloatArray = NDArray[np.float64]


def checked_pressures(pressures: ArrayLike) -> FloatArray:
    """Return the nominal pressures p/E* as a 1D array.

    Raises
    ------
    SolverError
        If they are not a list of positive, finite numbers.
    """
    p = np.asarray(pressures, float)
    if p.ndim != 1:
        raise SolverError(
            f"pressures must be a list of numbers, got an array of shape {p.shape}"
        )
    bad = np.flatnonzero(~((p > 0.0) & (p < math.inf)))
    if bad.size:
        raise SolverError(
            "pressures must be positive and finite (at p = 0 the bodies only touch), "
            f"got {p[bad[0]]} at index {bad[0]}"
        )
    return p


def checked_length(length: float) -> float:
    """Return the side of the cell.

    Raises
    ------
    SolverError
        If it is not a positive, finite number.
    """
    if not 0.0 < length < math.inf:
        raise SolverError(f"the length of the cell must be positive and finite, got {length}")
    return float(length)
