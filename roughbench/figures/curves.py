"""Curves over the pressure: what Figs. 3 and 4 draw, and how each contender looks.

The style says which contender it is (exact solver: squares with error bars, foundation:
solid line with a band, Persson: dashed), the colour which experiment; in a panel with
a single experiment the colour tells the contenders apart too.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.style import COLOURS, SMALL
from roughbench.results import ModelResult, Results

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
Quantity = Literal["area", "separation", "stiffness"]
Dashes = tuple[float, ...]

MODULUS = r"E\!^*"
PRESSURE = rf"pressure $p/{MODULUS}$"


@dataclass(frozen=True, slots=True)
class Curve:
    """What is drawn of one contender in one experiment; pressures ascend.

    Attributes
    ----------
    pressure : ndarray of float64, shape (P,)
        p/E*.
    value : ndarray of float64, shape (P,)
        Dimensionless mean, or median; inf at full contact (stiffness).
    lower, upper : ndarray of float64, shape (P,)
        Mean ± its standard error, or the 16 % and 84 % quantiles; nan for one realization.
    is_median : ndarray of bool, shape (P,)
        Whether these are median and quantiles.
    """

    pressure: FloatArray
    value: FloatArray
    lower: FloatArray
    upper: FloatArray
    is_median: NDArray[np.bool_]


def curve_of(result: ModelResult, quantity: Quantity) -> Curve:
    """Return a contender's curve, with lengths in the unit of the spectrum's h_rms.

    It is the mean with its standard error; where a realization in full contact makes
    the mean of the stiffness infinite, the median with the 16 % and 84 % quantiles. A
    contender drawn as a line is then the median at *all* pressures, because a change
    from one to the other would draw a step that is none of the contender's.

    Parameters
    ----------
    result : ModelResult
    quantity : {"area", "separation", "stiffness"}

    Returns
    -------
    Curve
    """
    height = float(result.attributes["rms_height"])
    unit = {"area": 1.0, "separation": height, "stiffness": 1.0 / height}[quantity]
    order = np.argsort(result["pressure"], kind="stable")

    def column(statistic: str) -> FloatArray:
        return np.asarray(result[f"{quantity}_{statistic}"], float)[order] / unit

    mean, error = column("mean"), column("sem")
    is_median = np.isinf(mean) & (result.n_realizations > 1)
    if result.kind not in _POINTS:
        is_median[:] = is_median.any()
    error = np.where(np.isfinite(mean), error, np.nan)
    return Curve(
        np.asarray(result["pressure"], float)[order],
        np.where(is_median, column("median"), mean),
        np.where(is_median, column("q16"), mean - error),
        np.where(is_median, column("q84"), mean + error),
        is_median,
    )


@dataclass(frozen=True, slots=True)
class Look:
    """How a contender is drawn.

    Attributes
    ----------
    marker : str
        Points with error bars; empty: a line with a band.
    dashes : tuple of float
        On, off, … in line widths; empty: solid.
    colour : str
        In a panel with a single experiment.
    order : int
        Higher is drawn over lower.
    """

    marker: str
    dashes: Dashes
    colour: str
    order: int


_POINTS = ("bem",)
"""Kinds drawn as points; all others are lines."""
_MARKERS = ("s", "o", "D", "^", "v")
_FOUNDATION: tuple[Dashes, ...] = ((), (9, 1.5), (6, 1, 1, 1))
_PERSSON: tuple[Dashes, ...] = ((3, 3), (1.5, 1.5), (6, 3))
_OTHERS: tuple[Dashes, ...] = ((5, 1.5, 1, 1.5), (1, 1), (5, 1.5, 1, 1.5, 1, 1.5), (2, 1))


def looks(results: Results) -> dict[str, Look]:
    """Return a look for every label in the results; equal labels look alike."""
    kinds = {result.label: result.kind for _, result in results.models()}
    count: dict[str, int] = {}
    chosen = {}
    other_colours = itertools.cycle((COLOURS[2], COLOURS[3], COLOURS[4], COLOURS[5]))
    for label, kind in kinds.items():
        group = kind if kind in ("bem", "foundation", "persson") else "others"
        number = count.get(group, 0)
        count[group] = number + 1
        first = number == 0
        if group == "bem":
            marker, colour = _MARKERS[number % len(_MARKERS)], "#000000"
            chosen[label] = Look(marker, (), colour if first else next(other_colours), 4)
        elif group == "foundation":
            dashes, colour = _FOUNDATION[number % len(_FOUNDATION)], COLOURS[0]
            chosen[label] = Look("", dashes, colour if first else next(other_colours), 3)
        elif group == "persson":
            dashes, colour = _PERSSON[number % len(_PERSSON)], COLOURS[1]
            chosen[label] = Look("", dashes, colour if first else next(other_colours), 2)
        else:
            chosen[label] = Look("", _OTHERS[number % len(_OTHERS)], next(other_colours), 2)
    return chosen


def draw_curve(
    axes: Axes, curve: Curve, look: Look, colour: str, *, name: str, turn: float = 0.0
) -> None:
    """Draw one contender; what a logarithmic axis cannot show (0, inf, nan) is left out.

    Parameters
    ----------
    axes : Axes
    curve : Curve
    look : Look
    colour : str
    name : str
        ``gid`` of the line, so that it is found again among the artists.
    turn : float
        From 0 to 1, different for each experiment: curves on top of each other then take
        turns with their dashes, and squares stand inside each other.
    """
    drawn = np.isfinite(curve.value) & (curve.value > 0.0)
    value = np.where(drawn, curve.value, np.nan)
    has_band = drawn & np.isfinite(curve.lower) & np.isfinite(curve.upper)
    if look.marker:
        below = np.where(has_band, curve.value - curve.lower, np.nan)
        above = np.where(has_band, curve.upper - curve.value, np.nan)
        bars = axes.errorbar(
            curve.pressure,
            value,
            yerr=np.maximum(np.stack([below, above]), 0.0),
            fmt=look.marker,
            color=colour,
            markerfacecolor="none" if turn else "white",
            markersize=4.2 - 2.2 * turn,
            elinewidth=0.7,
            zorder=look.order,
        )
        line = bars.lines[0]
    else:
        style = (turn * sum(look.dashes), look.dashes) if look.dashes else "-"
        (line,) = axes.plot(
            curve.pressure, value, color=colour, linestyle=style, zorder=look.order
        )
        if has_band.any():
            axes.fill_between(
                curve.pressure,
                curve.lower,
                curve.upper,
                where=has_band.tolist(),
                color=colour,
                alpha=0.25,
                linewidth=0,
                zorder=look.order - 0.5,
            )
    line.set_gid(name)


_FULL_CONTACT: Mapping[Quantity, tuple[float, str]] = {
    "separation": (0.025, "v"),
    "stiffness": (0.975, "^"),
}
"""Where curves leave a logarithmic axis at full contact, for 0 or inf, and the mark."""


def full_contact_pressure(curve: Curve) -> float | None:
    """Return the lowest pressure at which the curve is 0 or inf, if there is one."""
    full = (curve.value == 0.0) | np.isinf(curve.value)
    return float(curve.pressure[int(np.argmax(full))]) if full.any() else None


def _mark_full_contact(
    axes: Axes, curve: Curve, look: Look, colour: str, quantity: Quantity
) -> None:
    pressure = full_contact_pressure(curve)
    if pressure is None or quantity not in _FULL_CONTACT:
        return
    place, marker = _FULL_CONTACT[quantity]
    axes.plot(
        [pressure],
        [place],
        marker=marker,
        markersize=4.5,
        markerfacecolor="white" if look.marker else colour,
        markeredgecolor=colour,
        linestyle="none",
        transform=axes.get_xaxis_transform(),
        zorder=5,
        gid="full contact",
    )


def model_names(
    results: Results, experiments: Sequence[str], quantity: Quantity
) -> dict[str, str]:
    """Return the legend's text for every label: title, parameters, n, kind of average."""
    found: dict[str, list[ModelResult]] = {}
    for experiment in experiments:
        for label, result in results[experiment].items():
            found.setdefault(label, []).append(result)
    titles = [models[0].title for models in found.values()]
    names = {}
    for label, models in found.items():
        title, kind = models[0].title, models[0].kind
        if titles.count(title) > 1 and label != kind:
            title = f"{title}, {label}"
        remarks = _parameters(models[0], quantity) + _counts(models)
        if any(curve_of(model, quantity).is_median.all() for model in models):
            remarks.append("median")
        names[label] = ", ".join([title, *remarks])
    return names


