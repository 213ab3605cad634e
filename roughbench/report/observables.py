"""Charts of what a results file says about fields: observables, and maps of the contact."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.looks import PERSSON
from roughbench.figures.observed import DECADES
from roughbench.report.charts import (
    Chart,
    Line,
    content,
    curve_name,
    figure_of,
    line_traces,
)
from roughbench.report.looks import Look, experiment_dashes
from roughbench.report.markup import escape, number
from roughbench.report.sources import Source
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]

MOST_PRESSURES = 8
"""Pressures at which observables are drawn; of more, some between the ends are left out."""
MOST_MAPS = 12
MOST_POINTS = 256
"""Points of a map per side; finer fields are averaged over squares."""
_THEORY = Look(PERSSON.colour, "circle")
_WHITE_TO_DARK = [[0.0, "#ffffff"], [0.004, "#dce9c8"], [0.35, "#56b48a"], [1.0, "#1d2a5e"]]


@dataclass(frozen=True, slots=True)
class _Words:
    """Title and axes of one observable."""

    title: str
    x: str
    y: str
    is_log: tuple[bool, bool] = (True, True)
    is_spectrum: bool = False


_OBSERVABLES: Mapping[str, _Words] = {
    "pressure_pdf": _Words(
        "Distribution of the contact pressure", "pressure σ/(E*ξ)", "density", (False, True)
    ),
    "gap_pdf": _Words("Distribution of the gap", "gap g/h<sub>rms</sub>", "density"),
    "stress_spectrum": _Words(
        "Spectrum of the contact pressure",
        "wavevector q",
        "C<sub>σ</sub>(q)/E*²; of lines C<sub>σ</sub>/πq",
        is_spectrum=True,
    ),
    "contact_spectrum": _Words(
        "Spectrum of the contact",
        "wavevector q",
        "C<sub>c</sub>(q); of lines C<sub>c</sub>/πq",
        is_spectrum=True,
    ),
    "energy_spectrum": _Words(
        "Elastic energy by wavevector", "wavevector q", "energy per ring"
    ),
    "clusters": _Words("Patches of contact", "points of a patch", "number of patches"),
}


def drawn_pressures(source: Source) -> list[float]:
    """Return the pressures p/E* at which the observables of a file are drawn."""
    found = {
        float(p)
        for _, result in source.models()
        if any(f"{name}_bin" in result for name in _OBSERVABLES)
        for p in result["pressure"]
    }
    pressures = sorted(found)
    if len(pressures) <= MOST_PRESSURES:
        return pressures
    chosen = np.linspace(0, len(pressures) - 1, MOST_PRESSURES).round().astype(int)
    return [pressures[k] for k in chosen]


def pressure_key(pressure: float) -> str:
    """Return how the page's script calls a pressure."""
    return f"{pressure:.6e}"


def observable_charts(source: Source, looks: dict[str, Look]) -> list[Chart]:
    """Return a chart for every observable that is in the file.

    Parameters
    ----------
    source : Source
    looks : dict of str to Look
        By label.
    """
    charts = []
    pressures = drawn_pressures(source)
    for name, words in _OBSERVABLES.items():
        traces = [
            trace
            for experiment, result in source.models()
            if f"{name}_bin" in result
            for p in pressures
            for trace in _traces(source, experiment, result, name, p, looks[result.label])
        ]
        if traces:
            figure = figure_of(traces, words.x, words.y, is_log=words.is_log)
            label = f"{words.title} at single pressures, {source.name}"
            drawn = content(figure, _ranges(traces))
            charts.append(Chart(name.replace("_", "-"), words.title, label, drawn))
    return charts


def _traces(
    source: Source, experiment: str, result: ModelResult, name: str, pressure: float, look: Look
) -> Iterator[dict[str, Any]]:
    there = np.flatnonzero(np.isclose(result["pressure"], pressure, rtol=1e-9))
    if there.size == 0:
        return
    k = int(there[0])
    x = np.asarray(result[f"{name}_bin"], float)
    is_line = result.attributes.get("dimension") == 1 and _OBSERVABLES[name].is_spectrum
    unit = math.pi * x if is_line else np.ones_like(x)
    y = np.asarray(result[f"{name}_mean"], float)[k] / unit
    error = np.asarray(result[f"{name}_sem"], float)[k] / unit
    meta = {
        "model": result.label,
        "experiment": experiment,
        "pressure": pressure_key(pressure),
    }
    dash = experiment_dashes(list(source.results))[experiment]
    title = curve_name(source, experiment, result)
    yield from _thin(line_traces(_line(x, y, error, title, meta), look, dash), mode="lines")
    if f"{name}_persson" in result:
        theory = np.asarray(result[f"{name}_persson"], float)[k] / unit
        line = _line(x, theory, np.full_like(x, math.nan), f"Persson, beside {title}", meta)
        yield from _thin(line_traces(line, _THEORY, "dot")[1:], mode="lines")


