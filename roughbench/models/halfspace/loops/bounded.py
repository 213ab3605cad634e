"""Loops of the conjugate gradients where the pressure has an upper bound too, the hardness.

A point is *elastic* where 0 < p < H. It is *free* if it is elastic, or empty (p = 0) with a
gap ρ = r − α < 0, or *plastic* (p = H) with ρ > 0. ``free`` holds 1 at these points, of the
flat vectors of a working set; the loops otherwise do what those of :mod:`.relaxation` and
:mod:`.vectors` do where there is no bound.
"""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import NEVER_FREE, TILE, copy_row, inlined, loop


@loop
def advance(a, b, tiling, vectors, free, cells, scratch, bound, alpha, t_p, t_r):
    """p += t_p s, kept within 0 … H; r += t_r y; mark the free points; split ρ by tiles.

    As :func:`.relaxation.advance`. ``bound`` is H, and the pressure from which on a point
    counts as plastic: a step to H may miss it by rounding errors. Returns Σp|ρ|, of plastic
    points only where they lift off; the lowest ρ where p < H; and how many plastic points
    are not free.
    """
    height, rows, tiles = tiling
    p, r, _, s, y = vectors
    count, force = cells
    hardness, almost = bound
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    size = height * TILE
    one = p.dtype.type(1)
    zero = one - one
    total = 0.0
    lowest = zero
    n_held = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            column = tiles[tile]
            n_free = sum_rho = product = held = zero
            for k in range(base, base + size):
                pressure = p[k] + t_p * s[k]
                pressure = pressure if pressure > np.float32(1e-6) * p[k] else zero
                pressure = pressure if pressure < almost else hardness
                p[k] = pressure
                residual = r[k] + t_r * y[k]
                r[k] = residual
                rho = residual - alpha
                plastic = pressure >= hardness
                open_to = (rho > 0) if plastic else ((pressure > 0) | (rho < 0))
                free[k] = 1 if open_to else 0
                n_free += one if open_to else zero
                sum_rho += rho if open_to else zero
                wrong = max(rho, zero) if plastic else abs(rho)
                product += pressure * wrong
                lowest = lowest if plastic else min(lowest, rho)
                held += one if plastic and not open_to else zero
            total += product
            n_held += held
            count[tile_row, column] = n_free
            force[tile_row, column] = sum_rho
            mean = sum_rho / n_free if n_free > 0 else zero
            for i in range(min(height, n - i0)):
                row = scratch[i0 + i + 1]
                k = base + i * TILE
                for e in range(min(TILE, m - column * TILE)):
                    rho = r[k + e] - alpha - mean
                    row[column * TILE + 1 + e] = rho if free[k + e] else zero
    return total, np.float64(lowest), n_held


@loop
def precondition(a, b, tiling, vectors, free, cells, scratch, weights, alpha):
    """z = (1 − Q) stencil (1 − Q) ρ + coarse solution, as :func:`.relaxation.precondition`."""
    height, rows, tiles = tiling
    _, r, d, z, y = vectors
    count, coarse = cells
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    w0, wx, wy, wd = weights[0], weights[1], weights[2], weights[3]
    size = height * TILE
    zero = alpha - alpha
    n_free = sum_z = sum_rho = sum_y = sum_d = sum_zrho = sum_zy = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            column = tiles[tile]
            free_here = count[tile_row, column]
            if free_here == 0:
                z[base : base + size] = zero
                continue
            tile_z = zero
            for i in range(min(height, n - i0)):
                north, here, south = scratch[i0 + i], scratch[i0 + i + 1], scratch[i0 + i + 2]
                k = base + i * TILE
                for e in range(min(TILE, m - column * TILE)):
                    c = column * TILE + e + 1
                    value = (
                        w0 * here[c]
                        + wx * (here[c - 1] + here[c + 1])
                        + wy * (north[c] + south[c])
                        + wd * (north[c - 1] + north[c + 1] + south[c - 1] + south[c + 1])
                    )
                    z[k + e] = value
                    tile_z += value if free[k + e] else zero
            lift = coarse[tile_row, column] - tile_z / free_here
            tile_z = tile_rho = tile_y = tile_d = tile_zrho = tile_zy = zero
            for k in range(base, base + size):
                if not free[k]:
                    z[k] = zero
                    continue
                rho = r[k] - alpha
                value = z[k] + lift
                z[k] = value
                tile_z += value
                tile_rho += rho
                tile_y += y[k]
                tile_d += d[k]
                tile_zrho += value * rho
                tile_zy += value * y[k]
            n_free += free_here
            sum_z += tile_z
            sum_rho += tile_rho
            sum_y += tile_y
            sum_d += tile_d
            sum_zrho += tile_zrho
            sum_zy += tile_zy
    return n_free, sum_z, sum_rho, sum_y, sum_d, sum_zrho, sum_zy


