"""How a number with its error decides: the only rules that verdicts are made by.

A measured value x has an error e (half of a 68 % interval); what is decided is whether
x ± 2e, about its 95 % interval, lies on one side of a threshold. A value without an error,
of a theory or of a single realization, decides alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from roughbench.fits import Estimate


class Outcome(StrEnum):
    """What a measurement, or all of a claim's, says of the claim."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"
    NOT_TESTED = "not tested"


@dataclass(frozen=True, slots=True)
class AtLeast:
    """The claim holds if the value is at least ``threshold``."""

    threshold: float

    def decide(self, value: float, error: float, bound: str = "") -> Outcome:
        """Return what a value with its error says."""
        outcome = _side(value - self.threshold, error)
        return _with_bound(outcome, bound, holds_with="≥", fails_with="≤")


@dataclass(frozen=True, slots=True)
class AtMost:
    """The claim holds if the value is at most ``threshold``."""

    threshold: float

    def decide(self, value: float, error: float, bound: str = "") -> Outcome:
        """Return what a value with its error says."""
        outcome = _side(self.threshold - value, error)
        return _with_bound(outcome, bound, holds_with="≤", fails_with="≥")


@dataclass(frozen=True, slots=True)
class Near:
    """The claim holds if the value differs from ``target`` by at most ``tolerance``."""

    target: float
    tolerance: float

    def decide(self, value: float, error: float, bound: str = "") -> Outcome:
        """Return what a value with its error says; a bound decides nothing."""
        outcome = _side(self.tolerance - abs(value - self.target), error)
        return _with_bound(outcome, bound, holds_with="", fails_with="")


Rule = AtLeast | AtMost | Near


def decide(rule: Rule, estimate: Estimate, bound: str = "", *, exact: bool = False) -> Outcome:
    """Return what an estimate says of a claim.

    Parameters
    ----------
    rule : Rule
    estimate : Estimate
    bound : {"", "≤", "≥"}
        Whether its value is a bound.
    exact : bool
        Whether no error is expected: a theory, or a single realization.

    Returns
    -------
    Outcome
        ``NOT_TESTED`` where there is no value, ``UNDECIDED`` where an error is expected
        and there is none.
    """
    if math.isnan(estimate.value):
        return Outcome.NOT_TESTED
    if math.isinf(estimate.value):
        return rule.decide(estimate.value, 0.0, bound)
    if math.isnan(estimate.error):
        return rule.decide(estimate.value, 0.0, bound) if exact else Outcome.UNDECIDED
    return rule.decide(estimate.value, estimate.error, bound)


def together(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the outcome of a claim: it holds if it holds wherever it was tested.

    One failure is enough against it; else one open case leaves it open.
    """
    tested = {outcome for outcome in outcomes if outcome != Outcome.NOT_TESTED}
    for outcome in (Outcome.FAILS, Outcome.UNDECIDED, Outcome.HOLDS):
        if outcome in tested:
            return outcome
    return Outcome.NOT_TESTED


def _side(margin: float, error: float) -> Outcome:
    if margin >= 2.0 * error:
        return Outcome.HOLDS
    return Outcome.FAILS if margin < -2.0 * error else Outcome.UNDECIDED


def _with_bound(outcome: Outcome, bound: str, *, holds_with: str, fails_with: str) -> Outcome:
    """Leave open what the true value behind a bound might undo."""
    if not bound:
        return outcome
    certain = {Outcome.HOLDS: holds_with, Outcome.FAILS: fails_with}
    return outcome if certain.get(outcome) == bound else Outcome.UNDECIDED
