"""Fig. 3(b) of the paper: the mean separation ū/h_rms against the pressure p/E*.

Drawn as Fig. 3(a). A triangle on the lower edge marks the lowest pressure at which all
realizations are in full contact, where ū = 0 has no place on a logarithmic axis; what
lies below :data:`FLOOR` is cut off. The inset shows the same curves on a linear axis,
where ū = u0 ln(p0/p) is a straight line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures.curves import (
    curve_of,
    draw_panel,
    experiment_colours,
    height_label,
    legend_handles,
    unconverged_remarks,
)
from roughbench.figures.style import footnote, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FLOOR = 1e-4
"""Separations below this, in h_rms, are a hundred times thinner than any drawn gap."""


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return None if any(results.models()) else "the results of a model"


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (axes,) = new_figure(1, 3.0)
    panel(axes, results)
    experiments = list(results)
    colours = experiment_colours(experiments)
    handles = legend_handles(results, experiments, "separation", colours)
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    footnote(figure, unconverged_remarks(results))
    return figure


def panel(axes: Axes, results: Results) -> None:
    """Draw the curves and the inset, without a legend."""
    draw_panel(axes, results, list(results), "separation")
    axes.set_ylabel(r"separation $\bar u/h_\mathrm{rms}$" f"\n{height_label(results)}")
    values = [curve_of(result, "separation").value for _, result in results.models()]
    positive = np.concatenate([value[np.isfinite(value) & (value > 0.0)] for value in values])
    if positive.size and positive.max() > 10.0 * FLOOR > positive.min():
        axes.set_ylim(FLOOR, 2.5 * positive.max())
    inset = axes.inset_axes((0.115, 0.085, 0.44, 0.42))
    draw_panel(inset, results, list(results), "separation", is_inset=True)
