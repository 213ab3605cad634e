"""Charts of what the fields of a results file show: its observables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.observed import (
    DECADES,
    ObservableAxes,
    drawn_unit,
    observable_axes,
    unknown_observables,
)
from roughbench.observables import OBSERVABLES, Observable, clusters
from roughbench.report.charts import ChartSeries, Ranges, ReportChart
from roughbench.report.sources import ReportSource
from roughbench.report.styles import THEORY_COLOUR, DrawnModel, PageStyle, drawn_models

FloatArray = NDArray[np.float64]

MOST_PRESSURES = 8
"""Pressures at which observables are drawn; of more, some between the ends are left out."""


def charted_observables(source: ReportSource) -> Mapping[str, Observable]:
    """Return every observable by its variable: patches late, what only the file knows last."""
    known = sorted(OBSERVABLES.values(), key=lambda one: one is clusters)
    return {one.variable: one for one in [*known, *unknown_observables(source.results)]}


def drawn_pressures(source: ReportSource) -> list[float]:
    """Return the pressures p/E* at which the observables of a file are drawn."""
    charted = charted_observables(source)
    found = {
        float(p)
        for _, result in source.models()
        if any(f"{name}_bin" in result for name in charted)
        for p in result["pressure"]
    }
    pressures = sorted(found)
    if len(pressures) <= MOST_PRESSURES:
        return pressures
    chosen = np.linspace(0, len(pressures) - 1, MOST_PRESSURES).round().astype(int)
    return [pressures[k] for k in chosen]


def pressure_key(pressure: float) -> str:
    """Return the name of a pressure for the page's script."""
    return f"{pressure:.6e}"


def observable_charts(
    source: ReportSource, styles: Mapping[str, PageStyle]
) -> Iterator[ReportChart]:
    """Yield a chart for every observable that is in the file."""
    models = list(drawn_models(source, styles))
    pressures = drawn_pressures(source)
    for name, kind in charted_observables(source).items():
        shown = observable_axes(source.results, kind)
        series = [
            one
            for model in models
            if f"{name}_bin" in model.result
            for p in pressures
            for one in _series(model, kind, p, shown)
        ]
        if series:
            yield ReportChart(
                name.replace("_", "-"),
                kind.title,
                f"{kind.title} at single pressures, {source.name}",
                shown.x_label.replace("$", ""),
                shown.y_label.replace("$", ""),
                series,
                _ranges(series),
                (kind.x_is_log, True),
            )


def _series(
    model: DrawnModel, observable: Observable, pressure: float, shown: ObservableAxes
) -> Iterator[ChartSeries]:
    """Yield the curve of a model at one pressure, and Persson's theory if it is there."""
    result, name = model.result, observable.variable
    there = np.flatnonzero(np.isclose(result["pressure"], pressure, rtol=1e-9))
    if there.size == 0:
        return
    x = np.asarray(result[f"{name}_bin"], float)
    unit = drawn_unit(result, observable) * shown.divisor(result)
    x = x * shown.x

    def values(kind: str) -> FloatArray:
        return np.asarray(result[f"{name}_{kind}"], float)[int(there[0])] / unit

    curves = [(model.name, values("mean"), values("sem"), model.style.colour, model.dash)]
    if f"{name}_persson" in result:
        none = np.full_like(x, math.nan)
        theory = f"Persson, beside {model.name}"
        curves.append((theory, values("persson"), none, THEORY_COLOUR, "dot"))
    for title, y, error, colour, dash in curves:
        kept = _shown(y)
        y, error = np.where(y > 0.0, y, math.nan)[kept], error[kept]
        meta = model.meta | {"pressure": pressure_key(pressure)}
        yield ChartSeries(title, meta, x[kept], y, y - error, y + error, colour, dash)


def _shown(y: FloatArray) -> NDArray[np.bool_]:
    """Return which places say something: neither rings without waves nor empty ends."""
    drawn = np.isfinite(y) & (y > 0.0)
    begun = np.logical_or.accumulate(drawn)
    goes_on = np.logical_or.accumulate(drawn[::-1])[::-1]
    return ~np.isnan(y) & begun & goes_on


def _ranges(series: list[ChartSeries]) -> Ranges:
    values = np.concatenate([one.y for one in series])
    values = values[np.isfinite(values)]
    if values.size == 0:
        return {"log": None, "linear": None}
    high = float(values.max())
    low = max(float(values.min()), DECADES * high)
    return {"log": [math.log10(low / 2.0), math.log10(high * 2.0)], "linear": None}
