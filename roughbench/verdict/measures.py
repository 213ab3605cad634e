"""The numbers that claims are decided by, each with its error, from fitted experiments.

The thresholds of the claims are ours: the paper compares curves by eye. Models are held
against the exact solution where that itself has the law in question: for the area where
A ∼ p, for separation and stiffness where K ∼ p.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.fits import MISSING, Comparison, Estimate, factors, n_random
from roughbench.notation import typeset
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult
from roughbench.verdict.experiments import FittedExperiment, models_of, that_differ_in
from roughbench.verdict.rules import PowerLaw
from roughbench.verdict.sizes import size_exponent

SYMBOLS = {
    name: typeset(QUANTITIES[name].in_heights) for name in ("area", "separation", "stiffness")
}
MANY_SCALES = 32.0
"""q₁/q_r of a spectrum with many scales; the paper's is 1024 or more."""
ROLLOFF = 8.0
"""q_r/q₀ of the paper's surfaces with a roll-off."""
GAMMAS = (0.4, 0.5)
"""γ of the theory at its best: 0.45 of Yang and Persson (2008). The paper does not name it."""
SMALL_AREA = 0.01
"""A/A0 at which correlations are measured: the nearest pressure, in ln A."""
SMALL_AREAS = (0.003, 0.03)
"""Where that may lie: a factor of three away."""
OTHER_PRESSURES = "its pressures are not those of the exact solution"


@dataclass(frozen=True, slots=True)
class Reading:
    """A measured number, before a rule decides on it.

    Attributes
    ----------
    where, what : str
        Of which model, and its name.
    estimate : Estimate
    note : str
        A remark, or nothing.
    hurst : float
        H of the surface, for rules that depend on it.
    missing : str
        Why there is no number, where there is none.
    """

    where: str
    what: str
    estimate: Estimate
    note: str = ""
    hurst: float = math.nan
    missing: str = "there is no such region, or no value in it"


Experiments = Sequence[FittedExperiment]
Kinds = Sequence[str]
Measure = Callable[[Experiments, Kinds, int], Iterator[Reading]]
"""From the experiments, the kinds of models that are meant, and the number of resamples."""
Condition = Callable[[ModelResult], bool]


def everywhere(_model: ModelResult) -> bool:
    """Return whether a number may be taken: it may."""
    return True


def has_many_scales(model: ModelResult) -> bool:
    """Return whether q₁ is far enough above q_r; heights from a file have neither."""
    found = model.attributes
    if "q_max" not in found or "q_rolloff" not in found:
        return True
    return float(found["q_max"]) >= MANY_SCALES * float(found["q_rolloff"]) * (1.0 - 1e-9)


def has_the_rolloff(model: ModelResult) -> bool:
    """Return whether a surface has the paper's roll-off, in a cell of the longest wave."""
    found = model.attributes
    if "q_rolloff" not in found or "q_min" not in found:
        return False
    waves = float(found["q_min"]) * float(found["length"]) / (2.0 * math.pi)
    ratio = float(found["q_rolloff"]) / float(found["q_min"])
    return math.isclose(ratio, ROLLOFF) and math.isclose(waves, 1.0, rel_tol=1e-6)


def is_as_published(model: ModelResult) -> bool:
    """Return whether a theory is as the paper has it.

    Other γ, the self-consistent area and eq. (10) with a fitted prefactor are not.
    """
    found = model.attributes
    fitted = found.get("finite_size", "none") != "none"
    fitted &= float(found.get("theta", 1.0)) != 1.0
    usual = GAMMAS[0] <= float(found.get("gamma", GAMMAS[0])) <= GAMMAS[1]
    return usual and not fitted and "area_gamma" not in found


_TOO_NARROW = f"q₁ is less than {MANY_SCALES:g} q_r"


def fitted(name: str, what: str, only: Condition = everywhere) -> Measure:
    """Return the measure of a fitted number, on the surfaces that meet a condition."""

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if only(model) and name in fits:
                yield Reading(experiment.where(model), what, fits[name])

    return measure


