"""The curves of a results file over the pressure, as charts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.axes import Axes, Axis, axes_of
from roughbench.figures.curves import DrawnCurve, curve_of
from roughbench.numbers import number, with_error
from roughbench.quantities import Quantity, compared
from roughbench.report.charts import ChartSeries, Ranges, ReportChart
from roughbench.report.sources import ReportSource
from roughbench.report.styles import DrawnModel, PageStyle, drawn_models
from roughbench.report.text import from_notation, plain, plotly_text
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]


def _rms_slope(result: ModelResult) -> float:
    return float(result.attributes["rms_slope"])


@dataclass(frozen=True, slots=True)
class PressureChart:
    """One kind of chart over the pressure.

    Attributes
    ----------
    key : str
    title, axis : str
        With formulas in plain text; the axis is the ordinate, without units.
    quantity : str
        Where its values come from.
    per_pressure : callable, optional
        What the values are multiplied by where they are divided by the pressure: such charts
        are of dimensionless numbers, with and without units.
    lowest, highest : float
        What is cut off at first, until the reader zooms out; without units.
    is_log : bool
        Whether the ordinate is logarithmic at first.
    """

    key: str
    title: str
    axis: str
    quantity: str
    per_pressure: Callable[[ModelResult], float] | None = None
    lowest: float = 0.0
    highest: float = math.inf
    is_log: bool = True


def _of_quantity(quantity: Quantity) -> PressureChart:
    return PressureChart(
        quantity.name,
        quantity.words.capitalize(),
        quantity.scaled,
        quantity.name,
        lowest=quantity.lowest,
        highest=quantity.highest,
        is_log=quantity.at_full_contact != 0.0,
    )


_KAPPA = "κ = (A/A_0) E*ξ/p"
_BESIDE = {
    "area": PressureChart(
        "kappa",
        f"Is the area proportional to the pressure? {_KAPPA}",
        _KAPPA,
        "area",
        _rms_slope,
    ),
    "stiffness": PressureChart(
        "stiffness-by-pressure",
        "Is the stiffness proportional to the pressure? K h_rms/p",
        "K h_rms/p",
        "stiffness",
        lambda _: 1.0,
        highest=1e3,
    ),
}
"""By the quantity whose chart they follow."""


def charted() -> Iterator[PressureChart]:
    """Yield every kind of chart: of each quantity, and what is held against the pressure."""
    for name, quantity in compared().items():
        yield _of_quantity(quantity)
        if name in _BESIDE:
            yield _BESIDE[name]


def has_quantity(result: ModelResult, quantity: str) -> bool:
    """Return whether a model gives a quantity: a theory of the area alone has no stiffness."""
    return f"{quantity}_mean" in result


def pressure_charts(source: ReportSource, styles: Mapping[str, PageStyle]) -> list[ReportChart]:
    """Return the charts of all curves over the pressure, each with a curve at least."""
    models, shown = list(drawn_models(source, styles)), axes_of(source.results)
    charts = (_chart(source, kind, models, shown) for kind in charted())
    return [chart for chart in charts if chart.series]


def _chart(
    source: ReportSource, kind: PressureChart, models: Sequence[DrawnModel], shown: Axes
) -> ReportChart:
    given = [model for model in models if has_quantity(model.result, kind.quantity)]
    absent = (source.title(m.result.label) for m in models if m not in given)
    series = [_series(model, kind, shown) for model in given]
    axis = kind.axis if kind.per_pressure else shown[kind.quantity].title
    limits = [_limits(model.result, kind, shown) for model in given]
    label = (
        f"{plain(from_notation(axis))} against {shown.pressure.title}, {len(series)} curves of "
        f"{source.name}; the tables of the report say in numbers what they show"
    )
    return ReportChart(
        kind.key,
        kind.title,
        label,
        f"pressure {shown.pressure.title}",
        axis,
        series,
        _ranges(series, limits),
        (True, kind.is_log),
        list(dict.fromkeys(absent)),
    )


def _limits(result: ModelResult, kind: PressureChart, shown: Axes) -> tuple[float, float]:
    if kind.per_pressure is None:
        return shown[kind.quantity].limits(result)
    return kind.lowest, kind.highest


def _series(model: DrawnModel, kind: PressureChart, shown: Axes) -> ChartSeries:
    curve = curve_of(model.result, kind.quantity, shown)
    factor = np.ones_like(curve.pressure)
    if kind.per_pressure is not None:
        bare = curve_of(model.result.reduced(), kind.quantity)
        factor = kind.per_pressure(model.result) / bare.pressure
        curve = replace(bare, pressure=curve.pressure)
    symbol = kind.axis.partition(" = ")[0] if kind.per_pressure else shown[kind.quantity].symbol
    unit = "" if kind.per_pressure else shown[kind.quantity].unit
    return ChartSeries(
        name=model.name,
        meta=model.meta,
        x=curve.pressure,
        y=curve.value * factor,
        lower=curve.lower * factor,
        upper=curve.upper * factor,
        colour=model.style.colour,
        dash=model.dash,
        symbol=model.style.symbol,
        hover=_hover(curve, factor, (symbol, unit), shown.pressure),
    )


def _hover(
    curve: DrawnCurve, factor: FloatArray, named: tuple[str, str], pressure: Axis
) -> list[str]:
    symbol, unit = (plotly_text(from_notation(text)) for text in named)
    end, of_pressure = f" {unit}" * bool(unit), f" {pressure.unit}" * bool(pressure.unit)
    texts = []
    for k, p in enumerate(curve.pressure):
        value, low, high = (
            float(values[k] * factor[k]) for values in (curve.value, curve.lower, curve.upper)
        )
        if curve.is_median[k]:
            shown = f"{number(value)}{end} (median; {number(low)} to {number(high)})"
        else:
            shown = with_error(value, (high - low) / 2.0, 4)
            needs_brackets = end and " ± " in shown and not shown.startswith("(")
            shown = f"({shown}){end}" if needs_brackets else f"{shown}{end}"
        texts.append(f"{pressure.symbol} = {number(p)}{of_pressure}<br>{symbol} = {shown}")
    return texts


def _ranges(series: list[ChartSeries], limits: Sequence[tuple[float, float]]) -> Ranges:
    """Return what both kinds of ordinate show at first."""
    values = np.concatenate([np.empty(0), *(one.y for one in series)])
    finite = values[np.isfinite(values) & (values > 0.0)]
    if finite.size == 0:
        return {"log": None, "linear": None}
    low = max(float(finite.min()), min(lowest for lowest, _ in limits))
    high = min(float(finite.max()), max(highest for _, highest in limits))
    log = [math.log10(low / 1.4), math.log10(high * 1.4)] if low < high else None
    top = min(float(finite.max()), 4.0 * float(np.quantile(finite, 0.75)))
    return {"log": log, "linear": [0.0, 1.05 * top]}
