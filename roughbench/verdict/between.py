"""The numbers that several experiments tell together: what changes with one property."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from roughbench.fits import MISSING, Estimate, factors
from roughbench.fits.resampling import draw_counts, estimate, n_random
from roughbench.results import ModelResult
from roughbench.verdict.combined import difference_of, power_of, ratio_of
from roughbench.verdict.experiments import that_differ_in
from roughbench.verdict.measures import (
    SYMBOLS,
    TOO_NARROW,
    WIDER,
    Experiments,
    Kinds,
    Measure,
    Reading,
    has_many_scales,
    reading,
)
from roughbench.verdict.sizes import size_exponent
from roughbench.verdict.states import scatter_of

Fits = Mapping[str, Estimate]


def kappa_over_rolloff(
    experiments: Experiments, _kinds: Kinds, _resamples: int
) -> Iterator[Reading]:
    """Measure κ of surfaces with a roll-off over that of the one with the lowest."""
    for (first, there), *others in that_differ_in("q_rolloff", experiments):
        for experiment, here in others:
            ratio = ratio_of(
                experiment.fits[here.label]["kappa"], first.fits[there.label]["kappa"]
            )
            low, high = (float(one.attributes["q_rolloff"]) for one in (there, here))
            where, what = experiment.where(here), f"κ(q_r = {high:g}) / κ(q_r = {low:g})"
            if has_many_scales(here):
                yield Reading(where, what, ratio)
            else:
                yield Reading(where, what, MISSING, missing=TOO_NARROW, remedy=WIDER)


def factor_of_cutoff(quantity: str) -> Measure:
    """Return the measure of the factor that an empty spectrum below the roll-off makes."""
    what = f"factor in {SYMBOLS[quantity]} between cut-off and roll-off"

    def measure(experiments: Experiments, _kinds: Kinds, resamples: int) -> Iterator[Reading]:
        for (experiment, here), (_, there) in that_differ_in("below_rolloff", experiments):
            found = factors(here, there, resamples)  # cutoff, rolloff
            yield reading(experiment, here, what, found[f"{quantity}_factor"])

    return measure


def power_of_size(experiments: Experiments, kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure how the pressure at a given separation goes with the size of the cell."""
    for group in that_differ_in("length", experiments):
        series = [next(iter(one.of_kinds(kinds)), None) for one, _ in group]
        found = [model for model in series if model is not None]
        if len(found) != len(group) or any("separation" not in model for model in found):
            continue
        first, exact = group[0]
        start, end = (first.fits[exact.label][f"log_{side}"] for side in ("from", "to"))
        estimate = size_exponent(found, start.value, end.value, resamples)
        what = f"s of p ∼ Lˢ at the same ū, {len(found)} cells"
        yield reading(group[-1][0], found[-1], what, estimate)


def _over_rolloff(what: str, compare: Callable[[Fits, Fits], Estimate]) -> Measure:
    """Return a measure of surfaces with a roll-off against the one with the lowest."""

    def measure(experiments: Experiments, _kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for (first, there), *others in that_differ_in("q_rolloff", experiments):
            for experiment, here in others:
                found = compare(experiment.fits[here.label], first.fits[there.label])
                low, high = (float(one.attributes["q_rolloff"]) for one in (there, here))
                words = f"{what}, q_r = {high:g} and {low:g}"
                yield Reading(
                    experiment.where(here),
                    words,
                    found,
                    missing="K ∼ p begins or ends beyond the pressures, or is nowhere",
                    remedy="pressures from 1e-7 to 0.1, beyond both ends of K ∼ p",
                )

    return measure


widening = _over_rolloff(
    "decades of K ∼ p, difference",
    lambda a, b: difference_of(a["log_decades"], b["log_decades"]),
)
"""By how many decades the region K ∼ p is wider with a roll-off."""
earlier_start = _over_rolloff(
    "start of K ∼ p, ratio", lambda a, b: ratio_of(a["log_from"], b["log_from"])
)
"""The pressure where it starts, over that without."""


def finite_size_power(name: str, symbol: str) -> Measure:
    """Return the measure of the power with which θ of eq. (10) still depends on a property.

    Parameters
    ----------
    name : str
        Attribute that the surfaces differ in.
    symbol : str
        In words.
    """

    def measure(experiments: Experiments, _kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for group in that_differ_in(name, experiments):
            thetas = [
                one.fits[model.label].get("theta_realized", MISSING) for one, model in group
            ]
            values = [float(model.attributes[name]) for _, model in group]
            what = f"power of {symbol} left in θ, {len(group)} values"
            experiment, model = group[-1]
            yield Reading(experiment.where(model), what, power_of(values, thetas))

    return measure


def repetition(experiments: Experiments, _kinds: Kinds, resamples: int) -> Iterator[Reading]:
    """Measure how the scatter of K between surfaces falls with q_r/q0.

    n equal and independent parts have 1/√n of the scatter of one, and a surface that is as if
    repeated (q_r/q0)² times q0/q_r of it. It is taken in the middle of the region K ∼ p of the
    lowest roll-off, at the same pressure for all.
    """
    for group in that_differ_in("q_rolloff", experiments):
        first, lowest = group[0]
        start, end = (first.fits[lowest.label][f"log_{side}"].value for side in ("from", "to"))
        if not (start > 0.0 and end > start) or "stiffness" not in lowest:
            continue
        k = int(np.argmin(np.abs(np.log(lowest["pressure"] / math.sqrt(start * end)))))
        scatters = [_scatter(model, k, resamples) for _, model in group]
        ratios = [
            float(model.attributes["q_rolloff"]) / float(model.attributes["q_min"])
            for _, model in group
        ]
        what = f"s of scatter(K) ∼ (q_r/q₀)ˢ, {len(group)} values"
        note = f"at p = {float(lowest['pressure'][k]):.2g} E*"
        experiment, model = group[-1]
        found = power_of(ratios, scatters)
        yield Reading(experiment.where(model), what, found, note=note)


def _scatter(model: ModelResult, k: int, resamples: int) -> Estimate:
    if model.n_realizations < 2:
        return MISSING
    counts = draw_counts(model.n_realizations, resamples, 0)
    return estimate(scatter_of(model, "stiffness", counts)[:, k], count=n_random(model))
