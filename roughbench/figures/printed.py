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
from roughbench.figures.labels import height_remark, unconverged_remarks
from roughbench.fits import is_exact
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult, Results
from roughbench.verdict.measures import CUTOFF
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
    def models(self) -> list[ModelResult]:
        """Those that there are, at least one."""
        return [one for one in (self.springs, self.theory, self.exact) if one is not None]

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


def lack_of(results: Results, *names: str) -> str | None:
    """Return what results lack for a figure of some quantities as printed, or None."""
    if results.has_units:
        return "results without units"
    cases = cases_of(results)
    if not cases or not any(case.springs or case.theory for case in cases):
        return "a foundation or Persson's theory on a surface given by its spectrum"
    ratios = [case.ratio for case in cases]
    if len(set(ratios)) < len(ratios) or len(cases) < len(results):
        return f"experiments that differ in the roll-off alone, at most {len(_COLOURS)}"
    return next(filter(None, (_lack_of_values(results, name) for name in names)), None)


def _lack_of_values(results: Results, name: str) -> str | None:
    """Return what results lack that have no value of a quantity to be drawn, or None."""
    for case in cases_of(results):
        for model in case.models:
            if f"{name}_mean" in model:
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


def remarks_of(results: Results, *more: str) -> list[str]:
    """Return what stands under the panels: surfaces, lengths, counts, what is missing."""
    return [
        _surfaces_remark(results),
        height_remark(results),
        "; ".join(
            f"{words}: {', '.join(map(str, dict.fromkeys(found)))}"
            for words, found in _counts(cases_of(results))
            if found
        ),
        *_exact_remarks(results),
        *more,
        *unconverged_remarks(results),
    ]


def _surfaces_remark(results: Results) -> str:
    """Say what the surfaces have in common, as far as it is known."""
    known = [case.models[0].attributes for case in cases_of(results)]
    found = {
        "$H": {f"{one['hurst']:.6g}" for one in known if "hurst" in one},
        r"$\mathrm{rms\ slope}": {f"{one['rms_slope']:.6g}" for one in known},
        "$q_1/q_0": {f"{ratio:.6g}" for ratio in _cutoffs(results)},
    }
    values = {name: ", ".join(sorted(some)) for name, some in found.items()}
    return "; ".join(f"{name} = {text}$" for name, text in values.items() if text)


def _cutoffs(results: Results) -> set[float]:
    """Return q1/q0 of all cases, without the errors of rounding."""
    known = [case.models[0].attributes for case in cases_of(results)]
    ratios = (float(one["q_max"]) / float(one["q_min"]) for one in known if "q_max" in one)
    return {float(f"{ratio:.6g}") for ratio in ratios}


def _exact_remarks(results: Results) -> Iterator[str]:
    """Say of which cases there are no exact points, and how to get some."""
    cases = cases_of(results)
    without = [case.label for case in cases if case.exact is None]
    if without:
        whose = "" if len(without) == len(cases) else f" for {' and '.join(without)}"
        yield f"No exact points{whose} in these results; plot --with joins others."
        if _cutoffs(results) == {CUTOFF}:
            yield "At this cut-off they take 13.5 GB and hours: configs/paper/bem.yaml."


def _counts(cases: list[RollOffCase]) -> Iterator[tuple[str, list[int]]]:
    for words, name in (("surfaces", "exact"), ("lines", "springs")):
        models = (getattr(case, name) for case in cases)
        yield words, [one.n_realizations for one in models if one]


def scaled_axes(results: Results) -> Shown:
    """Return the axes of results without units."""
    return axes_of(results)
