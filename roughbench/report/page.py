"""The page: its parts put together, with styles, script and plotly inside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from string import Template

from roughbench import __version__
from roughbench.report.charts import Chart, curve_charts
from roughbench.report.looks import Look, experiment_dashes, model_looks
from roughbench.report.markup import escape, number
from roughbench.report.observables import (
    MOST_MAPS,
    drawn_pressures,
    field_charts,
    n_fields,
    observable_charts,
    pressure_key,
)
from roughbench.report.sources import Source, experiment_html
from roughbench.report.tables import Fits, compared, fit_tables, provenance
from roughbench.report.verdicts import summary, verdict_table
from roughbench.report.warnings import ABOUT, Remark, Severity, remarks
from roughbench.store import FORMAT_VERSION
from roughbench.verdict import Verdict

MOST_CURVES = 8
"""Curves that a chart shows at first with all experiments; of more, the first experiment."""
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
    fits : sequence of mapping
        What :func:`roughbench.fits.fit` returned for each of them.
    reference : str or None
        Label of the model that the others are held against, if one was named.
    resamples : int
        Draws of the realizations behind the errors.
    """

    sources: Sequence[Source]
    verdicts: Sequence[Verdict]
    fits: Sequence[Fits]
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
    from plotly.offline import get_plotlyjs

    folder = resources.files(__package__)

    def asset(name: str) -> str:
        return (folder / name).read_text(encoding="utf-8")

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
        summary=summary(content.verdicts),
        verdicts=verdict_table(content.verdicts),
        figures="\n".join(_figures(n, source, looks) for n, source in enumerate(sources)),
        fits="\n".join(
            fit_tables(source, fits, source.has(content.reference))
            for source, fits in zip(sources, content.fits, strict=True)
        ),
        resamples=content.resamples,
        warnings=_warnings(remarks(sources)),
        provenance="\n".join(provenance(source) for source in sources),
        command=escape(_command(content)),
        plotly=get_plotlyjs(),
        script=asset("page.js"),
    )


def _command(content: Content) -> str:
    words = ["roughbench report", *(source.name for source in content.sources)]
    if content.reference is not None:
        words.append(f"--reference {content.reference}")
    return " ".join([*words, f"--resamples {content.resamples}"])


def _figures(place: int, source: Source, looks: dict[str, Look]) -> str:
    charts = [
        *curve_charts(source, looks),
        *observable_charts(source, looks),
        *field_charts(source),
    ]
    drawn = "\n".join(_chart(f"file-{place}", chart) for chart in charts)
    left_out = n_fields(source) - MOST_MAPS
    more = f"<p>{left_out} more fields are in the file.</p>" if left_out > 0 else ""
    return (
        f'<section class="file" aria-label="{escape(source.name)}">'
        f"<h3>{escape(source.name)}</h3>\n{_switches(source, looks)}\n"
        f'<div class="charts">{drawn}</div>{more}</section>'
    )


_TOOLS = "".join(
    f'<button type="button" data-do="{action}">{words}</button>'
    for action, words in {
        "xaxis": "x",
        "yaxis": "y",
        "reset": "whole range",
        "save": "save as SVG",
    }.items()
)


def _chart(prefix: str, chart: Chart) -> str:
    return (
        f'<figure class="chart" id="{prefix}-{escape(chart.key)}">'
        f"<figcaption>{chart.title}</figcaption>"
        f'<div class="plot" role="img" aria-label="{escape(chart.label)}"></div>'
        f'<div class="tools" hidden>{_TOOLS}</div>'
        f'<script type="application/json">{chart.content}</script></figure>'
    )


def _switches(source: Source, looks: dict[str, Look]) -> str:
    """Return the legend, which is also where models and experiments are chosen."""
    titles = {result.label: result.title for _, result in source.models()}
    models = "".join(
        _switch("model", label, _model_sample(looks[label]), _model_words(label, title))
        for label, title in titles.items()
    )
    parts = [_fieldset("Models", models, len(titles))]
    dashes = experiment_dashes(list(source.results))
    if len(dashes) > 1:
        many = len(list(source.models())) > MOST_CURVES
        experiments = "".join(
            _switch(
                "experiment", name, _dash_sample(dash), experiment_html(name), on=place == 0 or not many
            )
            for place, (name, dash) in enumerate(dashes.items())
        )
        parts.append(_fieldset("Experiments", experiments, len(dashes)))
    else:
        (name,) = dashes
        parts.append(f'<input type="checkbox" name="experiment" value="{escape(name)}" checked hidden>')
    pressures = drawn_pressures(source)
    if pressures:
        parts.append(_pressure_select(pressures))
    return f'<form class="switches" autocomplete="off" hidden>{"".join(parts)}</form>'


