"""The stiffness as printed in Fig. 4 of the paper: (a) theory and exact points, (b) foundation.

Both roll-offs stand in each panel, in the colours of area and separation, Fig. 3. Dashed
vertical lines, in both panels, stand where the stiffness of the foundation starts to deviate
from the theory, triangles on the lower edge where the linear region of the theory starts, both
as :mod:`roughbench.verdict.onset` finds them. Dotted in (b) is the theory with the prefactor of
the law of few contacts that the foundation has: what the deviation is counted from.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures import printed
from roughbench.figures.axes import Axes as Shown
from roughbench.figures.labels import number_text
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.notation import mathtext
from roughbench.quantities import QUANTITIES
from roughbench.results import Results
from roughbench.verdict.onset import Theory, onset_of, theory_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

_PANELS = (("theory", "exact"), ("springs",))
_USUAL_GAMMA = 0.45
_NO_ONSET = "no law of few contacts in these pressures"


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    return printed.lack_of(results, "stiffness")


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, both = new_figure(2, 2.4, extra=0.6, share=True)
    cases, shown = printed.cases_of(results), printed.scaled_axes(results)
    remarks = []
    marks = False
    for number, (axes, models) in enumerate(zip(both, _PANELS, strict=True)):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for k, case in enumerate(cases):
            printed.draw_case(axes, case, "stiffness", shown, models, k / len(cases))
        axes.set_ylabel(mathtext(shown["stiffness"].label))
        axes.set_xlabel(mathtext(shown.pressure.label))
        axes.label_outer()
        letter(axes, number)
    for axes in both:
        axes.set_ylim(*_limits(cases, shown))
    for case in cases:
        found = _onset(case)
        if found is None:
            remarks.append(f"{case.label}: no dashed line, {_NO_ONSET}.")
            continue
        theory, m, (theta, deviates, linear) = found
        _mark(both, case, deviates, linear)
        _draw_counted_from(both[1], case, theory, theory.stiffness(theta, m), shown)
        marks = True
        where = number_text(deviates) if math.isfinite(deviates) else "nowhere"
        start = number_text(linear) if math.isfinite(linear) else "beyond"
        words = rf"$\theta = {theta:.3g}$, deviates from {where}, linear from {start}"
        remarks.append(f"{case.label}: {words}.")
    legend_above(
        figure, printed.legend_of(results, _PANELS[0] + _PANELS[1]) + _handles(marks=marks)
    )
    footnote(figure, printed.remarks_of(results, *remarks))
    return figure


def _onset(
    case: printed.RollOffCase,
) -> tuple[Theory, float, tuple[float, float, float]] | None:
    """Return theory, how its laws are joined, and θ, first deviation and linear region."""
    if case.springs is None or "stiffness_mean" not in case.springs:
        return None
    known = case.theory.attributes if case.theory is not None else {}
    m = float(known.get("m", 2.0)) if known.get("finite_size") == "blend" else math.inf
    theory = theory_of(case.springs, float(known.get("gamma", _USUAL_GAMMA)))
    if theory is None:
        return None
    order = np.argsort(case.springs["pressure"], kind="stable")
    stiffness = np.asarray(case.springs["stiffness_mean"], float)[order]
    found = onset_of(theory, stiffness, m)
    return None if math.isnan(found[0]) else (theory, m, found)


def _mark(both: list[Axes], case: printed.RollOffCase, deviates: float, linear: float) -> None:
    for axes in both:
        if math.isfinite(deviates):
            axes.axvline(
                deviates, color=case.colour, lw=0.7, ls=(0, (4, 3)), zorder=1, gid="deviates"
            )
        if math.isfinite(linear):
            axes.plot(
                [linear],
                [0.03],
                marker="^",
                color=case.colour,
                markersize=4.5,
                linestyle="none",
                transform=axes.get_xaxis_transform(),
                zorder=5,
                gid="linear",
            )


def _draw_counted_from(
    axes: Axes, case: printed.RollOffCase, theory: Theory, stiffness: FloatArray, shown: Shown
) -> None:
    if case.springs is not None:
        value = stiffness / shown["stiffness"].divisor(case.springs)
        look: dict[str, Any] = {"color": case.colour, "linewidth": 0.7, "linestyle": ":"}
        axes.plot(theory.pressure, value, zorder=2, gid="counted from", **look)


def _limits(cases: list[printed.RollOffCase], shown: Shown) -> tuple[float, float]:
    """Return the limits of both panels: all that is drawn, up to nearly full contact."""
    values = []
    for case in cases:
        for model in case.models:
            if "stiffness_mean" in model:
                _, mean, _ = printed.mean_of(model, "stiffness", shown)
                values += mean[np.isfinite(mean) & (mean > 0.0)].tolist()
    return min(values) / 2.0, min(2.0 * max(values), QUANTITIES["stiffness"].highest)


def _handles(*, marks: bool) -> list[Artist]:
    from matplotlib.lines import Line2D

    if not marks:
        return []
    grey = "0.25"
    return [
        Line2D([], [], color=grey, lw=0.7, ls=(0, (4, 3)), label="Popov starts to deviate"),
        Line2D([], [], color=grey, lw=0.7, ls=":", label=r"Persson, Popov's $\theta$"),
        Line2D([], [], color=grey, marker="^", ls="none", ms=4.5, label=r"linear from here"),
    ]
