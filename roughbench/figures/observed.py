"""An observable of the fields: one panel per pressure, all models in each.

Lines with bands are means with standard errors; Persson's theory, where it says something, is
thin. A line's spectrum is divided by πq: it stands for the surface's that is mapped to
it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.labels import (
    experiment_labels,
    height_remark,
    pressure_text,
    titles,
    unconverged_remarks,
)
from roughbench.figures.style import footnote, legend_above, letter, new_figure
from roughbench.figures.styles import CurveStyle, curve_style, curve_styles
from roughbench.models.persson import Persson
from roughbench.notation import mathtext
from roughbench.observables import OBSERVABLES, Observable
from roughbench.observables.described import described
from roughbench.results import ModelResult, Results
from roughbench.units import prefix

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

THEORY = replace(curve_style(Persson.style), order=1)
"""Of Persson's theory for the fields of a model."""
MOST_PANELS = 4
"""Pressures of a single experiment; of several, two each are drawn."""
DECADES = 1e-7
"""Values below the highest by more than this factor are cut off; in reports, at first."""


@dataclass(frozen=True, slots=True)
class ObservedLine:
    """One curve in one panel.

    Attributes
    ----------
    title : str
    x, y, error : ndarray of float64, shape (K,)
        What a logarithmic axis cannot show is left out.
    style : CurveStyle
        Of the contender; its marker is not drawn.
    is_theory : bool
        Drawn thin, without a band.
    """

    title: str
    x: FloatArray
    y: FloatArray
    error: FloatArray
    style: CurveStyle
    is_theory: bool = False


@dataclass(frozen=True, slots=True)
class ObservableFigure:
    """The figure of one observable.

    Attributes
    ----------
    observable : Observable
    """

    observable: Observable

    def missing(self, results: Results) -> str | None:
        """Return what the results lack for this figure, or None."""
        if any(self.observable.variable in result for _, result in results.models()):
            return None
        return f"the observable {self.observable.name}, which a spec asks for with observables"

    def draw(self, results: Results) -> Figure:
        """Return the figure."""
        scale = "log" if self.observable.x_is_log else "linear"
        shown = observable_axes(results, self.observable)
        axes = mathtext(shown.x_label), mathtext(shown.y_label)
        figure = panels(dict(self._panels(results, shown)), *axes, scale)
        height = [height_remark(results.reduced())] * self.observable.is_in_heights
        footnote(figure, height + unconverged_remarks(results))
        return figure

    def _panels(
        self, results: Results, shown: ObservableAxes
    ) -> Iterator[tuple[str, list[ObservedLine]]]:
        """Yield what is written over a panel, and its lines."""
        labels, styles = experiment_labels(results), curve_styles(results.models())
        most = MOST_PANELS if len(results) == 1 else 2
        for experiment, models in results.items():
            names = titles(models)
            own = {
                names[label]: result
                for label, result in models.items()
                if self.observable.variable in result
            }
            pressures = next((result["pressure"] for result in own.values()), np.empty(0))
            count = min(most, pressures.size)
            for k in np.linspace(0, pressures.size - 1, count).round().astype(int):
                words = [pressure_text(results, float(pressures[k]))]
                words += filter(None, [labels[experiment]])
                yield ", ".join(words), self._lines(own, styles, shown, int(k))

    def _lines(
        self,
        models: Mapping[str, ModelResult],
        styles: Mapping[str, CurveStyle],
        shown: ObservableAxes,
        k: int,
    ) -> list[ObservedLine]:
        name = self.observable.variable
        lines: list[ObservedLine] = []
        theory: list[ObservedLine] = []
        for title, result in models.items():
            x = result[f"{name}_bin"]
            unit = drawn_unit(result, self.observable) * shown.divisor(result)
            x = x * shown.x
            mean, sem = result[f"{name}_mean"][k], result[f"{name}_sem"][k]
            lines.append(ObservedLine(title, x, mean / unit, sem / unit, styles[result.label]))
            if f"{name}_persson" in result and not theory:
                values = result[f"{name}_persson"][k] / shown.divisor(result)
                none = np.full(x.shape, math.nan)
                title = self.observable.theory_title(result.attributes)
                theory.append(ObservedLine(title, x, values, none, THEORY, is_theory=True))
        return lines + theory


def unknown_observables(results: Results) -> list[Observable]:
    """Return the observables that results describe and that are not installed here."""
    known = {one.variable for one in OBSERVABLES.values()}
    found: dict[str, Observable] = {}
    for _, result in results.models():
        for one in described(result.attributes):
            if one.variable not in known:
                found.setdefault(one.variable, one)
    return list(found.values())


