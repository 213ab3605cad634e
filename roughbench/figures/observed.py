"""Pictures of fields: where the models touch, and their observables side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.style import (
    COLOURS,
    legend_above,
    letter,
    new_figure,
    publication_style,
    save,
)
from roughbench.figures.words import MODULUS, number_text

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

MOST_PANELS = 4
DECADES = 1e-7
"""Values below the highest by more than this factor are cut off."""
_DASHES = ((), (9, 1.5), (5, 1.5, 1, 1.5), (2, 1), (1, 1))


@dataclass(frozen=True, slots=True)
class ContactMap:
    """One state to be drawn.

    Attributes
    ----------
    title : str
        Of the model.
    pressure : ndarray of float64, shape (n, m) or (n,)
        Contact pressure, zero out of contact, in units of E*.
    """

    title: str
    pressure: FloatArray


@dataclass(frozen=True, slots=True)
class Line:
    """One curve in one panel.

    Attributes
    ----------
    title : str
    x, y, error : ndarray of float64, shape (K,)
        What a logarithmic axis cannot show is left out.
    is_theory : bool
        Drawn thin and grey, without a band.
    """

    title: str
    x: FloatArray
    y: FloatArray
    error: FloatArray
    is_theory: bool = False


def draw_contact_maps(
    maps: Sequence[ContactMap], rms_slope: float, name: str, folder: Path
) -> list[Path]:
    """Draw states side by side: white out of contact, the darker the higher the pressure.

    Parameters
    ----------
    maps : sequence of ContactMap
        Lines appear as stripes.
    rms_slope : float
        ξ; pressures are drawn up to E*ξ.
    name : str
        Of the files.
    folder : Path

    Returns
    -------
    list of Path
        PDF and PNG.
    """
    with publication_style():
        return save(contact_maps(maps, rms_slope), name, folder)


def contact_maps(maps: Sequence[ContactMap], rms_slope: float) -> Figure:
    """Return the figure of :func:`draw_contact_maps`."""
    columns = min(2, len(maps))
    rows = math.ceil(len(maps) / columns)
    # One colour bar for all; each panel is a square of half a column.
    from matplotlib import colormaps

    figure, panels = new_figure(rows, 1.9, columns)
    figure.set_figwidth(3.375 if columns == 2 else 2.2)
    colours = colormaps["viridis_r"].with_extremes(bad="white")
    for axes in panels[len(maps) :]:
        axes.remove()
    image = None
    for axes, drawn in zip(panels, maps, strict=False):
        pressure = drawn.pressure / rms_slope
        if pressure.ndim == 1:
            pressure = pressure[None, :]
        image = axes.imshow(
            np.where(pressure > 0.0, pressure, np.nan),
            cmap=colours,
            vmin=0.0,
            vmax=1.0,
            interpolation="nearest",
            aspect="auto" if drawn.pressure.ndim == 1 else "equal",
        )
        axes.set(xticks=[], yticks=[])
        share = np.count_nonzero(drawn.pressure) / drawn.pressure.size
        axes.set_title(f"{drawn.title}\n{100 * share:.3g} % of the points", fontsize=7.5)
    if image is not None:
        bar = figure.colorbar(image, ax=panels[: len(maps)], location="bottom", extend="max")
        bar.set_label(rf"pressure $\sigma/{MODULUS}\xi$")
    return figure


def draw_observable(
    lines: Mapping[float, Sequence[Line]],
    axis: str,
    value: str,
    name: str,
    folder: Path,
    scale: str = "log",
) -> list[Path]:
    """Draw an observable of all models, one panel per pressure.

    Parameters
    ----------
    lines : mapping of float to sequence of Line
        By pressure p/E*; of more than four pressures four are drawn.
    axis, value : str
        What is drawn over what.
    name : str
        Of the files.
    folder : Path
    scale : {"log", "linear"}
        Of the abscissa.

    Returns
    -------
    list of Path
        PDF and PNG.
    """
    with publication_style():
        return save(observable(lines, axis, value, scale), name, folder)


def observable(
    lines: Mapping[float, Sequence[Line]], axis: str, value: str, scale: str = "log"
) -> Figure:
    """Return the figure of :func:`draw_observable`."""
    pressures = sorted(lines)
    if len(pressures) > MOST_PANELS:
        chosen = np.linspace(0, len(pressures) - 1, MOST_PANELS).round().astype(int)
        pressures = [pressures[k] for k in chosen]
    columns = min(2, len(pressures))
    rows = math.ceil(len(pressures) / columns)
    figure, panels = new_figure(rows, 2.1, columns, extra=0.4, share=True)
    for axes in panels[len(pressures) :]:
        axes.remove()
    for number, (axes, pressure) in enumerate(zip(panels, pressures, strict=False)):
        _panel(axes, lines[pressure], scale)
        letter(axes, number, rf"$p/{MODULUS} = {number_text(pressure).strip('$')}$")
        axes.set_xlabel(axis)
        axes.set_ylabel(value)
        axes.label_outer()
    legend_above(figure, _handles([line for p in pressures for line in lines[p]]))
    return figure


def _panel(axes: Axes, lines: Sequence[Line], scale: str) -> None:
    axes.set_xscale(scale)
    axes.set_yscale("log")
    looks = _looks(lines)
    highest, lowest = 0.0, math.inf
    for line in lines:
        shown = np.isfinite(line.y) & (line.y > 0.0) & np.isfinite(line.x) & (line.x > 0.0)
        x, y, error = line.x[shown], line.y[shown], line.error[shown]
        look = looks[line.title]
        axes.plot(x, y, gid=line.title, **look)
        if y.size:
            highest, lowest = max(highest, y.max()), min(lowest, y.min())
        if not line.is_theory and np.isfinite(error).any():
            below = np.maximum(y - error, 1e-3 * y)  # a logarithmic axis has no zero
            axes.fill_between(x, below, y + error, color=look["color"], alpha=0.25, linewidth=0)
    if highest > 0.0:
        axes.set_ylim(max(lowest / 2.0, DECADES * highest), 3.0 * highest)


def _looks(lines: Sequence[Line]) -> dict[str, dict[str, Any]]:
    looks: dict[str, dict[str, Any]] = {}
    for line in lines:
        if line.title in looks:
            continue
        number = len(looks)
        dashes = _DASHES[number % len(_DASHES)]
        looks[line.title] = {
            "color": "0.45" if line.is_theory else COLOURS[number % len(COLOURS)],
            "linestyle": (0, (3, 2)) if line.is_theory else (0, dashes) if dashes else "-",
        }
    return looks


def _handles(lines: Sequence[Line]) -> list[Artist]:
    from matplotlib.lines import Line2D

    return [Line2D([], [], label=title, **look) for title, look in _looks(lines).items()]
