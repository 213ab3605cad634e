"""The page: its parts put together, with styles, script and plotly inside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import PurePosixPath
from string import Template

from roughbench import __version__
from roughbench.report.charts import Chart
from roughbench.report.curves import curve_charts
from roughbench.report.looks import Look, model_looks
from roughbench.report.maps import COLOURS, MOST_MAPS, MOST_POINTS, Map, field_maps, n_fields
from roughbench.report.markup import escape
from roughbench.report.observables import observable_charts
from roughbench.report.sources import Source, full_places, places
from roughbench.report.switches import switches
from roughbench.report.tables import compared, fit_tables, provenance
from roughbench.report.verdicts import summary, verdict_table
from roughbench.report.warnings import ABOUT, Remark, Severity, remarks
from roughbench.store import FORMAT_VERSION
from roughbench.verdict import Case, Outcome, Verdict

MOST_REMARKS = 12
"""Remarks on one topic that are shown at once; longer lists unfold."""
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:"
)
"""What browsers hold the page to: nothing comes from, or goes to, any other place."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """What the page shows.

    Attributes
    ----------
    sources : sequence of Source
    verdicts : sequence of Verdict
        On all of them together.
    cases : sequence of Case
        The experiments of all of them, with their fits.
    reference : str or None
        Label of the model that the others are held against, if one was named.
    resamples : int
        Draws of the realizations behind the errors.
    """

    sources: Sequence[Source]
    verdicts: Sequence[Verdict]
    cases: Sequence[Case]
    reference: str | None
    resamples: int


def render(content: Content) -> str:
    """Return the page, the same for the same content.

    Parameters
    ----------
    content : Content

    Returns
    -------
    str
        HTML.
    """
    folder = resources.files(__package__)

    def asset(*name: str) -> str:
        return folder.joinpath(*name).read_text(encoding="utf-8")

    sources = content.sources
    looks = model_looks(sources)
    names = ", ".join(dict.fromkeys(source.results.name or source.name for source in sources))
    return Template(asset("page.html")).substitute(
        policy=_POLICY,
        title=escape(f"Rough contact: {names}"),
        names=escape(names),
        style=asset("page.css"),
        version=escape(__version__),
        format_version=FORMAT_VERSION,
        compared=compared(sources),
        claims=len(content.verdicts),
        decided=_decided(content.verdicts),
        summary=summary(content.verdicts),
        verdicts=verdict_table(content.verdicts, places(sources)),
        figures="\n".join(_figures(n, source, looks) for n, source in enumerate(sources)),
        fits="\n".join(
            fit_tables(source, [case for case in content.cases if case.source == source.name])
            for source in sources
        ),
        resamples=content.resamples,
        warnings=_warnings(remarks(sources), full_places(sources)),
        provenance="\n".join(provenance(source) for source in sources),
        command=escape(_command(content)),
        plotly=asset("plotly", "plotly-basic.min.js"),
        script=asset("page.js"),
    )


def _decided(verdicts: Sequence[Verdict]) -> str:
    """Return in a sentence how many claims hold, fail, and so on."""
    words = {
        Outcome.HOLDS: "{} hold",
        Outcome.FAILS: "{} fail",
        Outcome.UNDECIDED: "{} are undecided",
        Outcome.NOT_TESTED: "{} cannot be tested on these results",
    }
    counts = {outcome: sum(v.outcome is outcome for v in verdicts) for outcome in words}
    return ", ".join(words[outcome].format(count) for outcome, count in counts.items())


def _command(content: Content) -> str:
    words = ["roughbench report", *(source.name for source in content.sources)]
    if content.reference is not None:
        words.append(f"--reference {content.reference}")
    return " ".join([*words, f"--resamples {content.resamples}"])


def _figures(place: int, source: Source, looks: dict[str, Look]) -> str:
    stem = PurePosixPath(source.name).stem
    parts = [_charts(place, stem, curve_charts(source, looks))]
    if observables := observable_charts(source, looks):
        parts += [
            f"<h4>Inside the contact</h4><p>{_OBSERVABLES}</p>",
            _charts(place, stem, observables),
        ]
    if maps := field_maps(source):
        drawn = "".join(_map(f"file-{place}-map-{k}", one) for k, one in enumerate(maps))
        parts += [
            f"<h4>Maps of the contact</h4><p>{_MAPS}</p>{_SCALE}",
            f'<div class="charts maps">{drawn}</div>',
        ]
    if (left_out := n_fields(source) - MOST_MAPS) > 0:
        parts.append(f"<p>{left_out} more fields are in the file.</p>")
    body = "\n".join(parts)
    return (
        f'<section class="file" aria-label="{escape(source.name)}">'
        f"<h3>{escape(source.name)}</h3>\n{switches(source, looks)}\n{body}</section>"
    )


_OBSERVABLES = (
    "What the pressures and gaps show beyond their averages, at the nominal "
    "pressure chosen above; thin and dotted, Persson’s theory."
)
_MAPS = (
    "The pressure in single states, white out of contact; lines appear as stripes. Fields "
    f"finer than {MOST_POINTS} points a side are averaged over squares."
)
_SCALE = (
    f'<div class="scale" style="background:linear-gradient(to right,'
    f'{",".join(f"{colour} {100 * at:g}%" for at, colour in COLOURS)})" role="img" '
    'aria-label="Colours from white at no pressure to dark blue at E*ξ and above"></div>'
    '<p class="scale-words" aria-hidden="true"><span>σ/(E*ξ) = 0</span><span>½</span>'
    "<span>≥ 1</span></p>"
)
_TOOLS = {"xaxis": "x", "yaxis": "y", "reset": "whole range", "save": "save the picture"}


def _charts(place: int, stem: str, charts: Sequence[Chart]) -> str:
    drawn = "".join(_chart(f"file-{place}-{c.key}", f"{stem}-{c.key}", c) for c in charts)
    return f'<div class="charts">{drawn}</div>'


def _chart(key: str, name: str, chart: Chart) -> str:
    tools = "".join(
        f'<button type="button" data-do="{action}">{words}</button>'
        for action, words in _TOOLS.items()
    )
    return (
        f'<figure class="chart" id="{escape(key)}" data-name="{escape(name)}">'
        f"<figcaption>{chart.title}</figcaption>"
        f'<div class="plot" role="img" aria-label="{escape(chart.label)}"></div>'
        f'<div class="tools" hidden>{tools}</div>'
        f'<script type="application/json">{chart.content}</script></figure>\n'
    )


def _map(key: str, drawn: Map) -> str:
    shape = " stripe" if drawn.is_line else ""
    return (
        f'<figure class="map{shape}" id="{key}" data-model="{escape(drawn.model)}" '
        f'data-experiment="{escape(drawn.experiment)}"><figcaption>{drawn.title}</figcaption>'
        f'<img src="{drawn.address}" alt="{escape(drawn.label)}"></figure>\n'
    )


# -- warnings ----------------------------------------------------------------------------


def _warnings(found: Sequence[Remark], named: Mapping[str, str]) -> str:
    if not found:
        return "<p>None.</p>"
    groups: dict[tuple[Severity, str], list[Remark]] = {}
    for remark in found:
        groups.setdefault((remark.severity, remark.topic), []).append(remark)
    return "\n".join(
        f'<section class="remarks {severity.value}">'
        f"<h3>{_MARKS[severity]} {escape(topic)}</h3><p>{escape(ABOUT[topic])}</p>"
        f"{_listed(group, named)}</section>"
        for (severity, topic), group in groups.items()
    )


def _listed(group: Sequence[Remark], named: Mapping[str, str]) -> str:
    listed = f"<ul>{''.join(_remark(remark, named) for remark in group)}</ul>"
    if len(group) <= MOST_REMARKS:
        return listed
    return f"<details><summary>{len(group)} places</summary>{listed}</details>"


_MARKS = {
    Severity.WARNING: '<span class="mark" role="img" aria-label="warning">▲</span>',
    Severity.NOTE: '<span class="mark" role="img" aria-label="note">●</span>',
}


def _remark(remark: Remark, named: Mapping[str, str]) -> str:
    where = named.get(remark.where) or escape(remark.where)
    return f'<li><span class="where">{where}</span> {escape(remark.text)}</li>'
