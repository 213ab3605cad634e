"""Fig. 3 of the paper, (a) above (b): contact area and mean separation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughbench.figures.labels import height_remark, unconverged_remarks
from roughbench.figures.panel import legend_handles
from roughbench.figures.quantity import QuantityFigure
from roughbench.figures.separation import SeparationFigure
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANELS = QuantityFigure("area"), SeparationFigure("separation")


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return next(filter(None, (panel.missing(results) for panel in _PANELS)), None)


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, both = new_figure(2, 2.3, extra=0.6, share=True)
    for panel, axes in zip(_PANELS, both, strict=True):
        panel.panel(axes, results)
    for number, axes in enumerate(both):
        axes.label_outer()
        letter(axes, number)
    legend_above(figure, legend_handles(results, list(results), "separation", of_all=True))
    footnote(figure, [*filter(None, [height_remark(results)]), *unconverged_remarks(results)])
    return figure
