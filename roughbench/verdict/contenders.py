"""Every contender, known or not, against the exact solution: one verdict for each.

For each quantity that a model gives, at equal pressure and, for area and stiffness, at equal
mean separation: between which pressures it is within 10 % and 50 % of the exact solution, and
the factor between both, where the exact solution has A ∼ p or K ∼ p (see
:mod:`roughbench.fits.comparisons`). The factor decides, as in the paper's claims.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from roughbench.fits import MISSING, PERCENTS, Comparison, Estimate, comparisons
from roughbench.notation import typeset
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult
from roughbench.verdict.criteria import TO_FOLLOW
from roughbench.verdict.experiments import FittedExperiment
from roughbench.verdict.judging import CaseOutcome, Measurement, Range, Verdict, measurement
from roughbench.verdict.measures import OTHER_PRESSURES, Reading, case_of, closed_note
from roughbench.verdict.rules import Outcome, agreed, together
from roughbench.verdict.trust import end_text

_RULE = (
    "factor between the model and the exact solution, where that has A ∼ p (for the area) or "
    f"K ∼ p, each with the rms height of its own surfaces: {TO_FOLLOW.text}"
)


def judge_contenders(experiments: Sequence[FittedExperiment]) -> list[Verdict]:
    """Return a verdict on every model but the exact one, in the order of the results."""
    found: dict[tuple[str, str], list[tuple[FittedExperiment, ModelResult]]] = {}
    for experiment in experiments:
        for model in experiment.contenders:
            found.setdefault((model.kind, model.label), []).append((experiment, model))
    return [_judge(kind, label, places) for (kind, label), places in found.items()]


def _judge(
    kind: str, label: str, places: Sequence[tuple[FittedExperiment, ModelResult]]
) -> Verdict:
    measured = tuple(
        one
        for experiment, model in places
        if experiment.exact is not None
        for one in _measurements(experiment, model)
    )
    cases = tuple(
        CaseOutcome(case, together(one.outcome for one in measured if one.case == case))
        for case in sorted({one.case for one in measured}, reverse=True)
    )
    outcome = agreed(one.outcome for one in cases)
    remedy = "a spec with bem" + ", at pressures where it has A ∼ p or K ∼ p" * bool(measured)
    return Verdict(
        key=f"contender-{label}" if label == kind else f"contender-{kind}-{label}",
        place="every contender",
        claim=f"{places[0][1].title} follows the exact solution.",
        rule=_RULE,
        measurements=measured,
        outcome=outcome,
        remedy=remedy if outcome is Outcome.NOT_TESTED else "",
        contender=label,
        cases=cases,
    )


def _measurements(experiment: FittedExperiment, model: ModelResult) -> Iterator[Measurement]:
    fits, where = experiment.fits[model.label], experiment.where(model)
    case = case_of(model)
    for comparison in comparisons():
        if not comparison.is_expected and comparison.factor not in fits:
            continue
        what = f"factor in {typeset(QUANTITIES[comparison.quantity].in_heights)}"
        if comparison.at_separation:
            if comparison.quantity not in model:
                continue  # said at equal pressure
            what += " at equal ū/h_rms"
        factor = fits.get(comparison.factor)
        if factor is None:
            reading = Reading(where, what, MISSING, missing=OTHER_PRESSURES, case=case)
            yield measurement(reading, TO_FOLLOW)
        elif not factor.is_given:
            yield measurement(Reading(where, what, factor, case=case), TO_FOLLOW)
        else:
            ranges = tuple(_range(fits, comparison, percent) for percent in PERCENTS)
            closed = fits.get(comparison.closed)
            texts = [_text(one, comparison) for one in ranges]
            note = "; ".join([*texts, *closed_note(closed)])
            missing = f"{note}; no factor: {_why_missing(comparison)}"
            reading = Reading(where, what, factor, note, missing=missing, case=case)
            yield measurement(reading, TO_FOLLOW, ranges)


def _why_missing(comparison: Comparison) -> str:
    law = "A ∼ p" if comparison.quantity == "area" else "K ∼ p"
    return f"the exact solution has no region {law}, or too few values of both are in it"


def _range(fits: Mapping[str, Estimate], comparison: Comparison, percent: int) -> Range:
    start, end = (fits[name] for name in comparison.ends(percent))
    return Range(percent, start, end)


def _text(found: Range, comparison: Comparison) -> str:
    """Say where a model agrees with the exact solution, with errors where there are any."""
    if not math.isfinite(found.start.value):
        return f"nowhere within {found.percent} %"
    first = f"the first pressure{' compared' * comparison.at_separation}"
    low = first if found.start.is_bound else f"p = {end_text(found.start)}"
    high = "the last" if found.end.is_bound else end_text(found.end)
    return f"within {found.percent} % from {low} to {high}"
