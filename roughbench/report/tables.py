"""Tables of the report: what was compared, the fits, and where the results come from."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

from roughbench.fits.tables import Cell, Table, departure_tables, law_tables
from roughbench.report.markup import (
    escape,
    muted,
    number,
    prose,
    series,
    table,
    with_error,
    without_folders,
)
from roughbench.report.sources import Source
from roughbench.report.warnings import is_random
from roughbench.results import Attribute, ModelResult
from roughbench.verdict import Case

_SURFACE = {
    "hurst": "H",
    "q_min": "q<sub>0</sub>",
    "q_rolloff": "q<sub>r</sub>",
    "q_max": "q<sub>1</sub>",
    "rms_slope": "ξ",
    "rms_height": "h<sub>rms</sub>",
    "length": "L",
}
_SPEC_NAMES = {"below_rolloff": "below_qr"}
"""Attribute of the results → key of the spec, where they differ."""
_NOT_OPTIONS = {*_SURFACE, "surface", "seed", "grid_points"}


# -- what was compared -------------------------------------------------------------------


def compared(sources: Sequence[Source]) -> str:
    """Return a table of the files: surfaces, models, pressures."""
    rows = [
        (
            f"{escape(source.name)}<br>{muted(source.results.name)}",
            _surface(source),
            _experiments(source),
            _models(source),
            _pressures(source),
        )
        for source in sources
    ]
    headings = ("File, run", "Surfaces", "Sweep", "Models", "Pressures p/E*")
    return table(headings, rows, numeric=False)


def _surface(source: Source) -> str:
    known = [result.attributes for _, result in source.models()]
    parts = []
    for name, symbol in _SURFACE.items():
        values = [float(attributes[name]) for attributes in known if name in attributes]
        if values:
            parts.append(f"{symbol}&nbsp;=&nbsp;{series(values)}")
    heights = sorted({_file_name(a["heights"]) for a in known if a["surface"] == "file"})
    return ", ".join([*parts, *(f"heights of {escape(name)}" for name in heights)])


def _file_name(path: Attribute) -> str:
    return PurePosixPath(str(path).replace("\\", "/")).name


def _experiments(source: Source) -> str:
    if len(source.results) == 1:
        return "–"
    return "; ".join(source.experiment(name) for name in source.results)


def _models(source: Source) -> str:
    found: dict[str, list[ModelResult]] = {}
    for _, result in source.models():
        found.setdefault(result.label, []).append(result)
    return "<br>".join(
        f"{escape(models[0].title)}{_label(models[0])}{_counted(models)}"
        for models in found.values()
    )


def _label(result: ModelResult) -> str:
    return "" if result.label == result.kind else f" ({escape(result.label)})"


def _counted(models: Sequence[ModelResult]) -> str:
    if not any(is_random(model) for model in models):
        return ""
    counts = series([model.n_realizations for model in models])
    points = [int(m.attributes["grid_points"]) for m in models if "grid_points" in m.attributes]
    size = f" of {series(points, 6)} points a side" if points else ""
    kind = "line" if models[0].attributes.get("dimension") == 1 else "surface"
    plural = "" if counts == "1" else "s"
    return f", {counts} {kind}{plural}{size}"


def _pressures(source: Source) -> str:
    values = [float(p) for _, result in source.models() for p in result["pressure"]]
    return series(values, most=3)


# -- fits --------------------------------------------------------------------------------


def fit_tables(source: Source, cases: Sequence[Case]) -> str:
    """Return the tables of ``roughbench fit``, for every experiment of a file.

    Parameters
    ----------
    source : Source
    cases : sequence of Case
        Its experiments, with their fits.
    """
    blocks = []
    for case in cases:
        title = f"{escape(source.name)}: {source.experiment(case.experiment)}"
        blocks.append(f"<h3>{title}</h3>")
        blocks += [_fit_table(source, fits) for fits in law_tables(case.fits)]
        if case.reference is None:
            continue
        others = [name for name in case.fits if name != case.reference]
        if ranges := list(departure_tables(case.fits, others)):
            blocks.append(_departures(source, ranges, case.reference))
    return "\n".join(blocks)


def _fit_table(source: Source, fits: Table) -> str:
    headings = ("Model", *(_symbols(heading) for heading in fits.headings))
    rows = [
        (escape(source.title(label)), *(_cell(cell) for cell in cells))
        for label, cells in fits.rows.items()
    ]
    return table(headings, rows, caption=_symbols(fits.title))


def _departures(source: Source, ranges: Sequence[Table], reference: str) -> str:
    headings = ("Model", *(_symbols(fits.title) for fits in ranges))
    labels = dict.fromkeys(name for fits in ranges for name in fits.rows)
    rows = [
        (
            escape(source.title(name)),
            *(_range(fits.rows[name]) if name in fits.rows else "–" for fits in ranges),
        )
        for name in labels
    ]
    exact = escape(source.title(reference))
    caption = f"Pressures p/E* between which a model agrees with {exact}"
    return table(headings, rows, caption=caption)


def _range(cells: Sequence[Cell]) -> str:
    if not all(cell.estimate.is_given for cell in cells):
        return "not given"
    if not all(math.isfinite(cell.estimate.value) for cell in cells):
        return "nowhere"
    return '<span class="to">to</span> '.join(f"<span>{_cell(cell)}</span> " for cell in cells)


def _cell(cell: Cell) -> str:
    estimate = cell.estimate
    if not estimate.is_given:
        return "not given"
    if cell.bound and math.isfinite(estimate.value):
        return f"{cell.bound} {number(estimate.value)}"
    return with_error(estimate.value, estimate.error)


def _symbols(text: str) -> str:
    """Return a heading of the fits with the subscripts that a terminal has not."""
    return re.sub(r"\b([Aup])0\b", r"\1<sub>0</sub>", prose(text)).replace("~", "∼")


# -- provenance --------------------------------------------------------------------------


def provenance(source: Source) -> str:
    """Return the spec of a file, what its models are, and how to compute it again."""
    results = source.results
    name = escape(results.name or "spec")
    file = escape(source.name.split("/")[-1])
    facts = {
        "Name of the run": escape(results.name),
        "Compute it again": f"save the spec below as <code>{name}.yaml</code>, then "
        f"<code>roughbench run {name}.yaml -o {file}</code>",
        "Fingerprint": f'<code class="hash">{escape(results.spec_sha256)}</code>, equal for '
        "equal specs (<code>spec_sha256</code> in the results file)",
    }
    listed = "".join(
        f"<div><dt>{fact}</dt><dd>{text}</dd></div>" for fact, text in facts.items()
    )
    spec = escape(without_folders(results.spec_text.strip()))
    return (
        f'<h3>{escape(source.name)}</h3>\n<dl class="facts">{listed}</dl>\n'
        f'{_model_table(source)}\n<pre tabindex="0"><code>{spec}</code></pre>'
    )


def _model_table(source: Source) -> str:
    found: dict[str, list[ModelResult]] = {}
    for _, result in source.models():
        found.setdefault(result.label, []).append(result)
    rows = [
        (
            escape(label),
            escape(models[0].kind),
            escape(models[0].title),
            series([model.n_realizations for model in models]),
            _values(models, "seed"),
            "; ".join(_options(models)) or "–",
        )
        for label, models in found.items()
    ]
    headings = ("Name in the spec", "kind", "Model", "realizations", "seed", "options")
    return table(headings, rows, numeric=False)


def _options(models: Sequence[ModelResult]) -> Iterator[str]:
    names = dict.fromkeys(name for model in models for name in model.attributes)
    for name in names:
        if name not in _NOT_OPTIONS:
            yield f"{escape(_SPEC_NAMES.get(name, name))} {_values(models, name)}"


def _values(models: Sequence[ModelResult], name: str) -> str:
    values = dict.fromkeys(m.attributes[name] for m in models if name in m.attributes)
    return ", ".join(
        escape(without_folders(value)) if isinstance(value, str) else number(value, 6)
        for value in values
    )
