"""Loops over dense fields: the kernel, full contact, and the gap at all points."""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import NEVER_FREE, TILE, loop


@loop
def multiply_by_kernel(a, b, spectral, qy_squared, qx_squared, factor, exponent, m):
    """Multiply rows of a half spectrum by ``factor·|q|**exponent`` (±1), zero at q = 0.

    The field has ``m`` columns. Returns its product sum with what it becomes, if +1.
    """
    work = 0.0
    for i in range(a, b):
        row = spectral[i]
        y = qy_squared[i]
        if exponent < 0:
            for j in range(row.shape[0]):
                row[j] *= factor / np.sqrt(y + qx_squared[j])
        else:
            # Each column but the first, and the last of an even number, stands for two.
            here = factor - factor
            for j in range(np.uint64(row.shape[0])):
                value = row[j]
                multiplier = factor * np.sqrt(y + qx_squared[j])
                here += multiplier * (value.real * value.real + value.imag * value.imag)
                row[j] = multiplier * value
            work += 2.0 * here
            for j in (0, row.shape[0] - 1):
                if j == 0 or m % 2 == 0:
                    multiplier = factor * np.sqrt(y + qx_squared[j])
                    if multiplier > 0:
                        value = row[j]
                        work -= (value.real * value.real + value.imag * value.imag) / multiplier
    if a == 0:
        spectral[0, 0] = 0.0
    return work


@loop
def multiply_by_even_table(spectral, table, first):
    """Multiply columns of a spectrum by ``table``, rows past its end by its mirror image."""
    n = spectral.shape[0]
    for i in range(n):
        row = spectral[i]
        factors = table[i if i < table.shape[0] else n - i]
        for j in range(row.shape[0]):
            row[j] *= factors[first + j]


@loop
def traction_at_full_contact(a, b, field, surface):
    """Lowest value of the traction in ``field``, its product sum with the heights, and Σσ²."""
    heights, scale, datum = surface
    lowest = np.inf
    product = 0.0
    squares = 0.0
    for i in range(a, b):
        row = field[i]
        h_row = heights[i]
        for j in range(row.shape[0]):
            lowest = min(lowest, row[j])
            product += row[j] * scale * (h_row[j] - datum)
            squares += row[j] * row[j]
    return lowest, product, squares


@loop
def gap_at_full_contact(a, b, traction, field, surface):
    """Σσ, Σ|g|, Σσ|g| and max(−g) of the traction σ and the gap g = u − h; u = field."""
    heights, scale, datum = surface
    total = 0.0
    gap = 0.0
    moment = 0.0
    deepest = 0.0
    for i in range(a, b):
        sigma, u_row, h_row = traction[i], field[i], heights[i]
        for j in range(h_row.shape[0]):
            g = u_row[j] - scale * (h_row[j] - datum)
            total += sigma[j]
            gap += abs(g)
            moment += sigma[j] * abs(g)
            deepest = max(deepest, -g)
    return total, gap, moment, deepest


@loop
def overlap_sums(a, b, surface, plane):
    """Σmax(h − d, 0) for a plane at height d, and the number of points above it."""
    heights, scale, datum = surface
    total = 0.0
    n = 0.0
    for i in range(a, b):
        row = heights[i]
        for j in range(row.shape[0]):
            overlap = scale * (row[j] - datum) - plane
            above = overlap > 0
            total += overlap if above else 0.0
            n += 1.0 if above else 0.0
    return total, n


@loop
def tile_tops(a, b, height, heights, highest):
    """``highest`` = largest height of each tile."""
    n, m = heights.shape
    for tile_row in range(a, b):
        top = highest[tile_row]
        top[:] = -np.inf
        for i in range(tile_row * height, min((tile_row + 1) * height, n)):
            row = heights[i]
            for tile in range(top.size):
                for j in range(tile * TILE, min((tile + 1) * TILE, m)):
                    top[tile] = max(top[tile], row[j])


