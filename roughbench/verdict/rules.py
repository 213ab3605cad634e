"""How a number with its error decides: the only rules that verdicts are made by.

A measurement x comes with a 68 % interval from low to high, which Student's t of its number
of realizations widens to 95 % (for factors and ratios: in the logarithm). The claim holds if
all of it lies where the claim wants it, fails if none of it does, and is undecided otherwise.
Without anything random, of a theory or measured heights, the value decides alone; a single
random surface decides nothing. A value that is a bound stands for all values beyond it, and
an infinite one for its 68 % interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from roughbench.fits import Estimate
from roughbench.fits.resampling import student


class Outcome(StrEnum):
    """What a measurement, or all of a claim's, says of the claim."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"
    NOT_TESTED = "not tested"


@dataclass(frozen=True, slots=True)
class Rule:
    """Where a claim wants a value.

    Attributes
    ----------
    inside : (float, float)
        It holds if the whole interval lies in here.
    outside : (float, float) or None
        It fails if the whole interval lies out of here; default: ``inside``.
    of_ratio : bool
        Whether the value is a positive ratio, whose error is one of its logarithm.
    """

    inside: tuple[float, float]
    outside: tuple[float, float] | None = None
    of_ratio: bool = False

    def decide(self, low: float, high: float) -> Outcome:
        """Return what an interval says."""
        if self.inside[0] <= low and high <= self.inside[1]:
            return Outcome.HOLDS
        wider = self.outside or self.inside
        if high < wider[0] or low > wider[1]:
            return Outcome.FAILS
        return Outcome.UNDECIDED


def at_least(
    threshold: float, *, fails_below: float | None = None, of_ratio: bool = False
) -> Rule:
    """Return the rule for values that must reach a threshold."""
    lower = threshold if fails_below is None else fails_below
    return Rule((threshold, math.inf), (lower, math.inf), of_ratio)


def at_most(
    threshold: float, *, fails_above: float | None = None, of_ratio: bool = False
) -> Rule:
    """Return the rule for values that must not pass a threshold."""
    upper = threshold if fails_above is None else fails_above
    return Rule((-math.inf, threshold), (-math.inf, upper), of_ratio)


def about(target: float, factor: float) -> Rule:
    """Return the rule for ratios that must be ``target`` within a factor."""
    return Rule((target / factor, target * factor), of_ratio=True)


def near(target: float, tolerance: float) -> Rule:
    """Return the rule for values that must be ``target`` within ``tolerance``."""
    return Rule((target - tolerance, target + tolerance))


def decide(rule: Rule, estimate: Estimate, bound: str = "") -> Outcome:
    """Return what an estimate says of a claim.

    Parameters
    ----------
    rule : Rule
    estimate : Estimate
    bound : {"", "≤", "≥"}
        Whether its value is a bound.

    Returns
    -------
    Outcome
        ``NOT_TESTED`` where there is no value, ``UNDECIDED`` where an error is expected
        and there is none.
    """
    x, low, high = estimate.value, estimate.low, estimate.high
    if math.isnan(x):
        return Outcome.NOT_TESTED
    if math.isnan(low):
        if estimate.count:
            return Outcome.UNDECIDED
        low = high = x
    if math.isfinite(x):  # an infinite value is at no distance of its quantiles
        low, high = min(x, low), max(x, high)
        wider = 2.0
        if estimate.count > 1:
            wider = student(0.975, estimate.count) / student(0.84, estimate.count)
        if rule.of_ratio and low > 0.0:
            low, high = x * (low / x) ** wider, x * (high / x) ** wider
        else:
            low, high = x - wider * (x - low), x + wider * (high - x)
    if bound == "≥":
        high = math.inf
    elif bound == "≤":
        low = -math.inf
    return rule.decide(low, high)


def together(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the outcome of a claim: it holds if it holds wherever it was tested.

    One failure is enough against it; else one open case leaves it open.
    """
    tested = {outcome for outcome in outcomes if outcome != Outcome.NOT_TESTED}
    for outcome in (Outcome.FAILS, Outcome.UNDECIDED, Outcome.HOLDS):
        if outcome in tested:
            return outcome
    return Outcome.NOT_TESTED