@loop
def use_residual(a, b, size, vectors, free, alpha):
    """s = ρ on free points, zero on the others; returns the number of these and Σs."""
    _, r, _, z, _ = vectors
    n_free = 0.0
    total = 0.0
    for k in range(a * size, b * size):
        value = r[k] - alpha
        z[k] = value if free[k] else value - value
        n_free += free[k]
        total += z[k]
    return n_free, total


@loop
def update_direction(a, b, size, vectors, free, beta, shift):
    """d = −z + βd + shift on free points, zero on the others."""
    _, _, d, z, _ = vectors
    zero = beta - beta
    for k in range(a * size, b * size):
        value = beta * d[k] - z[k] + shift
        d[k] = value if free[k] else zero


@loop
def tile_loads(a, b, size, p, d, free, tau, loads):
    """Set ``loads`` to Σ(p + τd) over the free points of each tile."""
    zero = tau - tau
    for tile in range(a, b):
        load = zero
        for k in range(tile * size, (tile + 1) * size):
            load += p[k] + tau * d[k] if free[k] else zero
        loads[tile] = load


@inlined
def _shift(p, d, free, base, size, hardness, tau, wanted):
    """How far to lower p + τd on the free points of a tile so that they carry ``wanted``.

    Newton's method within a bracket: what the points carry within 0 … H falls with the
    shift in straight pieces. Also returns what they carry then, what those between the
    bounds do, and how much more these and all free points could.
    """
    one = p.dtype.type(1)
    zero = one - one
    low, high = one / zero, -one / zero
    for k in range(base, base + size):
        trial = p[k] + tau * d[k]
        low = min(low, trial - hardness) if free[k] else low
        high = max(high, trial) if free[k] else high
    lower = load = inner_load = inner_room = room = zero
    for step in range(12):
        load = inner = inner_load = inner_room = room = zero
        for k in range(base, base + size):
            trial = p[k] + tau * d[k] - lower
            within = (trial > 0) & (trial < hardness)
            kept = min(max(trial, zero), hardness)
            if free[k]:
                load += kept
                room += hardness - kept
                inner += one if within else zero
                inner_load += kept if within else zero
                inner_room += hardness - kept if within else zero
        missed = load - wanted
        if abs(missed) <= np.float32(1e-6) * wanted or step == 11:
            break
        low = lower if missed > 0 else low
        high = lower if missed < 0 else high
        middle = (low + high) / (one + one)
        lower = lower + missed / inner if inner > 0 else middle
        lower = lower if (low <= lower) & (lower <= high) else middle
    return lower, load, inner_load, inner_room, room


