"""The numbers that claims are decided by, each with its error, from fitted experiments.

The thresholds of the claims are ours: the paper compares curves by eye. Models are held
against the exact solution where that itself has the law in question: for the area where
A ∼ p, for separation and stiffness where K ∼ p.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roughbench.fits import MISSING, Comparison, Estimate
from roughbench.fits.comparisons import HEIGHTS, PRESSURE_FACTOR
from roughbench.notation import typeset
from roughbench.numbers import with_interval
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult
from roughbench.verdict.combined import ratio_of
from roughbench.verdict.experiments import FittedExperiment, models_of
from roughbench.verdict.rules import PowerLaw

SYMBOLS = {
    name: typeset(QUANTITIES[name].in_heights) for name in ("area", "separation", "stiffness")
}
MANY_SCALES = 32.0
"""q₁/q_r of a spectrum with many scales; the paper's is 1024 or more."""
ROLLOFF = 8.0
"""q_r/q₀ of the paper's surfaces with a roll-off."""
CUTOFF = 8192.0
"""q₁/q₀ of the paper's surfaces."""
GAMMAS = (0.4, 0.5)
"""γ of the theory at its best: 0.45 of Yang and Persson (2008). The paper does not name it."""
SMALL_AREA = 0.01
"""A/A0 at which correlations are measured: the nearest pressure, in ln A."""
SMALL_AREAS = (0.003, 0.03)
"""Where that may lie: a factor of three away."""
NO_VALUE = "there is no such region, or no value in it"
OTHER_PRESSURES = "its pressures are not those of the exact solution"
SAME_PRESSURES = "the same pressures for both"
LAW_OF = {"area": "A ∼ p", "separation": "K ∼ p", "stiffness": "K ∼ p"}
"""Quantity → where the exact solution has which law models are held against it."""


def pressures_of(law: str) -> str:
    """Return what would give a value where there is none since the law lacks."""
    return f"more pressures where the exact solution has {law}, such as from 1e-6 to 0.1"


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
    case : str
        Of which surfaces, see :func:`case_of`.
    remedy : str
        What would give a number, where that is special.
    """

    where: str
    what: str
    estimate: Estimate
    note: str = ""
    hurst: float = math.nan
    missing: str = NO_VALUE
    case: str = ""
    remedy: str = ""


Experiments = Sequence[FittedExperiment]
Kinds = Sequence[str]
Measure = Callable[[Experiments, Kinds, int], Iterator[Reading]]
"""From the experiments, the kinds of models that are meant, and the number of resamples."""
Condition = Callable[[ModelResult], bool]


def case_of(model: ModelResult) -> str:
    """Return whether the surfaces of a model have a roll-off; empty where that is unknown."""
    found = model.attributes
    if "q_rolloff" not in found or "q_min" not in found:
        return ""
    has_one = float(found["q_rolloff"]) > float(found["q_min"]) * (1.0 + 1e-9)
    return "with roll-off" if has_one else "without roll-off"


def reading(
    experiment: FittedExperiment, model: ModelResult, what: str, found: Estimate, **more: Any
) -> Reading:
    """Return a number of a model, with the place and the case that it belongs to."""
    return Reading(experiment.where(model), what, found, case=case_of(model), **more)


def closed_note(closed: Estimate | None) -> list[str]:
    """Say how many pressures a factor leaves out since the model is closed there."""
    if closed is None or not closed.value > 0.0:
        return []
    many = int(closed.value)
    return [f"closed, and left out, at {many} of these pressures"]


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

    Other γ, the self-consistent area and a fitted prefactor of eq. (10) are not.
    """
    found = model.attributes
    fitted = found.get("finite_size", "none") != "none"
    fitted &= float(found.get("theta", 1.0)) != 1.0
    usual = GAMMAS[0] <= float(found.get("gamma", GAMMAS[0])) <= GAMMAS[1]
    return usual and not fitted and "area_gamma" not in found


def has_the_papers_size(model: ModelResult) -> bool:
    """Return whether a surface has the paper's roll-off and its cut-off."""
    ratio = float(model.attributes.get("q_max", 0.0)) / float(
        model.attributes.get("q_min", 1.0)
    )
    return has_the_rolloff(model) and math.isclose(ratio, CUTOFF)


TOO_NARROW = f"q₁ is less than {MANY_SCALES:g} q_r"
WIDER = f"surface.q1 of at least {MANY_SCALES:g} times the largest surface.qr"


