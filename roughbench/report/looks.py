"""Who is who in the charts: a colour and a symbol for each model, dashes per experiment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.figures.style import COLOURS
from roughbench.report.sources import Source

_FIRST = {"bem": "#000000", "foundation": COLOURS[0], "persson": COLOURS[1]}
"""Colours of the three models of the paper, as in the printed figures."""
_OTHERS = (
    *COLOURS[2:6],
    "#8C6D31",
    "#7F7F7F",
    "#5E3C99",
    "#A6761D",
    "#66A61E",
    "#882255",
)
_SYMBOLS = (
    "square-open",
    "circle",
    "triangle-up",
    "diamond",
    "triangle-down",
    "x",
    "cross",
    "pentagon",
    "star",
    "hourglass",
    "triangle-left",
    "triangle-right",
)
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")


@dataclass(frozen=True, slots=True)
class Look:
    """How a model is drawn.

    Attributes
    ----------
    colour : str
        ``#RRGGBB``.
    symbol : str
        Name of a marker of plotly.
    """

    colour: str
    symbol: str


def model_looks(sources: Sequence[Source]) -> dict[str, Look]:
    """Return a look for every label; equal labels look alike in all files."""
    kinds = {result.label: result.kind for source in sources for _, result in source.models()}
    free = dict(_FIRST)
    looks = {}
    others = 0
    for place, (label, kind) in enumerate(kinds.items()):
        colour = free.pop(kind, None)
        if colour is None:
            colour = _OTHERS[others % len(_OTHERS)]
            others += 1
        looks[label] = Look(colour, _SYMBOLS[place % len(_SYMBOLS)])
    return looks


def experiment_dashes(experiments: Sequence[str]) -> dict[str, str]:
    """Return the dashes of every experiment of a file, solid for the first."""
    return {name: DASHES[place % len(DASHES)] for place, name in enumerate(experiments)}
