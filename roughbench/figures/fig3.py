"""Fig. 3 of the paper, (a) above (b): contact area and mean separation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughbench.figures import area, separation
from roughbench.figures.labels import height_remark, unconverged_remarks
from roughbench.figures.panel import legend_handles
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return area.missing(results) or separation.missing(results)


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (upper, lower) = new_figure(2, 2.3, extra=0.6, share=True)
    area.panel(upper, results)
    separation.panel(lower, results)
    for number, axes in enumerate((upper, lower)):
        axes.label_outer()
        letter(axes, number)
    legend_above(figure, legend_handles(results, list(results), "separation", of_all=True))
    footnote(figure, [height_remark(results), *unconverged_remarks(results)])
    return figure
