"""The averages of one model over its realizations, for all resamples at once."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from roughbench.fits.laws import AREA_TOLERANCE, STIFFNESS_TOLERANCE, proportional
from roughbench.fits.resampling import draw_counts, harmonic_means, n_random, resampled_means
from roughbench.quantities import QUANTITIES, compared
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]


class Averages:
    """The averages of a model; their first row is over all realizations.

    Attributes
    ----------
    result : ModelResult
        Without units: pressures are p/E*.
    count : int
        Of random realizations, see :func:`~roughbench.fits.resampling.n_random`.
    given : frozenset of str
        The quantities that the model gives.
    pressure : ndarray of float64, shape (P,)
    means : dict of str to ndarray of float64, shape (B, P)
        What :func:`~roughbench.fits.laws.fit_laws` takes; nan for what is not given.
    height : ndarray of float64, shape (B, 1)
        Realized rms height.
    """

    def __init__(self, result: ModelResult, resamples: int, seed: int) -> None:
        result = result.reduced()
        counts = draw_counts(result.n_realizations, resamples, seed)
        self.result = result
        self.count = n_random(result)
        self.given = frozenset(name for name in compared() if name in result)
        self.pressure = np.asarray(result["pressure"], float)
        self.means = {}
        for name, quantity in compared().items():
            self.means[name] = resampled_means(result, name, counts)
            if quantity.has_harmonic_mean:
                self.means[quantity.averaged] = harmonic_means(result, name, counts)
        heights = np.asarray(result["rms_height"], float)
        self.height = (counts @ heights / heights.size)[:, None]

    @functools.cached_property
    def linear(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Where area and stiffness are proportional to the pressure: ends in ln p, (B,)."""
        return {
            name: proportional(self.pressure, self.means[name], tolerance)
            for name, tolerance in (
                ("area", AREA_TOLERANCE),
                ("stiffness", STIFFNESS_TOLERANCE),
            )
        }

    def in_own_units(self, quantity: str) -> FloatArray:
        """Return a quantity with lengths in units of the realized rms height, (B, P).

        Of the stiffness this is the harmonic mean: a single closed line makes the mean of
        K infinite.
        """
        described = QUANTITIES[quantity]
        return np.asarray(self.means[described.averaged] / self.height**described.length)
