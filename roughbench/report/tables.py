"""Tables of the report: what was compared, the fits, and where the results come from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from roughbench.figures.axes import axes_of
from roughbench.fits import Estimate
from roughbench.fits.tables import Table, departure_tables, law_tables
from roughbench.models.registry import has_option
from roughbench.numbers import is_lopsided, measured, number, series, with_interval
from roughbench.report.sources import ReportSource
from roughbench.report.text import RichText, Span, from_heading, joined, without_folders
from roughbench.results import MODULUS, ModelResult
from roughbench.units import in_words, prefix
from roughbench.verdict import FittedExperiment
from roughbench.verdict.trust import sample_noun

TableCell = str | RichText

_SURFACE = {
    "hurst": "H",
    "q_min": "q_0",
    "q_rolloff": "q_r",
    "q_max": "q_1",
    "rms_slope": "ξ",
    "rms_height": "h_rms",
    "length": "L",
}
_SI = {"q_min": "1/m", "q_rolloff": "1/m", "q_max": "1/m", "rms_height": "m", "length": "m"}
"""Units of those that have one, of results with units."""
_SPEC_NAMES = {"below_rolloff": "below_qr"}
"""Attribute of the results → key of the spec, where they differ."""
_NOT_OPTIONS = {
    *(*_SURFACE, MODULUS, "surface", "seed", "warnings"),
    *("grid_points", "grid_columns"),
}


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A table of the page; the first cell of a row is its heading.

    A title, if there is one, stands above it and notes beneath; cells that are numbers do not
    wrap.
    """

    headings: Sequence[TableCell]
    rows: Sequence[Sequence[TableCell]]
    title: TableCell = ""
    notes: Sequence[TableCell] = ()
    is_numeric: bool = True


# -- what was compared -------------------------------------------------------------------


def compared(sources: Sequence[ReportSource]) -> ReportTable:
    """Return a table of the files: surfaces, models, pressures."""
    rows = [
        (
            joined([source.name, [Span(source.results.name, "muted")]], "\n"),
            _surface(source),
            _experiments(source),
            joined([_counted(models) for models in source.by_label().values()], "\n"),
            _pressures(source),
        )
        for source in sources
    ]
    headings = ("File, run", "Surfaces", "Sweep", "Models", "Pressures")
    return ReportTable(headings, rows, is_numeric=False)


def _pressures(source: ReportSource) -> str:
    axis = axes_of(source.results).pressure
    values = (
        float(p) / axis.divisor(result)
        for _, result in source.models()
        for p in result["pressure"]
    )
    text = series(values, most=3)
    if not axis.unit:
        return f"{axis.symbol} = {text}"
    modulus = next((r.modulus for _, r in source.models() if r.modulus is not None), math.nan)
    return f"{text} {axis.unit}, E* = {in_words(modulus, 'Pa')}"


def _surface(source: ReportSource) -> RichText:
    known = [result.attributes for _, result in source.models()]
    parts: list[TableCell] = []
    for name, symbol in _SURFACE.items():
        values = [float(attributes[name]) for attributes in known if name in attributes]
        if values:
            text = series(values)
            if source.results.has_units and name in _SI:
                factor, unit = prefix(values, _SI[name])
                text = f"{series([value * factor for value in values])} {unit}"
            parts.append([*from_heading(symbol), Span(f"\xa0=\xa0{text}")])
    # An option of that name is no file.
    paths = [
        str(one.attributes["heights"])
        for _, one in source.models()
        if one.is_measured and not has_option(one.kind, "heights")
    ]
    names = {PurePosixPath(path.replace("\\", "/")).name for path in paths}
    return joined([*parts, *(f"heights of {name}" for name in sorted(names))])


def _experiments(source: ReportSource) -> TableCell:
    if not source.has_sweep:
        return "–"
    return joined([source.experiment(name) for name in source.results], "; ")


