"""Figures of runs that are not finished say so, and how far the run is."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

from roughbench.figures.style import COLUMN, GUIDE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_MODELS = 6
_LETTERS = 58
"""In a line of one column."""
_LINE = 0.13
"""Inches."""


def mark_partial(figure: Figure, partial: Mapping[str, tuple[int, int]]) -> None:
    """Write across a figure that it is partial, and below it how many realizations it shows.

    Parameters
    ----------
    figure : Figure
        It grows by what is written below it.
    partial : mapping of str to (int, int)
        As :attr:`roughbench.results.Results.partial`; nothing is written if it is empty.
    """
    if not partial:
        return
    shown = [
        f"{model} {there} of {planned}"
        for model, (there, planned) in list(partial.items())[:_MOST_MODELS]
    ]
    if more := len(partial) - len(shown):
        shown.append(f"{more} more")
    text = f"PARTIAL, a run that is not finished. Realizations: {', '.join(shown)}."
    letters = int(_LETTERS * figure.get_figwidth() / COLUMN)
    lines = textwrap.wrap(text, letters)
    before = figure.get_supxlabel()
    figure.supxlabel("\n".join([*filter(None, [before]), *lines]), color=GUIDE)
    figure.set_figheight(figure.get_figheight() + _LINE * len(lines))
    figure.text(
        *(0.5, 0.5, "PARTIAL"),
        rotation=30.0,
        fontsize=28.0,
        color=GUIDE,
        alpha=0.25,
        ha="center",
        va="center",
    )
