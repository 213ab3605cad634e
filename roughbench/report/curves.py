"""The curves of a results file over the pressure, as charts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.curves import Curve, Quantity, curve_of
from roughbench.report.charts import Chart, Line, Ranges, content, curve, curve_name
from roughbench.report.looks import Look, experiment_dashes
from roughbench.report.markup import number, with_error
from roughbench.report.sources import Source
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]
Scale = Callable[[ModelResult, FloatArray], FloatArray]


def _as_it_is(_result: ModelResult, pressure: FloatArray) -> FloatArray:
    return np.ones_like(pressure)


def _slope_by_pressure(result: ModelResult, pressure: FloatArray) -> FloatArray:
    return float(result.attributes["rms_slope"]) / pressure


def _by_pressure(_result: ModelResult, pressure: FloatArray) -> FloatArray:
    return 1.0 / pressure


@dataclass(frozen=True, slots=True)
class Plot:
    """One kind of chart over the pressure.

    Attributes
    ----------
    key : str
    title : str
        HTML.
    axis : str
        Of the ordinate, in plotly's subset of HTML.
    quantity : {"area", "separation", "stiffness"}
        Where its values come from.
    scale : callable
        What they are multiplied by, at each pressure.
    lowest, highest : float
        What is cut off at first, until the reader zooms out.
    is_log : bool
        Whether the ordinate is logarithmic at first.
    """

    key: str
    title: str
    axis: str
    quantity: Quantity
    scale: Scale = _as_it_is
    lowest: float = 0.0
    highest: float = math.inf
    is_log: bool = True


PLOTS = (
    Plot("area", "Contact area", "A/A<sub>0</sub>", "area"),
    Plot(
        "kappa",
        "Is the area proportional to the pressure? κ = (A/A<sub>0</sub>) E*ξ/p",
        "κ = (A/A<sub>0</sub>) E*ξ/p",
        "area",
        _slope_by_pressure,
    ),
    Plot(
        "separation",
        "Mean separation",
        "ū/h<sub>rms</sub>",
        "separation",
        lowest=1e-4,
        is_log=False,
    ),
    Plot("stiffness", "Stiffness", "K h<sub>rms</sub>/E*", "stiffness", highest=1e2),
    Plot(
        "stiffness-by-pressure",
        "Is the stiffness proportional to the pressure? K h<sub>rms</sub>/p",
        "K h<sub>rms</sub>/p",
        "stiffness",
        _by_pressure,
        highest=1e3,
    ),
)


def curve_charts(source: Source, looks: dict[str, Look]) -> list[Chart]:
    """Return the charts of all curves over the pressure.

    Parameters
    ----------
    source : Source
    looks : dict of str to Look
        By label.

    Returns
    -------
    list of Chart
        One of each of :data:`PLOTS` whose quantity a model gives.
    """
    return [
        _chart(source, plot, looks)
        for plot in PLOTS
        if any(plot.quantity in result for _, result in source.models())
    ]


def _chart(source: Source, plot: Plot, looks: dict[str, Look]) -> Chart:
    dashes = experiment_dashes(list(source.results))
    curves: list[dict[str, Any]] = []
    seen = []
    for experiment, result in source.models():
        if plot.quantity not in result:
            continue
        own = curve_of(result, plot.quantity)
        factor = plot.scale(result, own.pressure)
        line = Line(
            x=own.pressure,
            y=own.value * factor,
            lower=own.lower * factor,
            upper=own.upper * factor,
            words=_hover(own, factor, plot),
            name=curve_name(source, experiment, result),
            meta={"model": result.label, "experiment": experiment},
        )
        curves.append(curve(line, looks[result.label], dashes[experiment]))
        seen.append(line.y)
    ranges = _ranges(np.concatenate(seen), plot)
    label = (
        f"{_plain(plot.axis)} against p/E*, {len(curves)} curves of {source.name}; "
        "the tables of the report say in numbers what they show"
    )
    log = (True, plot.is_log)
    text = content(curves, "pressure p/E*", plot.axis, is_log=log, ranges=ranges)
    return Chart(plot.key, plot.title, label, text)


def _hover(curve: Curve, factor: FloatArray, plot: Plot) -> list[str]:
    words = []
    for p, value, low, high, is_median, f in zip(
        curve.pressure,
        curve.value,
        curve.lower,
        curve.upper,
        curve.is_median,
        factor,
        strict=True,
    ):
        if is_median:
            shown = f"{number(value * f)} (median; {number(low * f)} to {number(high * f)})"
        else:
            shown = with_error(value * f, (high - low) / 2.0 * f, 4)
        words.append(f"p/E* = {number(p)}<br>{plot.axis.partition(' = ')[0]} = {shown}")
    return words


def _ranges(values: FloatArray, plot: Plot) -> Ranges:
    """Return what both kinds of ordinate show at first; None: everything."""
    finite = values[np.isfinite(values) & (values > 0.0)]
    if finite.size == 0:
        return {"log": None, "linear": None}
    low = max(float(finite.min()), plot.lowest)
    high = min(float(finite.max()), plot.highest)
    log = [math.log10(low / 1.4), math.log10(high * 1.4)] if low < high else None
    top = min(float(finite.max()), 4.0 * float(np.quantile(finite, 0.75)))
    return {"log": log, "linear": [0.0, 1.05 * top]}


def _plain(text: str) -> str:
    return text.replace("<sub>", "").replace("</sub>", "")
