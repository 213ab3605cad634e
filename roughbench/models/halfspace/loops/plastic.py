"""Loops over dense fields where some points are plastic: the plane, the gap and its errors."""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import TILE, loop


@loop
def elastic_plane(a, b, tiling, p, field, surface, hardness):
    """Σw and Σw(u − h) with the weights w = min(p, H − p); u = field."""
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    weight = moment = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                k = (t * height + i - i0) * TILE
                for e in range(min(TILE, m - j)):
                    pressure = np.float64(p[k + e])
                    u = np.float64(field[i, j + e])
                    w = min(pressure, hardness - pressure)
                    weight += w
                    moment += w * (u - scale * (heights[i, j + e] - datum))
    return weight, moment


@loop
def dense_plane_range(a, b, tiling, p, field, surface, hardness):
    """Highest u − h of the plastic points and lowest of all others, of the whole grid."""
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    highest, lowest = -np.inf, np.inf
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            t = rows[tile_row]
            for j in range(m):
                while t < rows[tile_row + 1] and tiles[t] < j // TILE:
                    t += 1
                known = t < rows[tile_row + 1] and tiles[t] == j // TILE
                pressure = p[(t * height + i - i0) * TILE + j % TILE] if known else 0.0
                distance = field[i, j] - scale * (heights[i, j] - datum)
                if pressure >= hardness:
                    highest = max(highest, distance)
                else:
                    lowest = min(lowest, distance)
    return highest, lowest


@loop
def mark_tiles(a, b, tiling, p, field, surface, alpha, hardness, marked):
    """Mark the tiles with a point under pressure or of negative gap u − h − α.

    Returns Σp|gap|, of plastic points only where the gap is positive; the most negative gap
    where p < H; Σ of the positive gaps where p = 0; and Σ of the depths −gap of plastic points.
    """
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    total = worst = opened = depth = 0.0
    for tile_row in range(a, b):
        mark = marked[tile_row]
        mark[:] = 0
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            t = rows[tile_row]
            for j in range(m):
                column = j // TILE
                while t < rows[tile_row + 1] and tiles[t] < column:
                    t += 1
                known = t < rows[tile_row + 1] and tiles[t] == column
                pressure = (
                    np.float64(p[(t * height + i - i0) * TILE + j % TILE]) if known else 0.0
                )
                gap = field[i, j] - scale * (heights[i, j] - datum) - alpha
                if pressure >= hardness:
                    total += pressure * max(gap, 0.0)
                    depth += max(-gap, 0.0)
                else:
                    total += pressure * abs(gap)
                    worst = min(worst, gap)
                    opened += max(gap, 0.0) if pressure == 0.0 else 0.0
                if pressure > 0.0 or gap < 0.0:
                    mark[column] = 1
    return total, worst, opened, depth