def drawn_unit(result: ModelResult, observable: Observable) -> FloatArray:
    """Return what figures divide the values of an observable by, shape (K,)."""
    name = observable.variable
    if f"{name}_drawn_unit" in result:
        return np.asarray(result[f"{name}_drawn_unit"], float)
    places = np.asarray(result[f"{name}_bin"], float)
    return observable.drawn_unit(places, int(result.attributes.get("dimension", 2)))


@dataclass(frozen=True, slots=True)
class ObservableAxes:
    """What the places and values of an observable are multiplied with, and the axes' labels.

    Attributes
    ----------
    x, y : float
    x_label, y_label : str
        For :mod:`roughbench.notation`.
    modulus : int
        Power of E* by which values are divided, where the label says so.
    """

    x: float
    y: float
    x_label: str
    y_label: str
    modulus: int = 0

    def divisor(self, result: ModelResult) -> float:
        """Return what the values of a model are divided by."""
        return (result.modulus or 1.0) ** self.modulus / self.y


def observable_axes(results: Results, observable: Observable) -> ObservableAxes:
    """Return how an observable is drawn: as it is, or with units in SI with a prefix."""
    if not results.has_units:
        return ObservableAxes(1.0, 1.0, observable.x, observable.y)
    values, name = observable.values, observable.variable
    by_modulus = values.modulus if "E*" in observable.y else 0
    as_drawn = replace(values, modulus=values.modulus - by_modulus)
    own = [result for _, result in results.models() if name in result]
    places = np.concatenate([np.empty(0), *(result[f"{name}_bin"] for result in own)])
    x, x_unit = prefix(places.tolist(), observable.places.si_units())
    drawn = [np.empty(0)]
    for result in own:
        unit = drawn_unit(result, observable) * (result.modulus or 1.0) ** by_modulus
        drawn.append(np.ravel(result[f"{name}_mean"] / unit))
    y, y_unit = prefix(np.concatenate(drawn).tolist(), as_drawn.si_units())
    return ObservableAxes(
        x, y, _labelled(observable.x, x_unit), _labelled(observable.y, y_unit), by_modulus
    )


def _labelled(label: str, unit: str) -> str:
    base, caret, power = unit.partition("^")
    text = f"{base}$^{power}$" if caret else unit
    return label if unit == "1" else f"{label} ({text})"


def panels(
    lines: Mapping[str, Sequence[ObservedLine]], axis: str, value: str, scale: str = "log"
) -> Figure:
    """Return a figure of panels.

    Parameters
    ----------
    lines : mapping of str to sequence of ObservedLine
        By what is written over the panel.
    axis, value : str
        What is drawn over what.
    scale : {"log", "linear"}
        Of the abscissa.
    """
    columns = min(2, len(lines))
    rows = math.ceil(len(lines) / columns)
    figure, all_axes = new_figure(rows, 2.1, columns, extra=0.4, share=True)
    for axes in all_axes[len(lines) :]:
        axes.remove()
    handles: dict[str, dict[str, Any]] = {}
    for number, (axes, (title, some)) in enumerate(zip(all_axes, lines.items(), strict=False)):
        handles |= draw_panel(axes, some, scale)
        letter(axes, number, title)
        axes.set_xlabel(axis)
        axes.set_ylabel(value)
        axes.label_outer()
    legend_above(figure, handles_of(handles))
    return figure


def draw_panel(
    axes: Axes, lines: Sequence[ObservedLine], scale: str
) -> dict[str, dict[str, Any]]:
    """Draw the lines of a panel, and return how each of them is drawn."""
    axes.set_xscale(scale)
    axes.set_yscale("log")
    drawn = {}
    highest, lowest = 0.0, math.inf
    for line in lines:
        shown = np.isfinite(line.y) & (line.y > 0.0) & np.isfinite(line.x) & (line.x > 0.0)
        x, y, error = line.x[shown], line.y[shown], line.error[shown]
        style = drawn[line.title] = _style(line)
        axes.plot(x, y, gid=line.title, **style)
        if y.size:
            highest, lowest = max(highest, y.max()), min(lowest, y.min())
        if not line.is_theory and np.isfinite(error).any():
            below = np.maximum(y - error, 1e-3 * y)  # a logarithmic axis has no zero
            axes.fill_between(
                x, below, y + error, color=style["color"], alpha=0.25, linewidth=0
            )
    if highest > 0.0:
        axes.set_ylim(max(lowest / 2.0, DECADES * highest), 3.0 * highest)
    return drawn


def _style(line: ObservedLine) -> dict[str, Any]:
    return {
        "color": line.style.colour,
        "linestyle": (0, line.style.dashes) if line.style.dashes else "-",
        "linewidth": 0.7 if line.is_theory else 1.1,
    }


def handles_of(drawn: Mapping[str, dict[str, Any]]) -> list[Artist]:
    """Return the legend's handles of lines, by how each of them is drawn."""
    from matplotlib.lines import Line2D

    return [Line2D([], [], label=title, **style) for title, style in drawn.items()]