def has_medians(results: Results, quantity: Quantity) -> bool:
    """Return whether a curve shows a median somewhere."""
    return any(curve_of(result, quantity).is_median.any() for _, result in results.models())


def _counts(models: Sequence[ModelResult]) -> list[str]:
    """Return the number of realizations; a theory of the spectrum alone has none."""
    if models[0].kind == "persson":
        return []
    counts = sorted({model.n_realizations for model in models})
    span = f"{counts[0]}" if len(counts) == 1 else f"{counts[0]}–{counts[-1]}"
    return [f"$n = {span}$" if len(counts) == 1 else f"$n$ = {span}"]


def _parameters(model: ModelResult, quantity: Quantity) -> list[str]:
    remarks = []
    if "gamma" in model.attributes:
        remarks.append(rf"$\gamma = {model.attributes['gamma']:g}$")
    if quantity == "stiffness" and model.attributes.get("finite_size", "none") != "none":
        remarks.append("finite size")
    return remarks


_SYMBOLS: Mapping[str, str] = {
    "surface.H": "H",
    "surface.q0": "q_0",
    "surface.qr": "q_r",
    "surface.q1": "q_1",
    "surface.slope": r"\xi",
    "surface.length": "L",
    "surface.rms_height": r"h_\mathrm{rms}",
}


