"""Where the iteration of a state starts: springs, or the tangent of a state before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.evaluation import GapEvaluator
from roughbench.models.halfspace.loops import TILE, gap
from roughbench.models.halfspace.plastic import fit_load
from roughbench.models.halfspace.surface import ScaledHeights
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid, tile_height

PREDICTION_REACH = 4.0
"""Largest step of the load, as a factor, over which the tangent predicts a start. Beyond
it the points in contact before carry what others should, and a cold start needs fewer
iterations: of seven loads on two surfaces of 512² points it does at a factor of 10 on
five and six, at a factor of 3 on one and two."""


def cold_start(
    evaluator: GapEvaluator, load: float, modulus: float, dtype: DTypeLike
) -> WorkingSet:
    """Pressure of independent springs k max(h − d, 0) at this load, k = ``modulus``."""
    shape, size, team = evaluator.shape, evaluator.size, evaluator.team
    heights = evaluator.heights
    wanted = load / modulus * size
    points = _overlap_of_few(heights, wanted, shape, dtype)
    if points is None:
        plane = _spring_plane(
            lambda plane: team.sum(
                gap.overlap_sums, team.even(shape[0]), heights.surface, plane
            ),
            -heights.depth - load / modulus,  # there Σ(h − d) is the wanted sum already
            wanted,
        )
        evaluator.operator.field[...] = 0.0
        none = WorkingSet.on(shape, np.zeros(tile_grid(shape), np.uint8), dtype)
        marked, _, _ = evaluator.mark(none, -plane)
        points = evaluator.make_working_set(none, -plane, marked, dtype, 1.0)
        np.maximum(-points.r, 0, out=points.p)
    scale_to(points, load * size)
    return points


def from_field(pressure: NDArray[np.float64], dtype: DTypeLike) -> WorkingSet:
    """Return the positive pressures of a dense field, shape (n, m), as a working set."""
    shape = pressure.shape[0], pressure.shape[1]
    rows, columns = tile_grid(shape)
    height = tile_height(shape)
    padded = np.zeros((rows * height, columns * TILE), dtype)
    padded[: shape[0], : shape[1]] = pressure
    tiles = padded.reshape(rows, height, columns, TILE).swapaxes(1, 2)
    marked: NDArray[np.bool_] = np.any(tiles > 0, axis=(2, 3))
    points = WorkingSet.on(shape, marked.astype(np.uint8), dtype)
    points.p[:] = tiles[marked].ravel()
    points.keep_pressure()
    return points


def predict(
    solved: float,
    points: WorkingSet,
    rate: NDArray[np.floating],
    load: float,
    size: int,
    hardness: float | None = None,
) -> WorkingSet | None:
    """Pressure at another load than ``solved``: p + Δp̄ ∂p/∂p̄ where that is positive.

    None where the other load is too far away for this to be a good start, or more than these
    points can carry.
    """
    if load > PREDICTION_REACH * solved:
        return None
    rate *= rate.dtype.type(load - solved)
    points.p += rate
    np.maximum(points.p, 0, out=points.p)
    scale_to(points, load * size, hardness)
    if hardness is not None and points.p.sum(dtype=np.float64) < (1 - 1e-4) * load * size:
        return None
    return points


def scale_to(points: WorkingSet, total: float, hardness: float | None = None) -> None:
    """Multiply the pressures, none beyond the hardness, so that Σp is ``total``."""
    if hardness is not None:
        fit_load(points.p, hardness, total)
        return
    points.p *= points.p.dtype.type(total / points.p.sum(dtype=np.float64))


def _overlap_of_few(
    heights: ScaledHeights, wanted: float, shape: tuple[int, int], dtype: DTypeLike
) -> WorkingSet | None:
    """Overlap max(h − d, 0) of the wanted sum, if the highest tiles suffice."""
    tops = heights.tile_tops
    n_tiles = max(64, tops.size // 64)
    if n_tiles >= tops.size:
        return None
    floor = float(np.partition(tops, tops.size - n_tiles, axis=None)[-n_tiles])
    # No other tile rises above the floor.
    points = WorkingSet.on(shape, (tops > floor).view(np.uint8), np.float64)
    h = heights.on(points)

    def overlap_sums(plane: float) -> NDArray[np.float64]:
        overlap = np.maximum(h - plane, 0.0)
        return np.array([overlap.sum(), np.count_nonzero(overlap)])

    if overlap_sums(floor)[0] < wanted:
        return None
    plane = _spring_plane(overlap_sums, floor, wanted)
    overlap = np.maximum(h - plane, 0.0)
    points.p = overlap.astype(dtype)
    return points.in_contact()


def _spring_plane(
    overlap_sums: Callable[[float], NDArray[np.float64]], plane: float, wanted: float
) -> float:
    """Height d < 0 of the plane, from the top, at which Σmax(h − d, 0) is ``wanted``.

    Newton's method from below: the sum is convex and falls with d, so that no step passes
    the answer, but for rounding. Where it passes the top itself, where nothing overlaps,
    the next try lies a thousand times closer to the top than the last.
    """
    for _ in range(200):
        overlap, count = overlap_sums(plane)
        if abs(overlap - wanted) <= 1e-9 * wanted:
            break
        higher = plane + (overlap - wanted) / count
        plane = float(higher) if higher < 0.0 else 1e-3 * plane
    return plane
