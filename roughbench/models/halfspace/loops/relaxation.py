"""Loops of the conjugate gradients, in the order of one iteration."""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import (
    TILE,
    UNSIGNED_TILE,
    copy_row,
    inlined,
    loop,
)

_1, _2 = np.uint64(1), np.uint64(2)


@inlined
def _stencil(north, here, south, c, w0, wx, wy, wd):
    """3 × 3 stencil around column c of a grid with a halo, where it is column c + 1."""
    return (
        w0 * here[c + _1]
        + wx * (here[c] + here[c + _2])
        + wy * (north[c + _1] + south[c + _1])
        + wd * (north[c] + north[c + _2] + south[c] + south[c + _2])
    )


@inlined
def _centred(p, r, k, alpha, mean, zero):
    """ρ minus its tile's mean if point k is free, else zero."""
    rho = r[k] - alpha
    free = (p[k] > 0) | (rho < 0)
    rho -= mean
    return rho if free else zero


@loop
def advance(a, b, tiling, vectors, cells, scratch, one, alpha, t_p, t_r):
    """p += t_p s (not below zero), r += t_r y; split ρ = r − α on free points by tiles.

    The number of free points of each tile goes to ``count``, the sum of ρ over them to
    ``force``, and ρ minus its mean over them to ``scratch``. Returns Σp|ρ| and min ρ.
    """
    height, rows, tiles = tiling
    p, r, _, s, y = vectors
    count, force = cells
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    size = height * TILE
    zero = one - one
    total = 0.0
    # One minimum per place in a tile: no reduction. Its room keeps it apart from p … y.
    lowest = np.zeros(max(size, 256), p.dtype)
    for tile_row in range(a, b):
        i0 = tile_row * height
        rows_here = min(height, n - i0)
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            column = tiles[tile]
            j = column * TILE
            n_free = zero
            sum_rho = zero
            product = zero
            p_here, r_here = p[base : base + size], r[base : base + size]
            s_here, y_here = s[base : base + size], y[base : base + size]
            for k in range(size):
                pressure = p_here[k] + t_p * s_here[k]
                # A point that the step empties keeps no rounding residue of pressure.
                pressure = pressure if pressure > np.float32(1e-6) * p_here[k] else zero
                p_here[k] = pressure
                residual = r_here[k] + t_r * y_here[k]
                r_here[k] = residual
                rho = residual - alpha
                free = (pressure > 0) | (rho < 0)
                n_free += one if free else zero
                sum_rho += rho if free else zero
                product += pressure * abs(rho)
                lowest[k] = min(lowest[k], rho)
            total += product
            was_free = count[tile_row, column]
            count[tile_row, column] = n_free
            force[tile_row, column] = sum_rho
            if n_free == 0 and was_free == 0:
                continue
            mean = sum_rho / n_free if n_free > 0 else zero
            for i in range(rows_here):
                row = scratch[i0 + i + 1]
                k = np.uint64(base + i * TILE)
                c = np.uint64(j + 1)
                if j + TILE <= m:
                    for e in range(UNSIGNED_TILE):
                        row[c + e] = _centred(p, r, k + e, alpha, mean, zero)
                else:
                    for e in range(np.uint64(m - j)):
                        row[c + e] = _centred(p, r, k + e, alpha, mean, zero)
    return total, np.float64(lowest.min())


@loop
def precondition(a, b, tiling, vectors, cells, scratch, weights, alpha):
    """z = (1 − Q) stencil (1 − Q) ρ + coarse solution, on free points; z takes the place of s.

    Q takes the mean over the free points of each tile; ``scratch`` holds (1 − Q)ρ and
    ``coarse`` one value per tile. Returns the number of free points and, over them,
    Σz, Σρ, Σy, Σd, Σzρ, Σzy.
    """
    height, rows, tiles = tiling
    p, r, d, z, y = vectors
    count, coarse = cells
    one = p.dtype.type(1)
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    w0, wx, wy, wd = weights[0], weights[1], weights[2], weights[3]
    size = height * TILE
    zero = one - one
    smooth = np.empty((height, m), p.dtype)
    n_free = sum_z = sum_rho = sum_y = sum_d = sum_zrho = sum_zy = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        rows_here = min(height, n - i0)
        # Along whole rows the stencil compiles to vector instructions, seven times faster
        # than in rows of eight: worth it where a fourth of the row is wanted.
        dense = 4 * (rows[tile_row + 1] - rows[tile_row]) * TILE > m
        if dense:
            for i in range(rows_here):
                north, here, south = scratch[i0 + i], scratch[i0 + i + 1], scratch[i0 + i + 2]
                row = smooth[i]
                for j in range(np.uint64(m)):
                    row[j] = _stencil(north, here, south, j, w0, wx, wy, wd)
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            column = tiles[tile]
            free_here = count[tile_row, column]
            if free_here == 0:
                z[base : base + size] = zero
                continue
            j = column * TILE
            for i in range(rows_here):
                first = base + i * TILE
                if dense:
                    copy_row(smooth[i], j, z, first, min(TILE, m - j))
                    continue
                north, here, south = scratch[i0 + i], scratch[i0 + i + 1], scratch[i0 + i + 2]
                c, k = np.uint64(j), np.uint64(first)
                if j + TILE <= m:
                    for e in range(UNSIGNED_TILE):
                        z[k + e] = _stencil(north, here, south, c + e, w0, wx, wy, wd)
                else:
                    for e in range(np.uint64(m - j)):
                        z[k + e] = _stencil(north, here, south, c + e, w0, wx, wy, wd)
            p_here, r_here = p[base : base + size], r[base : base + size]
            d_here, y_here = d[base : base + size], y[base : base + size]
            z_here = z[base : base + size]
            tile_z = zero
            for k in range(size):
                free = (p_here[k] > 0) | (r_here[k] - alpha < 0)
                value = z_here[k]
                tile_z += value if free else zero
            lift = coarse[tile_row, column] - tile_z / free_here
            tile_rho = tile_y = tile_d = tile_zrho = tile_zy = zero
            tile_z = zero
            for k in range(size):
                rho = r_here[k] - alpha
                free = (p_here[k] > 0) | (rho < 0)
                rho = rho if free else zero
                value = z_here[k] + lift
                value = value if free else zero
                image = y_here[k]
                image = image if free else zero
                before = d_here[k]
                z_here[k] = value
                tile_z += value
                tile_rho += rho
                tile_y += image
                tile_d += before if free else zero
                tile_zrho += value * rho
                tile_zy += value * image
            n_free += free_here
            sum_z += tile_z
            sum_rho += tile_rho
            sum_y += tile_y
            sum_d += tile_d
            sum_zrho += tile_zrho
            sum_zy += tile_zy
    return n_free, sum_z, sum_rho, sum_y, sum_d, sum_zrho, sum_zy


