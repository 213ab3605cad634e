"""Lists of points x, y, height in any order, put on the regular grid that they form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.scans.headers import Header
from roughbench.scans.image import Image
from roughbench.scans.lengths import in_metres

FloatArray = NDArray[np.float64]

_OFF_GRID = 0.05
"""Largest distance of a point from its node, in steps of the grid."""
_ROUNDING = 1e-9
"""Coordinates closer than this share of their range are one."""
_MOST_GUESSES = 16
_FEWEST_THERE = 0.25
"""Share of the nodes that must be there for a list to be a grid with holes."""


@dataclass(frozen=True, slots=True)
class _GridAxis:
    """Equal steps along an axis."""

    first: float
    step: float
    n_nodes: int
    off: float
    """Largest distance from a node, in steps."""

    def places(self, x: FloatArray) -> NDArray[np.int64]:
        return np.rint((x - self.first) / self.step).astype(np.int64)


def on_grid(values: FloatArray, header: Header, unit: float | None, name: str) -> Image:
    """Return points on a regular grid as an image; rows with rising y, columns with rising x.

    Nodes without a point are missing. The size is the number of nodes times their distance.

    Parameters
    ----------
    values : ndarray of float64, shape (n, 3)
        x, y and height of each point.
    header : Header
        For the unit of x and y.
    unit : float or None
        Metres per unit of the heights.
    name : str
        Of the file, for messages.

    Raises
    ------
    SurfaceError
        If they form no regular grid, with the numbers that show it.
    """
    if values.shape[1] != 3:
        raise SurfaceError(
            f"{name}: a list of points has three columns, x, y and height, got "
            f"{values.shape[1]}; leave out the others"
        )
    n_points = values.shape[0]
    if not np.isfinite(values[:, :2]).all():
        bad = int(np.argmin(np.isfinite(values[:, :2]).all(axis=1)))
        raise SurfaceError(
            f"{name}: point {bad + 1} of {n_points} has no coordinates; only the height of a "
            "point may be missing"
        )
    x_axis, y_axis = (_axis(values[:, i], n_points, "xy"[i], name) for i in (0, 1))
    n_nodes = x_axis.n_nodes * y_axis.n_nodes
    grid = f"a grid of {y_axis.n_nodes} by {x_axis.n_nodes} nodes (y, x)"
    steps = f"{y_axis.step:.6g} and {x_axis.step:.6g} apart"
    if n_points < _FEWEST_THERE * n_nodes:
        raise SurfaceError(
            f"{name}: no regular grid: its {n_points} points would fill "
            f"{n_points / n_nodes:.2%} of {grid} {steps}; interpolate them on one first"
        )
    nodes = y_axis.places(values[:, 1]) * x_axis.n_nodes + x_axis.places(values[:, 0])
    counts = np.bincount(nodes, minlength=n_nodes)
    if counts.max() > 1:
        twice = int(np.argmax(counts))
        row, column = divmod(twice, x_axis.n_nodes)
        raise SurfaceError(
            f"{name}: {counts[twice]} points at one place, x = "
            f"{x_axis.first + column * x_axis.step:.9g}, y = "
            f"{y_axis.first + row * y_axis.step:.9g}: {n_points} points on {grid}; leave one"
        )
    heights = np.full(n_nodes, np.nan)
    heights[nodes] = values[:, 2]
    notes = []
    off = max(x_axis.off, y_axis.off)
    if off > 1e-2:
        notes.append(f"points are up to {off:.1%} of a step off their nodes")
    lateral = [in_metres(text) for text in header.lateral]
    size = None
    if lateral[0] is not None and lateral[1] is not None:
        size = (
            y_axis.step * y_axis.n_nodes * lateral[1],
            x_axis.step * x_axis.n_nodes * lateral[0],
        )
    return Image(
        heights.reshape(y_axis.n_nodes, x_axis.n_nodes),
        unit,
        size,
        header.channel,
        tuple(notes),
        aspect=y_axis.step / x_axis.step,
    )


def _axis(x: FloatArray, n_points: int, letter: str, name: str) -> _GridAxis:
    """Find the step of coordinates: the smallest whose multiples all of them are."""
    places = np.unique(x)
    span = float(places[-1] - places[0])
    gaps = np.diff(places)
    gaps = np.sort(gaps[gaps > _ROUNDING * span])
    if not gaps.size:
        raise SurfaceError(
            f"{name}: all {n_points} points have {letter} = {places[0]:g}: a line, no map"
        )
    # Coordinates of one row may differ a little: a step is a gap well above those before it.
    jumps = gaps[1:] / gaps[:-1]
    largest = 1 + np.argsort(jumps)[::-1][:_MOST_GUESSES]
    best: _GridAxis | None = None
    for guess in (gaps[0], *gaps[np.sort(largest)]):
        # The guess is one rounded gap; all of them together say how many steps there are.
        typical = np.median(gaps[np.rint(gaps / guess) == 1.0])
        n_steps = int(np.rint(gaps / typical).sum())
        if n_steps > n_points:
            continue
        step = span / n_steps
        steps = (places - places[0]) / step
        axis = _GridAxis(
            float(places[0]), step, n_steps + 1, float(np.abs(steps - np.rint(steps)).max())
        )
        if axis.off <= _OFF_GRID:
            return axis
        if best is None or axis.off < best.off:
            best = axis
    off = (
        f"they are up to {best.off:.0%} of a step of {best.step:.6g} off"
        if best
        else (f"their smallest distance is {gaps[0]:.3g} of {span:.6g}")
    )
    raise SurfaceError(
        f"{name}: no regular grid: the {places.size} values of {letter} have no common step, "
        f"{off}; interpolate the points on a grid first"
    )
