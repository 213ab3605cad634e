"""Fig. 3(a) of the paper: the real contact area A/A0 against the pressure p/E*.

Exact solver as squares with standard errors, foundation as a solid line with a
standard-error band, Persson dashed; one colour for each experiment (each roll-off).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughbench.figures.looks import experiment_colours
from roughbench.figures.panel import draw_panel, legend_handles
from roughbench.figures.style import footnote, legend_above, new_figure
from roughbench.figures.words import unconverged_remarks
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_INSIDE = 6
"""Entries of a legend that find room under the curves."""


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return None if any(results.models()) else "the results of a model"


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (axes,) = new_figure(1, 2.6)
    panel(axes, results)
    experiments = list(results)
    handles = legend_handles(results, experiments, "area", experiment_colours(experiments))
    if len(handles) <= MOST_INSIDE:
        axes.legend(handles=handles, loc="lower right")
    else:
        legend_above(figure, handles, room=0.6)
    footnote(figure, unconverged_remarks(results))
    return figure


def panel(axes: Axes, results: Results) -> None:
    """Draw the curves, without a legend."""
    draw_panel(axes, results, list(results), "area")
    axes.set_ylabel(r"contact area $A/A_0$")
    axes.set_ylim(top=2.0)
