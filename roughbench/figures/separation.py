"""Fig. 3(b) of the paper: the mean separation ū/h_rms against the pressure p/E*.

Drawn as Fig. 3(a). A triangle on the lower edge marks the lowest pressure at which all
realizations are in full contact, where ū = 0 has no place on a logarithmic axis; what
lies below :data:`FLOOR` is cut off. The inset shows the same curves on a linear axis,
where ū = u0 ln(p0/p) is a straight line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughbench.figures.curves import Curve, curve_of
from roughbench.figures.labels import height_remark, unconverged_remarks
from roughbench.figures.panel import draw_panel, legend_handles, limit_to_curves
from roughbench.figures.style import footnote, legend_above, new_figure
from roughbench.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FLOOR = 1e-4
"""Separations below this, in h_rms, are a hundred times thinner than any drawn gap."""
_INSET = (0.115, 0.085, 0.44, 0.42)
"""Left, bottom, width and height of the inset, as fractions of the panel."""


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    gives = any("separation" in result for _, result in results.models())
    return None if gives else "a model with a separation"


def draw(results: Results) -> Figure:
    """Return the figure."""
    figure, (axes,) = new_figure(1, 3.0)
    panel(axes, results)
    legend_above(figure, legend_handles(results, list(results), "separation"))
    footnote(figure, [height_remark(results), *unconverged_remarks(results)])
    return figure


def panel(axes: Axes, results: Results) -> None:
    """Draw the curves and the inset, without a legend."""
    draw_panel(axes, results, list(results), "separation")
    axes.set_ylabel(r"separation $\bar u/h_\mathrm{rms}$")
    limit_to_curves(axes, results, "separation", lowest=FLOOR)
    room = min(_room(axes, curve_of(result, "separation")) for _, result in results.models())
    left, bottom, width, height = _INSET
    width = min(width, room - 0.03 - left)
    if width > 0.2:
        inset = axes.inset_axes((left, bottom, width, height))
        draw_panel(inset, results, list(results), "separation", is_inset=True)


def _room(axes: Axes, curve: Curve) -> float:
    """Return where a curve first comes down to the inset, as a fraction of the width."""
    seen = np.isfinite(curve.value) & (curve.value > 0.0)
    if not seen.any():
        return 1.0
    to_fractions = axes.transData + axes.transAxes.inverted()
    x, y = to_fractions.transform(np.stack([curve.pressure, curve.value], axis=1)[seen]).T
    way = np.linspace(x[0], x[-1], 1000)
    low = np.interp(way, x, y) < _INSET[1] + _INSET[3] + 0.03
    return float(way[np.argmax(low)]) if low.any() else 1.0
