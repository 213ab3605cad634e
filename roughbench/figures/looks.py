"""How each contender and each experiment looks.

The style says which contender it is (exact solver: squares with error bars, foundation:
solid line with a band, Persson: dashed, all others a pattern of dashes of their own), the
colour which experiment; in a panel with a single experiment the colour tells the contenders
apart too. Variants of one of the others share its colour, with shorter dashes.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.figures.style import COLOURS
from roughbench.results import Results

Dashes = tuple[float, ...]
_MARKERS = ("s", "o", "D", "^", "v")
_FOUNDATION: tuple[Dashes, ...] = ((), (9, 1.5), (6, 1, 1, 1))
_PERSSON: tuple[Dashes, ...] = ((3, 3), (1.5, 1.5), (6, 3))
_OTHERS: tuple[Dashes, ...] = ((5, 1.5, 1, 1.5), (1, 1), (5, 1.5, 1, 1.5, 1, 1.5), (2, 1))
_KINDS: dict[str, tuple[Dashes, str]] = {
    "line": ((9, 2, 1.5, 2), COLOURS[2]),
    "winkler": ((5, 1.5, 1, 1.5), COLOURS[3]),
    "gw": ((1.2, 1.2), COLOURS[4]),
    "gw_elliptic": ((5, 1.5, 1, 1.5, 1, 1.5), COLOURS[5]),
    "bgt": ((12, 3), "0.55"),
    "hertz_top": ((2.5, 1), "#8C6D31"),
}
"""Dashes and colour of contenders that are drawn as lines without a band in mind."""
_VARIANTS = (1.0, 0.5, 1.7)
"""How much longer the dashes of the first, second, third of a kind are."""


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


def looks(results: Results) -> dict[str, Look]:
    """Return a look for every label in the results; equal labels look alike."""
    kinds = {result.label: result.kind for _, result in results.models()}
    count: dict[str, int] = {}
    chosen = {}
    other_colours = itertools.cycle((COLOURS[2], COLOURS[3], COLOURS[4], COLOURS[5]))
    for label, kind in kinds.items():
        known = kind in ("bem", "foundation", "persson") or kind in _KINDS
        group = kind if known else "others"
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
        elif group in _KINDS:
            dashes, colour = _KINDS[group]
            stretch = _VARIANTS[number % len(_VARIANTS)]
            chosen[label] = Look("", tuple(stretch * dash for dash in dashes), colour, 2)
        else:
            chosen[label] = Look("", _OTHERS[number % len(_OTHERS)], next(other_colours), 2)
    return chosen


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
