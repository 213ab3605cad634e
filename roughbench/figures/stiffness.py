r"""Fig. 4 of the paper: the stiffness K h_rms/E* against p/E*, one panel per experiment.

Exact solver as squares on top, foundation as a solid line, Persson dashed; grey guide
lines have the slopes 1 and 1/(1 + H). A triangle on the upper edge marks the lowest
pressure at which the curve is infinite (full contact); the line ends before it. Where a
mean is infinite there stands a median, and lines are medians throughout then
(:func:`~roughbench.figures.curves.curve_of`).

**Where Popov leaves the analytical result.** The dashed vertical lines stand where

.. math:: |\ln (K_\mathrm{Popov} / K_\mathrm{Persson})| = \ln 2

(:data:`FACTOR`): at the ends of the widest range of pressure, in :math:`\ln p`, in which
the two curves as drawn differ by less than this factor. Between the pressures of the
results :math:`\ln(K_\mathrm{Popov}/K_\mathrm{Persson})` is taken as linear in
:math:`\ln p`; from a finite value to an infinite one the *inverse* ratio is. Persson's
stiffness contains the finite-size term if the spec says so. The factor is a choice, and
a coarse one: the standard errors of 100 realizations are some 3 %, but Persson's
prefactor depends on γ by 30 % and eq. (10)'s on θ by a factor 2. :func:`departures`
returns the pressures, for this factor or another.

With the paper's surfaces (H = 0.7, q1 = 8192 q0, ξ = 0.1; γ = 0.45; 100 realizations of
32768 springs; 71 pressures from 1e-8 to 0.1) the two agree within a factor 2 for p/E* from
2.0e-5 to 1.6e-3 (qr = q0) and from 3.4e-6 to 2.1e-4 (qr = 8 q0). The larger of Persson's
stiffness and eq. (10) with θ = 1 moves only the first, to 1.6e-5. With a factor 1.5 it is
4.9e-5 to 1.3e-3 and 1.1e-5 to 1.2e-4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.figures.curves import (
    MODULUS,
    curve_of,
    draw_panel,
    experiment_label,
    has_medians,
    height_label,
    legend_handles,
    number_text,
    unconverged_remarks,
)
from roughbench.figures.style import (
    BACKGROUND,
    GUIDE,
    SMALL,
    footnote,
    legend_above,
    letter,
    new_figure,
)
from roughbench.results import ModelResult, Results

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

FACTOR = 2.0
"""Largest ratio of two stiffnesses that counts as agreement."""
CEILING = 1e2
"""Stiffnesses K h_rms/E* above this are cut off: there is hardly a gap left to close."""

_DEPARTURE: dict[str, Any] = {"color": "0.3", "linewidth": 0.7, "linestyle": (0, (4, 3))}


@dataclass(frozen=True, slots=True)
class Agreement:
    """The widest range of pressure in which two stiffnesses agree within a factor.

    Attributes
    ----------
    factor : float
        The criterion.
    found : bool
        Whether they agree anywhere.
    lower, upper : float or None
        p/E* where they part; None where they agree up to the last pressure there is.
    """

    factor: float
    found: bool
    lower: float | None = None
    upper: float | None = None

    @property
    def pressures(self) -> tuple[float, ...]:
        """The pressures of departure, none to two of them."""
        return tuple(p for p in (self.lower, self.upper) if p is not None)


def agreement(
    pressure: ArrayLike, stiffness: ArrayLike, reference: ArrayLike, factor: float = FACTOR
) -> Agreement:
    """Return where two curves agree within a factor, by the criterion of this module.

    Parameters
    ----------
    pressure : array_like of float64, shape (P,)
        p/E* > 0, ascending.
    stiffness, reference : array_like of float64, shape (P,)
        Positive, in one unit, may be inf; states with nan, or with both infinite, are
        passed over.
    factor : float
        Greater than 1.

    Returns
    -------
    Agreement

    Examples
    --------
    >>> p = [1.0, 10.0, 100.0]
    >>> agreement(p, [1.0, 10.0, 100.0], [10.0, 10.0, 10.0], factor=3.0).pressures
    (3.33..., 30.0...)
    >>> agreement(p, [1.0, 1.0, 1.0], [5.0, 5.0, 5.0]).found
    False
    """
    if not factor > 1.0:
        raise ValueError(f"the factor must be greater than 1, got {factor}")
    with np.errstate(invalid="ignore"):
        ratio = np.asarray(stiffness, float) / np.asarray(reference, float)
    known = ~np.isnan(ratio)
    x = np.log(np.asarray(pressure, float)[known])
    ratio = ratio[known]
    best: tuple[float, float] | None = None
    start: float | None = None
    for a, b, y_a, y_b in zip(x, x[1:], ratio, ratio[1:], strict=False):
        inside = _inside(y_a, y_b, factor)
        if inside is None:
            start = None
            continue
        left, right = a + inside[0] * (b - a), a + inside[1] * (b - a)
        start = left if start is None or inside[0] > 0.0 else start
        if best is None or right - start > best[1] - best[0]:
            best = (start, right)
        start = start if inside[1] == 1.0 else None
    if best is None:
        return Agreement(factor, found=False)
    lower, upper = best
    return Agreement(
        factor,
        found=True,
        lower=math.exp(lower) if lower > x[0] else None,
        upper=math.exp(upper) if upper < x[-1] else None,
    )


def _inside(y_a: float, y_b: float, factor: float) -> tuple[float, float] | None:
    """Part of the way from a to b, within 0 … 1, on which 1/factor < y < factor."""
    if math.isinf(y_a) and math.isinf(y_b):
        return None
    if math.isinf(y_a) or math.isinf(y_b):
        ends, low, high = (1.0 / y_a, 1.0 / y_b), 1.0 / factor, factor
    elif y_a == 0.0 or y_b == 0.0:
        ends, low, high = (y_a, y_b), 1.0 / factor, factor
    else:
        ends, high = (math.log(y_a), math.log(y_b)), math.log(factor)
        low = -high
    rise = ends[1] - ends[0]
    if rise == 0.0:
        return (0.0, 1.0) if low < ends[0] < high else None
    crossings = sorted(((low - ends[0]) / rise, (high - ends[0]) / rise))
    first, last = max(crossings[0], 0.0), min(crossings[1], 1.0)
    return (first, last) if first < last else None


def departures(results: Results, factor: float = FACTOR) -> dict[str, Agreement | None]:
    """Return for every experiment where the foundation and Persson's theory agree.

    Parameters
    ----------
    results : Results
    factor : float
        The criterion.

    Returns
    -------
    dict of str to Agreement or None
        By experiment; None where one of the two is missing, or their pressures differ.
        Of several models of one kind the first counts.
    """
    return {name: _agreement_in(results, name, factor) for name in results}


def _agreement_in(results: Results, experiment: str, factor: float) -> Agreement | None:
    popov = _first(results, experiment, "foundation")
    persson = _first(results, experiment, "persson")
    if popov is None or persson is None:
        return None
    curve, reference = curve_of(popov, "stiffness"), curve_of(persson, "stiffness")
    if not np.array_equal(curve.pressure, reference.pressure):
        return None
    return agreement(curve.pressure, curve.value, reference.value, factor)


def _first(results: Results, experiment: str, kind: str) -> ModelResult | None:
    return next((r for r in results[experiment].values() if r.kind == kind), None)


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    has_line = any(
        np.isfinite(curve_of(result, "stiffness").value).any() for _, result in results.models()
    )
    return None if has_line else "a model with a finite stiffness"


def draw(results: Results) -> Figure:
    """Return the figure: one column of panels, from four experiments on two."""
    experiments = list(results)
    columns = 1 if len(experiments) < 4 else 2
    rows = math.ceil(len(experiments) / columns)
    figure, panels = new_figure(rows, 2.3, columns, extra=0.6, share=True)
    for axes in panels[len(experiments) :]:
        axes.remove()
    for number, (axes, experiment) in enumerate(zip(panels, experiments, strict=False)):
        _panel(axes, results, experiment, number)
    legend_above(figure, _handles(results, experiments))
    remarks = unconverged_remarks(results)
    if has_medians(results, "stiffness"):
        remarks.insert(0, "Medians with 16 % and 84 % quantiles where a mean is infinite.")
    footnote(figure, remarks)
    return figure


def _panel(axes: Axes, results: Results, experiment: str, number: int) -> None:
    draw_panel(axes, results, [experiment], "stiffness")
    label = rf"stiffness $K h_\mathrm{{rms}}/{MODULUS}$"
    axes.set_ylabel(f"{label}\n{height_label(results)}")
    axes.label_outer()
    if len(results) > 1:
        letter(axes, number, experiment_label(experiment))
    _limit(axes, results)
    _draw_guides(axes, results, experiment)
    _draw_departures(axes, _agreement_in(results, experiment, FACTOR))


def _handles(results: Results, experiments: list[str]) -> list[Artist]:
    from matplotlib.lines import Line2D

    handles = legend_handles(results, experiments, "stiffness")
    found = departures(results).values()
    if any(range_ is not None and range_.pressures for range_ in found):
        words = f"Popov/Persson = {FACTOR:g}, 1/{FACTOR:g}"
        handles.append(Line2D([], [], label=words, **_DEPARTURE))
    return handles


def _limit(axes: Axes, results: Results) -> None:
    """Show all panels from the lowest value to the highest, but not above CEILING."""
    values = np.concatenate([curve_of(r, "stiffness").value for _, r in results.models()])
    values = values[np.isfinite(values) & (values > 0.0)]
    if values.size and values.min() < CEILING:
        axes.set_ylim(values.min() / 3.0, 2.0 * min(values.max(), CEILING))


def _draw_guides(axes: Axes, results: Results, experiment: str) -> None:
    """Draw short lines with the slopes of K ∝ p and of K ∝ p^{1/(1+H)}."""
    models = results[experiment].values()
    curves = [curve_of(result, "stiffness") for result in models]
    points = np.concatenate(
        [np.stack([curve.pressure, curve.value]) for curve in curves], axis=1
    )
    points = points[:, np.isfinite(points[1]) & (points[1] > 0.0) & (points[1] < CEILING)]
    if points.size == 0:
        return
    x = np.log(points[0])
    y = np.log(points[1])
    span = x.max() - x.min()

    def guide(slope: float, start: float, stop: float, side: float, text: str) -> None:
        left, right = x.min() + start * span, x.min() + stop * span
        near = (x >= left - 0.02 * span) & (x <= right + 0.02 * span)
        if not near.any():
            return
        rest = y[near] - slope * x[near]
        level = rest.max() + 0.9 if side > 0 else rest.min() - 0.9
        ends = np.array([left, right])
        axes.plot(
            np.exp(ends),
            np.exp(level + slope * ends),
            color=GUIDE,
            linewidth=0.7,
            zorder=1,
            gid=f"guide {slope:.6g}",
        )
        above = side > 0
        axes.annotate(
            text,
            (math.exp(left if above else right), math.exp(level + slope * ends.mean())),
            (0, 8) if above else (0, -4),
            textcoords="offset points",
            ha="left" if above else "right",
            va="bottom" if above else "top",
            color=GUIDE,
            fontsize=SMALL,
            bbox=BACKGROUND,
        )

    guide(1.0, 0.42, 0.68, -1.0, "slope 1")
    known = [model.attributes["hurst"] for model in models if "hurst" in model.attributes]
    for hurst in known[:1]:
        guide(1.0 / (1.0 + float(hurst)), 0.02, 0.28, 1.0, r"slope $1/(1+H)$")


def _draw_departures(axes: Axes, found: Agreement | None) -> None:
    """Draw and name the ends of the range of agreement, or say that there are none."""
    if found is None:
        return
    left, right = np.log(axes.get_xlim())
    for pressure, outwards in ((found.lower, -1), (found.upper, 1)):
        if pressure is None:
            continue
        place = (math.log(pressure) - left) / (right - left)
        side = outwards if 0.07 < place < 0.93 else -outwards
        axes.axvline(pressure, zorder=1, gid="departure", **_DEPARTURE)
        axes.annotate(
            number_text(pressure),
            (pressure, 0.91),
            (1.5 * side, 0),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            rotation=90,
            ha="left" if side > 0 else "right",
            va="top",
            color=_DEPARTURE["color"],
            fontsize=SMALL,
        )
    if not found.pressures:
        where = "everywhere" if found.found else "nowhere"
        text = f"Popov and Persson agree {where}\nwithin a factor {found.factor:g}"
        axes.text(0.97, 0.04, text, transform=axes.transAxes, ha="right", fontsize=SMALL)