def _line(
    x: FloatArray, y: FloatArray, error: FloatArray, name: str, meta: dict[str, Any]
) -> Line:
    """Return a line without the places that say nothing: rings without waves, empty ends."""
    drawn = np.isfinite(y) & (y > 0.0)
    known = ~np.isnan(y) & np.logical_or.accumulate(drawn) & _until_last(drawn)
    x, y, error = x[known], np.where(drawn, y, math.nan)[known], error[known]
    return Line(x, y, y - error, y + error, [], name, meta)


def _until_last(drawn: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.logical_or.accumulate(drawn[::-1])[::-1]


def _thin(traces: list[dict[str, Any]], mode: str) -> Iterator[dict[str, Any]]:
    for trace in traces:
        if trace["meta"]["role"] == "curve":
            del trace["text"], trace["marker"]
            trace["mode"] = mode
            trace["hovertemplate"] = f"{trace['name']}<br>%{{x:.3g}}: %{{y:.3g}}<extra></extra>"
        yield trace


def _ranges(traces: list[dict[str, Any]]) -> dict[str, list[float] | None]:
    values = [
        y
        for trace in traces
        if trace["meta"]["role"] == "curve"
        for y in trace["y"]
        if y is not None
    ]
    if not values:
        return {"log": None, "linear": None}
    high = max(values)
    low = max(min(values), DECADES * high)
    return {"log": [math.log10(low / 2.0), math.log10(high * 2.0)], "linear": None}


# -- fields ------------------------------------------------------------------------------


def field_charts(source: Source) -> list[Chart]:
    """Return maps of the contact pressure of the fields that are kept in the file."""
    maps = []
    for experiment, result in source.models():
        if "field_pressure" not in result:
            continue
        slope = float(result.attributes["rms_slope"])
        for k, field in enumerate(np.asarray(result["field_pressure"], float)):
            maps.append(_map(source, experiment, result, k, np.atleast_2d(field) / slope))
    return maps[:MOST_MAPS]


def n_fields(source: Source) -> int:
    """Return how many fields are kept in the file."""
    return sum(
        len(result["field_pressure"])
        for _, result in source.models()
        if "field_pressure" in result
    )


def _map(
    source: Source, experiment: str, result: ModelResult, k: int, pressure: FloatArray
) -> Chart:
    trace = {
        "type": "heatmap",
        "z": _quantized(_coarse(pressure)),
        "zmin": 0,
        "zmax": 255,
        "colorscale": _WHITE_TO_DARK,
        "colorbar": {
            "title": {"text": "σ/(E*ξ)", "side": "right"},
            "tickvals": [0, 63.75, 127.5, 191.25, 255],
            "ticktext": ["0", "¼", "½", "¾", "≥ 1"],
            "thickness": 12,
            "outlinewidth": 0,
        },
        "hoverinfo": "skip",
        "meta": {"model": result.label, "experiment": experiment, "role": "map"},
    }
    figure = figure_of([trace], "", "", is_log=(False, False))
    bare = {"showticklabels": False, "ticks": "", "minor": {"ticks": ""}, "showgrid": False}
    figure.update_xaxes(**bare)
    figure.update_yaxes(**bare)
    if min(pressure.shape) > 1:
        figure.update_yaxes(scaleanchor="x", constrain="domain")
        figure.update_xaxes(constrain="domain")
    parts = [escape(result.label)]
    if len(source.results) > 1:
        parts.append(source.experiment(experiment))
    if "field_nominal_pressure" in result:
        parts.append(f"p/E* = {number(float(result['field_nominal_pressure'][k]))}")
    if "field_realization" in result:
        parts.append(f"realization {int(result['field_realization'][k])}")
    label = f"Map of the contact pressure of {result.label}, {experiment}, {source.name}"
    key = f"field-{experiment}-{result.label}-{k}".replace("=", "-").replace(",", "-")
    return Chart(key, ", ".join(parts), label, content(figure), has_axes=False)


def _coarse(field: FloatArray) -> FloatArray:
    """Return the field with at most MOST_POINTS points per side, averaged over squares."""
    for axis in (0, 1):
        factor = -(-field.shape[axis] // MOST_POINTS)
        if factor > 1:
            cut = field.shape[axis] // factor * factor
            parts = np.moveaxis(field, axis, 0)[:cut]
            field = np.moveaxis(parts.reshape(-1, factor, parts.shape[1]).mean(axis=1), 0, axis)
    return field


def _quantized(field: FloatArray) -> NDArray[np.uint8]:
    """Return values from 0 to 1 as whole numbers from 0 to 255; whatever touches is not 0."""
    steps = np.ceil(255.0 * np.clip(np.nan_to_num(field), 0.0, 1.0))
    return steps.astype(np.uint8)
