"""Where some points are plastic: the gap that a pressure leads to, loads, starts.

The pressure nowhere exceeds the hardness H; see :mod:`.bounded`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.optimize import brentq

from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.evaluation import SMALL_GAP, Evaluation, GapEvaluator
from roughbench.models.halfspace.loops import gap, plastic
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.surface import ScaledHeights
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid


class BoundedEvaluator(GapEvaluator):
    """Evaluates pressures up to H, by transforms.

    Parameters
    ----------
    heights, operator
        As of :class:`GapEvaluator`.
    hardness : float
    """

    def __init__(
        self, heights: ScaledHeights, operator: HalfSpaceOperator, hardness: float
    ) -> None:
        super().__init__(heights, operator)
        self._hardness = hardness

    def direct_for(self, points: WorkingSet) -> DirectOperator | None:
        """Return none: with a hardness G takes transforms at any load."""
        del points
        return None

    def evaluate(self, points: WorkingSet) -> Evaluation:
        """Gap at all points; α from the elastic ones, weighted by their distance to a bound.

        Between the plastic and the empty points where none is elastic.
        """
        _, energy, sum_p = self.displace(points)
        blocks, _ = self.team.split(points.rows)
        on = points.tiling, points.p, self.operator.field, self.heights.surface
        weight, moment = self.team.sum(plastic.elastic_plane, blocks, *on, self._hardness)
        marked = np.empty(tile_grid(self.shape), np.uint8)
        tile_rows = self.team.even(marked.shape[0])
        if weight > 0.0:
            alpha = float(moment / weight)
        else:
            parts = self.team.run(plastic.dense_plane_range, tile_rows, *on, self._hardness)
            alpha = plane_between(parts)
        sums = self.team.run(plastic.mark_tiles, tile_rows, *on, alpha, self._hardness, marked)
        opened = sum(part[2] for part in sums) / self.size
        depth = sum(part[3] for part in sums) / self.size
        separation = self.heights.depth - alpha
        if abs(separation) < SMALL_GAP:
            separation = opened - depth

        def make(dtype: DTypeLike, total: float) -> WorkingSet:
            del total  # pressures at the bound cannot be scaled to it
            return self.make_working_set(points, alpha, marked, dtype, 1.0)

        return Evaluation(
            alpha=alpha,
            separation=separation,
            energy=energy,
            sum_p=sum_p,
            sum_p_gap=sum(part[0] for part in sums),
            lowest_gap=min(part[1] for part in sums),
            make_working_set=make,
            open_gap=opened,
            plastic_depth=depth,
        )


def plane_between(parts: Sequence[tuple[float, float]]) -> float:
    """α where no point is elastic: half-way between plastic points and all others.

    Parameters
    ----------
    parts : sequence of (float, float)
        Highest gap of plastic points and lowest of the others, of each block of the grid;
        −inf and inf where there are none.
    """
    highest, lowest = max(part[0] for part in parts), min(part[1] for part in parts)
    if math.isinf(lowest):
        return highest
    return lowest if math.isinf(highest) else 0.5 * (highest + lowest)


def scaled_within(
    loads: NDArray[np.floating], capacities: NDArray[np.floating], wanted: float
) -> NDArray[np.floating]:
    """Multiply loads by a common factor, none beyond its capacity, to sum to ``wanted``.

    As near to it as the capacities allow. Each round fills at least one more, or ends.

    Examples
    --------
    >>> scaled_within(np.array([1.0, 2.0, 0.0]), np.array([4.0, 3.0, 5.0]), 5.0).tolist()
    [2.0, 3.0, 0.0]
    """
    full = np.zeros(loads.shape, np.bool_)
    factor = 1.0
    while True:
        left = float(loads.sum(dtype=np.float64, where=~full))
        if not left > 0.0:
            break
        factor = (wanted - float(capacities.sum(dtype=np.float64, where=full))) / left
        more = ~full & (factor * loads > capacities)
        if not more.any():
            break
        full |= more
    scaled = loads * loads.dtype.type(max(factor, 0.0))
    return np.where(full, capacities, np.minimum(scaled, capacities))


def fit_load(p: NDArray[np.floating], hardness: float, total: float) -> None:
    """Clip pressures to 0 … H and multiply those within, in place, so that Σp is ``total``.

    Where the plastic points alone carry more than that, all are lowered; where nothing more can
    be carried by the points under pressure, the sum stays below ``total``.
    """
    upper = p.dtype.type(hardness)
    np.clip(p, 0, upper, out=p)
    plastic = p >= upper
    rest = total - hardness * float(np.count_nonzero(plastic))
    if rest <= 0.0:
        p *= p.dtype.type(min(total / float(p.sum(dtype=np.float64)), 1.0))
        return
    within = p[~plastic]
    p[~plastic] = scaled_within(within, np.full_like(within, upper), rest)


def bounded_cold_start(
    evaluator: GapEvaluator, load: float, modulus: float, hardness: float, dtype: DTypeLike
) -> WorkingSet:
    """Pressure of independent springs min(k max(h − d, 0), H) at this load, k = ``modulus``."""
    shape, team, heights = evaluator.shape, evaluator.team, evaluator.heights
    reach = hardness / modulus

    def missing(plane: float) -> float:
        """Load beyond the wanted one: the overlap, without what lies deeper than H/k."""
        overlap, beyond = (
            team.sum(gap.overlap_sums, team.even(shape[0]), heights.surface, level)[0]
            for level in (plane, plane + reach)
        )
        return float(overlap - beyond) * modulus / evaluator.size - load

    lowest = float(heights.surface[0].min() - heights.surface[2]) * heights.scale
    # A load next to H leaves it to rounding errors whether the lowest plane carries it.
    bracket = (lowest - reach) * (1 + 1e-9), 0.0
    plane = bracket[0] if missing(bracket[0]) <= 0.0 else brentq(missing, *bracket, rtol=1e-9)
    evaluator.operator.field[...] = 0.0
    none = WorkingSet.on(shape, np.zeros(tile_grid(shape), np.uint8), dtype)
    marked, _, _ = evaluator.mark(none, -plane)
    points = evaluator.make_working_set(none, -plane, marked, dtype, 1.0)
    np.maximum(-points.r, 0, out=points.p)
    points.p *= points.p.dtype.type(modulus)
    fit_load(points.p, hardness, load * evaluator.size)
    return points


def rounded_down(hardness: float, dtype: DTypeLike) -> float:
    """Return the largest number of this precision that is not above ``hardness``."""
    number: np.floating = np.full(1, hardness, dtype)[0]
    if float(number) > hardness:  # float32 against float64 would be compared in float32
        number = np.nextafter(number, number.dtype.type(0))
    return float(number)
