"""Fig. 3(a) of the paper: the real contact area A/A0 against the pressure p/E*.

Exact solver as squares with standard errors, foundation as a solid line with a
standard-error band, Persson dashed; one shade for each experiment (each roll-off).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughbench.figures.labels import unconverged_remarks
from roughbench.figures.panel import draw_panel, legend_handles, limit_to_curves
from roughbench.figures.style import footnote, legend_above, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGHEST = 1.0
"""All of A0; what models without a bound say beyond it is cut off."""


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return None if any(results.models()) else "the results of a model"


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (axes,) = new_figure(1, 3.0)
    panel(axes, results)
    legend_above(figure, legend_handles(results, list(results), "area"))
    footnote(figure, unconverged_remarks(results))
    return figure


def panel(axes: Axes, results: Results) -> None:
    """Draw the curves, without a legend."""
    draw_panel(axes, results, list(results), "area")
    axes.set_ylabel(r"contact area $A/A_0$")
    limit_to_curves(axes, results, "area", highest=HIGHEST)
