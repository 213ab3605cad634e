"""Area and separation as printed in Fig. 3 of the paper: over a linear axis of the pressure.

(a) A/A0 and (b) ū/h_rms, its logarithm, with both roll-offs in each panel. The axis of the
pressure goes to where theory and exact solution have half of A0 in contact: the printed range
is not known, and over a longer one the foundation would be no wider than a line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures import printed
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.notation import mathtext
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MODELS = ("springs", "theory", "exact")
_HALF = 0.5


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return printed.lack_of(results, "area", "separation")


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, both = new_figure(2, 2.3, extra=0.5)
    cases, shown = printed.cases_of(results), printed.scaled_axes(results)
    limit = _limit(cases, results)
    for number, (axes, name) in enumerate(zip(both, ("area", "separation"), strict=True)):
        lowest = 1.0
        for k, case in enumerate(cases):
            printed.draw_case(axes, case, name, shown, _MODELS, k / len(cases))
            for model in case.models:
                if model is not case.springs and f"{name}_mean" in model:
                    pressure, mean, _ = printed.mean_of(model, name, shown)
                    seen = mean[(pressure <= limit) & (mean > 0.0)]
                    lowest = min(lowest, seen.min(initial=1.0))
        axes.set_xlim(0.0, limit)
        axes.set_ylabel(mathtext(shown[name].label))
        if name == "area":
            axes.set_ylim(0.0, 1.0)
        else:
            axes.set_yscale("log")
            axes.set_ylim(lowest / 3.0, 10.0)
        axes.set_xlabel(mathtext(shown.pressure.label))
        axes.label_outer()
        letter(axes, number)
    legend_above(figure, printed.legend_of(results, _MODELS))
    footnote(figure, printed.remarks_of(results))
    return figure


def _limit(cases: list[printed.RollOffCase], results: Results) -> float:
    """Return the highest pressure of the axes, p/E*."""
    shown, ends = printed.scaled_axes(results), []
    highest = 0.0
    for case in cases:
        for model in case.models:
            if "area_mean" not in model:
                continue
            pressure, area, _ = printed.mean_of(model, "area", shown)
            highest = max(highest, float(pressure[-1]))
            if model is not case.springs and area[0] < _HALF < area[-1]:
                ends.append(float(np.interp(_HALF, area, pressure)))
    return max(ends, default=highest)
