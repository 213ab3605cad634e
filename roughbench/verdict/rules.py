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
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum

from roughbench.fits import Estimate
from roughbench.fits.resampling import student


class Outcome(StrEnum):
    """What a measurement, or all of a claim's, says of the claim.

    A claim that holds for some surfaces and fails for others depends on them.
    """

    HOLDS = "holds"
    FAILS = "fails"
    DEPENDS = "depends"
    UNDECIDED = "undecided"
    NOT_TESTED = "not tested"


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """An exponent that depends on the Hurst exponent H.

    Attributes
    ----------
    text : str
        Its formula.
    exponent : callable
        Its value for an H.
    """

    text: str
    exponent: Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Rule:
    """Where a claim wants a value.

    Attributes
    ----------
    inside : (float, float)
        It holds if the whole interval lies in here.
    outside : (float, float)
        It fails if the whole interval lies out of here.
    of_ratio : bool
        Whether the value is a positive ratio, whose error is one of its logarithm.
    law : PowerLaw or None
        What both are counted from; default: from zero.
    unit : str
        Of the value, in the singular.
    """

    inside: tuple[float, float]
    outside: tuple[float, float]
    of_ratio: bool = False
    law: PowerLaw | None = None
    unit: str = ""

    @property
    def text(self) -> str:
        """The rule in words, made from its numbers."""
        (low, high), (lowest, highest) = self.inside, self.outside
        if math.isinf(high):
            text, last = f"at least {low:g}", low
            ending = f" (fails up to {lowest:g})" if lowest < low else ""
        elif math.isinf(low):
            text, last = f"at most {high:g}", high
            ending = f" (fails from {highest:g} on)" if highest > high else ""
        elif self.of_ratio:
            text, last = f"{math.sqrt(low * high):g}", math.inf
            ending = f" within a factor {math.sqrt(high / low):g}"
        else:
            centre, last = 0.5 * (low + high), 0.5 * (high - low)
            text = f"{self.law.text if self.law else f'{centre:g}'} ± {last:g}"
            ending = ""
        unit = f" {self.unit}{'s' * (last != 1.0)}" if self.unit else ""
        return f"{text}{unit}{ending}".replace("-", "−")

    def decide(self, estimate: Estimate, hurst: float = math.nan) -> Outcome:
        """Return what an estimate says of the claim.

        Parameters
        ----------
        estimate : Estimate
        hurst : float
            H of the surface, for rules with a law.

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
            if self.of_ratio and low > 0.0:
                low, high = x * (low / x) ** wider, x * (high / x) ** wider
            else:
                low, high = x - wider * (x - low), x + wider * (high - x)
        if estimate.bound == "≥":
            high = math.inf
        elif estimate.bound == "≤":
            low = -math.inf
        zero = self.law.exponent(hurst) if self.law else 0.0
        if zero + self.inside[0] <= low and high <= zero + self.inside[1]:
            return Outcome.HOLDS
        if high < zero + self.outside[0] or low > zero + self.outside[1]:
            return Outcome.FAILS
        return Outcome.UNDECIDED


def at_least(
    threshold: float,
    unit: str = "",
    *,
    fails_below: float | None = None,
    of_ratio: bool = False,
) -> Rule:
    """Return the rule for values that must reach a threshold."""
    lower = threshold if fails_below is None else fails_below
    return Rule((threshold, math.inf), (lower, math.inf), of_ratio, unit=unit)


def at_most(
    threshold: float,
    unit: str = "",
    *,
    fails_above: float | None = None,
    of_ratio: bool = False,
) -> Rule:
    """Return the rule for values that must not pass a threshold."""
    upper = threshold if fails_above is None else fails_above
    return Rule((-math.inf, threshold), (-math.inf, upper), of_ratio, unit=unit)


def about(target: float, factor: float) -> Rule:
    """Return the rule for ratios that must be ``target`` within a factor."""
    ends = (target / factor, target * factor)
    return Rule(ends, ends, of_ratio=True)


def near(target: float | PowerLaw, tolerance: float, unit: str = "") -> Rule:
    """Return the rule for values that must be ``target`` within ``tolerance``."""
    law, centre = (target, 0.0) if isinstance(target, PowerLaw) else (None, target)
    ends = (centre - tolerance, centre + tolerance)
    return Rule(ends, ends, law=law, unit=unit)


def together(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the outcome of several criteria, all of which must be met.

    One failure is enough against them; else one open criterion leaves it open.
    """
    tested = set(outcomes)
    for outcome in (Outcome.FAILS, Outcome.DEPENDS, Outcome.UNDECIDED, Outcome.HOLDS):
        if outcome in tested:
            return outcome
    return Outcome.NOT_TESTED


def agreed(outcomes: Iterable[Outcome]) -> Outcome:
    """Return what the same criterion says on several surfaces: no single one decides.

    Examples
    --------
    >>> str(agreed([Outcome.HOLDS, Outcome.FAILS])), str(agreed([Outcome.HOLDS]))
    ('depends', 'holds')
    """
    tested = set(outcomes) - {Outcome.NOT_TESTED}
    if Outcome.DEPENDS in tested or {Outcome.HOLDS, Outcome.FAILS} <= tested:
        return Outcome.DEPENDS
    for outcome in (Outcome.UNDECIDED, Outcome.FAILS, Outcome.HOLDS):
        if outcome in tested:
            return outcome
    return Outcome.NOT_TESTED
