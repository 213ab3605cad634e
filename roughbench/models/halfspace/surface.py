"""The heights as the loops take them: dimensionless, counted from the highest point."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.loops import TILE, gap
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid, tile_height


class ScaledHeights:
    """Heights in their rms value, from the highest point downwards; none is copied.

    Parameters
    ----------
    heights : ndarray, shape (n, m)
    team : ThreadTeam
    flat : float
        What flat heights have instead of an rms value.

    Counted from there, h, α and u are all as small as the displacements are where little
    touches, and their difference keeps its digits.

    Attributes
    ----------
    mean, rms : float
        Of the heights, in their unit.
    depth : float
        −⟨h⟩, dimensionless.
    surface : tuple
        Heights, scale and datum for the loops: h = scale·(heights − datum).
    """

    def __init__(
        self, heights: NDArray[np.floating], team: ThreadTeam, flat: float = 0.0
    ) -> None:
        self.mean = float(heights.mean(dtype=np.float64))
        self.rms = _rms(heights, self.mean) or flat
        self.scale = 1.0 / self.rms if self.rms > 0 else 0.0
        self._top = float(heights.max())
        self.surface = heights, self.scale, self._top
        self.depth = (self._top - self.mean) * self.scale
        self._team = team

    @cached_property
    def spring_modulus(self) -> float:
        """Modulus of springs to start from: ½E*q with a mean wavevector q, in E*/Δ.

        The geometric mean of the rms slope over the rms height and of the longest wave.
        Only a start; between neighbouring rows no slope is taken.
        """
        longest = 2.0 * math.pi / max(self.surface[0].shape)
        total = 0.0
        for row in self.surface[0]:
            total += float((np.diff(row.astype(np.float64)) ** 2).sum())
        slope = math.sqrt(2.0 * total / self.surface[0].size) * self.scale
        return 0.5 * math.sqrt(max(slope, longest) * longest)

    def on(self, points: WorkingSet) -> NDArray[np.float64]:
        """h on a working set; −inf beyond the grid."""
        heights, scale, top = self.surface
        n, m = heights.shape
        tops, lefts = points.corners
        rows = tops[:, None] + np.arange(points.height)
        columns = lefts[:, None] + np.arange(TILE)
        values = heights[
            np.minimum(rows, n - 1)[:, :, None], np.minimum(columns, m - 1)[:, None, :]
        ].astype(np.float64)
        values -= top
        values *= scale
        values[(rows >= n)[:, :, None] | (columns >= m)[:, None, :]] = -np.inf
        return values.ravel()

    @cached_property
    def tile_tops(self) -> NDArray[np.float64]:
        """Largest h of each tile."""
        heights, scale, top = self.surface
        tops = np.empty(tile_grid(heights.shape))
        self._team.run(
            gap.tile_tops,
            self._team.even(tops.shape[0]),
            *(tile_height(heights.shape), heights, tops),
        )
        return (tops - top) * scale


def _rms(heights: NDArray[np.floating], mean: float) -> float:
    """Rms height in float64, row by row: no second array of the size of the heights."""
    total = 0.0
    for row in heights:
        deviation = row.astype(np.float64) - mean
        total += float((deviation * deviation).sum())
    return math.sqrt(total / heights.size)
