"""The numbers that fields tell: exponents of spectra, distributions at different loads."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughbench.fits import MISSING, Estimate, n_random
from roughbench.fits.resampling import draw_counts, estimate
from roughbench.numbers import number
from roughbench.results import ModelResult
from roughbench.verdict.experiments import models_of
from roughbench.verdict.measures import (
    SMALL_AREA,
    SMALL_AREAS,
    Experiments,
    Kinds,
    Measure,
    Reading,
    reading,
)
from roughbench.verdict.rules import PowerLaw

FloatArray = NDArray[np.float64]

AREAS = (1e-3, 0.1)
"""A/A0 between which distributions are compared: where A ∼ p."""
APART = 3.0
"""So many times apart the pressures have to be."""


def spectrum_exponent(observable: str, law: PowerLaw) -> Measure:
    """Return the measure of a spectrum's exponent, where the exact area is nearest to 1 %."""
    name, what = f"{observable}_exponent", f"exponent, {law.text}"

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, _ in models_of(experiments, kinds):
            exact = experiment.exact
            if exact is None or f"{name}_mean" not in model or "hurst" not in model.attributes:
                continue
            k = _place_of_small_area(exact)
            if k is None or not np.array_equal(model["pressure"], exact["pressure"]):
                low, high = SMALL_AREAS
                why = f"no pressure has an exact A/A₀ between {low} and {high}"
                yield reading(experiment, model, what, MISSING, missing=why)
                continue
            mean, error = float(model[f"{name}_mean"][k]), float(model[f"{name}_sem"][k])
            count = n_random(model)
            estimate = Estimate(mean, error, mean - error, mean + error, 1.0, count=count)
            hurst = float(model.attributes["hurst"])
            expected, pressure = law.exponent(hurst), float(model["pressure"][k])
            note = f"{number(expected)} expected; at p = {number(pressure, 2)} E*"
            yield reading(experiment, model, what, estimate, note=note, hurst=hurst)

    return measure


def _place_of_small_area(exact: ModelResult) -> int | None:
    if "area_mean" not in exact:
        return None
    area = np.asarray(exact["area_mean"], float)
    close = (area >= SMALL_AREAS[0]) & (area <= SMALL_AREAS[1])
    if not close.any():
        return None
    distance = np.abs(np.log(np.where(close, area, math.nan) / SMALL_AREA))
    return int(np.nanargmin(distance))


def change_with_load(observable: str) -> Measure:
    """Return the measure of how much a distribution changes with the load.

    It is the largest difference of the cumulative distributions (Kolmogorov's distance, from 0
    to 1) at the lowest and at the highest of the pressures with A/A0 from 0.001 to 0.1.
    """
    what = f"distance of the {observable} at two loads"

    def measure(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
        for experiment, model, _ in models_of(experiments, kinds):
            if observable not in model or "area_mean" not in model:
                continue
            area, p = (np.asarray(model[name], float) for name in ("area_mean", "pressure"))
            chosen = np.flatnonzero((area >= AREAS[0]) & (area <= AREAS[1]))
            if chosen.size < 2 or p[chosen].max() < APART * p[chosen].min():
                why = f"no two pressures have A/A₀ from {AREAS[0]:g} to {AREAS[1]:g}"
                yield reading(experiment, model, what, MISSING, missing=why)
                continue
            low, high = (int(chosen[place(p[chosen])]) for place in (np.argmin, np.argmax))
            found = distance(model, observable, (low, high), resamples)
            note = f"at p = {number(p[low], 2)} and {number(p[high], 2)} E*"
            yield reading(experiment, model, what, found, note=note)

    return measure


def distance(
    model: ModelResult, observable: str, places: tuple[int, int], resamples: int
) -> Estimate:
    """Return Kolmogorov's distance of the distributions at two of the pressures."""
    counts = draw_counts(model.n_realizations, resamples, 0)
    values = np.asarray(model[observable], float)[:, list(places)]
    means = np.einsum("br,rpk->bpk", counts, np.nan_to_num(values))
    summed = np.cumsum(means, axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = summed / summed[:, :, -1:]
    found = np.abs(shares[:, 0] - shares[:, 1]).max(axis=1)
    return estimate(found, count=n_random(model))
