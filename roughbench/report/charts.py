"""Charts for plotly: data and axes as JSON, in the look of the page.

The page's own script draws them and connects them with the switches of models and
experiments; it knows each trace by the entries of its ``meta``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.report.looks import Look
from roughbench.report.markup import escape
from roughbench.report.sources import Source
from roughbench.results import ModelResult

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

FloatArray = NDArray[np.float64]

_FLOOR = 1e-3
"""Bands do not fall below this part of their curve: a logarithmic axis has no zero."""
_FONT = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"
_INK = "#222222"
_GRID = "#e4e4e4"


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
        JSON for the page's script: data, layout, ranges of the axes.
    has_axes : bool
        Whether its axes may be logarithmic.
    """

    key: str
    title: str
    label: str
    content: str
    has_axes: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One curve with its band.

    Attributes
    ----------
    x, y, lower, upper : ndarray of float64, shape (P,)
        What is not finite is left out.
    words : list of str
        What hovering over each point shows.
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


def line_traces(line: Line, look: Look, dash: str) -> list[dict[str, Any]]:
    """Return the traces of a curve: its band, which may be empty, and the curve over it."""
    known = np.isfinite(line.y)
    y = np.where(known, line.y, math.nan)
    band = {
        **_band(line, known),
        "type": "scatter",
        "mode": "lines",
        "fill": "toself",
        "fillcolor": _transparent(look.colour),
        "line": {"width": 0, "color": look.colour},
        "hoverinfo": "skip",
        "showlegend": False,
        "name": line.name,
        "meta": line.meta | {"role": "band"},
    }
    curve = {
        "type": "scatter",
        "mode": "lines+markers",
        "x": _numbers(line.x),
        "y": _numbers(y),
        "text": line.words,
        "hovertemplate": f"<b>{line.name}</b><br>%{{text}}<extra></extra>",
        "line": {"width": 1.6, "color": look.colour, "dash": dash},
        "marker": {
            "symbol": look.symbol,
            "size": 6,
            "color": look.colour,
            "line": {"width": 1.2 if look.symbol.endswith("open") else 0, "color": look.colour},
        },
        "connectgaps": False,
        "name": line.name,
        "meta": line.meta | {"role": "curve"},
    }
    return [band, curve]


def _band(line: Line, known: NDArray[np.bool_]) -> dict[str, list[float | None]]:
    """Return the outlines of the band: one polygon for every unbroken stretch."""
    has = known & np.isfinite(line.lower) & np.isfinite(line.upper)
    lower = np.maximum(line.lower, _FLOOR * np.abs(np.where(known, line.y, 1.0)))
    x: list[float | None] = []
    y: list[float | None] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], has, [False]]).astype(int)))
    for start, end in edges.reshape(-1, 2):
        if end - start > 1:
            there = line.x[start:end]
            x += [*_numbers(there), *_numbers(there[::-1]), None]
            y += [*_numbers(line.upper[start:end]), *_numbers(lower[start:end][::-1]), None]
    return {"x": x[:-1], "y": y[:-1]}


def curve_name(source: Source, experiment: str, result: ModelResult) -> str:
    """Return how a curve is called, in plotly's subset of HTML."""
    name = escape(result.label)
    return name if len(source.results) == 1 else f"{name}, {source.experiment(experiment)}"


def figure_of(
    traces: Sequence[dict[str, Any]],
    x_axis: str,
    y_axis: str,
    *,
    is_log: tuple[bool, bool] = (True, True),
) -> Figure:
    """Return a figure in the look of the page, checked by plotly.

    Parameters
    ----------
    traces : sequence of dict
        For plotly.
    x_axis, y_axis : str
        Titles of the axes.
    is_log : (bool, bool)
        Which axes are logarithmic at first.
    """
    import plotly.graph_objects as go

    axis = {
        "showline": True,
        "linecolor": _INK,
        "linewidth": 1,
        "mirror": True,
        "ticks": "inside",
        "ticklen": 5,
        "tickcolor": _INK,
        "gridcolor": _GRID,
        "zeroline": False,
        "exponentformat": "power",
        "showexponent": "all",
        "minor": {"ticks": "inside", "ticklen": 3, "tickcolor": _INK},
        "automargin": True,
    }
    layout = {
        "template": "none",
        "font": {"family": _FONT, "size": 12, "color": _INK},
        "margin": {"l": 8, "r": 12, "t": 10, "b": 8},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "showlegend": False,
        "hovermode": "closest",
        "hoverlabel": {"bgcolor": "white", "font": {"color": _INK, "size": 12}},
        "dragmode": "zoom",
        "xaxis": axis | {"title": {"text": x_axis}, "type": _type(is_log[0]), "nticks": 6},
        "yaxis": axis | {"title": {"text": y_axis}, "type": _type(is_log[1]), "nticks": 8},
    }
    return go.Figure(data=list(traces), layout=layout)


def _type(is_log: bool) -> str:  # noqa: FBT001
    return "log" if is_log else "linear"


def content(figure: Figure, ranges: dict[str, list[float] | None] | None = None) -> str:
    """Return a figure as JSON that may stand in a script element."""
    drawn = json.loads(figure.to_json(engine="json"))
    drawn["ranges"] = ranges or {"log": None, "linear": None}
    text = json.dumps(drawn, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _numbers(values: FloatArray) -> list[float | None]:
    """Return numbers with the digits that a picture can show; None for what is none."""
    return [float(f"{v:.7g}") if math.isfinite(v) else None for v in values.tolist()]


def _transparent(colour: str) -> str:
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.18)"
