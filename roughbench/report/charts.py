"""Charts of the page: curves with their bands and axes, as data for the page's script.

Nothing here knows what draws them: the page's own script makes plotly's traces of them, and
connects them with the switches of models and experiments by the entries of their ``meta``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.report.text import from_notation, plotly_text

FloatArray = NDArray[np.float64]
Ranges = dict[str, list[float] | None]
"""What the ordinate shows at first, by its kind, ``log`` or ``linear``; None: everything."""

_FLOOR = 1e-3
"""Bands do not fall below this part of their curve: a logarithmic axis has no zero."""
_DIGITS, _FEW_DIGITS = 7, 4
"""More than a picture can show; of curves without marked points, hundreds of numbers each."""


@dataclass(frozen=True, slots=True, eq=False)
class ChartSeries:
    """One curve with its band.

    Attributes
    ----------
    name : str
        In plotly's subset of HTML.
    meta : dict
        By which the page's script finds it.
    x, y, lower, upper : ndarray of float64, shape (P,)
        What is not finite is left out.
    colour, dash : str
        ``#RRGGBB``, and plotly's name of the dashes.
    symbol : str
        plotly's name of the marker; empty: the points are not marked.
    hover : list of str
        What pointing at each point shows; empty: its numbers.
    """

    name: str
    meta: dict[str, str]
    x: FloatArray
    y: FloatArray
    lower: FloatArray
    upper: FloatArray
    colour: str
    dash: str
    symbol: str = ""
    hover: Sequence[str] = ()

    def data(self) -> dict[str, Any]:
        """Return the curve for the page's script; without a band, if there is none."""
        digits = _DIGITS if self.symbol else _FEW_DIGITS
        data: dict[str, Any] = {
            "name": self.name,
            "meta": self.meta,
            "colour": self.colour,
            "dash": self.dash,
            "x": _numbers(self.x, digits),
            "y": _numbers(self.y, digits),
        }
        if self.symbol:
            data["symbol"] = self.symbol
        if self.hover:
            data["text"] = list(self.hover)
        has_band = np.isfinite(self.y) & np.isfinite(self.lower) & np.isfinite(self.upper)
        if has_band.any():
            lower = np.maximum(self.lower, _FLOOR * np.abs(self.y))
            data["lower"] = _numbers(np.where(has_band, lower, math.nan), digits)
            data["upper"] = _numbers(np.where(has_band, self.upper, math.nan), digits)
        return data


@dataclass(frozen=True, slots=True, eq=False)
class ReportChart:
    """One chart of the page, told from the others of its file by its key.

    Title and axes have formulas in plain text, and the label stands in place of the picture.
    Axes are logarithmic at first or not, x before y; the models in ``not_given`` have no such
    curve. A legend stands at the ``top`` or the ``bottom`` of charts without switches.
    """

    key: str
    title: str
    label: str
    x_axis: str
    y_axis: str
    series: Sequence[ChartSeries]
    ranges: Ranges
    is_log: tuple[bool, bool] = (True, True)
    not_given: Sequence[str] = ()
    legend: str = ""

    @property
    def data(self) -> dict[str, Any]:
        """What the page's script draws, as JSON knows it."""
        x, y = (
            {"title": plotly_text(from_notation(title)), "type": "log" if log else "linear"}
            for title, log in zip((self.x_axis, self.y_axis), self.is_log, strict=True)
        )
        curves = [series.data() for series in self.series]
        data = {"curves": curves, "x": x, "y": y, "ranges": self.ranges}
        return data | ({"legend": self.legend} if self.legend else {})


def _numbers(values: FloatArray, digits: int) -> list[float | None]:
    """Return numbers with so many significant digits; None for what is none."""
    return [float(f"{v:.{digits}g}") if math.isfinite(v) else None for v in values.tolist()]
