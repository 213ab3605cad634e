r"""G as a short-ranged kernel, summed over near points, and a smooth one on a coarse grid.

.. math:: 2/q = (2/q) \operatorname{erf}(qσ/2) + (2/q) \operatorname{erfc}(qσ/2)

The first part falls like erfc(r/σ)/(πr) in real space and is summed point by point within
3σ; the second is smooth on the scale of a tile, and taken by transforms of a grid as coarse
as the tiles (Hockney and Eastwood, *Computer Simulation Using Particles*, 1988, chapter 8).
The few thousand points that carry pressure at 10⁻⁵ E* then cost a twentieth of a transform
pair on 4096² points.

The sum is good to some 2·10⁻⁶ of the displacement: enough for the steps of a relaxation in
float32, whose first residual is exact, and not for an evaluation. Left out is the alternating
tail of G along the rows and columns of the grid, 0.044 (−1)ˣ/x², which comes of the sharp end
of its spectrum at the Nyquist wavevector.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.special import erf, erfc, i0

from roughbench.models.halfspace.direct import cost_of_transforms
from roughbench.models.halfspace.loops import TILE
from roughbench.models.halfspace.loops import split as loops
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet
from roughbench.transform import RealTransform

REACH = 56
"""Grid points within which the short-ranged part is summed, at least: 3σ."""

SIGMA = REACH / 3.0
"""G is cut off where erfc(3) = 2e-5 of it is left, and smooth to erfc(3.7) = 2e-7."""

_EDGE = REACH + 2 * TILE - 2
"""Largest offset between points of two tiles that have points within the reach."""

_TABLE_ROWS = 2 * _EDGE + 1

_BETA = 2.1 * loops.SPREAD
"""Of the Kaiser-Bessel window that spreads points: the coarse grid is then off by some 3e-8."""

NEAR_PRODUCTS, SPREAD_PRODUCTS, MESH_PRODUCTS = 0.5, 500.0, 100.0
"""Products of a direct sum that take as long as one of the near sum, spreading one point and
interpolating one."""

SMALLEST_GRID = 4 * REACH
"""Points per axis from which on no two images of a point are near the same one."""


class SplitOperator:
    """G on the tiles of one working set at a time, in float32.

    Parameters
    ----------
    shape : (int, int)
        Grid, at least ``SMALLEST_GRID`` points along each axis.
    team : ThreadTeam
    """

    def __init__(self, shape: tuple[int, int], team: ThreadTeam) -> None:
        self.shape = shape
        self.team = team
        n, m = (2 * next_fast_len(-(-side // (2 * TILE)), real=True) for side in shape)
        self._transform = RealTransform((n, m), np.float32, threads=1)
        self._mesh = tuple(_weights(*sides) for sides in zip(shape, (n, m), strict=True))
        self._multiplier = _coarse_kernel(shape, (n, m))
        self._table = _short_table()
        place = np.arange(TILE * TILE)
        self._points: WorkingSet | None = None
        self._pairs: tuple[NDArray[Any], ...] | None = None
        self._offsets = (place % TILE * _TABLE_ROWS + place // TILE) * TILE

    def open(self, points: WorkingSet, most: float = math.inf) -> bool:
        """Find which tiles of a working set are near each other.

        Returns False, and is not open, where a sum over them costs ``most`` or more.
        """
        self._points = self._pairs = None  # those of the set before
        n_tiles = self._n_pairs = points.tiles.size  # each is near itself, at least
        if self.cost(points.n_contact, n_tiles) >= most:
            return False
        blocks = self.team.even(n_tiles)
        start = np.zeros(n_tiles + 1, np.int64)
        none = np.empty(0, np.int32)
        wanted = points.tiling, self.shape, REACH, _TABLE_ROWS, start
        self._n_pairs = int(sum(self.team.run(loops.near_pairs, blocks, *wanted, none, none)))
        if self.cost(points.n_contact, n_tiles) >= most:
            return False
        np.cumsum(start, out=start)
        neighbour, shift = np.empty(self._n_pairs, np.int32), np.empty(self._n_pairs, np.int32)
        self.team.run(loops.near_pairs, blocks, *wanted, neighbour, shift)
        self._pairs = start, neighbour, shift
        self._blocks = blocks
        self._points = points
        return True

    def cost(self, n_sources: int, n_tiles: int) -> float:
        """Products of a direct sum that take as long as this one, on the set opened last."""
        products = NEAR_PRODUCTS * n_sources * self._n_pairs / max(n_tiles, 1)
        products += MESH_PRODUCTS * n_tiles
        transforms = cost_of_transforms(self._transform.real.shape)
        return transforms + products * TILE * TILE + SPREAD_PRODUCTS * n_sources

    def apply(
        self, sources: WorkingSet, x: NDArray[Any], targets: WorkingSet, u: NDArray[Any]
    ) -> None:
        """u = G x on the targets, for x on the sources: both the set that was opened."""
        if not (sources is self._points is targets):
            raise ValueError("another working set is open")
        loaded = np.flatnonzero(x)
        tile, place = np.divmod(loaded, TILE * TILE)
        corners = tops, lefts = targets.corners
        packed = (
            np.searchsorted(tile, np.arange(tops.size + 1)),
            self._offsets[place],
            *(tops[tile] + place // TILE, lefts[tile] + place % TILE, x[loaded]),
        )
        coarse = self._transform
        loops.spread(packed, self._mesh, coarse.real)
        coarse.forward()
        coarse.spectral *= self._multiplier
        coarse.backward()
        run = self.team.run
        run(loops.interpolate, self._blocks, corners, self._mesh, coarse.real, u)
        run(loops.near_sum, self._blocks, self._pairs, packed, self._table, u)


def _weights(side: int, coarse: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """First coarse point among which each grid point is spread, and the weights.

    For whole tiles: the last may reach beyond the grid, and around its periodic edge.
    """
    position = np.arange(-(-side // TILE) * TILE) * (coarse / side)
    first = np.ceil(position - loops.SPREAD / 2).astype(np.int64)
    distance = position[:, None] - (first[:, None] + np.arange(loops.SPREAD))
    inside = np.maximum(0.0, 1.0 - (2.0 * distance / loops.SPREAD) ** 2)
    weights = i0(_BETA * np.sqrt(inside)) * (_BETA / math.sinh(_BETA))
    return first % coarse, weights.astype(np.float32)


def _coarse_kernel(shape: tuple[int, int], coarse: tuple[int, int]) -> NDArray[np.float32]:
    """Smooth part of G over the square of the spectrum of the weights, by mode."""

    def window(modes: NDArray[Any], side: int) -> NDArray[Any]:
        # Of i0(β√(1 − t²)) β/sinh β; the modes reach up to half a cycle per coarse point.
        root = np.sqrt(_BETA**2 - (math.pi * loops.SPREAD * modes / side) ** 2)
        spectrum: NDArray[Any] = (
            loops.SPREAD * (_BETA / math.sinh(_BETA)) * np.sinh(root) / root
        )
        return spectrum

    (n, m), (rows, columns) = shape, coarse
    ky, kx = np.fft.fftfreq(rows) * rows, np.fft.rfftfreq(columns) * columns
    q = 2.0 * math.pi * np.hypot(ky[:, None] / n, kx / m)
    q[0, 0] = 1.0
    kernel = 2.0 / q * erfc(q * (SIGMA / 2.0))
    kernel[0, 0] = -2.0 * SIGMA / math.sqrt(math.pi)  # what the short-ranged part has at q = 0
    kernel /= (window(ky, rows)[:, None] * window(kx, columns)) ** 2 * (n * m)
    return kernel.astype(np.float32)


@cache
def _short_table() -> NDArray[np.float32]:
    """Short-ranged part: entry ((x + edge) rows + y + edge) 8 + e is that at (y, x + e).

    Taken from a periodic grid of 512 points per side, whose edge it does not reach.
    """
    frequencies = 2.0 * math.pi * np.fft.fftfreq(512)
    q = np.hypot(frequencies[:, None], frequencies[:257])
    q[0, 0] = 1.0
    spectrum = 2.0 / q * erf(q * (SIGMA / 2.0))
    spectrum[0, 0] = 2.0 * SIGMA / math.sqrt(math.pi)
    short = np.fft.irfft2(spectrum, s=(512, 512))
    x = np.arange(-_EDGE, _EDGE + 1)[:, None, None] + np.arange(TILE)
    y = np.arange(_TABLE_ROWS)[:, None] - _EDGE
    return short[y, x].astype(np.float32).ravel()
