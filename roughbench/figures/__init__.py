"""The paper's figures, and those of fields, each drawn from the results alone.

>>> import roughbench as rb
>>> from roughbench import figures
>>> results = rb.run(
...     {
...         "surface": {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1},
...         "pressures": [1e-4, 1e-3, 1e-2],
...         "models": [{"kind": "persson"}],
...     }
... )
>>> figures.available(results)
['spectrum', 'area', 'separation', 'stiffness', 'fig3', 'printed_fig3', 'printed_fig4']
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.figures import (
    contact,
    distributions,
    fig3,
    foundation,
    measured,
    printed_fig3,
    printed_fig4,
    spectrum,
    stiffness,
)
from roughbench.figures.agreement import Agreement, departures
from roughbench.figures.files import FORMATS, USUAL, check_files, save, source_of
from roughbench.figures.joined import join
from roughbench.figures.observed import ObservableFigure, unknown_observables
from roughbench.figures.partial import mark_partial
from roughbench.figures.points import overlaid, quantities_of
from roughbench.figures.quantity import QuantityFigure
from roughbench.figures.recipe import Recipe, load_figure
from roughbench.figures.separation import SeparationFigure
from roughbench.figures.style import Canvas, drawing_on, publication_style
from roughbench.observables import OBSERVABLES
from roughbench.quantities import compared
from roughbench.registry import Registry
from roughbench.results import Results
from roughbench.source_files import blamed, names_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "FIGURES",
    "FORMATS",
    "NOT_COMPUTED",
    "USUAL",
    "Agreement",
    "Recipe",
    "available",
    "departures",
    "drawn_of",
    "join",
    "needed",
    "overlaid",
    "plot",
    "recipes_of",
    "render",
    "shows_points",
]


T = TypeVar("T")

_PAPER: Mapping[str, Recipe] = {
    "foundation": foundation,
    "spectrum": spectrum,
    "area": QuantityFigure("area"),
    "separation": SeparationFigure("separation"),
    "stiffness": stiffness,
    "fig3": fig3,
    "printed_fig3": printed_fig3,
    "printed_fig4": printed_fig4,
}
_OF_FIELDS: Mapping[str, Recipe] = {
    **{one.variable: ObservableFigure(one) for one in OBSERVABLES.values()},
    "distributions": distributions,
    "contact": contact,
}
_MORE = {name: QuantityFigure(name) for name in compared() if name not in _PAPER}

FIGURES: Mapping[str, Recipe] = Registry(
    "roughbench.figures", {"surface": measured, **_PAPER, **_MORE, **_OF_FIELDS}
)
"""Name → recipe: the measured surface; the foundation, Fig. 1 of the paper; the spectrum,
Fig. 2; area and separation, Fig. 3; the stiffness, Fig. 4; further quantities; each observable,
and the fields that are kept; those that other packages declare."""


NOT_COMPUTED = frozenset({"spectrum", "surface"})
"""Figures of what the spec says, not of what was computed."""


def available(results: Results) -> list[str]:
    """Return the names of the figures that these results allow, the paper's in its order."""
    recipes = recipes_of(results)
    return [name for name, recipe in recipes.items() if recipe.missing(results) is None]


def recipes_of(results: Results) -> Mapping[str, Recipe]:
    """Return :data:`FIGURES`, and those of observables that the results alone know."""
    own = {one.variable: ObservableFigure(one) for one in unknown_observables(results)}
    return {**FIGURES, **own}


def drawn_of(folder: str | os.PathLike[str]) -> set[str]:
    """Return the names of the results files that the figures in a folder say they are of."""
    suffixes = {f".{suffix}" for suffix in FORMATS}
    found = {source_of(path) for path in Path(folder).glob("*.*") if path.suffix in suffixes}
    return found - {""}


def needed(results: Results, name: str) -> Callable[[Results], str | None]:
    """Return what says of results whether a figure can be drawn of them: None, or what lacks.

    Parameters
    ----------
    results : Results
        That the figure can be drawn of.
    name : str
        As for :func:`render`.

    Raises
    ------
    StoreError, ModelError
        As :func:`render`.
    """
    return _allowed(results, name)[1].missing


def shows_points(results: Results, name: str) -> bool:
    """Return whether a figure shows some of the points that were laid over results."""
    there = quantities_of(results)
    if name == "fig3":
        return bool(there & {"area", "separation"})
    return name in there


