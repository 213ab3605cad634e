r"""Two-level preconditioner of S restricted to the points without contact.

The gap lives on islands, or around them, and S = \|q\|/2 couples points at a distance r as
1/r³: its inverse on a region of open points is near that of the whole plane with the waves
longer than the region cut off, 1/(\|q\|/2 + ε). That is split in two,

.. math:: \frac{1}{|q|/2 + ε} = \frac{1}{|q|/2 + c} + \left[\frac{1}{|q|/2 + ε} -
          \frac{1}{|q|/2 + c}\right] ,

of which the first is short-ranged, and applied by the 3 × 3 stencil of its values around
the origin, and the second smooth: it acts on the sums over cells of 4 × 4 points, by a
transform that has a sixteenth of the points. Both are positive.

At the edges of an open region its inverse is smaller than that of the plane: the gap goes to
zero there. So the whole is applied between weights ω = (k/9)^γ, k being the number of open
points among a point and its eight neighbours.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import DTypeLike

from roughbench.models.halfspace.kernel import HALF_SPACE, nearest_values
from roughbench.models.halfspace.loops.gap_form import CELL
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.transform import RealTransform

CUTOFF = 0.25
"""ε per contact fraction, in 1/Δ: the open regions are the wider the less touches."""

CROSSOVER = 0.6
"""c, in 1/Δ."""

EXPONENT = 0.2
"""γ of the weights."""


class GapPreconditioner:
    """Smooth part of the preconditioner on the cells, and stencil of the rest.

    Parameters
    ----------
    shape : (int, int)
        Grid.
    dtype : dtype
        float32 or float64.
    team : ThreadTeam

    Attributes
    ----------
    cells : ndarray, one value per cell
        Sums over the cells; after :meth:`spread` what they add to each of their points.
    weights : ndarray
        Stencil: centre, along rows, across rows, diagonal.
    by_count : ndarray, shape (10,)
        ω for each number of open points among nine.
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike, team: ThreadTeam) -> None:
        height = 1 if shape[0] == 1 else CELL
        grid = -(-shape[0] // height), -(-shape[1] // CELL)
        self._transform = RealTransform(grid, dtype, team.threads)
        self.cells = self._transform.real
        qy = 2 * math.pi * np.fft.fftfreq(grid[0]) / height
        qx = 2 * math.pi * np.fft.rfftfreq(grid[1]) / CELL
        self._half = (np.hypot(qy[:, None], qx) / 2).astype(self._transform.dtype)
        self._points = grid[0] * grid[1] * height * CELL
        open_points = np.maximum(np.arange(10), 1) / 9
        self.by_count = (open_points**EXPONENT).astype(self._transform.dtype)
        short = 1 / (HALF_SPACE.wavenumbers(shape) / 2 + CROSSOVER)
        self.weights = nearest_values(short).astype(self._transform.dtype)

    def open(self, contact_fraction: float) -> None:
        """Start at this contact fraction."""
        half, points = self._half, self._half.dtype.type(self._points)
        cutoff = half.dtype.type(max(CUTOFF * contact_fraction, 0.02))
        self._multiplier = (
            1 / (half + cutoff) - 1 / (half + half.dtype.type(CROSSOVER))
        ) / points

    def spread(self) -> None:
        """Replace the sums over cells by the smooth part of their response."""
        self._transform.forward()
        self._transform.spectral *= self._multiplier
        self._transform.backward()