def number_text(value: float) -> str:
    r"""Return a positive number with two digits, as in a text.

    Examples
    --------
    >>> print(number_text(2.73e-05))
    $2.7\times10^{-5}$
    """
    digits, exponent = f"{value:.1e}".split("e")
    return rf"${digits}\times10^{{{int(exponent)}}}$"


def experiment_label(name: str) -> str:
    """Return how an experiment is called in a legend; empty for the only one, ``main``.

    Examples
    --------
    >>> experiment_label("surface.qr=8.0"), experiment_label("main")
    ('$q_r = 8$', '')
    """
    if name == "main":
        return ""
    words = []
    for part in name.split(","):
        key, equals, value = part.partition("=")
        if re.fullmatch(r"-?\d+\.0", value):
            value = value.removesuffix(".0")
        if key in _SYMBOLS and re.fullmatch(r"[-+.\de]+", value):
            words.append(f"${_SYMBOLS[key]} = {value}$")
        else:
            words.append(f"{key.removeprefix('surface.')} = {value}" if equals else part)
    return ", ".join(words)


def height_label(results: Results) -> str:
    """Return which rms height the lengths are divided by, in words for an axis.

    The sum over the modes of a cell exceeds the integral over the spectrum by up to
    40 % of h_rms without a roll-off, so a figure has to name its h_rms.
    """
    from_files = {result.attributes.get("surface") == "file" for _, result in results.models()}
    words = {
        frozenset({False}): "spectrum, continuum",
        frozenset({True}): "of the given heights",
    }
    return rf"($h_\mathrm{{rms}}$: {words.get(frozenset(from_files), 'spectrum or heights')})"


def experiment_colours(experiments: Sequence[str]) -> dict[str, str]:
    """Return a colour for each experiment: distinct up to seven, then along a scale.

    Empty for a single one: the colours are the contenders' then.
    """
    if len(experiments) < 2:
        return {}
    if len(experiments) <= len(COLOURS):
        return dict(zip(experiments, COLOURS, strict=False))
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    scale = colormaps["viridis"]
    steps = np.linspace(0.0, 0.92, len(experiments))
    return {name: to_hex(scale(step)) for name, step in zip(experiments, steps, strict=True)}


