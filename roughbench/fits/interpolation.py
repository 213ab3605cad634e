"""Curves between the pressures of the results."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

FloatArray = NDArray[np.float64]


def separation_between(
    x: FloatArray, separation: FloatArray, stiffness: FloatArray, fine: FloatArray
) -> FloatArray:
    """Return ū between the pressures of the results, which may be half a decade apart.

    A cubic whose slopes are dū/d ln p = −p⟨1/K⟩; monotone where K is not given, and linear
    where ū is not everywhere.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        ln p, rising.
    separation : ndarray of float64, shape (P,)
        Length.
    stiffness : ndarray of float64, shape (P,)
        1/⟨1/K⟩, E*/length; inf in full contact, nan where it is not given.
    fine : ndarray of float64, shape (n,)
        ln p between the first and the last x.

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    if not np.isfinite(separation).all():
        return np.interp(fine, x, separation)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = -np.exp(x) / stiffness
    if np.isnan(slopes).any():
        return np.asarray(PchipInterpolator(x, separation)(fine))
    return np.asarray(CubicHermiteSpline(x, separation, slopes)(fine))