@loop
def update_direction(a, b, tiling, vectors, count, alpha, beta, shift, tau):
    """d = −z + βd + shift on free points, zero on the others; Σ of the loads of the tiles.

    The load of a tile is Σ(p + τd), or zero where that is negative.
    """
    height, rows, tiles = tiling
    p, r, d, z, _ = vectors
    size = height * TILE
    zero = alpha - alpha
    total = 0.0
    for tile_row in range(a, b):
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            if count[tile_row, tiles[tile]] == 0:
                d[base : base + size] = zero
                continue
            p_here, r_here = p[base : base + size], r[base : base + size]
            z_here, d_here = z[base : base + size], d[base : base + size]
            load = zero
            for k in range(size):
                free = (p_here[k] > 0) | (r_here[k] - alpha < 0)
                value = beta * d_here[k] - z_here[k] + shift
                value = value if free else zero
                d_here[k] = value
                load += p_here[k] + tau * value
            total += max(load, zero)
    return total


@loop
def trial_step(a, b, tiling, vectors, count, field, dense, alpha, tau, scale):
    """Step s to a trial pressure near p + τd that is nowhere negative.

    If ``dense``, the step is also written to ``field``.

    Within each tile the pressures that p + τd leaves positive are lowered by the same
    amount (and the rest of the excess in proportion), so that the tile's load is
    ``scale``·Σ(p + τd) as if nothing had been clipped. Returns Σsρ and the number of
    points that lose all their pressure.
    """
    height, rows, tiles = tiling
    p, r, d, s, _ = vectors
    one = p.dtype.type(1)
    n, m = field.shape
    size = height * TILE
    zero = one - one
    slope = 0.0
    clipped = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        rows_here = min(height, n - i0)
        if dense and (rows[tile_row + 1] - rows[tile_row]) * TILE < m:
            for i in range(i0, i0 + rows_here):
                field[i, :] = 0
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            j = tiles[tile] * TILE
            width = min(TILE, m - j)
            if count[tile_row, tiles[tile]] == 0:
                if dense:
                    for i in range(rows_here):
                        field[i0 + i, j : j + width] = zero
                s[base : base + size] = zero
                continue
            p_here, r_here = p[base : base + size], r[base : base + size]
            s_here, d_here = s[base : base + size], d[base : base + size]
            load = above = n_above = zero
            for k in range(size):
                trial = p_here[k] + tau * d_here[k]
                load += trial
                above += trial if trial > 0 else zero
                n_above += one if trial > 0 else zero
            lower = max(above - load, zero) / n_above if n_above > 0 else zero
            left = zero
            for k in range(size):
                trial = p_here[k] + tau * d_here[k] - lower
                left += trial if trial > 0 else zero
            keep = scale * load / left if (load > 0) & (left > 0) else zero
            slope_here = lost = zero
            for k in range(size):
                pressure = p_here[k]
                trial = pressure + tau * d_here[k] - lower
                value = keep * trial
                value = (value if trial > 0 else zero) - pressure
                s_here[k] = value
                slope_here += value * (r_here[k] - alpha)
                lost += one if (pressure > 0) & (trial <= 0) else zero
            slope += slope_here
            clipped += lost
            for i in range(rows_here if dense else 0):
                copy_row(s, base + i * TILE, field[i0 + i], j, width)
    return slope, clipped


@loop
def gather_step(a, b, tiling, vectors, x, field, dense, one):
    """Return Σxy, and over p > 0 the number of points, Σr and Σy.

    If ``dense``, y is first taken over from ``field``.
    """
    height, rows, tiles = tiling
    p, r, _, _, y = vectors
    n, m = field.shape
    size = height * TILE
    zero = one - one
    curvature = n_contact = sum_r = sum_y = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        rows_here = min(height, n - i0)
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            j = tiles[tile] * TILE
            for i in range(rows_here if dense else 0):
                copy_row(field[i0 + i], j, y, base + i * TILE, min(TILE, m - j))
            p_here, r_here = p[base : base + size], r[base : base + size]
            x_here, y_here = x[base : base + size], y[base : base + size]
            tile_xy = tile_n = tile_r = tile_y = zero
            for k in range(size):
                loaded = p_here[k] > 0
                residual = r_here[k]
                image = y_here[k]
                tile_xy += x_here[k] * image
                tile_n += one if loaded else zero
                tile_r += residual if loaded else zero
                tile_y += image if loaded else zero
            curvature += tile_xy
            n_contact += tile_n
            sum_r += tile_r
            sum_y += tile_y
    return curvature, n_contact, sum_r, sum_y