def _pressure_select(pressures: Sequence[float]) -> str:
    """Return the choice of the pressure at which observables are shown."""
    middle = len(pressures) // 2
    options = "".join(
        f'<option value="{pressure_key(p)}"{" selected" if k == middle else ""}>{number(p)}</option>'
        for k, p in enumerate(pressures)
    )
    return (
        "<fieldset><legend>Observables</legend><label>at the pressure p/E* = "
        f'<select name="pressure">{options}</select></label></fieldset>'
    )


def _model_words(label: str, title: str) -> str:
    return f"{escape(label)} <span class='muted'>{escape(title)}</span>"


def _fieldset(legend: str, switches: str, count: int) -> str:
    everything = '<button type="button" data-do="all">all</button>' if count > 1 else ""
    return f"<fieldset><legend>{legend}</legend>{switches}{everything}</fieldset>"


def _switch(name: str, value: str, sample: str, words: str, *, on: bool = True) -> str:
    checked = " checked" if on else ""
    return (
        f'<span class="switch"><label><input type="checkbox" name="{name}" '
        f'value="{escape(value)}"{checked}>{sample}<span>{words}</span></label>'
        f'<button type="button" data-do="only" aria-label="only {escape(value)}">only</button>'
        "</span>"
    )


_SHAPES = {
    "square-open": '<rect x="8.5" y="2.5" width="7" height="7" fill="white" stroke="{c}" stroke-width="1.3"/>',
    "circle": '<circle cx="12" cy="6" r="3.6" fill="{c}"/>',
    "triangle-up": '<path d="M12 1.6 16.4 9.6H7.6Z" fill="{c}"/>',
    "diamond": '<path d="M12 1.2 16.8 6 12 10.8 7.2 6Z" fill="{c}"/>',
    "triangle-down": '<path d="M12 10.4 16.4 2.4H7.6Z" fill="{c}"/>',
    "x": '<path d="M9 3 15 9M15 3 9 9" stroke="{c}" stroke-width="2.4"/>',
    "cross": '<path d="M12 1.8V10.2M7.8 6H16.2" stroke="{c}" stroke-width="2.8"/>',
    "pentagon": '<path d="M12 1.5 16.4 4.8 14.7 10H9.3L7.6 4.8Z" fill="{c}"/>',
    "star": '<path d="M12 .8 13.5 4.4 17.2 4.6 14.3 7 15.3 10.8 12 8.7 8.7 10.8 9.7 7 6.8 4.6 10.5 4.4Z" fill="{c}"/>',
    "hourglass": '<path d="M8.2 2H15.8L8.2 10H15.8Z" fill="{c}"/>',
    "triangle-left": '<path d="M7.6 6 15.6 1.6V10.4Z" fill="{c}"/>',
    "triangle-right": '<path d="M16.4 6 8.4 1.6V10.4Z" fill="{c}"/>',
}


def _model_sample(look: Look) -> str:
    """Return a piece of the curve as the chart draws it, for the legend."""
    shape = _SHAPES[look.symbol].format(c=look.colour)
    return (
        '<svg class="sample" viewBox="0 0 24 12" width="24" height="12" aria-hidden="true">'
        f'<path d="M0 6H24" stroke="{look.colour}" stroke-width="1.6"/>{shape}</svg>'
    )


_STROKES = {
    "solid": "",
    "dash": "7 4",
    "dot": "2 3",
    "dashdot": "7 3 2 3",
    "longdash": "11 4",
    "longdashdot": "11 3 2 3",
}


def _dash_sample(dash: str) -> str:
    pattern = f' stroke-dasharray="{_STROKES[dash]}"' if _STROKES[dash] else ""
    return (
        '<svg class="sample" viewBox="0 0 34 12" width="34" height="12" aria-hidden="true">'
        f'<path d="M0 6H34" stroke="#222" stroke-width="1.8"{pattern}/></svg>'
    )


# -- warnings ----------------------------------------------------------------------------


def _warnings(found: Sequence[Remark]) -> str:
    if not found:
        return "<p>None.</p>"
    groups: dict[tuple[Severity, str], list[Remark]] = {}
    for remark in found:
        groups.setdefault((remark.severity, remark.topic), []).append(remark)
    return "\n".join(
        f'<section class="remarks {severity.value}">'
        f"<h3>{_MARKS[severity]} {escape(topic)}</h3><p>{escape(ABOUT[topic])}</p>"
        f"{_listed(group)}</section>"
        for (severity, topic), group in groups.items()
    )


def _listed(group: Sequence[Remark]) -> str:
    listed = f"<ul>{''.join(_remark(remark) for remark in group)}</ul>"
    if len(group) <= MOST_REMARKS:
        return listed
    return f"<details><summary>{len(group)} places</summary>{listed}</details>"


_MARKS = {
    Severity.WARNING: '<span class="mark" role="img" aria-label="warning">▲</span>',
    Severity.NOTE: '<span class="mark" role="img" aria-label="note">●</span>',
}


def _remark(remark: Remark) -> str:
    return f'<li><span class="where">{escape(remark.where)}</span> {escape(remark.text)}</li>'
