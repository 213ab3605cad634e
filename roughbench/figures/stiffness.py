"""Fig. 4 of the paper: the stiffness K h_rms/E* against p/E*, one panel per experiment.

Exact solver as squares on top, foundation as a solid line, Persson dashed; grey guide
lines have the slopes 1 and 1/(1 + H). A triangle on the upper edge marks the lowest
pressure at which the curve is infinite (full contact); the line ends before it. Where a
mean is infinite there stands a median, and lines are medians throughout then
(:func:`~roughbench.figures.curves.curve_of`). Dashed vertical lines stand at the
pressures where Popov leaves the analytical result: see
:mod:`roughbench.figures.agreement`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from roughbench.figures.agreement import FACTOR, Agreement, agreement_in, departures
from roughbench.figures.axes import axes_of
from roughbench.figures.curves import curves_of, has_medians
from roughbench.figures.labels import (
    experiment_labels,
    height_remark,
    number_text,
    unconverged_remarks,
)
from roughbench.figures.panel import draw_panel, legend_handles, limit_to_curves
from roughbench.figures.style import (
    BACKGROUND,
    GUIDE,
    SMALL,
    footnote,
    legend_above,
    letter,
    new_figure,
)
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DEPARTURE: dict[str, Any] = {"color": "0.3", "linewidth": 0.7, "linestyle": (0, (4, 3))}


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    curves = curves_of(results, "stiffness")
    has_line = any(np.isfinite(curve.value).any() for _, _, curve in curves)
    return None if has_line else "a model with a finite stiffness"


def draw(results: Results) -> Figure:
    """Return the figure: one column of panels, from four experiments on two."""
    experiments = list(results)
    columns = 1 if len(experiments) < 4 else 2
    rows = math.ceil(len(experiments) / columns)
    figure, panels = new_figure(rows, 2.3, columns, extra=0.6, share=True)
    for axes in panels[len(experiments) :]:
        axes.remove()
    for number, (axes, experiment) in enumerate(zip(panels, experiments, strict=False)):
        _panel(axes, results, experiment, number)
    legend_above(figure, _handles(results))
    remarks = [*filter(None, [height_remark(results)])]
    if has_medians(results, "stiffness"):
        remarks.append("Medians with 16 % and 84 % quantiles where a mean is infinite.")
    footnote(figure, remarks + unconverged_remarks(results))
    return figure


def _panel(axes: Axes, results: Results, experiment: str, number: int) -> None:
    draw_panel(axes, results, [experiment], "stiffness")
    axes.label_outer()
    if len(results) > 1:
        letter(axes, number, experiment_labels(results)[experiment])
    limit_to_curves(axes, results, "stiffness")
    _draw_guides(axes, results, experiment)
    found = agreement_in(results, experiment, FACTOR, axes_of(results))
    _draw_departures(axes, found, has_units=results.has_units)


def _handles(results: Results) -> list[Artist]:
    from matplotlib.lines import Line2D

    handles = legend_handles(results, list(results), "stiffness", in_one_panel=False)
    found = departures(results).values()
    if any(range_ is not None and range_.pressures for range_ in found):
        words = f"Popov/Persson = {FACTOR:g}, 1/{FACTOR:g}"
        handles.append(Line2D([], [], label=words, **_DEPARTURE))
    return handles


def _draw_guides(axes: Axes, results: Results, experiment: str) -> None:
    """Draw short lines with the slopes of K ∝ p and of K ∝ p^{1/(1+H)}."""
    models = results[experiment].values()
    points = np.concatenate(
        [
            np.empty((2, 0)),
            *(
                np.stack([curve.pressure, curve.value])
                for _, _, curve in curves_of(results, "stiffness", [experiment])
            ),
        ],
        axis=1,
    )
    shown = axes_of(results)["stiffness"]
    highest = max((shown.limits(model)[1] for model in models), default=math.inf)
    drawn = (points[1] > 0.0) & (points[1] < highest)
    points = points[:, np.isfinite(points[1]) & drawn]
    if points.size == 0:
        return
    x = np.log(points[0])
    y = np.log(points[1])
    span = x.max() - x.min()

    def guide(slope: float, start: float, stop: float, side: float, text: str) -> None:
        left, right = x.min() + start * span, x.min() + stop * span
        near = (x >= left - 0.02 * span) & (x <= right + 0.02 * span)
        if not near.any():
            return
        rest = y[near] - slope * x[near]
        level = rest.max() + 0.9 if side > 0 else rest.min() - 0.9
        ends = np.array([left, right])
        axes.plot(
            np.exp(ends),
            np.exp(level + slope * ends),
            color=GUIDE,
            linewidth=0.7,
            zorder=1,
            gid=f"guide {slope:.6g}",
        )
        above = side > 0
        axes.annotate(
            text,
            (math.exp(left if above else right), math.exp(level + slope * ends.mean())),
            (0, 8) if above else (0, -4),
            textcoords="offset points",
            ha="left" if above else "right",
            va="bottom" if above else "top",
            color=GUIDE,
            fontsize=SMALL,
            bbox=BACKGROUND,
        )

    guide(1.0, 0.42, 0.68, -1.0, "slope 1")
    known = [model.attributes["hurst"] for model in models if "hurst" in model.attributes]
    for hurst in known[:1]:
        guide(1.0 / (1.0 + float(hurst)), 0.02, 0.28, 1.0, r"slope $1/(1+H)$")


def _draw_departures(axes: Axes, found: Agreement | None, *, has_units: bool) -> None:
    """Draw and name the ends of the range of agreement, or say that there are none."""
    if found is None:
        return
    left, right = np.log(axes.get_xlim())
    for pressure, outwards in ((found.lower, -1), (found.upper, 1)):
        if pressure is None:
            continue
        place = (math.log(pressure) - left) / (right - left)
        side = outwards if 0.07 < place < 0.93 else -outwards
        axes.axvline(pressure, zorder=1, gid="departure", **_DEPARTURE)
        axes.annotate(
            f"{pressure:.2g}" if has_units else number_text(pressure),
            (pressure, 0.91),
            (1.5 * side, 0),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            rotation=90,
            ha="left" if side > 0 else "right",
            va="top",
            color=_DEPARTURE["color"],
            fontsize=SMALL,
        )
    if not found.pressures:
        where = "everywhere" if found.found else "nowhere"
        text = f"Popov and Persson agree {where}\nwithin a factor {found.factor:g}"
        axes.text(0.97, 0.04, text, transform=axes.transAxes, ha="right", fontsize=SMALL)