def plot(
    results: Results,
    name: str,
    *,
    ax: Axes | Sequence[Axes] | NDArray[np.object_] | None = None,
    overlay: str | os.PathLike[str] | None = None,
    style: str | os.PathLike[str] = "",
) -> Axes | list[Axes]:
    r"""Draw a figure of results, to be shown in a notebook, changed or saved.

    Parameters
    ----------
    results : Results
    name : str
        As for :func:`render`: ``area``, ``separation``, ``stiffness``, ``spectrum`` …; see
        :func:`available`.
    ax : Axes or array of Axes, optional
        Panel to draw into, of a figure of the caller's, whose style it keeps; for a figure of
        several panels as many, row by row. The legend stands in the first, remarks stand under
        the axis of the last.
    overlay : path, optional
        A CSV file of points to draw over the curves, see :mod:`roughbench.figures.points`.
    style : str or path
        A style of Matplotlib, or a style file, over that of roughbench; not with ``ax``.

    Returns
    -------
    Axes or list of Axes
        The panels; ``axes.figure.savefig("area.pdf")`` saves them.

    Raises
    ------
    StoreError
        If there is no such figure, the results lack what it shows, it has more or fewer panels
        than ``ax``, or it shows nothing of the points.
    ModelError
        If a figure from outside cannot be used.

    Examples
    --------
    >>> import matplotlib
    >>> matplotlib.use("Agg")
    >>> import roughbench as rb
    >>> results = rb.run({
    ...     "surface": {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1},
    ...     "pressures": [1e-4, 1e-3, 1e-2],
    ...     "models": [{"kind": "persson"}],
    ... })
    >>> axes = rb.plot(results, "area")
    >>> axes.get_xscale(), [one.get_text() for one in axes.figure.legends[0].get_texts()]
    ('log', ['Persson, $\\gamma = 0.45$'])
    """
    if overlay is not None:
        results = overlaid(results, Path(overlay))
        if not names_file(name) and not shows_points(results, name):
            raise StoreError(f"the figure {name!r} shows no column of {Path(overlay).name}")
    name, recipe = _allowed(results, name)
    canvas = Canvas(None if ax is None else _panels_in(ax))
    if canvas.axes is not None:
        if style:
            raise StoreError("ax has a style already: give either ax or style")
        with drawing_on(canvas):
            figure = _asked(recipe.draw, name, results)
        if not canvas.panels:
            raise StoreError(f"the figure {name!r} makes panels of its own; leave out ax")
        panels = [panel for panel in canvas.panels if panel in figure.axes]
        return panels[0] if len(canvas.panels) == 1 else panels
    import matplotlib.pyplot as plt

    # Loads the backend, whose settings are the caller's, not ours.
    plt.draw_if_interactive()  # type: ignore[no-untyped-call]
    with publication_style(Path(style) if style else ""):
        with drawing_on(canvas):
            figure = _asked(recipe.draw, name, results)
        figure.draw_without_rendering()  # all of it in this style, whenever it is shown
    panels = [panel for panel in canvas.panels or figure.axes if panel in figure.axes]
    return panels[0] if len(panels) == 1 else panels


def render(
    results: Results,
    name: str,
    folder: str | os.PathLike[str],
    source: str = "",
    *,
    formats: Sequence[str] = USUAL,
    style: str | os.PathLike[str] = "",
) -> list[Path]:
    """Draw a figure into a folder, as PDF and PNG.

    The same results give the same bytes. Each file is replaced in one step, if it is a
    figure that roughbench drew.

    Parameters
    ----------
    results : Results
        Nothing else is read: neither the results file nor the surfaces.
    name : str
        One of :func:`recipes_of`, or the class of a file, as ``tour.py:Proportionality``,
        which is found from the current folder and run.
    folder : path
        Made if it does not exist.
    source : str
        Name of the results file, for :func:`drawn_of`.
    formats : sequence of str
        Of :data:`FORMATS`.
    style : str or path
        A style of Matplotlib, or a style file, over that of roughbench.

    Returns
    -------
    list of Path
        ``<name>.pdf`` and ``<name>.png``, in the order of the formats.

    Raises
    ------
    StoreError
        If there is no such figure, format or style, the results lack what it shows, or a file
        cannot be written or is somebody else's.
    ModelError
        If there is no such file or class, it is no figure, or ends with an error.
    """
    name, recipe = _allowed(results, name)
    check_files(name, Path(folder), formats)
    with publication_style(Path(style) if style else ""):
        figure = _asked(recipe.draw, name, results)
        mark_partial(figure, results.partial)
        return save(figure, name, Path(folder), source, formats)


def _panels_in(ax: object) -> tuple[Axes, ...]:
    """Return the panels that a caller has given, one or an array of them."""
    from matplotlib.axes import Axes

    given = tuple(np.asarray(ax, dtype=object).ravel())
    for one in given:
        if not isinstance(one, Axes):
            raise StoreError(f"ax is no panel of Matplotlib, nor an array of them: got {one!r}")
    return given


def _allowed(results: Results, name: str) -> tuple[str, Recipe]:
    """Return name and recipe of a figure that lacks nothing."""
    if names_file(name):
        name, recipe = load_figure(name, FIGURES)
    else:
        recipes = recipes_of(results)
        if name not in recipes:
            raise StoreError(f"there is no figure {name!r}; choose one of {', '.join(recipes)}")
        recipe = recipes[name]
    if lack := _asked(recipe.missing, name, results):
        allowed = ", ".join(available(results)) or "none"
        raise StoreError(
            f"figure {name!r} needs {lack}; figures that these results allow: {allowed}"
        )
    return name, recipe


def _asked(function: Callable[[Results], T], name: str, results: Results) -> T:
    """Return what a recipe answers; an error of one from outside is told with its line."""
    try:
        return function(results)
    except Exception as error:
        recipe = getattr(function, "__self__", None)  # None of a module
        found = error if recipe is None else blamed(recipe, error, f"the figure {name}")
        if found is error:
            raise
        raise found from error
