"""How each model and each experiment is drawn, in the printed figures and in reports.

The colour says which model it is, in every figure the same; so does the style (exact solver:
squares with error bars, foundation: solid line with a band, Persson: dashed, all others a
pattern of dashes of their own, shorter ones for variants). Each model says its own
(:class:`roughbench.models.style.Style`); one that does not, or is not known here, gets a spare
one. In a panel with several experiments the shade says which: the first is drawn in the full
colour, the others the lighter the later they come in the sweep.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.models.registry import declared
from roughbench.models.style import Dashes, Style, style_of_text
from roughbench.results import ModelResult

_SPARE_COLOURS = ("#882255", "#332288", "#66A61E", "#AA4499", "#44AA99", "#6A3D1A", "#5B5BD6")
"""Of variants, and of models without a colour, in this order."""
_SPARE_DASHES: tuple[Dashes, ...] = (
    (5, 1.5, 1, 1.5),
    (1, 1),
    (5, 1.5, 1, 1.5, 1, 1.5),
    (2, 1),
)
_STRETCHES = (1.0, 0.5, 1.7)
"""How much longer the dashes of the first, second, third of a kind are."""
_LIGHTEST = 0.6
"""Share of white in the colour of the last experiment."""


@dataclass(frozen=True, slots=True)
class CurveStyle:
    """How the curves of one model are drawn.

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


def style_of(result: ModelResult) -> Style:
    """Return the style of a model: the one that its results carry, or its class says."""
    carried = style_of_text(result.attributes.get("style", ""))
    model = declared(result.kind) if carried is None else None
    return carried or (model.style if model else Style())


def curve_styles(results: Iterable[tuple[str, ModelResult]]) -> dict[str, CurveStyle]:
    """Return a style for every label of results; equal labels are drawn alike.

    Parameters
    ----------
    results : iterable of (str, ModelResult)
        As :meth:`roughbench.results.Results.models` yields them; of several files one after
        the other.
    """
    first: dict[str, ModelResult] = {}
    for _, result in results:
        first.setdefault(result.label, result)
    return styles_of({label: (one.kind, style_of(one)) for label, one in first.items()})


def styles_of(models: dict[str, tuple[str, Style]]) -> dict[str, CurveStyle]:
    """Return how models are drawn together.

    Parameters
    ----------
    models : dict of str to (str, Style)
        Label → kind and its style.

    Examples
    --------
    >>> style = Style("#123456", ((4, 2),))
    >>> drawn = styles_of({"a": ("k", style), "b": ("k", style)})
    >>> drawn["a"].colour, drawn["b"].colour
    ('#123456', '#882255')
    """
    count: dict[str, int] = {}
    taken: set[str] = set()
    spare = 0
    chosen = {}
    for label, (kind, style) in models.items():
        group = kind if style.dashes or style.markers else ""
        number = count.get(group, 0)
        count[group] = number + 1
        colour = style.colour
        if not colour or colour in taken:
            colour = _SPARE_COLOURS[spare % len(_SPARE_COLOURS)]
            spare += 1
        taken.add(style.colour)
        marker = style.markers[number % len(style.markers)] if style.markers else ""
        dashes = () if marker else _dashes(style.dashes or _SPARE_DASHES, number)
        chosen[label] = CurveStyle(marker, dashes, colour, style.order)
    return chosen


def curve_style(style: Style) -> CurveStyle:
    """Return how the first model of a style is drawn."""
    return styles_of({"": ("", style)})[""]


def _dashes(patterns: tuple[Dashes, ...], number: int) -> Dashes:
    if len(patterns) > 1:
        return patterns[number % len(patterns)]
    stretch = _STRETCHES[number % len(_STRETCHES)]
    return tuple(stretch * dash for dash in patterns[0])


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