def _counted(models: Sequence[ModelResult]) -> str:
    """Return a model's title and name, and how many surfaces of which size it looked at."""
    first = models[0]
    name = first.title if first.label == first.kind else f"{first.title} ({first.label})"
    if not any(model.is_random for model in models):
        return name
    counts = series([model.n_realizations for model in models])
    noun = sample_noun(first)
    points = [int(m.attributes["grid_points"]) for m in models if "grid_points" in m.attributes]
    size = f" of {series(points, 6)} points{' a side' * (noun == 'surface')}" if points else ""
    return f"{name}, {counts} {noun}{'s' * (counts != '1')}{size}"


# -- fits --------------------------------------------------------------------------------


def fit_tables(
    sources: Sequence[ReportSource], experiments: Sequence[FittedExperiment]
) -> Iterator[tuple[RichText, list[ReportTable]]]:
    """Yield a heading and the tables of ``roughbench fit`` for every experiment."""
    by_name = {source.name: source for source in sources}
    for one in experiments:
        source = by_name[one.source]
        tables = [_fit_table(source, fits) for fits in law_tables(one.fits)]
        if one.reference is not None:
            others = [model.label for model in one.contenders]
            ranges = list(departure_tables(one.fits, others))
            tables += [_departures(source, ranges, one.reference)] * bool(ranges)
        yield joined([source.name, source.experiment(one.experiment)], ": "), tables


def _fit_table(source: ReportSource, fits: Table) -> ReportTable:
    rows = [
        (source.title(label), *(_cell(found) for found in row))
        for label, row in fits.rows.items()
    ]
    headings: list[TableCell] = ["Model", *(from_heading(heading) for heading in fits.headings)]
    return ReportTable(headings, rows, from_heading(fits.title))


def _departures(source: ReportSource, ranges: Sequence[Table], reference: str) -> ReportTable:
    labels = dict.fromkeys(name for fits in ranges for name in fits.rows)
    rows = [
        (
            source.title(name),
            *(_range(fits.rows[name]) if name in fits.rows else "–" for fits in ranges),
        )
        for name in labels
    ]
    headings: list[TableCell] = ["Model", *(from_heading(fits.title) for fits in ranges)]
    exact = source.title(reference)
    title = f"Pressures p/E* between which a model agrees with {exact}"
    return ReportTable(headings, rows, title)


def _range(ends: Sequence[Estimate]) -> TableCell:
    if not all(end.is_given for end in ends):
        return "not given"
    if not all(math.isfinite(end.value) for end in ends):
        return "nowhere"
    start, end = map(_cell, ends)
    return [Span(f"{start} "), Span("to", "muted"), Span(f" {end}")]


def _cell(found: Estimate) -> str:
    if not found.is_given:
        return "not given"
    if not found.bound and is_lopsided(found.value, found.low, found.high):
        return with_interval(found.value, found.low, found.high)
    return measured(found.value, math.nan if found.bound else found.error, found.bound)


# -- where the results come from ---------------------------------------------------------


def model_table(source: ReportSource) -> ReportTable:
    """Return the models of a file with kind, realizations, seed and options."""
    rows = [
        (
            label,
            models[0].kind,
            models[0].title,
            series([model.n_realizations for model in models]),
            _values(models, "seed"),
            "; ".join(_options(models)) or "–",
        )
        for label, models in source.by_label().items()
    ]
    headings = ("Name in the spec", "kind", "Model", "realizations", "seed", "options")
    return ReportTable(headings, rows, is_numeric=False)


def _options(models: Sequence[ModelResult]) -> Iterator[str]:
    for name in dict.fromkeys(name for model in models for name in model.attributes):
        if name not in _NOT_OPTIONS:
            yield f"{_SPEC_NAMES.get(name, name)} {_values(models, name)}"


def _values(models: Sequence[ModelResult], name: str) -> str:
    values = dict.fromkeys(m.attributes[name] for m in models if name in m.attributes)
    return ", ".join(
        without_folders(value) if isinstance(value, str) else number(value, 6)
        for value in values
    )
