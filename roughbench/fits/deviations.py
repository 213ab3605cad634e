"""How far a model is from the reference at single pressures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.fits.averages import Averages
from roughbench.fits.resampling import Estimate, estimate, n_random

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Deviations:
    """How far a model is from the reference in one quantity.

    Attributes
    ----------
    pressure : ndarray of float64, shape (P,)
        p/E*, ascending: those of the results.
    estimates : tuple of Estimate
        Model over reference, less 1, at each of them: -0.32 is 32 % too little. Infinite
        where the model alone is, or the reference alone is zero.
    """

    pressure: FloatArray
    estimates: tuple[Estimate, ...]


def deviations(one: Averages, reference: Averages) -> dict[str, Deviations]:
    """Return the deviations by quantity, of those that both give at the same pressures.

    They are those of the means over the realizations that ranges of agreement are found
    with, see :mod:`roughbench.fits.comparisons`.
    """
    if not np.array_equal(one.pressure, reference.pressure):
        return {}
    count = n_random(one.result, reference.result)
    return {
        name: Deviations(
            reference.pressure,
            tuple(
                estimate(column, count=count)
                for column in deviation(one.means[name], reference.means[name]).T
            ),
        )
        for name in one.given & reference.given
    }


def deviation(values: FloatArray, reference: FloatArray) -> FloatArray:
    """Return values over their reference, less 1; 0 where both are zero or both infinite.

    Parameters
    ----------
    values, reference : ndarray of float64, shape (B, P)
        Non-negative; may be inf; of one without randomness, B = 1.

    Examples
    --------
    >>> deviation(np.array([1.2, 0.0, np.inf, 3.0]), np.array([1.0, 0.0, 2.0, np.inf])).round(3)
    array([ 0.2,  0. ,  inf, -1. ])
    """
    values, reference = np.broadcast_arrays(values, reference)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = values / reference - 1.0
    return np.where(values == reference, 0.0, found)
