"""How a model is drawn, as it says it itself; without any drawing."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

Dashes = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Style:
    """How a model is drawn.

    Parameters
    ----------
    colour : str
        ``#RRGGBB`` of the first model of this kind; empty: one of the spare ones. Further
        models of the kind always get spare ones.
    dashes : tuple of tuples of float
        On, off, … in line widths; an empty pattern is a solid line. One pattern for each of
        several models of this kind; a single one is shortened or stretched for them. None at
        all: spare ones.
    markers : str
        Points with error bars instead of a line with a band: one of Matplotlib's markers for
        each of several models of this kind.
    order : int
        Higher is drawn over lower.
    """

    colour: str = ""
    dashes: tuple[Dashes, ...] = ()
    markers: str = ""
    order: int = 2

    def __post_init__(self) -> None:
        if self.colour and not re.fullmatch(r"#[0-9A-Fa-f]{6}", self.colour):
            raise ValueError(f"a colour must read #RRGGBB, got {self.colour!r}")
        if any(not dash > 0.0 for pattern in self.dashes for dash in pattern):
            raise ValueError(f"dashes must be positive, got {self.dashes}")
        if any(len(pattern) % 2 for pattern in self.dashes):
            raise ValueError(f"dashes come in pairs of on and off, got {self.dashes}")
        if set(self.markers) - set("soD^v<>ph*X"):
            raise ValueError(f"markers must be some of soD^v<>ph*X, got {self.markers!r}")

    def as_text(self) -> str:
        """Return it as JSON, for results of a model that may not be installed elsewhere."""
        return json.dumps([self.colour, self.dashes, self.markers, self.order])


def style_of_text(text: object) -> Style | None:
    """Return the style that :meth:`Style.as_text` wrote; None for anything else.

    Examples
    --------
    >>> style_of_text(Style("#112233", ((1.0, 2.0),)).as_text())
    Style(colour='#112233', dashes=((1.0, 2.0),), markers='', order=2)
    >>> style_of_text("red") is None
    True
    """
    try:
        colour, dashes, markers, order = json.loads(str(text))
        patterns = tuple(tuple(map(float, pattern)) for pattern in dashes)
        return Style(str(colour), patterns, str(markers), int(order))
    except (ValueError, TypeError, OverflowError):
        return None
