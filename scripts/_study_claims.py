"""The table of the paper's claims in docs/study.md, from the verdicts on the study's runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from roughbench.numbers import measured, with_interval
from roughbench.results import Results
from roughbench.verdict import Measurement, Outcome, Verdict, judge
from roughbench.verdict.judging import GROUPS

RUNS = ("contenders-256", "theory")
"""What the verdicts are on. Other runs have too few pressures for their ranges."""
RESAMPLES = 300
_MOST = 4


def claims(runs: Mapping[str, Results]) -> str:
    """Return a table for each group of claims: place, claim, outcome, by which numbers."""
    sources = [(name, runs[name]) for name in RUNS if name in runs]
    verdicts = [one for one in judge(sources, resamples=RESAMPLES) if one.group]
    parts = []
    for group, heading in GROUPS.items():
        rows = [
            _row(one)
            for one in verdicts
            if one.group == group and one.outcome is not Outcome.NOT_TESTED
        ]
        head = ["| place | claim | outcome | by |", "|---|---|---|---|"]
        parts.append("\n".join([f"### {heading}", "", *head, *rows]))
    untested = ", ".join(one.key for one in verdicts if one.outcome is Outcome.NOT_TESTED)
    if untested:
        parts.append(f"Not tested by these runs: {untested}.")
    return "\n\n".join(parts)


def _row(verdict: Verdict) -> str:
    cells = (verdict.place, verdict.claim, _outcome(verdict), _numbers(verdict))
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def _outcome(verdict: Verdict) -> str:
    """Return the outcome, and where it depends on the surfaces, that of each kind."""
    kinds = [f"{one.outcome} {one.case}" for one in verdict.cases if one.case]
    if len({one.outcome for one in verdict.cases}) > 1:
        return f"{verdict.outcome}: {', '.join(kinds)}"
    return str(verdict.outcome)


def _numbers(verdict: Verdict) -> str:
    """Return the numbers that decide, those of one name together; of many the first."""
    by_name: dict[str, list[str]] = {}
    for one in verdict.measurements:
        if one.outcome is not Outcome.NOT_TESTED:
            by_name.setdefault(one.what, []).append(_measured(one))
    return "; ".join(_series(name, found) for name, found in by_name.items())


def _series(name: str, found: list[str]) -> str:
    shown = list(_first(found))
    return f"{name} {', '.join(shown)}"


def _first(found: list[str]) -> Iterator[str]:
    yield from found[:_MOST]
    if len(found) > _MOST:
        yield f"… ({len(found)} in all)"


def _measured(one: Measurement) -> str:
    if one.bound:
        return measured(one.value, one.error, one.bound)
    return with_interval(one.value, one.low, one.high)
