"""The verdicts on the paper's claims as HTML: counts, and the table with what was measured."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from roughbench.models import MODELS
from roughbench.report.markup import escape, number, prose, with_error
from roughbench.verdict import Measurement, Outcome, Verdict

_SPEC_WORDS = re.compile(
    r"((?:sweep|observables): (?:\{[^}]*\}|\[[^\]]*\])|\bsurface\.\w+|\bq[r01]\b|"
    rf"\b(?:{'|'.join(MODELS)})\b)"
)
"""What stands in specs: two keys with their values, wavevectors, kinds of models."""
MOST_OPEN = 12
"""Measurements of a claim that are shown at once; longer lists unfold."""
_SYMBOLS = {
    Outcome.HOLDS: "✓",
    Outcome.FAILS: "✗",
    Outcome.UNDECIDED: "?",
    Outcome.NOT_TESTED: "–",
}


def badge(outcome: Outcome) -> str:
    """Return the outcome as a symbol and a word, coloured by its class."""
    return (
        f'<span class="badge {_class(outcome)}"><span aria-hidden="true">'
        f"{_SYMBOLS[outcome]}</span> {escape(outcome.value)}</span>"
    )


def _class(outcome: Outcome) -> str:
    return outcome.value.replace(" ", "-")


def summary(verdicts: Sequence[Verdict]) -> str:
    """Return how many claims hold, fail, and so on, each with links to its claims."""
    rows = []
    for outcome in Outcome:
        meant = [(n, v) for n, v in enumerate(verdicts, 1) if v.outcome is outcome]
        links = " ".join(
            f'<a href="#claim-{escape(v.key)}" title="{escape(v.claim)}">{n}</a>'
            for n, v in meant
        )
        rows.append(
            f'<div class="count {_class(outcome)}"><dt>{badge(outcome)}</dt>'
            f"<dd><strong>{len(meant)}</strong> "
            f'<span class="claims">{links}</span></dd></div>'
        )
    return f'<dl class="counts">{"".join(rows)}</dl>'


def verdict_table(verdicts: Sequence[Verdict], places: Mapping[str, str]) -> str:
    """Return the table of all claims that the results test, and one line on the others.

    Parameters
    ----------
    verdicts : sequence of Verdict
    places : mapping of str to str
        See :func:`roughbench.report.sources.places`.
    """
    numbered = list(enumerate(verdicts, 1))
    tested = [(n, v) for n, v in numbered if v.outcome is not Outcome.NOT_TESTED]
    others = [(n, v) for n, v in numbered if v.outcome is Outcome.NOT_TESTED]
    parts = [_table(tested, places)] * bool(tested)
    if others:
        some = "One claim" if len(others) == 1 else f"{len(others)} claims"
        claims = ", ".join(str(number) for number, _ in others)
        parts.append(
            f'<details class="untested"><summary>{some} cannot be tested on these results '
            f"(No. {claims}). Which, and what would test them</summary>"
            f"{_table(others, places)}</details>"
        )
    return "\n".join(parts)


def _table(numbered: Sequence[tuple[int, Verdict]], places: Mapping[str, str]) -> str:
    rows = "\n".join(_row(number, verdict, places) for number, verdict in numbered)
    return (
        '<table class="verdicts"><thead><tr><th scope="col">No.</th>'
        '<th scope="col">Claim, and how it is decided</th><th scope="col">Measured</th>'
        f'<th scope="col">Verdict</th></tr></thead>\n<tbody>\n{rows}\n</tbody></table>'
    )


def _row(number: int, verdict: Verdict, places: Mapping[str, str]) -> str:
    return (
        f'<tr id="claim-{escape(verdict.key)}"><th scope="row">{number}</th>'
        f'<td class="claim"><p class="place">{prose(verdict.place)}</p>'
        f"<p>{prose(verdict.claim)}</p>"
        f'<p class="rule"><span class="lead">Rule.</span> {prose(verdict.rule)}</p></td>'
        f'<td class="measured">{_measured(number, verdict, places)}</td>'
        f'<td class="outcome">{badge(verdict.outcome)}</td></tr>'
    )


def spec_words(text: str) -> str:
    """Return what a spec needs, as HTML: keys and kinds of a spec set as code.

    Examples
    --------
    >>> spec_words("a spec with bem and qr = 8 q0")
    'a spec with <code>bem</code> and <code>qr</code> = 8 <code>q0</code>'
    """
    text = re.sub(r"(?<![\w.])\d(?:\.\d+)?e[-+]\d+(?!\w)", lambda m: number(float(m[0])), text)
    return _SPEC_WORDS.sub(r"<code>\1</code>", escape(text))


def _measured(number: int, verdict: Verdict, places: Mapping[str, str]) -> str:
    remedy = ""
    if verdict.remedy:
        remedy = (
            '<p class="remedy"><span class="lead">To test it:</span> '
            f"{spec_words(verdict.remedy)}</p>"
        )
    if not verdict.measurements:
        return remedy or "<p>–</p>"
    rows = "".join(_measurement(measured, places) for measured in verdict.measurements)
    count = len(verdict.measurements)
    state = " open" if count <= MOST_OPEN else ""
    tally = ", ".join(
        f"{many} {escape(outcome.value)}"
        for outcome in Outcome
        if (many := sum(m.outcome is outcome for m in verdict.measurements))
    )
    plural = "s" * (count > 1)
    return (
        f"<details{state}><summary>{count} measurement{plural}: {tally}</summary>"
        f'<table class="measurements" aria-label="Measurements for claim {number}">'
        '<thead><tr><th scope="col">where</th><th scope="col">what</th>'
        '<th scope="col">value ± error</th><th scope="col">outcome</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></details>{remedy}"
    )


def _measurement(measured: Measurement, places: Mapping[str, str]) -> str:
    value = with_error(measured.value, measured.error)
    if measured.bound and math.isfinite(measured.value):
        value = f"{escape(measured.bound)} {value}"
    note = f'<span class="aside">{prose(measured.note)}</span>' if measured.note else ""
    outcome = (
        f'<span class="{_class(measured.outcome)}"><span aria-hidden="true">'
        f"{_SYMBOLS[measured.outcome]}</span> {escape(measured.outcome.value)}</span>"
    )
    where = places.get(measured.where) or escape(measured.where)
    what = prose(measured.what) + note
    return (
        f'<tr><th scope="row">{where}</th><td>{what}</td>'
        f'<td class="value">{value}</td><td>{outcome}</td></tr>'
    )