def kappa(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
    """Measure κ, on spectra of many scales."""
    for experiment, model, fits in models_of(experiments, kinds):
        where = experiment.where(model)
        if has_many_scales(model):
            yield Reading(where, "κ", fits["kappa"])
        else:
            yield Reading(where, "κ", MISSING, missing=_TOO_NARROW)


def stiffness_exponent(law: PowerLaw) -> Measure:
    """Return the measure of the exponent of K at the lowest pressures."""

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if "exponent_expected" in fits:
                hurst = float(model.attributes["hurst"])
                note = f"{law.text} = {law.exponent(hurst):.3f}"
                where = experiment.where(model)
                yield Reading(where, "n of K ∼ pⁿ", fits["exponent"], note, hurst)

    return measure


def factor(quantity: str, only: Condition = everywhere) -> Measure:
    """Return the measure of the factor between models and the exact solution."""
    what, name = f"factor in {SYMBOLS[quantity]}", f"{quantity}_factor"

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            where = experiment.where(model)
            if not only(model):
                continue
            if name in fits:
                note = agreement(fits, Comparison(quantity), 50)
                yield Reading(where, what, fits[name], note)
            elif experiment.exact is not None:
                yield Reading(where, what, MISSING, missing=OTHER_PRESSURES)

    return measure


def agreement(fits: Mapping[str, Estimate], comparison: Comparison, percent: int) -> str:
    """Say between which pressures a model agrees with the exact solution."""
    start, end = (fits[name] for name in comparison.ends(percent))
    if not math.isfinite(start.value):
        return f"nowhere within {percent} %"
    low = "the first pressure" if start.is_bound else f"p = {start.value:.2g} E*"
    high = "the last" if end.is_bound else f"{end.value:.2g} E*"
    return f"within {percent} % from {low} to {high}"


def closing_ratio(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
    """Measure how much earlier a model closes than the exact solution."""
    for experiment, model, fits in models_of(experiments, kinds):
        if experiment.reference is not None:
            there = experiment.fits[experiment.reference]["half_contact"]
            ratio = _ratio(there, fits["half_contact"])
            what = f"p at A/A₀ = ½, exact over {model.kind}"
            yield Reading(experiment.where(model), what, ratio)


def kappa_over_rolloff(
    experiments: Experiments, _kinds: Kinds, _resamples: int
) -> Iterator[Reading]:
    """Measure κ of surfaces with a roll-off over that of the one with the lowest."""
    for (first, there), *others in that_differ_in("q_rolloff", experiments):
        for experiment, here in others:
            ratio = _ratio(
                experiment.fits[here.label]["kappa"], first.fits[there.label]["kappa"]
            )
            low, high = (float(one.attributes["q_rolloff"]) for one in (there, here))
            where, what = experiment.where(here), f"κ(q_r = {high:g}) / κ(q_r = {low:g})"
            if has_many_scales(here):
                yield Reading(where, what, ratio)
            else:
                yield Reading(where, what, MISSING, missing=_TOO_NARROW)


def factor_of_cutoff(
    experiments: Experiments, _kinds: Kinds, resamples: int
) -> Iterator[Reading]:
    """Measure by which factor a spectrum that is zero below the roll-off differs."""
    for (experiment, here), (_, there) in that_differ_in("below_rolloff", experiments):
        found = factors(here, there, resamples)  # cutoff, rolloff
        for quantity, symbol in SYMBOLS.items():
            what = f"factor in {symbol} between cut-off and roll-off"
            yield Reading(experiment.where(here), what, found[f"{quantity}_factor"])


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
        yield Reading(group[-1][0].where(found[-1]), what, estimate)


def spectrum_exponent(observable: str, law: PowerLaw) -> Measure:
    """Return the measure of a spectrum's exponent, where the exact area is nearest to 1 %."""
    name, what = f"{observable}_exponent", f"exponent, {law.text}"

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, _ in models_of(experiments, kinds):
            exact, where = experiment.exact, experiment.where(model)
            if exact is None or f"{name}_mean" not in model or "hurst" not in model.attributes:
                continue
            k = _place_of_small_area(exact)
            if k is None or not np.array_equal(model["pressure"], exact["pressure"]):
                low, high = SMALL_AREAS
                why = f"no pressure has an exact A/A₀ between {low} and {high}"
                yield Reading(where, what, MISSING, missing=why)
                continue
            mean, error = float(model[f"{name}_mean"][k]), float(model[f"{name}_sem"][k])
            count = n_random(model)
            estimate = Estimate(mean, error, mean - error, mean + error, 1.0, count=count)
            hurst = float(model.attributes["hurst"])
            expected, pressure = law.exponent(hurst), float(model["pressure"][k])
            note = f"{expected:.2f} expected; at p = {pressure:.2g} E*"
            yield Reading(where, what, estimate, note, hurst)

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


def _ratio(a: Estimate, b: Estimate) -> Estimate:
    """Return a/b of two estimates; their errors are taken as independent."""
    if not (math.isfinite(a.value) and math.isfinite(b.value)):
        return MISSING
    count = min((x.count for x in (a, b) if x.count), default=0)
    value = a.value / b.value
    parts = [x.error / x.value if x.count else 0.0 for x in (a, b)]
    error = value * math.hypot(*parts) if count else math.nan
    share = min(a.share, b.share)
    return Estimate(value, error, value - error, value + error, share, count=count)
