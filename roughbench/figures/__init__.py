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
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from roughbench.errors import StoreError
from roughbench.figures import (
    contact,
    fig3,
    foundation,
    measured,
    printed_fig3,
    printed_fig4,
    spectrum,
    stiffness,
)
from roughbench.figures.agreement import Agreement, departures
from roughbench.figures.joined import join
from roughbench.figures.observed import ObservableFigure, unknown_observables
from roughbench.figures.quantity import QuantityFigure
from roughbench.figures.recipe import Recipe, load_figure
from roughbench.figures.separation import SeparationFigure
from roughbench.figures.style import check_files, publication_style, save, source_of
from roughbench.observables import OBSERVABLES
from roughbench.quantities import compared
from roughbench.registry import Registry
from roughbench.results import Results
from roughbench.source_files import blamed, names_file

__all__ = [
    "FIGURES",
    "NOT_COMPUTED",
    "Agreement",
    "Recipe",
    "available",
    "departures",
    "drawn_of",
    "join",
    "needed",
    "recipes_of",
    "render",
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
    found = {source_of(path) for path in Path(folder).glob("*.png")}
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
    return _recipe(results, name)[1].missing


def _recipe(results: Results, name: str) -> tuple[str, Recipe]:
    """Return name and recipe of a figure that the results allow."""
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


def render(
    results: Results, name: str, folder: str | os.PathLike[str], source: str = ""
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

    Returns
    -------
    list of Path
        ``<name>.pdf`` and ``<name>.png``.

    Raises
    ------
    StoreError
        If there is no such figure, the results lack what it shows, or a file cannot be
        written or is somebody else's.
    ModelError
        If there is no such file or class, it is no figure, or ends with an error.
    """
    name, recipe = _recipe(results, name)
    check_files(name, Path(folder))
    with publication_style():
        return save(_asked(recipe.draw, name, results), name, Path(folder), source)


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