def legend_handles(
    results: Results,
    experiments: Sequence[str],
    quantity: Quantity,
    colours: Mapping[str, str] | None = None,
) -> list[Artist]:
    """Return one handle per contender, one per experiment, one for full contact.

    Parameters
    ----------
    results : Results
    experiments : sequence of str
    quantity : {"area", "separation", "stiffness"}
    colours : mapping of str to str, optional
        Of the experiments, where colours tell them apart.

    Returns
    -------
    list of Artist
        Only what is there: no full contact where no curve gets so far.
    """
    from matplotlib.lines import Line2D

    styles = looks(results)
    handles: list[Artist] = []
    for label, name in model_names(results, experiments, quantity).items():
        look = styles[label]
        handles.append(
            Line2D(
                [],
                [],
                color="0.25" if colours else look.colour,
                marker=look.marker or "none",
                markerfacecolor="none",
                linestyle="none" if look.marker else (0, look.dashes) if look.dashes else "-",
                label=name,
            )
        )
    if colours:
        handles += [
            Line2D([], [], color=colours[name], linewidth=3, label=experiment_label(name))
            for name in experiments
        ]
    if quantity in _FULL_CONTACT and any(
        full_contact_pressure(curve_of(result, quantity)) is not None
        for name in experiments
        for result in results[name].values()
    ):
        marker = Line2D([], [], marker=_FULL_CONTACT[quantity][1], linestyle="none")
        marker.set(color="0.25", markersize=4.5, label="full contact")
        handles.append(marker)
    return handles


def draw_panel(
    axes: Axes,
    results: Results,
    experiments: Sequence[str],
    quantity: Quantity,
    *,
    is_inset: bool = False,
) -> None:
    """Draw the curves of all contenders in the given experiments, on two log axes.

    Parameters
    ----------
    axes : Axes
    results : Results
    experiments : sequence of str
        With one of them, colours tell the contenders apart; else the experiments.
    quantity : {"area", "separation", "stiffness"}
    is_inset : bool
        Small, with a linear ordinate, without error bars and marks.
    """
    axes.set_xscale("log")
    axes.set_yscale("linear" if is_inset else "log")
    colours = experiment_colours(experiments)
    styles = looks(results)
    for number, experiment in enumerate(experiments):
        turn = number / len(experiments)
        for label, result in results[experiment].items():
            curve = curve_of(result, quantity)
            look = styles[label]
            colour = colours.get(experiment, look.colour)
            name = f"{experiment}/{label}/{quantity}"
            if is_inset:
                draw_thin(axes, curve, look, colour, turn=turn)
            else:
                draw_curve(axes, curve, look, colour, name=name, turn=turn)
                _mark_full_contact(axes, curve, look, colour, quantity)
    pressures = [
        result["pressure"] for name in experiments for result in results[name].values()
    ]
    extent = np.concatenate(pressures)
    if extent.min() == extent.max():
        axes.set_xlim(extent.min() / 10.0, extent.max() * 10.0)
    if is_inset:
        axes.tick_params(labelsize=SMALL - 0.5, length=2, pad=1.5)
        axes.tick_params(which="minor", length=0)
    else:
        axes.set_xlabel(PRESSURE)


def draw_thin(axes: Axes, curve: Curve, look: Look, colour: str, *, turn: float) -> None:
    """Draw one contender in an inset."""
    axes.plot(
        curve.pressure,
        curve.value,
        color=colour,
        linewidth=0.8,
        marker=look.marker or "none",
        markersize=1.8,
        markerfacecolor="none",
        markeredgewidth=0.5,
        linestyle="none" if look.marker else (turn, look.dashes) if look.dashes else "-",
        zorder=look.order,
    )


def unconverged_remarks(results: Results) -> list[str]:
    """Return a line for every contender with states that the averages leave out."""
    total: dict[str, tuple[str, int, int]] = {}
    for _, result in results.models():
        _, failed, states = total.get(result.label, ("", 0, 0))
        total[result.label] = (
            result.title,
            failed + result.n_unconverged,
            states + result.n_states,
        )
    return [
        f"{title}: {failed} of {states} states did not converge and are left out."
        for title, failed, states in total.values()
        if failed
    ]
