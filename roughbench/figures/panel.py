"""One panel of curves over the pressure, and its legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures.axes import axes_of
from roughbench.figures.curves import DrawnCurve, curves_of, full_contact_pressure
from roughbench.figures.labels import experiment_labels, model_names
from roughbench.figures.style import SMALL
from roughbench.figures.styles import CurveStyle, curve_styles, experiment_shades, lighter
from roughbench.notation import mathtext
from roughbench.quantities import QUANTITIES
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_FULL_CONTACT = {0.0: (0.025, "v"), math.inf: (0.975, "^")}
"""Where curves leave a logarithmic axis at full contact, for 0 or inf, and the mark."""


def draw_panel(
    axes: Axes,
    results: Results,
    experiments: Sequence[str],
    quantity: str,
    *,
    is_inset: bool = False,
) -> None:
    """Draw the curves of all contenders in the given experiments, on two log axes.

    Parameters
    ----------
    axes : Axes
    results : Results
    experiments : sequence of str
        Colours tell the contenders apart, shades the experiments.
    quantity : str
    is_inset : bool
        Small, with a linear ordinate, without error bars and marks.
    """
    axes.set_xscale("log")
    axes.set_yscale("linear" if is_inset else "log")
    shades = experiment_shades(experiments)
    styles, shown = curve_styles(results.models()), axes_of(results)
    for number, experiment in enumerate(experiments):
        turn = number / len(experiments)
        for _, result, curve in curves_of(results, quantity, [experiment]):
            style = styles[result.label]
            colour = lighter(style.colour, shades[experiment])
            name = f"{experiment}/{result.label}/{quantity}"
            if is_inset:
                _draw_thin(axes, curve, style, colour, turn=turn)
            else:
                _draw_curve(axes, curve, style, colour, name=name, turn=turn)
                _mark_full_contact(axes, curve, style, colour, quantity)
    pressures = [
        result["pressure"] / shown.pressure.divisor(result)
        for name in experiments
        for result in results[name].values()
    ]
    extent = np.concatenate(pressures)
    if extent.min() == extent.max():
        axes.set_xlim(extent.min() / 10.0, extent.max() * 10.0)
    if is_inset:
        axes.tick_params(labelsize=SMALL - 0.5, length=2, pad=1.5)
        axes.tick_params(which="minor", length=0)
    else:
        axes.set_xlabel(mathtext(shown.pressure.label))
        axes.set_ylabel(mathtext(shown[quantity].label))


def limit_to_curves(axes: Axes, results: Results, quantity: str) -> None:
    """Show the curves from the lowest value to the highest, whatever their bands do.

    A band whose lower edge is at or below zero has no end on a logarithmic axis: it runs out
    of the panel. What lies beyond the limits of the quantity is cut off.

    Parameters
    ----------
    axes : Axes
        With a logarithmic ordinate.
    results : Results
        All of them, so that panels side by side have the same limits.
    quantity : str
    """
    curves = list(curves_of(results, quantity))
    limits = [axes_of(results)[quantity].limits(result) for _, result, _ in curves]
    lowest, highest = min(low for low, _ in limits), max(high for _, high in limits)
    values = np.concatenate([curve.value for _, _, curve in curves])
    values = values[np.isfinite(values) & (values > 0.0)]
    if values.size and values.min() < highest and values.max() > lowest:
        low, high = max(values.min(), lowest), min(values.max(), highest)
        axes.set_ylim(low if low == lowest else low / 2.0, 2.0 * high)


def _draw_curve(
    axes: Axes,
    curve: DrawnCurve,
    style: CurveStyle,
    colour: str,
    *,
    name: str,
    turn: float = 0.0,
) -> None:
    """Draw one contender; what a logarithmic axis cannot show (0, inf, nan) is left out.

    Parameters
    ----------
    axes : Axes
    curve : DrawnCurve
    style : CurveStyle
    colour : str
    name : str
        ``gid`` of the line, so that it is found again among the artists.
    turn : float
        From 0 to 1, different for each experiment: curves on top of each other then take
        turns with their dashes, and squares stand inside each other.
    """
    drawn = np.isfinite(curve.value) & (curve.value > 0.0)
    value = np.where(drawn, curve.value, np.nan)
    has_band = drawn & np.isfinite(curve.lower) & np.isfinite(curve.upper)
    # At full contact there is nothing to subtract: inf - inf would be a fault.
    lower, upper = np.where(has_band, [curve.lower, curve.upper], np.nan)
    if style.marker:
        bars = axes.errorbar(
            curve.pressure,
            value,
            yerr=np.maximum(np.stack([value - lower, upper - value]), 0.0),
            fmt=style.marker,
            color=colour,
            markerfacecolor="none" if turn else "white",
            markersize=4.2 - 2.2 * turn,
            elinewidth=0.7,
            zorder=style.order,
        )
        line = bars.lines[0]
    else:
        linestyle = (turn * sum(style.dashes), style.dashes) if style.dashes else "-"
        (line,) = axes.plot(
            curve.pressure, value, color=colour, linestyle=linestyle, zorder=style.order
        )
        if has_band.any():
            axes.fill_between(
                curve.pressure,
                lower,
                upper,
                where=has_band.tolist(),
                color=colour,
                alpha=0.25,
                linewidth=0,
                zorder=style.order - 0.5,
            )
    line.set_gid(name)


def _draw_thin(
    axes: Axes, curve: DrawnCurve, style: CurveStyle, colour: str, *, turn: float
) -> None:
    """Draw one contender in an inset."""
    axes.plot(
        curve.pressure,
        curve.value,
        color=colour,
        linewidth=0.8,
        marker=style.marker or "none",
        markersize=1.8,
        markerfacecolor="none",
        markeredgewidth=0.5,
        linestyle="none" if style.marker else (turn, style.dashes) if style.dashes else "-",
        zorder=style.order,
    )


def _mark_full_contact(
    axes: Axes, curve: DrawnCurve, style: CurveStyle, colour: str, quantity: str
) -> None:
    pressure, full = full_contact_pressure(curve), QUANTITIES[quantity].at_full_contact
    if pressure is None or full is None:
        return
    place, marker = _FULL_CONTACT[full]
    axes.plot(
        [pressure],
        [place],
        marker=marker,
        markersize=4.5,
        markerfacecolor="white" if style.marker else colour,
        markeredgecolor=colour,
        linestyle="none",
        transform=axes.get_xaxis_transform(),
        zorder=5.0 + 0.1 * style.order,
        gid="full contact",
    )


def legend_handles(
    results: Results,
    experiments: Sequence[str],
    quantity: str,
    *,
    in_one_panel: bool = True,
    of_all: bool = False,
) -> list[Artist]:
    """Return one handle per contender, one per experiment of several, one for full contact.

    Parameters
    ----------
    results : Results
    experiments : sequence of str
    quantity : str
    in_one_panel : bool
        Whether shades tell the experiments apart; else each has a panel of its own.
    of_all : bool
        Also of contenders that do not give the quantity.

    Returns
    -------
    list of Artist
        Only what is there: no full contact where no curve gets so far.
    """
    from matplotlib.lines import Line2D

    styles = curve_styles(results.models())
    handles: list[Artist] = []
    shown = {
        label for name in experiments for label, one in results[name].items() if quantity in one
    }
    for label, name in model_names(results, experiments, quantity).items():
        if label not in shown and not of_all:
            continue
        style = styles[label]
        handles.append(
            Line2D(
                [],
                [],
                color=style.colour,
                marker=style.marker or "none",
                markerfacecolor="none",
                linestyle="none"
                if style.marker
                else (0, style.dashes)
                if style.dashes
                else "-",
                label=name,
            )
        )
    if in_one_panel and len(experiments) > 1:
        names = experiment_labels(results)
        handles += [
            Line2D([], [], color=lighter("#000000", share), linewidth=3, label=names[name])
            for name, share in experiment_shades(experiments).items()
        ]
    full = QUANTITIES[quantity].at_full_contact
    if full is not None and any(
        full_contact_pressure(curve) is not None
        for _, _, curve in curves_of(results, quantity, experiments)
    ):
        marker = Line2D([], [], marker=_FULL_CONTACT[full][1], linestyle="none")
        marker.set(color="0.25", markersize=4.5, label="full contact")
        handles.append(marker)
    return handles
