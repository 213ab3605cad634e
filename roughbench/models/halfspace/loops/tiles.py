"""Loops between working sets and dense fields, and counts around single points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.loops import TILE, copy_row, loop

PRESCRIBED_RATIO = 0.75
"""Of two points in a row at a free edge, where p = A√s, the outer one carries at most 1/√2 of
what the inner one does; at an edge that the heights prescribe the pressure does not fall."""

EDGE_BEND, NARROW_EDGE_BEND = 4.0, 30.0
"""Bend of the heights at a prescribed edge, in units of pΔ/E*, at least: in contacts of three
or more points, and of two. A heuristic, chosen on punches, plateaus and stairs against rough
surfaces with 2, 4 and 8 points on the shortest wave (H = 0.3 to 0.9, A = 1e-3 to 0.98), of
whose 191,000, 116,000 and 68,000 edges it takes 0.09, 0.011 and 0.0015 % for prescribed."""


@loop
def scatter(a, b, tiling, values, field):
    """Dense tile rows that are ``values`` on the working set and zero elsewhere."""
    height, rows, tiles = tiling
    n, m = field.shape
    for tile_row in range(a, b):
        i0 = tile_row * height
        partial = (rows[tile_row + 1] - rows[tile_row]) * TILE < m
        for i in range(i0, min(i0 + height, n)):
            row = field[i]
            if partial:
                row[:] = 0
            k = rows[tile_row] * height * TILE + (i - i0) * TILE
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                copy_row(values, k, row, j, min(TILE, m - j))
                k += height * TILE


def wrap_halo(scratch: NDArray[Any]) -> None:
    """Fill the halo periodically."""
    scratch[0] = scratch[-2]
    scratch[-1] = scratch[1]
    scratch[:, 0] = scratch[:, -2]
    scratch[:, -1] = scratch[:, 1]


@loop
def clear(a, b, tiling, scratch):
    """Set ``scratch`` to zero on the working set."""
    height, rows, tiles = tiling
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            row = scratch[i + 1]
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                row[j + 1 : min(j + TILE, m) + 1] = 0


@loop
def spread_pressure(a, b, tiling, p, scratch):
    """Write p to ``scratch`` on the working set."""
    height, rows, tiles = tiling
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            row = scratch[i + 1]
            k = rows[tile_row] * height * TILE + (i - i0) * TILE
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                copy_row(p, k, row, j + 1, min(TILE, m - j))
                k += height * TILE


@loop
def _is_free(i, j, di, dj, scratch, heights, scale, spacing, ends):
    """Whether the edge between point (i, j) and (i + di, j + dj), outside, is free."""
    n, m = heights.shape
    if ends and not (0 <= i + di < n and 0 <= j + dj < m):
        return False
    p = scratch[i + 1, j + 1]
    behind = scratch[i + 1 - di, j + 1 - dj]
    if not (behind > 0 and p > PRESCRIBED_RATIO * behind):
        return True
    beyond = scratch[(i - 2 * di) % n + 1, (j - 2 * dj) % m + 1]
    if ends and not (0 <= i - 2 * di < n and 0 <= j - 2 * dj < m):
        beyond = scratch[0, 0]  # nothing
    sides = max(scratch[i + 1 - dj, j + 1 - di], scratch[i + 1 + dj, j + 1 + di])
    h = np.float64(heights[i, j])
    inner = heights[(i - di) % n, (j - dj) % m]
    outer = heights[(i + di) % n, (j + dj) % m]
    bend = scale * ((h - inner) + (h - outer))
    least = spacing * (EDGE_BEND if beyond > 0 else NARROW_EDGE_BEND)
    return bend <= least * max(max(p, behind), max(sides, beyond))


@loop
def count_edges(a, b, tiling, scratch, surface, aspect, ends, plastic):
    """Points with p > 0, and free grid edges between these and others.

    ``scratch`` holds p, with its halo; ``aspect`` is the spacing of columns over that of
    rows, and ``ends`` whether nothing lies beyond the grid. From ``plastic`` on a point has no
    free edges. For what is free see
    :func:`roughbench.models.halfspace.perimeter.count_edges`.
    """
    height, rows, tiles = tiling
    heights, scale, _ = surface
    n, m = heights.shape
    contact = 0.0
    free = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            here = scratch[i + 1]
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j0 = tiles[t] * TILE
                for j in range(j0, min(j0 + TILE, m)):
                    c = j + 1
                    if not here[c] > 0:
                        continue
                    contact += 1.0
                    if here[c] >= plastic:
                        continue
                    # One call, whose steps are no constants: for each of these it would be
                    # compiled anew.
                    for side in range(4):
                        step = 2 * (side % 2) - 1
                        di = step if side < 2 else 0
                        dj = step - di
                        spacing = 1.0 if side < 2 else aspect
                        if scratch[i + 1 + di, c + dj] == 0 and _is_free(
                            i, j, di, dj, scratch, heights, scale, spacing, ends
                        ):
                            free += 1.0
    return contact, free
