"""Loops of the split sum: near points one by one, the rest by way of a coarse grid.

``image``, ``pairs`` and ``sources`` are about the tiles of one working set:

- ``pairs``: entries ``start[t] … start[t + 1]`` of ``neighbour`` are the tiles near tile t, and
  those of ``shift`` the places in the table for the first points of the two;
- ``sources``: entries ``first[t] … first[t + 1]`` are the loaded points of tile t: what each
  subtracts from ``shift``, grid row, grid column and value;
- ``mesh``: per axis the first coarse point that a grid point weighs, and the weights.
"""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import TILE, UNSIGNED_TILE, loop

SPREAD = 8
"""Coarse points per axis among which a point is spread."""

_PLACES = np.uint64(TILE * TILE)


@loop
def _around(offset, n):
    """Return the offset, or its periodic image nearest to zero."""
    if 2 * offset > n:
        return offset - n
    if 2 * offset < -n:
        return offset + n
    return offset


@loop
def near_pairs(a, b, tiling, grid, reach, table_rows, start, neighbour, shift):
    """Find tiles with points within ``reach`` of a point of tiles a … b.

    Without room in ``neighbour`` they are counted, in entry t + 1 of ``start`` those of tile t;
    else they are listed, from entry t of ``start`` on. Returns how many there are.
    """
    _, rows, tiles = tiling
    n, m = grid
    n_rows = rows.size - 1
    listing = neighbour.size > 0
    edge = reach + 2 * TILE - 2
    around = min(edge // TILE + 2, (n_rows - 1) // 2)
    total = 0
    row = 0
    for tile in range(a, b):
        while rows[row + 1] <= tile:
            row += 1
        k = start[tile]
        count = 0
        for offset in range(-around, around + 1):
            other = (row + offset + n_rows) % n_rows
            dy = _around((row - other) * TILE, n)
            gap_y = max(abs(dy) - (TILE - 1), 0)
            if gap_y > reach:
                continue
            for t in range(rows[other], rows[other + 1]):
                dx = _around(np.int64(tiles[tile] - tiles[t]) * TILE, m)
                gap_x = max(abs(dx) - (TILE - 1), 0)
                if gap_x * gap_x + gap_y * gap_y > reach * reach:
                    continue
                if listing:
                    neighbour[k + count] = t
                    shift[k + count] = ((dx + edge) * table_rows + dy + edge) * TILE
                count += 1
        if not listing:
            start[tile + 1] = count
        total += count
    return total


@loop
def near_sum(a, b, pairs, sources, table, image):
    """Add to ``image`` on tiles a … b what near sources give, four of them at a time.

    What a source gives on the 64 points of a tile lies side by side in ``table``.
    """
    start, neighbour, shift = pairs
    first, offsets, _, _, values = sources
    for tile in range(a, b):
        total = image[tile * TILE * TILE : (tile + 1) * TILE * TILE]
        for pair in range(start[tile], start[tile + 1]):
            other, base = neighbour[pair], shift[pair]
            k, end = first[other], first[other + 1]
            while k + 4 <= end:
                v0, v1, v2, v3 = values[k], values[k + 1], values[k + 2], values[k + 3]
                o0, o1 = np.uint64(base - offsets[k]), np.uint64(base - offsets[k + 1])
                o2, o3 = np.uint64(base - offsets[k + 2]), np.uint64(base - offsets[k + 3])
                for e in range(_PLACES):
                    total[e] += (v0 * table[o0 + e] + v1 * table[o1 + e]) + (
                        v2 * table[o2 + e] + v3 * table[o3 + e]
                    )
                k += 4
            while k < end:
                v0, o0 = values[k], np.uint64(base - offsets[k])
                for e in range(_PLACES):
                    total[e] += v0 * table[o0 + e]
                k += 1


@loop
def spread(sources, mesh, field):
    """Spread the sources over the points of the coarse ``field``, which is set."""
    _, _, rows, columns, values = sources
    (first_rows, row_weights), (first_columns, column_weights) = mesh
    n, m = field.shape
    field[:, :] = 0
    for k in range(values.size):
        i, j0 = first_rows[rows[k]], first_columns[columns[k]]
        weights = column_weights[columns[k]]
        for a in range(SPREAD):
            value = values[k] * row_weights[rows[k], a]
            row = field[i]
            j = j0
            for c in range(SPREAD):
                row[j] += value * weights[c]
                j += 1
                if j == m:
                    j = 0
            i += 1
            if i == n:
                i = 0


@loop
def interpolate(a, b, corners, mesh, field, image):
    """Set ``image`` on tiles a … b to the coarse ``field``, weighed as :func:`spread` does."""
    tops, lefts = corners
    (first_rows, row_weights), (first_columns, column_weights) = mesh
    n, m = field.shape
    line = np.empty(SPREAD + TILE + 1, field.dtype)
    for tile in range(a, b):
        left = lefts[tile]
        start = first_columns[left]
        # The weights of the last point of the tile may begin beyond the periodic edge.
        width = (first_columns[left + TILE - 1] - start) % m + SPREAD
        for y in range(TILE):
            i = first_rows[tops[tile] + y]
            line[:width] = 0
            for r in range(SPREAD):
                weight = row_weights[tops[tile] + y, r]
                row = field[i]
                j = start
                for c in range(width):
                    line[c] += weight * row[j]
                    j += 1
                    if j == m:
                        j = 0
                i += 1
                if i == n:
                    i = 0
            k = np.uint64((tile * TILE + y) * TILE)
            for e in range(UNSIGNED_TILE):
                offset = np.uint64((first_columns[left + e] - start) % m)
                total = image.dtype.type(0)
                for c in range(np.uint64(SPREAD)):
                    total += column_weights[left + e, c] * line[offset + c]
                image[k + e] = total
