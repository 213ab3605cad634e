"""Who is who in the charts: a colour and a symbol for each model, dashes per experiment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.figures.looks import model_colours
from roughbench.report.sources import Source

_SYMBOLS = {
    "square-open": '<path d="M8.5 2.5H15.5V9.5H8.5Z" fill="white" stroke="{0}"/>',
    "circle": '<circle cx="12" cy="6" r="3.6" fill="{0}"/>',
    "triangle-up": '<path d="M12 1.6 16.4 9.6H7.6Z" fill="{0}"/>',
    "diamond": '<path d="M12 1.2 16.8 6 12 10.8 7.2 6Z" fill="{0}"/>',
    "triangle-down": '<path d="M12 10.4 16.4 2.4H7.6Z" fill="{0}"/>',
    "x": '<path d="M9 3 15 9M15 3 9 9" stroke="{0}" stroke-width="2.4"/>',
    "cross": '<path d="M12 1.8V10.2M7.8 6H16.2" stroke="{0}" stroke-width="2.8"/>',
    "pentagon": '<path d="M12 1.5 16.4 4.8 14.7 10H9.3L7.6 4.8Z" fill="{0}"/>',
    "star-triangle-up": '<path d="M12 .8 13.4 4.6 17 8.8 12 7.8 7 8.8 10.6 4.6Z" fill="{0}"/>',
    "hourglass": '<path d="M8.2 2H15.8L8.2 10H15.8Z" fill="{0}"/>',
    "triangle-left": '<path d="M7.6 6 15.6 1.6V10.4Z" fill="{0}"/>',
    "triangle-right": '<path d="M16.4 6 8.4 1.6V10.4Z" fill="{0}"/>',
}
"""plotly's name of a marker → how the legend draws it, in a box of 24 by 12."""
_DASHES = {
    "solid": "",
    "dash": "7 4",
    "dot": "2 3",
    "dashdot": "7 3 2 3",
    "longdash": "11 4",
    "longdashdot": "11 3 2 3",
}
"""plotly's name of a dash → the same for the legend."""


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
    colours = model_colours(kinds)
    symbols = list(_SYMBOLS)
    return {
        label: Look(colours[label], symbols[place % len(symbols)])
        for place, label in enumerate(kinds)
    }


def experiment_dashes(experiments: Sequence[str]) -> dict[str, str]:
    """Return the dashes of every experiment of a file, solid for the first."""
    dashes = list(_DASHES)
    return {name: dashes[place % len(dashes)] for place, name in enumerate(experiments)}


def model_sample(look: Look) -> str:
    """Return a piece of a model's curve for the legend, as SVG."""
    shape = _SYMBOLS[look.symbol].format(look.colour)
    line = f'<path d="M0 6H24" stroke="{look.colour}" stroke-width="1.6"/>'
    return _sample(24, line + shape)


def dash_sample(dash: str) -> str:
    """Return a piece of a line with the dashes of an experiment for the legend, as SVG."""
    pattern = f' stroke-dasharray="{_DASHES[dash]}"' if _DASHES[dash] else ""
    return _sample(34, f'<path d="M0 6H34" stroke="#222" stroke-width="1.8"{pattern}/>')


def _sample(width: int, drawing: str) -> str:
    return (
        f'<svg class="sample" viewBox="0 0 {width} 12" width="{width}" height="12" '
        f'aria-hidden="true">{drawing}</svg>'
    )
