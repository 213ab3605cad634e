"""Charts of what the fields of a results file show: its observables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.looks import PERSSON
from roughbench.figures.observed import DECADES
from roughbench.report.charts import Chart, Line, Ranges, content, curve, curve_name
from roughbench.report.looks import Look, experiment_dashes
from roughbench.report.sources import Source
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]

MOST_PRESSURES = 8
"""Pressures at which observables are drawn; of more, some between the ends are left out."""
_THEORY = Look(PERSSON.colour, "circle")


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
        curves = [
            drawn
            for experiment, result in source.models()
            if f"{name}_bin" in result
            for p in pressures
            for drawn in _curves(source, experiment, result, name, p, looks[result.label])
        ]
        if curves:
            label = f"{words.title} at single pressures, {source.name}"
            ranges = _ranges(curves)
            text = content(curves, words.x, words.y, is_log=words.is_log, ranges=ranges)
            charts.append(Chart(name.replace("_", "-"), words.title, label, text))
    return charts


def _curves(
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
    yield curve(_line(x, y, error, title, meta), look, dash, has_symbols=False)
    if f"{name}_persson" in result:
        theory = np.asarray(result[f"{name}_persson"], float)[k] / unit
        line = _line(x, theory, np.full_like(x, math.nan), f"Persson, beside {title}", meta)
        yield curve(line, _THEORY, "dot", has_symbols=False)


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


def _ranges(curves: list[dict[str, Any]]) -> Ranges:
    values = [y for drawn in curves for y in drawn["y"] if y is not None]
    if not values:
        return {"log": None, "linear": None}
    high = max(values)
    low = max(min(values), DECADES * high)
    return {"log": [math.log10(low / 2.0), math.log10(high * 2.0)], "linear": None}
