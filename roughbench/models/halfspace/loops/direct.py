"""G applied point by point from a table."""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import TILE, inlined, loop


@inlined
def _reading(top, left, row, column, grid, table_rows):
    """Rows from the source to the tile's first, and where reading the table starts.

    Reading goes on to larger offsets: from the tile's first row, or from its last where the
    tile is above the source.
    """
    height, n, m, shift = grid
    rows = top - row
    if 2 * rows > n:
        rows -= n
    elif 2 * rows < -n:
        rows += n
    columns = left - column + shift
    if columns < 0:
        columns += m
    elif columns >= m:
        columns -= m
    nearest = rows if rows >= 0 else 1 - height - rows
    strip = (columns // TILE) * table_rows
    return rows, (strip + nearest) * (2 * TILE) + columns % TILE


@loop
def direct_sum(a, b, corners, sources, grid, table, image):
    """``image`` on tiles a … b = Σ values G over the source points.

    ``corners`` are the first grid rows and columns of the tiles, ``sources`` grid rows, grid
    columns and values, ``grid`` the height of a tile, the shape of the grid and the shift of
    the table: entry (k, i, j) of ``table`` is G at ±i rows and 8k + j − shift columns from its
    source.

    A strip of the table is 16 columns wide and a tile 8. Reading the rows of a tile in one
    go, with the 8 columns between them that nobody wants, is two to three times faster than
    row by row. Tiles above a source are read upside down.
    """
    tops, lefts = corners
    source_rows, source_columns, values = sources
    height = grid[0]
    table_rows = table.shape[1]
    flat = table.reshape(-1)
    length = np.uint64((2 * height - 1) * TILE)
    upright = np.empty(2 * height * TILE, table.dtype)
    turned = np.empty_like(upright)
    for tile in range(a, b):
        top, left = tops[tile], lefts[tile]
        upright[:] = 0
        turned[:] = 0
        k = 0
        while k < values.size:
            rows, start = _reading(
                top, left, source_rows[k], source_columns[k], grid, table_rows
            )
            v0 = values[k]
            if -height + 1 < rows < 0:  # a source beside the tile, with rows above and below
                for i in range(height):
                    o = start + (abs(rows + i) + rows + height - 1) * (2 * TILE)
                    for e in range(TILE):
                        upright[2 * TILE * i + e] += v0 * flat[o + e]
                k += 1
                continue
            wide = upright if rows >= 0 else turned
            o0 = np.uint64(start)
            if k + 4 <= values.size:
                rows1, start1 = _reading(
                    top, left, source_rows[k + 1], source_columns[k + 1], grid, table_rows
                )
                rows2, start2 = _reading(
                    top, left, source_rows[k + 2], source_columns[k + 2], grid, table_rows
                )
                rows3, start3 = _reading(
                    top, left, source_rows[k + 3], source_columns[k + 3], grid, table_rows
                )
                lowest = min(min(rows, rows1), min(rows2, rows3))
                highest = max(max(rows, rows1), max(rows2, rows3))
                if lowest >= 0 or (highest < 0 and highest <= 1 - height):
                    v1, v2, v3 = values[k + 1], values[k + 2], values[k + 3]
                    o1, o2, o3 = np.uint64(start1), np.uint64(start2), np.uint64(start3)
                    for e in range(length):
                        wide[e] += (v0 * flat[o0 + e] + v1 * flat[o1 + e]) + (
                            v2 * flat[o2 + e] + v3 * flat[o3 + e]
                        )
                    k += 4
                    continue
            for e in range(length):
                wide[e] += v0 * flat[o0 + e]
            k += 1
        total = image[tile * height * TILE : (tile + 1) * height * TILE]
        for i in range(height):
            for e in range(TILE):
                total[TILE * i + e] = (
                    upright[2 * TILE * i + e] + turned[2 * TILE * (height - 1 - i) + e]
                )