@loop
def dense_gap(a, b, field, surface, alpha, gap):
    """Dense gap u − h − α."""
    heights, scale, datum = surface
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        g_row = gap[i]
        for j in range(h_row.shape[0]):
            g_row[j] = u_row[j] - scale * (h_row[j] - datum) - alpha


@loop
def gap_sums(a, b, tiling, p, field, surface):
    """Σp, Σp(u − h) and Σpu over the working set; u = field."""
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    mass = 0.0
    moment = 0.0
    energy = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            u_row = field[i]
            h_row = heights[i]
            k = rows[tile_row] * height * TILE + (i - i0) * TILE
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                for e in range(min(TILE, m - j)):
                    pressure = np.float64(p[k + e])
                    u = np.float64(u_row[j + e])
                    mass += pressure
                    moment += pressure * (u - scale * (h_row[j + e] - datum))
                    energy += pressure * u
                k += height * TILE
    return mass, moment, energy


@loop
def open_gap(a, b, tiling, p, field, surface, alpha):
    """Σ of the gap u − h − α, where it is positive, over the points without pressure."""
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    total = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            u_row = field[i]
            h_row = heights[i]
            t = rows[tile_row]
            for j in range(m):
                while t < rows[tile_row + 1] and tiles[t] < j // TILE:
                    t += 1
                known = t < rows[tile_row + 1] and tiles[t] == j // TILE
                if not (known and p[(t * height + i - i0) * TILE + j % TILE] > 0):
                    total += max(u_row[j] - scale * (h_row[j] - datum) - alpha, 0.0)
    return (total,)


@loop
def mark_tiles(a, b, tiling, p, field, surface, alpha, marked):
    """Mark the tiles with a point under pressure or of negative gap u − h − α.

    ``marked`` has the shape of the tiles. Returns Σp|gap| and the most negative gap of
    all points.
    """
    height, rows, tiles = tiling
    heights, scale, datum = surface
    n, m = field.shape
    total = 0.0
    worst = 0.0
    for tile_row in range(a, b):
        mark = marked[tile_row]
        mark[:] = 0
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            u_row = field[i]
            h_row = heights[i]
            for tile in range(mark.shape[0]):
                j0 = tile * TILE
                lowest = np.inf
                for j in range(j0, min(j0 + TILE, m)):
                    gap = u_row[j] - scale * (h_row[j] - datum) - alpha
                    lowest = min(lowest, gap)
                worst = min(worst, lowest)
                if lowest < 0:
                    mark[tile] = 1
            k = rows[tile_row] * height * TILE + (i - i0) * TILE
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                for e in range(min(TILE, m - j)):
                    pressure = p[k + e]
                    if pressure > 0:
                        h = scale * (h_row[j + e] - datum)
                        total += pressure * abs(u_row[j + e] - h - alpha)
                        mark[tiles[t]] = 1
                k += height * TILE
    return total, worst


@loop
def fill_tiles(a, b, tiling, p, field, surface, alpha, new_tiling, new_p, new_r):
    """Copy p to the marked tiles, and set r to the gap u − h − α there."""
    height, rows, tiles = tiling
    heights, scale, datum = surface
    _, new_rows, new_tiles = new_tiling
    n, m = field.shape
    size = height * TILE
    for tile_row in range(a, b):
        i0 = tile_row * height
        old = rows[tile_row]
        for t in range(new_rows[tile_row], new_rows[tile_row + 1]):
            while old < rows[tile_row + 1] and tiles[old] < new_tiles[t]:
                old += 1
            known = old < rows[tile_row + 1] and tiles[old] == new_tiles[t]
            j = new_tiles[t] * TILE
            for i in range(i0, i0 + height):
                k = t * size + (i - i0) * TILE
                k_old = old * size + (i - i0) * TILE
                for e in range(TILE):
                    if i < n and j + e < m:
                        h = scale * (heights[i, j + e] - datum)
                        new_r[k + e] = field[i, j + e] - h - alpha
                        new_p[k + e] = p[k_old + e] if known else 0
                    else:
                        new_r[k + e] = NEVER_FREE
                        new_p[k + e] = 0
