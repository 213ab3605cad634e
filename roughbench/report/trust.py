"""Where each contender can be trusted, as tables: one for each on every surface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from roughbench.report.sources import ReportSource
from roughbench.report.tables import ReportTable, TableCell
from roughbench.report.text import RichText, Span, from_notation, joined
from roughbench.verdict import ContenderTrust, Trust


def trust_tables(
    sources: Sequence[ReportSource], trusts: Sequence[ContenderTrust]
) -> Iterator[tuple[RichText, list[ReportTable]]]:
    """Yield a heading and the tables of its contenders for every experiment that has some.

    The only experiment of the only file needs no heading, and has an empty one.
    """
    for source in sources:
        for experiment in source.results:
            own = [t for t in trusts if (t.source, t.experiment) == (source.name, experiment)]
            if own:
                named = [source.name] * (len(sources) > 1)
                swept = [source.experiment(experiment)] * source.has_sweep
                yield joined([*named, *swept], ": "), [_table(source, one) for one in own]


def _table(source: ReportSource, one: ContenderTrust) -> ReportTable:
    places = list(dict.fromkeys(d.place for t in one.quantities for d in t.deviations))
    rows = [_row(trust, places) for trust in one.quantities]
    headings: list[TableCell] = ["Quantity", "Where it can be trusted"]
    headings += [[Span("at "), *from_notation(place)] for place in places]
    title = joined([[Span(source.title(one.label), "strong")], [Span(one.basis, "muted")]])
    return ReportTable(headings, rows, title, is_numeric=False)


def _row(trust: Trust, places: Sequence[str]) -> list[TableCell]:
    deviations = {one.place: one.text for one in trust.deviations}
    return [
        joined([trust.quantity.words, from_notation(trust.quantity.symbol)], " "),
        from_notation(trust.range_text),
        *(deviations.get(place, "–") for place in places),
    ]
