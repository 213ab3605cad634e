"""Fig. 1 of the paper: the rough punch on its foundation of independent springs.

The springs are those of the fields that a run keeps (``save_fields``): of all experiments and
pressures that it kept, the state that shows the most contact regions
(:func:`~roughbench.figures.pressed.most_telling`). Above the whole line: the rigid
punch, its lower side at the height d - h_i over the unloaded springs, which it compresses
by h_i - d where that is negative. Below the springs of a window that shows contact and
gaps (:func:`~roughbench.figures.pressed.choose_window`), every one or every few of them.
Heights are in h_rms and drawn much exaggerated; the length of a spring has no meaning in
the model and is chosen for the eye.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures.labels import experiment_labels, height_remark, pressure_text
from roughbench.figures.pressed import (
    FloatArray,
    Pressed,
    Window,
    choose_window,
    most_telling,
    pressed_lines,
)
from roughbench.figures.style import BACKGROUND, SMALL, footnote, letter, new_figure
from roughbench.models.foundation import Foundation
from roughbench.results import Results
from roughbench.units import in_words, prefix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PUNCH, _PUNCH_EDGE = "0.85", "0.2"
_FREE, _COMPRESSED = "0.45", Foundation.style.colour
_WINDOW = "0.0"


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if any(True for _ in pressed_lines(results)):
        return None
    return (
        "the fields of a foundation, not yet in full contact, which a spec asks for with "
        "save_fields: {pressures: [...], realizations: [0]}"
    )


def draw(results: Results) -> Figure:
    """Return the figure."""
    pressed = most_telling(results)
    figure, (whole, zoom) = new_figure(2, 1.75)
    window = choose_window(pressed.clearance < 0.0)
    unit, name_of_unit = _heights(pressed)
    _draw_whole(whole, pressed, window, unit)
    _draw_springs(zoom, pressed, window, unit)
    separation = rf"$\bar u = {pressed.separation / pressed.rms_height:.2g}\,h_\mathrm{{rms}}$"
    if pressed.has_units:
        separation = rf"$\bar u$ = {in_words(pressed.separation, 'm', 2)}"
    state = f"{pressure_text(results, pressed.pressure)}, {separation}"
    name = experiment_labels(results)[pressed.experiment]
    letter(whole, 0, ", ".join(filter(None, [name, state])))
    shown = "" if window.step == 1 else f", one in {window.step} drawn"
    letter(zoom, 1, f"some of the {pressed.clearance.size} springs{shown}")
    figure.supylabel(name_of_unit, fontsize=9)
    footnote(figure, [*filter(None, [height_remark(results)])])
    return figure


def _heights(pressed: Pressed) -> tuple[float, str]:
    """Return what heights are divided by, and what the axis says."""
    if not pressed.has_units:
        return pressed.rms_height, r"height/$h_\mathrm{rms}$"
    factor, unit = prefix(pressed.clearance.tolist(), "m")
    return 1.0 / factor, f"height ({unit})"


def _draw_whole(axes: Axes, pressed: Pressed, window: Window, unit: float) -> None:
    n = pressed.clearance.size
    x = (np.arange(n) + 0.5) / n
    z = pressed.clearance / unit
    bottom, top = z.min() - 0.15 * np.ptp(z), z.max() + 0.3 * np.ptp(z)
    axes.fill_between(x, z, top, color=_PUNCH, linewidth=0)
    axes.plot(x, z, color=_PUNCH_EDGE, linewidth=0.4, gid="punch")
    axes.fill_between(x, z, 0.0, where=(z < 0.0).tolist(), color=_COMPRESSED, linewidth=0.3)
    axes.axhline(0.0, color=_COMPRESSED, linewidth=0.7)
    window_ends = [window.start / n, window.stop / n]
    for end in window_ends:
        axes.axvline(end, color=_WINDOW, linewidth=0.6)
    axes.plot(
        window_ends,
        [0.0, 0.0],
        color=_WINDOW,
        linewidth=4,
        solid_capstyle="butt",
        transform=axes.get_xaxis_transform(),
    )
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("position $x/L$")
    for y, align, word, ground in (
        (0.95, "top", "rigid punch", _PUNCH),
        (0.06, "bottom", "springs", "white"),
    ):
        axes.text(
            0.02,
            y,
            word,
            transform=axes.transAxes,
            va=align,
            fontsize=SMALL + 1.0,
            bbox=BACKGROUND | {"facecolor": ground},
            zorder=5,
        )


def _draw_springs(axes: Axes, pressed: Pressed, window: Window, unit: float) -> None:
    from matplotlib.collections import LineCollection

    start = window.start
    margin = max(window.step // 2, 1)
    x = np.arange(start - margin, window.stop + margin)
    z = np.take(pressed.clearance, x, mode="wrap") / unit
    deepest, highest = -min(float(z.min()), 0.0), max(float(z.max()), 0.0)
    span = deepest + highest
    base = -(deepest + 0.9 * span)
    ends = np.minimum(z[margin : -margin : window.step], 0.0)
    springs = [
        spring(start + window.step * i, base, end, 0.3 * window.step)
        for i, end in enumerate(ends)
    ]
    colours = [_COMPRESSED if end < 0.0 else _FREE for end in ends]
    axes.add_collection(LineCollection(springs, colors=colours, linewidths=0.55, gid="springs"))
    axes.fill_between(x, z, highest + 0.3 * span, color=_PUNCH, linewidth=0)
    axes.plot(x, z, color=_PUNCH_EDGE, linewidth=0.8, gid="window")
    axes.axhline(0.0, color=_FREE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
    axes.fill_between(
        [x[0], x[-1]],
        base - 0.12 * span,
        base,
        facecolor="white",
        edgecolor=_PUNCH_EDGE,
        hatch="//////",
        linewidth=0.6,
    )
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(base - 0.12 * span, highest + 0.3 * span)
    axes.set_xlabel("spring number")


def spring(x: float, bottom: float, top: float, swing: float, coils: int = 7) -> FloatArray:
    """Return the zigzag of a spring, straight at both ends.

    Parameters
    ----------
    x : float
        Its axis.
    bottom, top : float
        Its ends.
    swing : float
        How far it goes to either side.
    coils : int
        The same for every spring, so that a compressed one is denser.

    Returns
    -------
    ndarray of float64, shape (2 coils + 4, 2)
    """
    n = 2 * coils
    side = np.concatenate([[0.0, 0.0], swing * (-1.0) ** np.arange(n), [0.0, 0.0]])
    along = np.concatenate([[0.0, 0.06], 0.06 + 0.88 * (np.arange(n) + 0.5) / n, [0.94, 1.0]])
    return np.column_stack([x + side, bottom + (top - bottom) * along])
