"""Loops of the relaxation with the gap as unknown, over dense fields, whole rows at a time.

A point is *free* if its gap g is positive or its traction w negative. ``masked`` has a halo
of one point and holds ωw on the free points, zero elsewhere, ω being the weight of a point;
``cells`` has one value for each block of ``CELL`` × ``CELL`` points. Every loop works on rows
``a`` to ``b`` of cells, if nothing else is said.
"""

from __future__ import annotations

import numpy as np

from roughbench.models.halfspace.loops import TILE, copy_row, inlined, loop

CELL = 4
"""Points per cell and direction; a tile is a whole number of cells."""


@inlined
def _sum_cells(row, sums):
    """Add the values of ``row``, which has a halo, to those of the cells."""
    m = row.shape[0] - 2
    for cell in range(np.uint64(m // CELL)):
        j = np.uint64(CELL) * cell
        sums[cell] += (
            row[j + np.uint64(1)]
            + row[j + np.uint64(2)]
            + row[j + np.uint64(3)]
            + row[j + np.uint64(4)]
        )
    for j in range(m - m % CELL, m):
        sums[m // CELL] += row[j + 1]


@loop
def start(a, b, surface, u, alpha, factor, g, w, error):
    """Gap g where there is no pressure, and by how much it differs from that of ``u``.

    ``w`` holds the pressure, and is multiplied by ``factor`` as ``u`` is.
    """
    heights, scale, datum = surface
    n, m = g.shape
    for i in range(CELL * a, min(CELL * b, n)):
        u_row, h_row = u[i], heights[i]
        for j in range(m):
            gap = factor * u_row[j] - scale * (h_row[j] - datum) - alpha
            pressure = factor * w[i, j]
            kept = 0.0 if pressure > 0 else max(gap, 0.0)
            g[i, j] = kept
            w[i, j] = pressure
            error[i, j] = kept - gap


@loop
def advance(a, b, fields, weight, masked, cells, one, tau, length):
    """g += length·s with s = max(g + τd, 0) − g, w += length·y; ωw of the free points."""
    g, w, d, y = fields
    n, m = g.shape
    zero = one - one
    for block in range(a, b):
        sums = cells[block]
        sums[:] = 0
        for i in range(CELL * block, min(CELL * block + CELL, n)):
            g_row, w_row, d_row, y_row, row = g[i], w[i], d[i], y[i], masked[i + 1]
            weights = weight[i]
            for j in range(np.uint64(m)):
                before = g_row[j]
                trial = before + tau * d_row[j]
                trial = trial if trial > 0 else zero
                value = before + length * (trial - before)
                # A point that the step closes keeps no rounding residue of a gap.
                value = value if value > np.float32(1e-6) * before else zero
                g_row[j] = value
                traction = w_row[j] + length * y_row[j]
                w_row[j] = traction
                free = (value > 0) | (traction < 0)
                weighted = weights[j] * traction
                row[j + np.uint64(1)] = weighted if free else zero
            _sum_cells(row, sums)


@loop
def weigh(a, b, masked, by_count, weight):
    """ω of a point by the number of free points among it and its eight neighbours."""
    n, m = weight.shape
    count = np.empty(m + 2, np.uint8)
    for i in range(CELL * a, min(CELL * b, n)):
        north, here, south, row = masked[i], masked[i + 1], masked[i + 2], weight[i]
        for j in range(np.uint64(m + 2)):
            count[j] = (
                np.uint8(north[j] != 0) + np.uint8(here[j] != 0) + np.uint8(south[j] != 0)
            )
        for j in range(m):
            row[j] = by_count[count[j] + count[j + 1] + count[j + 2]]


@loop
def precondition(a, b, masked, weight, cells, y, weights):
    r"""z = ω (stencil of ``masked`` + ``cells``) on the free points, in place of y.

    Returns Σzw and Σzy over the free points, and the largest \|z\|.
    """
    n, m = y.shape
    w0, wx, wy, wd = weights[0], weights[1], weights[2], weights[3]
    zero = w0 - w0
    lift = np.empty(m, y.dtype)
    one, two = np.uint64(1), np.uint64(2)
    power = product = 0.0
    largest = zero
    for block in range(a, b):
        values = cells[block]
        for j in range(m):
            lift[j] = values[j // CELL]
        for i in range(CELL * block, min(CELL * block + CELL, n)):
            north, here, south, y_row = masked[i], masked[i + 1], masked[i + 2], y[i]
            omega = weight[i]
            row_power = row_product = zero
            for j in range(np.uint64(m)):
                traction = here[j + one]  # weighted
                value = (
                    lift[j]
                    + w0 * traction
                    + wx * (here[j] + here[j + two])
                    + wy * (north[j + one] + south[j + one])
                    + wd * (north[j] + north[j + two] + south[j] + south[j + two])
                )
                value = value if traction != 0 else zero
                row_power += value * traction
                value *= omega[j]
                row_product += value * y_row[j]
                largest = max(largest, abs(value))
                y_row[j] = value
            power += row_power
            product += row_product
    return power, product, np.float64(largest)


@loop
def turn(a, b, fields, masked, beta, tau):
    """d = βd − z on the free points, z being in the place of y; then the trial step.

    Returns what :func:`try_step` does.
    """
    g, w, d, y = fields
    n, m = g.shape
    zero = beta - beta
    slope = lost = 0.0
    for i in range(CELL * a, min(CELL * b, n)):
        g_row, w_row, d_row, y_row, row = g[i], w[i], d[i], y[i], masked[i + 1]
        row_slope = row_lost = zero
        one = np.uint64(1)
        for j in range(np.uint64(m)):
            direction = beta * d_row[j] - y_row[j]
            direction = direction if row[j + one] != 0 else zero
            d_row[j] = direction
            before = g_row[j]
            trial = before + tau * direction
            closed = trial <= 0
            step = (zero if closed else trial) - before
            y_row[j] = step
            row_slope += step * w_row[j]
            row_lost += before if closed else zero
        slope += row_slope
        lost += row_lost
    return slope, lost


@loop
def try_step(a, b, fields, tau):
    """Write the trial step s = max(g + τd, 0) − g in the place of y.

    Returns Σsw, and Σg over the points that it closes.
    """
    g, w, d, y = fields
    n, m = g.shape
    zero = tau - tau
    slope = lost = 0.0
    for i in range(CELL * a, min(CELL * b, n)):
        g_row, w_row, d_row, y_row = g[i], w[i], d[i], y[i]
        row_slope = row_lost = zero
        for j in range(np.uint64(m)):
            before = g_row[j]
            trial = before + tau * d_row[j]
            closed = trial <= 0
            step = (zero if closed else trial) - before
            y_row[j] = step
            row_slope += step * w_row[j]
            row_lost += before if closed else zero
        slope += row_slope
        lost += row_lost
    return slope, lost


@loop
def largest_step(a, b, fields, tau):
    """Largest t with g + ts ≥ 0 for the trial step s."""
    g, _, d, _ = fields
    n, m = g.shape
    zero = tau - tau
    reach = np.inf
    for i in range(CELL * a, min(CELL * b, n)):
        g_row, d_row = g[i], d[i]
        for j in range(m):
            before = g_row[j]
            trial = before + tau * d_row[j]
            step = (trial if trial > 0 else zero) - before
            if step < 0:
                reach = min(reach, -before / step)
    return reach


@loop
def keep_pressure(a, b, g, w, stiffness, height, marked):
    """Leave in w the pressure of the points in contact alone, and mark their tiles.

    Contact is where w > 0 and the gap is less than w alone would open, ``stiffness``·g < w.
    What the other points of a tile carry, which is little but would be an error of long
    waves, is added to its contact in proportion. Works on rows of tiles.
    """
    n, m = g.shape
    zero = stiffness - stiffness
    for tile_row in range(a, b):
        mark = marked[tile_row]
        i0, i1 = tile_row * height, min((tile_row + 1) * height, n)
        for tile in range(mark.shape[0]):
            j0, j1 = TILE * tile, min(TILE * tile + TILE, m)
            load = kept = zero
            for i in range(i0, i1):
                g_row, w_row = g[i], w[i]
                for j in range(j0, j1):
                    traction = w_row[j]
                    loaded = (traction > 0) & (stiffness * g_row[j] < traction)
                    load += traction
                    kept += traction if loaded else zero
                    w_row[j] = traction if loaded else zero
            mark[tile] = kept > 0
            if (kept > 0) & (load > 0):
                factor = load / kept
                for i in range(i0, i1):
                    w_row = w[i]
                    for j in range(j0, j1):
                        w_row[j] *= factor


@loop
def gather(a, b, tiling, field, values):
    """Take ``values`` on the tiles from a dense field; zero beyond the grid."""
    height, rows, tiles = tiling
    n, m = field.shape
    for tile_row in range(a, b):
        for t in range(rows[tile_row], rows[tile_row + 1]):
            j = tiles[t] * TILE
            width = min(TILE, m - j)
            for e in range(height):
                i = tile_row * height + e
                k = (t * height + e) * TILE
                if i < n:
                    copy_row(field[i], j, values, k, width)
                    for c in range(width, TILE):
                        values[k + c] = 0
                else:
                    for c in range(TILE):
                        values[k + c] = 0


@loop
def advance_frozen(a, b, fields, closed, weight, masked, cells, one, length):
    """v += length·d, r += length·y; ωr of the open points to ``masked``."""
    v, r, d, y = fields
    n, m = v.shape
    zero = one - one
    for block in range(a, b):
        sums = cells[block]
        sums[:] = 0
        for i in range(CELL * block, min(CELL * block + CELL, n)):
            v_row, r_row, d_row, y_row, row = v[i], r[i], d[i], y[i], masked[i + 1]
            shut, weights = closed[i], weight[i]
            for j in range(np.uint64(m)):
                v_row[j] += length * d_row[j]
                residual = r_row[j] + length * y_row[j]
                r_row[j] = residual
                weighted = weights[j] * residual
                row[j + np.uint64(1)] = zero if shut[j] else weighted
            _sum_cells(row, sums)


@loop
def turn_frozen(a, b, fields, masked, beta):
    """d = βd − z on the open points, z being in the place of y, which takes d over."""
    _, _, d, y = fields
    n, m = d.shape
    zero = beta - beta
    for i in range(CELL * a, min(CELL * b, n)):
        d_row, y_row, row = d[i], y[i], masked[i + 1]
        for j in range(np.uint64(m)):
            direction = beta * d_row[j] - y_row[j]
            direction = direction if row[j + np.uint64(1)] != 0 else zero
            d_row[j] = direction
            y_row[j] = direction