@loop
def trial_step(a, b, tiling, vectors, free, field, dense, hardness, alpha, tau, targets):
    """Step s to a trial pressure near p + τd within 0 … H, with the wanted load in each tile.

    Within each tile the pressures p + τd are moved by the same amount, and the rest in
    proportion to p, or to H − p, so that the free points carry ``targets``. If ``dense``,
    the step is also written to ``field``. Returns Σsρ and how many points come to a bound.
    """
    height, rows, tiles = tiling
    p, r, d, s, _ = vectors
    n, m = field.shape
    size = height * TILE
    one = p.dtype.type(1)
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
            wanted = targets[tile]
            lower, load, inner_load, inner_room, room = _shift(
                p, d, free, base, size, hardness, tau, wanted
            )
            # What the shift has missed: in proportion, of the elastic points if they can.
            surplus = load - wanted
            fall = rise = one
            everywhere = (surplus >= inner_load) if surplus > 0 else (-surplus > inner_room)
            if surplus > 0:
                fall = wanted / load if everywhere else one - surplus / inner_load
            elif surplus < 0 and room > 0:
                rise = max(one + surplus / (room if everywhere else inner_room), zero)
            slope_here = lost = zero
            for k in range(base, base + size):
                pressure = p[k]
                kept = min(max(pressure + tau * d[k] - lower, zero), hardness)
                at_bound = (kept <= 0) | (kept >= hardness)
                if everywhere or not at_bound:
                    kept = fall * kept if surplus > 0 else hardness - rise * (hardness - kept)
                step = kept - pressure if free[k] else zero
                s[k] = step
                slope_here += step * (r[k] - alpha)
                was_elastic = (pressure > 0) & (pressure < hardness)
                lost += one if free[k] and at_bound and was_elastic else zero
            slope += slope_here
            clipped += lost
            for i in range(rows_here if dense else 0):
                j = tiles[tile] * TILE
                copy_row(s, base + i * TILE, field[i0 + i], j, min(TILE, m - j))
    return slope, clipped


@loop
def largest_step(a, b, size, p, s, hardness):
    """Largest t with 0 ≤ p + ts ≤ H."""
    one = p.dtype.type(1)
    reach = one / (one - one)
    for k in range(a * size, b * size):
        if s[k] < 0:
            reach = min(reach, -p[k] / s[k])
        elif s[k] > 0:
            reach = min(reach, (hardness - p[k]) / s[k])
    return np.float64(reach)


@loop
def elastic_sums(a, b, size, p, r, x, y, hardness):
    """Return Σxy, and over 0 < p < H the number of points, Σr and Σy."""
    zero = hardness - hardness
    one = p.dtype.type(1)
    curvature = n = sum_r = sum_y = 0.0
    for tile in range(a, b):
        tile_xy = tile_n = tile_r = tile_y = zero
        for k in range(tile * size, (tile + 1) * size):
            elastic = (p[k] > 0) & (p[k] < hardness)
            tile_xy += x[k] * y[k]
            tile_n += one if elastic else zero
            tile_r += r[k] if elastic else zero
            tile_y += y[k] if elastic else zero
        curvature += tile_xy
        n += tile_n
        sum_r += tile_r
        sum_y += tile_y
    return curvature, n, sum_r, sum_y


@loop
def plane_range(a, b, size, p, r, y, length, hardness):
    """Highest r + ty of plastic points and lowest of the others; −inf and inf for none."""
    highest, lowest = -np.inf, np.inf
    for k in range(a * size, b * size):
        if r[k] < NEVER_FREE / 2:
            residual = np.float64(r[k] + length * y[k])
            if p[k] >= hardness:
                highest = max(highest, residual)
            else:
                lowest = min(lowest, residual)
    return highest, lowest


@loop
def drop_residues(a, b, size, p, r, alpha, stiffness, hardness):
    """p = 0, or H, where ρ = r − α is more than what is missing to it could close alone.

    In that half of the pressures which is next to the bound.
    """
    for k in range(a * size, b * size):
        closed = stiffness * (r[k] - alpha)
        if p[k] < min(closed, hardness / 2):
            p[k] = 0
        elif hardness - p[k] < min(-closed, hardness / 2):
            p[k] = hardness
