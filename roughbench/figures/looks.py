"""How each contender and each experiment looks, in the printed figures and in reports.

The colour says which contender it is, in every figure the same (:func:`model_colours`); so
does the style (exact solver: squares with error bars, foundation: solid line with a band,
Persson: dashed, all others a pattern of dashes of their own, shorter ones for variants). In a
panel with several experiments the shade says which: the first is drawn in the full colour,
the others the lighter the later they come in the sweep.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.figures.style import COLOURS
from roughbench.results import Results

Dashes = tuple[float, ...]
_KIND_COLOURS = {
    "bem": "#000000",
    "foundation": COLOURS[0],
    "persson": COLOURS[1],
    "line": COLOURS[2],
    "winkler": COLOURS[3],
    "gw": COLOURS[4],
    "gw_elliptic": COLOURS[5],
    "bgt": "#7F7F7F",
    "hertz_top": "#8C6D31",
}
"""Colour of the first contender of each kind."""
_MORE_COLOURS = ("#882255", "#332288", "#66A61E", "#AA4499", "#44AA99", "#6A3D1A", "#5B5BD6")
"""Of variants, and of kinds that are not in the table, in this order."""
_MARKERS = ("s", "o", "D", "^", "v")
_DASHES: dict[str, tuple[Dashes, ...]] = {
    "foundation": ((), (9, 1.5), (6, 1, 1, 1)),
    "persson": ((3, 3), (1.5, 1.5), (6, 3)),
}
_OTHERS: tuple[Dashes, ...] = ((5, 1.5, 1, 1.5), (1, 1), (5, 1.5, 1, 1.5, 1, 1.5), (2, 1))
_KIND_DASHES: dict[str, Dashes] = {
    "line": (9, 2, 1.5, 2),
    "winkler": (5, 1.5, 1, 1.5),
    "gw": (1.2, 1.2),
    "gw_elliptic": (5, 1.5, 1, 1.5, 1, 1.5),
    "bgt": (12, 3),
    "hertz_top": (2.5, 1),
}
"""Dashes of contenders that are drawn as lines without a band in mind."""
_VARIANTS = (1.0, 0.5, 1.7)
"""How much longer the dashes of the first, second, third of a kind are."""
_ORDER = {"bem": 4, "foundation": 3}
_LIGHTEST = 0.6
"""Share of white in the colour of the last experiment."""


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
        ``#RRGGBB``.
    order : int
        Higher is drawn over lower.
    """

    marker: str
    dashes: Dashes
    colour: str
    order: int


def model_colours(kinds: Mapping[str, str]) -> dict[str, str]:
    """Return a colour for every contender: the only table that figures and reports have.

    Parameters
    ----------
    kinds : mapping of str to str
        Label to kind, in the order of the spec.

    Returns
    -------
    dict of str to str
        Label to ``#RRGGBB``.

    Examples
    --------
    >>> model_colours({"bem": "bem", "persson": "persson", "fitted": "persson"})
    {'bem': '#000000', 'persson': '#D55E00', 'fitted': '#882255'}
    """
    free = dict(_KIND_COLOURS)
    more = 0
    chosen = {}
    for label, kind in kinds.items():
        if kind in free:
            chosen[label] = free.pop(kind)
        else:
            chosen[label] = _MORE_COLOURS[more % len(_MORE_COLOURS)]
            more += 1
    return chosen


FOUNDATION = Look("", (), _KIND_COLOURS["foundation"], _ORDER["foundation"])
PERSSON = Look("", _DASHES["persson"][0], _KIND_COLOURS["persson"], 1)
"""Of both where they stand for more than one of their curves: springs, a theory of fields."""


def looks(results: Results) -> dict[str, Look]:
    """Return a look for every label in the results; equal labels look alike."""
    kinds = {result.label: result.kind for _, result in results.models()}
    colours = model_colours(kinds)
    count: dict[str, int] = {}
    chosen = {}
    for label, kind in kinds.items():
        known = kind == "bem" or kind in _DASHES or kind in _KIND_DASHES
        group = kind if known else "others"
        number = count.get(group, 0)
        count[group] = number + 1
        marker = ""
        dashes: Dashes = ()
        if group == "bem":
            marker = _MARKERS[number % len(_MARKERS)]
        elif group in _KIND_DASHES:
            stretch = _VARIANTS[number % len(_VARIANTS)]
            dashes = tuple(stretch * dash for dash in _KIND_DASHES[group])
        else:
            patterns = _DASHES.get(group, _OTHERS)
            dashes = patterns[number % len(patterns)]
        chosen[label] = Look(marker, dashes, colours[label], _ORDER.get(group, 2))
    return chosen


def experiment_shades(experiments: Sequence[str]) -> dict[str, float]:
    """Return the share of white in the colours of each experiment, 0 for the first.

    Examples
    --------
    >>> experiment_shades(["main"]), experiment_shades(["a", "b"])
    ({'main': 0.0}, {'a': 0.0, 'b': 0.6})
    """
    steps = np.linspace(0.0, _LIGHTEST, len(experiments)) if len(experiments) > 1 else [0.0]
    return {name: float(step) for name, step in zip(experiments, steps, strict=True)}


def lighter(colour: str, share: float) -> str:
    """Return a colour mixed with white.

    Examples
    --------
    >>> lighter("#D55E00", 0.0), lighter("#000000", 0.5)
    ('#D55E00', '#808080')
    """
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(part + share * (255 - part)):02X}" for part in parts)
