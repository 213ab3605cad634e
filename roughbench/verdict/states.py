"""The numbers that states of single experiments tell: energy, scatter, ranges, the onset."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughbench.fits import MISSING, Estimate
from roughbench.fits.averages import Averages
from roughbench.fits.drift import least_drift
from roughbench.fits.laws import inside
from roughbench.fits.resampling import draw_counts, estimate, n_random, resampled_means
from roughbench.fits.windows import straight_line
from roughbench.numbers import number
from roughbench.results import ModelResult
from roughbench.verdict.combined import ratio_of
from roughbench.verdict.experiments import models_of
from roughbench.verdict.measures import (
    Experiments,
    Kinds,
    Measure,
    Reading,
    pressure_words,
    reading,
)
from roughbench.verdict.onset import onset, theory_of
from roughbench.verdict.rules import PowerLaw

FloatArray = NDArray[np.float64]

STIFF = 1.0
"""K h_rms/E* by whose pressure models are told apart that diverge: far above K ∼ p."""
_ENERGY_DECADES = 2
_NO_START = "the region K ∼ p begins at the lowest pressure, or there is none"
_LOWER = "a spec with bem at lower pressures"


def energy_drift(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure by which factor U/p changes over two decades where it changes least."""
    for experiment, model, _ in models_of(experiments, kinds):
        if "energy" in model:
            x, rate = _energy_rate(model, resamples)
            found = estimate(least_drift(x, rate, _ENERGY_DECADES), count=n_random(model))
            yield reading(experiment, model, "drift of U/p over 2 decades", found)


