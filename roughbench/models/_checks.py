"""What the contenders check before they compute."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SolverError
from roughbench.inputs import check_heights, float_array, real_array, real_number
from roughbench.models.base import CompleteCurve, Status

FloatArray = NDArray[np.float64]


def checked_pressures(pressures: ArrayLike) -> FloatArray:
    """Return the nominal pressures p/E* as a 1D array.

    Raises
    ------
    SolverError
        If they are not a list of positive, finite numbers.
    """
    p = float_array(pressures, "pressures")
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


def checked_positive(value: float, name: str) -> float:
    """Return an option.

    Raises
    ------
    SolverError
        If it is not a positive, finite number.
    """
    number = real_number(value, name)
    if not 0.0 < number < math.inf:
        raise SolverError(f"{name} must be positive and finite, got {number}")
    return number


def checked_length(length: float) -> float:
    """Return the side of the cell; else as :func:`checked_positive`."""
    return checked_positive(length, "the length of the cell")


def checked_heights(heights: ArrayLike, fault: str) -> FloatArray:
    """Return heights of any shape in float64.

    Parameters
    ----------
    heights : array_like
        Length.
    fault : str
        What to say of heights that are not finite.

    Raises
    ------
    SolverError
        If they are masked, no real numbers, not finite, too large or small for float64, or
        stored too coarsely.
    """
    h = real_array(heights, "heights", kinds="buif")
    check_heights(h, fault)
    return h.astype(np.float64, copy=False)


def refuse_overflow(curve: CompleteCurve) -> CompleteCurve:
    """Return a curve, if its converged states are numbers; K may be infinite where all touches.

    Raises
    ------
    SolverError
        If a value has left the range of float64.
    """
    converged = curve.status == Status.CONVERGED
    for name in ("area", "separation", "energy", "stiffness"):
        bad = converged & ~np.isfinite(getattr(curve, name))
        if name == "stiffness":
            bad &= curve.area < 1.0
        if bad.any():
            raise SolverError(
                f"at p/E* = {curve.pressure[bad][0]:g} the {name} leaves the range of float64; "
                "choose another unit of length, in which heights and length are nearer to 1"
            )
    return curve
