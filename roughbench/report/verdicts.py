"""The verdicts on the paper's claims, numbered and sorted for the page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.numbers import with_interval
from roughbench.verdict import Measurement, Outcome, Verdict
from roughbench.verdict.judging import GROUPS


def measured_value(found: Measurement) -> str:
    """Return a measured number after its bound, with its interval."""
    text = with_interval(found.value, found.low, found.high)
    return f"{found.bound} {text}" if found.bound and math.isfinite(found.value) else text


MOST_OPEN = 12
"""Measurements of a claim that are shown at once; longer lists unfold."""


@dataclass(frozen=True, slots=True)
class NumberedVerdict:
    """A verdict with the number of its claim on the page, from 1."""

    number: int
    verdict: Verdict

    @property
    def tally(self) -> list[tuple[int, Outcome]]:
        """How many measurements have each outcome, without those that none has."""
        found = [measured.outcome for measured in self.verdict.measurements]
        return [(found.count(outcome), outcome) for outcome in Outcome if outcome in found]

    @property
    def is_open(self) -> bool:
        """Whether all measurements are shown at once."""
        return len(self.verdict.measurements) <= MOST_OPEN


def numbered(verdicts: Sequence[Verdict], first: int = 1) -> list[NumberedVerdict]:
    """Return verdicts with numbers from ``first`` on."""
    return [NumberedVerdict(number, verdict) for number, verdict in enumerate(verdicts, first)]


@dataclass(frozen=True, slots=True)
class VerdictGroup:
    """The verdicts on the claims of one group.

    Attributes
    ----------
    name, heading : str
        Of :data:`roughbench.verdict.judging.GROUPS`.
    by_outcome : dict of Outcome to list of NumberedVerdict
        For all outcomes.
    """

    name: str
    heading: str
    by_outcome: dict[Outcome, list[NumberedVerdict]]

    @property
    def count(self) -> int:
        """How many claims are in it."""
        return sum(map(len, self.by_outcome.values()))


def grouped(verdicts: Sequence[Verdict]) -> list[VerdictGroup]:
    """Return the verdicts on the paper's claims, and those of the other groups that exist."""
    found = numbered(verdicts)
    groups = []
    for name, heading in GROUPS.items():
        own = [one for one in found if (one.verdict.group or "paper") == name]
        by_outcome = {
            outcome: [one for one in own if one.verdict.outcome is outcome]
            for outcome in Outcome
        }
        if own or name == "paper":
            groups.append(VerdictGroup(name, heading, by_outcome))
    return groups
