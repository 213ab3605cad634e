"""From what a claim says to a verdict: its criteria, applied to what was measured."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from roughbench.fits import Estimate
from roughbench.verdict.experiments import FittedExperiment
from roughbench.verdict.measures import Measure, Reading
from roughbench.verdict.rules import Outcome, Rule, agreed, together

GROUPS = {
    "paper": "What the paper claims",
    "explanation": "Our tests of its explanation",
    "beyond": "Beyond the paper",
}
"""Whose claims they are: name → heading."""


@dataclass(frozen=True, slots=True)
class Range:
    """The pressures between which a model agrees with the exact solution.

    Attributes
    ----------
    percent : int
        Within how many percent of it.
    start, end : Estimate
        p/E* of the exact solution; nan where it agrees nowhere.
    """

    percent: int
    start: Estimate
    end: Estimate


@dataclass(frozen=True, slots=True)
class Measurement:
    """One measured number behind a verdict.

    Attributes
    ----------
    where : str
        Experiment and label of the model, after the source where there are several.
    what : str
        Its name.
    value : float
        nan: there is none.
    error : float
        Half of a 68 % interval; nan: none.
    bound : {"", "≤", "≥"}
        Whether the value is a bound only.
    outcome : Outcome
        Of this number alone.
    note : str
        A remark, or nothing.
    ranges : tuple of Range
        Of a contender: where it agrees with the exact solution.
    low, high : float
        Ends of the 68 % interval; nan: none.
    case : str
        What surfaces it is of, see :class:`CaseOutcome`.
    """

    where: str
    what: str
    value: float
    error: float
    bound: str
    outcome: Outcome
    note: str = ""
    ranges: tuple[Range, ...] = ()
    low: float = math.nan
    high: float = math.nan
    case: str = ""


@dataclass(frozen=True, slots=True)
class CaseOutcome:
    """What is found of a claim on one kind of surfaces.

    Attributes
    ----------
    case : str
        ``without roll-off`` or ``with roll-off``; empty for heights without a spectrum, and for
        what compares surfaces.
    outcome : Outcome
    """

    case: str
    outcome: Outcome


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim, what was measured of it, and what follows.

    Attributes
    ----------
    key : str
        Short name.
    place : str
        Where the paper says it.
    claim : str
        What it says.
    rule : str
        How it is decided.
    measurements : tuple of Measurement
    outcome : Outcome
        Over all cases: what they agree in, or that it depends on them.
    remedy : str
        What spec would test it, or what of it is missing; empty where it is decided.
    contender : str
        Label of the model that it is on; empty for the paper's claims.
    group : str
        Of :data:`GROUPS`; empty for a contender.
    cases : tuple of CaseOutcome
        The outcome by case; empty where nothing was measured.
    """

    key: str
    place: str
    claim: str
    rule: str
    measurements: tuple[Measurement, ...]
    outcome: Outcome
    remedy: str
    contender: str = ""
    group: str = ""
    cases: tuple[CaseOutcome, ...] = ()


@dataclass(frozen=True, slots=True)
class Criterion:
    """One number that a claim is decided by.

    Attributes
    ----------
    text : str
        What is measured, with ``{rule}`` where the rule's words belong.
    measure : callable
        Takes the number, on all experiments.
    rule : Rule
        What it has to be.
    """

    text: str
    measure: Measure
    rule: Rule


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and how it is tested.

    Attributes
    ----------
    key, place, statement : str
        Short name, where the paper says it, and what it says.
    kinds : tuple of str
        Of the models that it is about.
    criteria : tuple of Criterion
        Of several, all must be met.
    remedy : str
        What spec would test it; default: one with these kinds.
    group : str
        Of :data:`GROUPS`.
    """

    key: str
    place: str
    statement: str
    kinds: tuple[str, ...]
    criteria: tuple[Criterion, ...]
    remedy: str = ""
    group: str = "paper"

    def judge(self, experiments: Sequence[FittedExperiment], resamples: int) -> Verdict:
        """Return the verdict: case by case, and then over all of them."""
        readings = [
            list(criterion.measure(experiments, self.kinds, resamples))
            for criterion in self.criteria
        ]
        parts = [
            [measurement(reading, criterion.rule) for reading in found]
            for criterion, found in zip(self.criteria, readings, strict=True)
        ]
        cases = tuple(
            CaseOutcome(case, _of_case(case, parts))
            for case in _cases(one for p in parts for one in p)
        )
        outcome = agreed(one.outcome for one in cases)
        untested = [
            reading.remedy
            for part, found in zip(parts, readings, strict=True)
            for one, reading in zip(part, found, strict=True)
            if one.outcome is Outcome.NOT_TESTED
        ]
        lacking = any(
            agreed(one.outcome for one in part) is Outcome.NOT_TESTED for part in parts
        )
        default = self.remedy or f"a spec with bem and {' or '.join(self.kinds)}"
        remedy = next(filter(None, untested), default)
        return Verdict(
            self.key,
            self.place,
            self.statement,
            "; ".join(one.text.format(rule=one.rule.text) for one in self.criteria),
            tuple(found for part in parts for found in part),
            outcome,
            remedy if lacking and outcome is not Outcome.FAILS else "",
            group=self.group,
            cases=cases,
        )


def _cases(measurements: Iterable[Measurement]) -> list[str]:
    return sorted(
        {one.case for one in measurements}, key=lambda case: (not case, case), reverse=True
    )


def _of_case(case: str, parts: Sequence[Sequence[Measurement]]) -> Outcome:
    """Return what all criteria say in one case; one without a number leaves it open."""
    outcomes = [agreed(one.outcome for one in part if one.case in (case, "")) for part in parts]
    outcome = together(one for one in outcomes if one is not Outcome.NOT_TESTED)
    lacks = Outcome.NOT_TESTED in outcomes
    return Outcome.UNDECIDED if outcome is Outcome.HOLDS and lacks else outcome


def measurement(reading: Reading, rule: Rule, ranges: tuple[Range, ...] = ()) -> Measurement:
    """Return what a rule says of a number."""
    found = reading.estimate
    outcome = rule.decide(found, reading.hurst)
    note = reading.note
    if not found.is_given:
        note = "not given"
    elif outcome is Outcome.NOT_TESTED:
        note = reading.missing
    elif math.isnan(found.low) and found.count == 1:
        note = "; ".join(filter(None, (note, "a single surface: no error")))
    return Measurement(
        reading.where,
        reading.what,
        found.value,
        found.error,
        found.bound,
        outcome,
        note,
        ranges,
        found.low,
        found.high,
        reading.case,
    )
