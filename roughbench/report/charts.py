"""Charts of the page: curves with their bands and axes, as JSON.

Nothing here knows what draws them: the page's own script makes plotly's traces of them, and
connects them with the switches of models and experiments by the entries of their ``meta``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.report.looks import Look
from roughbench.report.markup import escape
from roughbench.report.sources import Source
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]
Ranges = dict[str, list[float] | None]

_FLOOR = 1e-3
"""Bands do not fall below this part of their curve: a logarithmic axis has no zero."""
_DIGITS, _FEW_DIGITS = 7, 4
"""More than a picture can show; of curves without marked points, hundreds of numbers each."""


@dataclass(frozen=True, slots=True)
class Chart:
    """One chart of the page.

    Attributes
    ----------
    key : str
        Tells it from the others of its file.
    title : str
        HTML.
    label : str
        Plain text in place of the picture.
    content : str
        JSON for the page's script: curves, axes, ranges of the ordinate.
    """

    key: str
    title: str
    label: str
    content: str


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One curve with its band.

    Attributes
    ----------
    x, y, lower, upper : ndarray of float64, shape (P,)
        What is not finite is left out.
    words : list of str
        What hovering over each point shows; empty: its numbers.
    name : str
        In plotly's subset of HTML.
    meta : dict
        By which the page's script finds it.
    """

    x: FloatArray
    y: FloatArray
    lower: FloatArray
    upper: FloatArray
    words: list[str]
    name: str
    meta: dict[str, Any]


def curve(line: Line, look: Look, dash: str, *, has_symbols: bool = True) -> dict[str, Any]:
    """Return a curve for the page's script; without a band, if there is none.

    Parameters
    ----------
    line : Line
    look : Look
    dash : str
        plotly's name of the dashes.
    has_symbols : bool
        Whether the points are marked.
    """
    known = np.isfinite(line.y)
    y = np.where(known, line.y, math.nan)
    digits = _DIGITS if has_symbols else _FEW_DIGITS
    drawn: dict[str, Any] = {
        "name": line.name,
        "meta": line.meta,
        "colour": look.colour,
        "dash": dash,
        "x": numbers(line.x, digits),
        "y": numbers(y, digits),
    }
    if has_symbols:
        drawn["symbol"] = look.symbol
    if line.words:
        drawn["text"] = line.words
    has_band = known & np.isfinite(line.lower) & np.isfinite(line.upper)
    if has_band.any():
        floor = _FLOOR * np.abs(np.where(known, line.y, 1.0))
        lower = np.where(has_band, np.maximum(line.lower, floor), math.nan)
        drawn["lower"] = numbers(lower, digits)
        drawn["upper"] = numbers(np.where(has_band, line.upper, math.nan), digits)
    return drawn


def curve_name(source: Source, experiment: str, result: ModelResult) -> str:
    """Return how a curve is called, in plotly's subset of HTML."""
    name = escape(source.title(result.label))
    return name if len(source.results) == 1 else f"{name}, {source.experiment(experiment)}"


def content(
    curves: Sequence[dict[str, Any]],
    x_axis: str,
    y_axis: str,
    *,
    is_log: tuple[bool, bool] = (True, True),
    ranges: Ranges | None = None,
) -> str:
    """Return a chart as JSON that may stand in a script element.

    Parameters
    ----------
    curves : sequence of dict
        As :func:`curve` returns them.
    x_axis, y_axis : str
        Titles of the axes, in plotly's subset of HTML.
    is_log : (bool, bool)
        Which axes are logarithmic at first.
    ranges : dict, optional
        What the ordinate shows at first, by its kind; None: everything.
    """
    drawn = {
        "curves": list(curves),
        "x": {"title": x_axis, "type": _type(is_log[0])},
        "y": {"title": y_axis, "type": _type(is_log[1])},
        "ranges": ranges or {"log": None, "linear": None},
    }
    text = json.dumps(drawn, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _type(is_log: bool) -> str:  # noqa: FBT001
    return "log" if is_log else "linear"


def numbers(values: FloatArray, digits: int) -> list[float | None]:
    """Return numbers with so many significant digits; None for what is none."""
    return [float(f"{v:.{digits}g}") if math.isfinite(v) else None for v in values.tolist()]