def energy_height(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure U/(p h_rms), with the realized h_rms, where K ∼ p."""
    for experiment, model, fits in models_of(experiments, kinds):
        if "energy" in model and "log_from" in fits:
            x, rate = _energy_rate(model, resamples)
            heights = Averages(model, resamples, 0).height
            rate = rate - np.log(heights)
            found = estimate(np.exp(_mean_in(x, rate, fits)), count=n_random(model))
            chosen = np.exp(rate[0][np.isfinite(rate[0])])
            note = f"{chosen.min():.2g} to {chosen.max():.2g} over all pressures"
            yield reading(experiment, model, "U/(p h_rms) where K ∼ p", found, note=note)


def energy_over_u0(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure U/p over the u₀ of ū = u₀ ln(p₀/p), both where K ∼ p."""
    for experiment, model, fits in models_of(experiments, kinds):
        if "energy" in model and "u0" in fits:
            x, rate = _energy_rate(model, resamples)
            energy = estimate(np.exp(_mean_in(x, rate, fits)), count=n_random(model))
            yield reading(experiment, model, "U/(p u₀)", ratio_of(energy, fits["u0"]))


def _energy_rate(model: ModelResult, resamples: int) -> tuple[FloatArray, FloatArray]:
    """Return ln p and ln(U/p), (P,) and (B, P)."""
    counts = draw_counts(model.n_realizations, resamples, 0)
    pressure = np.asarray(model["pressure"], float)
    energy = resampled_means(model, "energy", counts)
    known = np.isfinite(energy) & (energy > 0.0)
    return np.log(pressure), np.where(
        known, np.log(np.where(known, energy, 1.0) / pressure), math.nan
    )


def _mean_in(x: FloatArray, rate: FloatArray, fits: dict[str, Estimate] | object) -> FloatArray:
    """Return the mean of a logarithm where K ∼ p; nan where there is no such region."""
    ends = (math.log(fits[f"log_{side}"].value) for side in ("from", "to"))  # type: ignore[index]
    start, end = ends
    if math.isnan(start):
        return np.full(len(rate), math.nan)
    chosen = inside(x, np.full(1, start), np.full(1, end))[0]
    return np.asarray(rate[:, chosen].mean(axis=1))


def same_range(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure the part of the region K ∼ p, in ln p, in which A ∼ p as well."""
    for experiment, model, _ in models_of(experiments, kinds):
        if "area" not in model or "stiffness" not in model:
            continue
        linear = Averages(model, resamples, 0).linear
        (a, b), (start, end) = linear["area"], linear["stiffness"]
        with np.errstate(invalid="ignore"):
            common = np.maximum(np.minimum(b, end) - np.maximum(a, start), 0.0)
            share = common / (end - start)
        found = estimate(share, count=n_random(model))
        yield reading(experiment, model, "part of K ∼ p with A ∼ p", found)


def area_before_stiffness(
    experiments: Experiments, kinds: Kinds, _resamples: int
) -> Iterator[Reading]:
    """Measure where A ∼ p begins over where K ∼ p does."""
    what = "start of A ∼ p over that of K ∼ p"
    for experiment, model, fits in models_of(experiments, kinds):
        if "area" in model and "stiffness" in model:
            area, stiffness = (fits[f"{name}_from"] for name in ("kappa", "log"))
            found = MISSING if stiffness.is_bound else ratio_of(area, stiffness)
            words = f"{pressure_words(area)} and {pressure_words(stiffness)}"
            more = {"note": words, "missing": _NO_START, "remedy": _LOWER}
            yield reading(experiment, model, what, found, **more)


def scatter_of(model: ModelResult, name: str, counts: FloatArray) -> FloatArray:
    """Return the relative scatter of a quantity between realizations, for each resample.

    Returns
    -------
    ndarray of float64, shape (B, P)
        Standard deviation over mean; nan where a value is infinite.
    """
    values = np.where(np.isfinite(model[name]), model[name], math.nan)
    number = counts.sum(axis=1)[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = counts @ values / number
        variance = np.maximum(counts @ values**2 / number - mean**2, 0.0)
        return np.asarray(np.sqrt(variance * number / (number - 1.0)) / mean)


def fluctuations(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure how much more K scatters at the lowest pressure than in the region K ∼ p."""
    what = "scatter of K between surfaces, lowest p over K ∼ p"
    for experiment, model, fits in models_of(experiments, kinds):
        if "stiffness" not in model or not model.is_random or model.n_realizations < 3:
            continue
        start, end = (fits[f"log_{side}"] for side in ("from", "to"))
        if start.is_bound or not math.isfinite(start.value):
            yield reading(experiment, model, what, MISSING, missing=_NO_START, remedy=_LOWER)
            continue
        counts = draw_counts(model.n_realizations, resamples, 0)
        scatter = scatter_of(model, "stiffness", counts)
        p = np.asarray(model["pressure"], float)
        first = int(np.argmin(p))
        middle = int(np.argmin(np.abs(np.log(p / math.sqrt(start.value * end.value)))))
        with np.errstate(invalid="ignore", divide="ignore"):
            found = estimate(scatter[:, first] / scatter[:, middle], count=n_random(model))
        note = "; ".join(
            f"{100 * scatter[0, k]:.2g} % at p = {p[k]:.2g} E*" for k in (first, middle)
        )
        yield reading(experiment, model, what, found, note=note)


def divergence(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure how much earlier K of a model diverges than the exact one."""
    for experiment, model, _ in models_of(experiments, kinds):
        exact = experiment.exact
        if exact is not None and "stiffness" in model and "stiffness" in exact:
            ratio = ratio_of(stiff_pressure(exact, resamples), stiff_pressure(model, resamples))
            what = f"p at K h_rms/E* = {STIFF:g}, exact over {model.kind}"
            yield reading(experiment, model, what, ratio)


def stiff_pressure(model: ModelResult, resamples: int) -> Estimate:
    """Return p/E* at which 1/⟨1/K⟩ reaches :data:`STIFF` in units of the realized h_rms.

    The compliance is taken as linear in ln p between the pressures, which knows K = ∞.
    """
    averages = Averages(model, resamples, 0)
    with np.errstate(divide="ignore"):
        compliance = 1.0 / averages.in_own_units("stiffness")
    x = np.log(averages.pressure)
    found = np.full(len(compliance), math.nan)
    for row, curve in enumerate(compliance):
        below = np.flatnonzero(curve < 1.0 / STIFF)
        if below.size and below[0] > 0:
            k = int(below[0])
            part = (curve[k - 1] - 1.0 / STIFF) / (curve[k - 1] - curve[k])
            found[row] = math.exp(x[k - 1] + part * (x[k] - x[k - 1]))
    return estimate(found, count=averages.count)


def exponent_below(law: PowerLaw) -> Measure:
    """Return the measure of a model's exponent of K below the exact solution's K ∼ p."""

    def measure(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
        for experiment, model, _ in models_of(experiments, kinds):
            if experiment.reference is None or "stiffness" not in model:
                continue
            if "hurst" not in model.attributes:
                continue
            start = experiment.fits[experiment.reference]["log_from"].value
            averages = Averages(model, resamples, 0)
            with np.errstate(divide="ignore", invalid="ignore"):
                rate = np.log(averages.means["stiffness_harmonic"])
            below = np.isfinite(rate) & (averages.pressure < start)
            slope, _ = straight_line(np.log(averages.pressure), rate, below)
            hurst = float(model.attributes["hurst"])
            note = f"{law.text} = {law.exponent(hurst):.3f}; below p = {number(start, 2)} E*"
            found = estimate(slope, count=averages.count)
            what = "n of K ∼ pⁿ"
            yield reading(experiment, model, what, found, note=note, hurst=hurst)

    return measure


def start_of_deviation(
    experiments: Experiments, kinds: Kinds, resamples: int
) -> Iterator[Reading]:
    """Measure where K starts to deviate from the theory, over where that becomes linear."""
    for experiment, model, _ in models_of(experiments, kinds):
        theory = theory_of(model, 0.45) if "stiffness" in model else None
        if theory is None:
            continue
        for m, joined in ((math.inf, "their larger"), (2.0, "the root of their squares")):
            found = onset(model, theory, m=m, resamples=resamples)
            what = f"first deviation over start of K ∼ p; theory: {joined}"
            note = f"{pressure_words(found.deviates)} and {pressure_words(found.linear)}"
            yield reading(experiment, model, what, found.ratio, note=note)
