"""A quantity over the pressure, in one panel, as the area A/A0 in Fig. 3(a) of the paper.

Exact solver as squares with standard errors, foundation as a solid line with a
standard-error band, Persson dashed; one shade for each experiment (each roll-off). A triangle
on the edge marks the lowest pressure at which all realizations are in full contact, where it
is 0 or inf and has no place on a logarithmic axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from roughbench.figures.curves import curves_of
from roughbench.figures.labels import height_remark, unconverged_remarks
from roughbench.figures.panel import draw_panel, legend_handles, limit_to_curves
from roughbench.figures.style import footnote, legend_above, new_figure
from roughbench.quantities import QUANTITIES
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class QuantityFigure:
    """The figure of one quantity.

    Attributes
    ----------
    name : str
        Of the quantity.
    """

    name: str

    def missing(self, results: Results) -> str | None:
        """Return what the results lack for this figure, or None."""
        if not any(results.models()):
            return "the results of a model"
        if not any(curves_of(results, self.name)):
            return f"a model that gives the {QUANTITIES[self.name].words}"
        return None

    def draw(self, results: Results) -> Figure:
        """Return the figure."""
        figure, (axes,) = new_figure(1, 3.0)
        self.panel(axes, results)
        legend_above(figure, legend_handles(results, list(results), self.name))
        height = [height_remark(results)] * (QUANTITIES[self.name].length != 0)
        footnote(figure, [*filter(None, height), *unconverged_remarks(results)])
        return figure

    def panel(self, axes: Axes, results: Results) -> None:
        """Draw the curves, without a legend."""
        draw_panel(axes, results, list(results), self.name)
        limit_to_curves(axes, results, self.name)
