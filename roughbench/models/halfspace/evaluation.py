"""The gap that a pressure leads to at all points, in float64 from the pressure alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.loops import NEVER_FREE, gap, tiles
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.surface import ScaledHeights
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid

DIRECT_SUM_MAX_FRACTION = 5e-4
"""Fraction of points under pressure from which on a direct sum is not considered."""

SMALL_GAP = 1e-6
"""Mean gap, in h_rms, below which it is summed over the points without pressure: as a
difference of α and ⟨h⟩ it would be lost in their rounding errors."""


@dataclass(slots=True)
class Evaluation:
    """What a pressure leads to, in float64.

    Attributes
    ----------
    alpha, separation, energy : float
        α = Σp(u − h)/Σp, the mean gap and ½⟨pu⟩.
    sum_p, sum_p_gap : float
        Σp and Σp|g|.
    lowest_gap : float
        The most negative gap of all points; of those below the hardness where there is one.
    make_working_set : callable
        Makes the next working set, of a precision and a load Σp: tiles with pressure or
        negative gap, p copied and r = gap. In float64, p and u are scaled to that load,
        which float32 holds to 1e-7 only: steps that had to mend it would not descend.
    open_gap : float
        Mean gap without the depths of plastic points; without a hardness the mean gap.
    plastic_depth : float
        Mean of −g over plastic points, per point of the grid.
    """

    alpha: float
    separation: float
    energy: float
    sum_p: float
    sum_p_gap: float
    lowest_gap: float
    make_working_set: Callable[[DTypeLike, float], WorkingSet]
    open_gap: float = math.nan
    plastic_depth: float = 0.0

    def __post_init__(self) -> None:
        if math.isnan(self.open_gap):
            self.open_gap = self.separation


class GapEvaluator:
    """Evaluates pressures: by a transform pair or, where few points carry, a direct sum.

    Parameters
    ----------
    heights : ScaledHeights
    operator : HalfSpaceOperator
        In float64; its field is overwritten by most methods.
    """

    def __init__(self, heights: ScaledHeights, operator: HalfSpaceOperator) -> None:
        self.heights = heights
        self.operator = operator
        self.team = operator.team
        self.shape = operator.field.shape
        self.size = operator.field.size
        # Without a period ū is minus the approach, counted from the first contact.
        self.depth = heights.depth if operator.periodic else 0.0
        self._direct: DirectOperator | None = None

    def evaluate(self, points: WorkingSet) -> Evaluation:
        """Gap at all points under the pressure of a working set."""
        return self._evaluate_directly(points) or self._evaluate_by_transforms(points)

    def displace(self, points: WorkingSet) -> tuple[float, float, float]:
        """Put u = G p into the field; return α = Σp(u − h)/Σp, ½⟨pu⟩ and Σp."""
        blocks, _ = self.team.split(points.rows)
        field = self.operator.field
        self.team.run(tiles.scatter, blocks, points.tiling, points.p, field)
        self.operator.displace()
        sum_p, moment, energy = self.team.sum(
            gap.gap_sums, blocks, points.tiling, points.p, field, self.heights.surface
        )
        return moment / sum_p, energy / (2 * self.size), sum_p

    def mark(self, points: WorkingSet, alpha: float) -> tuple[NDArray[np.uint8], float, float]:
        """Tiles with pressure or negative gap, Σp|g| and the most negative gap."""
        marked = np.empty(tile_grid(self.shape), np.uint8)
        parts = self.team.run(
            gap.mark_tiles,
            self.team.even(marked.shape[0]),
            *(points.tiling, points.p, self.operator.field, self.heights.surface),
            *(alpha, marked),
        )
        return marked, sum(part[0] for part in parts), min(part[1] for part in parts)

    def make_working_set(
        self,
        points: WorkingSet,
        alpha: float,
        marked: NDArray[np.uint8],
        dtype: DTypeLike,
        factor: float,
    ) -> WorkingSet:
        """Working set of the marked tiles, with p copied and r = gap.

        In float64, p and u are multiplied by ``factor``.
        """
        made = WorkingSet.on(self.shape, marked, dtype)
        exactly = made.p.dtype == np.float64
        if exactly:
            self.operator.field[...] *= factor
        self.team.run(
            gap.fill_tiles,
            self.team.even(marked.shape[0]),
            *(points.tiling, points.p, self.operator.field, self.heights.surface, alpha),
            *(made.tiling, made.p, made.r),
        )
        if exactly:
            made.p *= factor
        return made

    def direct_for(self, points: WorkingSet) -> DirectOperator | None:
        """Return the direct sum, where it is cheaper than transforms on this working set."""
        n_sources = points.n_contact
        if not self.operator.periodic:
            return None
        if n_sources >= DIRECT_SUM_MAX_FRACTION * self.size:
            self._direct = None  # its tables are not needed any more
            return None
        if self._direct is None:
            self._direct = DirectOperator(self.operator)
        return self._direct if self._direct.is_cheaper(n_sources, points.tiles.size) else None

    def _evaluate_by_transforms(self, points: WorkingSet) -> Evaluation:
        alpha, energy, sum_p = self.displace(points)
        marked, sum_p_gap, lowest_gap = self.mark(points, alpha)
        separation = self.depth - alpha
        if separation < SMALL_GAP and self.operator.periodic:
            blocks, _ = self.team.split(points.rows)
            (total,) = self.team.sum(
                gap.open_gap,
                blocks,
                *(points.tiling, points.p, self.operator.field, self.heights.surface, alpha),
            )
            separation = total / self.size

        def make(dtype: DTypeLike, total: float) -> WorkingSet:
            return self.make_working_set(points, alpha, marked, dtype, total / sum_p)

        return Evaluation(alpha, separation, energy, sum_p, sum_p_gap, lowest_gap, make)

    def _evaluate_directly(self, points: WorkingSet) -> Evaluation | None:
        """By a direct sum, or None where a transform pair is cheaper.

        Where the pressure is on few points, a bound from below on u spares most others:
        a gap can be negative only at heights above it. Only tiles that reach so high are
        looked at.
        """
        if points.n_contact >= DIRECT_SUM_MAX_FRACTION * self.size:
            self._direct = None  # its tables are not needed any more
            return None
        loaded = points.in_contact()
        direct = self.direct_for(loaded)
        if direct is None:
            return None
        p = loaded.p.astype(np.float64)
        u = np.empty_like(p)
        direct.apply(loaded, p, loaded, u)
        h = self.heights.on(loaded)
        contact = p > 0
        sum_p = float(p.sum())
        alpha = float((p[contact] * (u - h)[contact]).sum()) / sum_p
        reaching = self.heights.tile_tops > sum_p * direct.lowest - alpha
        reaching[loaded.places] = False
        n_others = int(np.count_nonzero(reaching))
        if 4 * n_others > reaching.size or not direct.is_cheaper(loaded.n_contact, n_others):
            return None
        # Its p holds u here.
        others = WorkingSet.on(self.shape, reaching.view(np.uint8), np.float64)
        direct.apply(loaded, p, others, others.p)
        np.subtract(others.p, self.heights.on(others), out=others.r)
        others.r -= alpha
        g = u - h - alpha
        sum_p_gap = float((p[contact] * np.abs(g[contact])).sum())
        lowest_gap = min(0.0, float(g.min()), float(others.r.min(initial=0.0)))
        size = loaded.tile_size

        def make(dtype: DTypeLike, total: float) -> WorkingSet:
            more = total / sum_p - 1.0 if np.dtype(dtype) == np.float64 else 0.0
            below = others.r.reshape(-1, size).min(axis=1, initial=0.0) < 0
            places = tuple(place[below] for place in others.places)
            marked = np.zeros(reaching.shape, np.uint8)
            marked[loaded.places] = marked[places] = 1
            made = WorkingSet.on(self.shape, marked, dtype)
            index = np.empty(marked.shape, np.intp)
            index[made.places] = np.arange(made.tiles.size)
            p_tiles, r_tiles = made.p.reshape(-1, size), made.r.reshape(-1, size)
            p_tiles[:] = 0
            p_tiles[index[loaded.places]] = (p + more * p).reshape(-1, size)
            r_tiles[index[loaded.places]] = gaps(g, u, more)
            r_tiles[index[places]] = gaps(others.r, others.p, more)[below]
            return made

        def gaps(
            g: NDArray[np.float64], u: NDArray[np.float64], more: float
        ) -> NDArray[np.float64]:
            return np.minimum(g + more * u, NEVER_FREE).reshape(-1, size)

        energy = float((p * u).sum()) / (2 * self.size)
        separation = self.depth - alpha
        return Evaluation(alpha, separation, energy, sum_p, sum_p_gap, lowest_gap, make)
