"""Fig. 3(b) of the paper: the mean separation ū/h_rms against the pressure p/E*.

The inset shows the same curves on a linear axis, where ū = u0 ln(p0/p) is a straight line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures.curves import DrawnCurve, curves_of
from roughbench.figures.panel import draw_panel
from roughbench.figures.quantity import QuantityFigure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_INSET = (0.115, 0.085, 0.44, 0.42)
"""Left, bottom, width and height of the inset, as fractions of the panel."""
_MARGIN = 0.05
"""Of the inset below zero; what models without a bound say of negative gaps is cut off."""


class SeparationFigure(QuantityFigure):
    """The figure of the mean separation."""

    def panel(self, axes: Axes, results: Results) -> None:
        """Draw the curves and the inset, without a legend."""
        QuantityFigure.panel(self, axes, results)
        room = min(_room(axes, curve) for _, _, curve in curves_of(results, self.name))
        left, bottom, width, height = _INSET
        width = min(width, room - 0.03 - left)
        if width > 0.2:
            inset = axes.inset_axes((left, bottom, width, height))
            draw_panel(inset, results, list(results), self.name, is_inset=True)
            low, high = inset.get_ylim()
            inset.set_ylim(max(low, -_MARGIN * high), high)


def _room(axes: Axes, curve: DrawnCurve) -> float:
    """Return where a curve first comes down to the inset, as a fraction of the width."""
    seen = np.isfinite(curve.value) & (curve.value > 0.0)
    if not seen.any():
        return 1.0
    to_fractions = axes.transData + axes.transAxes.inverted()
    x, y = to_fractions.transform(np.stack([curve.pressure, curve.value], axis=1)[seen]).T
    way = np.linspace(x[0], x[-1], 1000)
    low = np.interp(way, x, y) < _INSET[1] + _INSET[3] + 0.03
    return float(way[np.argmax(low)]) if low.any() else 1.0