def fitted(
    name: str,
    what: str,
    only: Condition = everywhere,
    *,
    among: Condition = everywhere,
    except_of: str = "",
    remedy: str = "",
) -> Measure:
    """Return the measure of a fitted number, on the surfaces that meet a condition.

    Parameters
    ----------
    name, what : str
        Of the fit, and in words.
    only : callable
        Others are left out, or told of if ``except_of`` says why they do not count.
    among : callable
        Surfaces that do not meet this condition are not spoken of at all.
    except_of, remedy : str
    """

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if name not in fits or not among(model):
                continue
            if only(model):
                yield reading(experiment, model, what, fits[name], remedy=remedy)
            elif except_of:
                why = {"missing": except_of, "remedy": remedy}
                yield reading(experiment, model, what, MISSING, **why)

    return measure


def kappa(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
    """Measure κ, on spectra of many scales."""
    yield from fitted("kappa", "κ", has_many_scales, except_of=TOO_NARROW, remedy=WIDER)(
        experiments, kinds, _resamples
    )


def stiffness_exponent(law: PowerLaw) -> Measure:
    """Return the measure of the exponent of K at the lowest pressures."""

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if "exponent_expected" in fits:
                hurst = float(model.attributes["hurst"])
                note = f"{law.text} = {law.exponent(hurst):.3f}"
                more = {"note": note, "hurst": hurst}
                yield reading(experiment, model, "n of K ∼ pⁿ", fits["exponent"], **more)

    return measure


def factor(quantity: str, only: Condition = everywhere) -> Measure:
    """Return the measure of the factor between models and the exact solution."""
    what, name = f"factor in {SYMBOLS[quantity]}", f"{quantity}_factor"

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if not only(model):
                continue
            if name in fits:
                note = agreement(fits, Comparison(quantity), 50)
                closed = closed_note(fits.get(Comparison(quantity).closed))
                note = "; ".join([note, *closed])
                missing = "; ".join([NO_VALUE, *closed])
                remedy = pressures_of(LAW_OF[quantity])
                more = {"note": note, "missing": missing, "remedy": remedy}
                yield reading(experiment, model, what, fits[name], **more)
            elif experiment.exact is not None:
                more = {"missing": OTHER_PRESSURES, "remedy": SAME_PRESSURES}
                yield reading(experiment, model, what, MISSING, **more)

    return measure


def pressure_factor(only: Condition = everywhere) -> Measure:
    """Return the measure of the factor between the pressures at equal mean separation."""

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        for experiment, model, fits in models_of(experiments, kinds):
            if only(model) and PRESSURE_FACTOR in fits:
                what, note = "factor in p at equal ū/h_rms", pressures_note(fits)
                more = {"note": note, "remedy": pressures_of("K ∼ p")}
                yield reading(experiment, model, what, fits[PRESSURE_FACTOR], **more)

    return measure


def pressures_note(fits: Mapping[str, Estimate]) -> str:
    """Say which parts of the exact pressure lead to some mean separations."""
    ratios = {h: fits[f"pressure_at_{h}h"] for h in HEIGHTS}
    known = {h: ratio for h, ratio in ratios.items() if math.isfinite(ratio.value)}
    words = ", ".join(with_interval(one.value, one.low, one.high, 2) for one in known.values())
    places = ", ".join(map(str, known))
    return f"{words} times the exact p at ū/h_rms = {places}" if known else ""


def agreement(fits: Mapping[str, Estimate], comparison: Comparison, percent: int) -> str:
    """Say between which pressures a model agrees with the exact solution."""
    start, end = (fits[name] for name in comparison.ends(percent))
    if not math.isfinite(start.value):
        return f"nowhere within {percent} %"
    low = "the first pressure" if start.is_bound else f"p = {pressure_words(start)}"
    high = "the last" if end.is_bound else pressure_words(end)
    return f"within {percent} % from {low} to {high}"


def pressure_words(found: Estimate) -> str:
    """Return a pressure with its interval, in E*.

    Examples
    --------
    >>> pressure_words(Estimate(2.0e-5, 1.0e-6, 1.9e-5, 2.1e-5, 1.0))
    '(2.00 ± 0.10)·10⁻⁵ E*'
    >>> pressure_words(Estimate(0.2, 0.01, 0.19, 0.21, 1.0))
    '(0.200 ± 0.010) E*'
    """
    text = with_interval(found.value, found.low, found.high, 2)
    is_bare = " ± " in text and not text.startswith("(")
    return f"({text}) E*" if is_bare else f"{text} E*"


def closing_ratio(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
    """Measure how much earlier a model closes than the exact solution."""
    for experiment, model, fits in models_of(experiments, kinds):
        if experiment.reference is not None:
            there = experiment.fits[experiment.reference]["half_contact"]
            ratio = ratio_of(there, fits["half_contact"])
            what = f"p at A/A₀ = ½, exact over {model.kind}"
            yield reading(experiment, model, what, ratio)
