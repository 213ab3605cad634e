"""What the figures as printed in the paper share: its cases, their colours, their curves.

The paper's figures hold a surface without a roll-off in blue and one with a roll-off in red:
here the colour says which roll-off it is, the style which model (exact solution as squares,
foundation solid, theory dashed). Only these three are drawn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.axes import Axes as Shown
from roughbench.figures.axes import axes_of
from roughbench.fits import is_exact
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult, Results
from roughbench.verdict.onset import foundation_and_theory

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]

_COLOURS = ("#0072B2", "#D62728", "#009E73", "#E69F00", "#CC79A7", "#56B4E9")
"""Blue and red as in the paper, and further ones for more roll-offs."""
DASHES = (0, (4, 2))
_FEW = 40
"""Fewer states of springs than this are marked: the straight lines between them are no law."""


@dataclass(frozen=True, slots=True)
class RollOffCase:
    """The surfaces of one roll-off, and who was computed for them.

    Attributes
    ----------
    experiment : str
    ratio : float
        q_r/q0.
    colour : str
    springs, theory, exact : ModelResult or None
    """

    experiment: str
    ratio: float
    colour: str
    springs: ModelResult | None
    theory: ModelResult | None
    exact: ModelResult | None

    @property
    def label(self) -> str:
        """What a legend says."""
        return rf"$q_\mathrm{{r}}/q_0 = {self.ratio:.6g}$"


def cases_of(results: Results) -> list[RollOffCase]:
    """Return the cases of results, those of the lowest roll-off first."""
    found = []
    for experiment, models in results.experiments.items():
        foundation, theory = foundation_and_theory(models)
        exact = next((one for one in models.values() if is_exact(one)), None)
        known = next(iter(models.values())).attributes if models else {}
        if {"q_rolloff", "q_min"} <= set(known) and (foundation or theory or exact):
            ratio = float(known["q_rolloff"]) / float(known["q_min"])
            found.append((ratio, experiment, foundation, theory, exact))
    found.sort(key=lambda one: one[0])
    return [
        RollOffCase(experiment, ratio, colour, foundation, theory, exact)
        for colour, (ratio, experiment, foundation, theory, exact) in zip(
            _COLOURS, found, strict=False
        )
    ]


def lack_of(results: Results) -> str | None:
    """Return what results lack for a figure as printed, or None."""
    if results.has_units:
        return "results without units"
    cases = cases_of(results)
    if not cases or not any(case.springs or case.theory for case in cases):
        return "a foundation or Persson's theory on a surface given by its spectrum"
    ratios = [case.ratio for case in cases]
    if len(set(ratios)) < len(ratios) or len(cases) < len(results):
        return f"experiments that differ in the roll-off alone, at most {len(_COLOURS)}"
    return None


def lack_of_values(results: Results, name: str) -> str | None:
    """Return what results lack that have no value of a quantity to be drawn, or None."""
    for case in cases_of(results):
        for model in (case.springs, case.theory, case.exact):
            if model is not None and f"{name}_mean" in model:
                mean = np.asarray(model[f"{name}_mean"], float)
                if (np.isfinite(mean) & (mean > 0.0)).any():
                    return None
    return f"a finite {QUANTITIES[name].words} of one of them"


def mean_of(result: ModelResult, name: str, shown: Shown) -> tuple[FloatArray, ...]:
    """Return pressure, mean and standard error of a quantity, scaled, pressures ascending."""
    order = np.argsort(result["pressure"], kind="stable")
    unit = shown[name].divisor(result)
    columns = (np.asarray(result[f"{name}_{one}"], float)[order] for one in ("mean", "sem"))
    mean, error = (column / unit for column in columns)
    return np.asarray(result["pressure"], float)[order], mean, error


def draw_case(
    axes: Axes, case: RollOffCase, name: str, shown: Shown, models: tuple[str, ...], turn: float
) -> None:
    """Draw a quantity of some of the models of a case.

    Parameters
    ----------
    axes : Axes
    case : RollOffCase
    name : str
        Of the quantity.
    shown : roughbench.figures.axes.Axes
    models : tuple of str
        Attributes of the case.
    turn : float
        0 to 1: dashed curves on top of each other take turns, and so each is seen.
    """
    for model in models:
        result: ModelResult | None = getattr(case, model)
        if result is None or f"{name}_mean" not in result:
            continue
        pressure, mean, error = mean_of(result, name, shown)
        value = np.where(np.isfinite(mean) & (mean > 0.0), mean, np.nan)
        gid = f"{case.experiment}/{result.label}/{name}"
        if model == "exact":
            bars = np.where(np.isfinite(error) & np.isfinite(value), error, 0.0)
            drawn = axes.errorbar(
                pressure,
                value,
                yerr=bars,
                fmt="s",
                color=case.colour,
                markerfacecolor="white",
                elinewidth=0.7,
                zorder=4,
            )
            drawn.lines[0].set_gid(gid)
            continue
        style = (turn * 6.0, DASHES[1]) if model == "theory" else "-"
        (line,) = axes.plot(pressure, value, color=case.colour, linestyle=style, zorder=3)
        if model == "springs" and np.isfinite(value).sum() < _FEW:
            line.set(marker=".", markersize=4.0)
        line.set_gid(gid)


def legend_of(results: Results, models: tuple[str, ...]) -> list[Artist]:
    """Return a handle for every roll-off and every kind of curve that is drawn."""
    from matplotlib.lines import Line2D

    cases = cases_of(results)
    handles: list[Artist] = [
        Line2D([], [], color=case.colour, linewidth=2.5, label=case.label) for case in cases
    ]
    words = {"exact": "exact", "springs": "Popov", "theory": "Persson"}
    looks: dict[str, dict[str, Any]] = {
        "exact": {"marker": "s", "linestyle": "none", "markerfacecolor": "white"},
        "springs": {"linestyle": "-"},
        "theory": {"linestyle": DASHES},
    }
    return handles + [
        Line2D([], [], color="0.25", label=words[model], **looks[model])
        for model in models
        if any(getattr(case, model) for case in cases)
    ]


def counts_remark(results: Results) -> str:
    """Say how many surfaces and lines the averages are over."""
    return "; ".join(
        f"{words}: {', '.join(map(str, dict.fromkeys(found)))}"
        for words, found in _counts(cases_of(results))
        if found
    )


def exact_remark(results: Results) -> str:
    """Say of which cases there are no exact points; nothing if all have some."""
    cases = cases_of(results)
    without = [case.label for case in cases if case.exact is None]
    if not without:
        return ""
    whose = "" if len(without) == len(cases) else f" for {' and '.join(without)}"
    return f"no exact points{whose}: not in these results (plot --with joins others)"


def _counts(cases: list[RollOffCase]) -> Iterator[tuple[str, list[int]]]:
    for words, name in (("surfaces", "exact"), ("lines", "springs")):
        models = (getattr(case, name) for case in cases)
        yield words, [one.n_realizations for one in models if one]


def scaled_axes(results: Results) -> Shown:
    """Return the axes of results without units."""
    return axes_of(results)
