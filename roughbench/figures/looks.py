"""How each contender and each experiment looks.

The style says which contender it is (exact solver: squares with error bars, foundation:
solid line with a band, Persson: dashed), the colour which experiment; in a panel with
a single experiment the colour tells the contenders apart too.
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
