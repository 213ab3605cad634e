"""How the pressure that leads to a given separation goes with the size of the cell."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roughbench.fits import MISSING, Estimate, n_random
from roughbench.fits.interpolation import separation_between
from roughbench.fits.resampling import (
    draw_counts,
    estimate,
    harmonic_means,
    resampled_means,
)
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]

STEPS = 64
"""Between two pressures of the results, where a curve is looked up."""


def size_exponent(
    series: Sequence[ModelResult],
    start: float,
    end: float,
    resamples: int,
) -> Estimate:
    """Return s of p ∼ L^s at the same mean separation.

    Parameters
    ----------
    series : sequence of ModelResult
        One model in cells of different ``length``, the first the smallest.
    start, end : float
        p/E*: where the exact solution in the smallest cell has K ∼ p. The separation that
        is compared is that of the series' first model at the pressure in the middle (of
        ln p).
    resamples : int

    Returns
    -------
    Estimate
        Least-squares slope of ln p over ln L; nan where a curve does not reach this
        separation, or the region does not exist.
    """
    if not (start > 0.0 and end > start):
        return MISSING
    middle = 0.5 * (math.log(start) + math.log(end))
    sizes = np.log([float(model.attributes["length"]) for model in series])
    places = []
    level = math.nan
    for model in series:
        counts = draw_counts(model.n_realizations, resamples, 0)
        means = resampled_means(model, "separation", counts)
        x = np.log(np.asarray(model["pressure"], float))
        stiffness = harmonic_means(model, "stiffness", counts)
        fine = np.interp(np.arange((x.size - 1) * STEPS + 1) / STEPS, np.arange(x.size), x)
        curves = [
            separation_between(x, mean, k, fine)
            for mean, k in zip(means, stiffness, strict=True)
        ]
        if math.isnan(level):
            level = float(np.interp(middle, fine, curves[0]))
        places.append(_pressure_at(fine, curves, level))
    count = max(len(place) for place in places)
    table = np.stack([np.broadcast_to(place, count) for place in places], axis=1)
    offset = sizes - sizes.mean()
    slopes = np.asarray(table @ offset / (offset @ offset))
    return estimate(slopes, count=n_random(*series))


def _pressure_at(x: FloatArray, curves: Sequence[FloatArray], level: float) -> FloatArray:
    """Return ln p at which each falling curve passes a level; nan where it does not."""
    place = np.full(len(curves), math.nan)
    for row, curve in enumerate(curves):
        if curve[-1] < level < curve[0]:
            place[row] = np.interp(-level, -curve, x)
    return place
