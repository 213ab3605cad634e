"""What a figure is: one of roughbench, of a package, or a class of a Python file."""

from __future__ import annotations

import re
from collections.abc import Container
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from roughbench.errors import ModelError
from roughbench.results import Results
from roughbench.source_files import load_reference
from roughbench.text import on_one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Recipe(Protocol):
    """What the module of a figure offers, or an object like it."""

    def missing(self, results: Results) -> str | None:
        """Return what the results lack for the figure, or None."""

    def draw(self, results: Results) -> Figure:
        """Return the figure, of results that lack nothing."""


def load_figure(reference: str, taken: Container[str]) -> tuple[str, Recipe]:
    """Return name and recipe of a figure in a file.

    Parameters
    ----------
    reference : str
        File, relative to the current folder, and class: ``tour.py:Proportionality``. Its
        figure is called ``proportionality``.
    taken : collection of str
        Names that it must not have.

    Raises
    ------
    ModelError
        If there is no such file or class, or it is no figure.
    """
    where = Path(reference).name
    found = load_reference(reference, Path())
    lacks = [name for name in ("missing", "draw") if not callable(getattr(found, name, None))]
    if lacks:
        raise ModelError(
            f"{where} lacks {' and '.join(lacks)}; see docs/adding-an-observable.md"
        )
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", found.__name__).lower()
    if name in taken:
        raise ModelError(f"{where}: there is a figure {name!r} already; rename the class")
    try:
        return name, cast(Recipe, found())
    except Exception as error:  # (whatever its constructor does)
        raise ModelError(
            f"{where} cannot be made without arguments: {type(error).__name__}: "
            f"{on_one_line(str(error))}"
        ) from error
