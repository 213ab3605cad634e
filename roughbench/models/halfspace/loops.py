"""Fused loops of the exact solver: one pass over memory each, sums in float64.

A *working set* is a list of tiles of the grid, 8 × 8 points (a line: 1 × 8), tile row
by tile row: those of tile row I are ``tiles[rows[I]:rows[I + 1]]``, increasing tile
columns. Vectors on it are flat, tile after tile, each row by row, so that the innermost
loops run over 8 adjacent numbers and need no index. Where the grid ends inside a tile,
the points beyond it have p = 0 and r = ``NEVER``.

A point is *free* if p > 0 or ρ = r − α < 0. ``field`` is a dense (n, m) array;
``scratch`` is one with a halo of one point, zero off the free points. ``one`` is 1 in the
working precision: sums over a tile are taken in that precision, sums over tiles in
float64. Values are computed for every point and then selected, which compiles to vector
instructions where a branch would not.

Every loop works on tile rows, or tiles, or grid rows ``a`` to ``b``, releases the
interpreter lock and returns its sums, so that :class:`Team` can run several blocks at
once and add the sums in block order.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from roughbench.models._compiled import compiled

TILE = 8
"""Points per tile and direction."""

NEVER = 1e30
"""Residual of points that can never be free."""

STEEPEST = 0.75
"""Of two points in a row at a free edge, where p = A√s, the outer one carries at most 1/√2 of
what the inner one does; at an edge that the heights prescribe the pressure does not fall."""

STEP, NARROW_STEP = 4.0, 30.0
"""Bend of the heights at a prescribed edge, in units of pΔ/E*, at least: in contacts of three
or more points, and of two. A heuristic, chosen on punches, plateaus and stairs against rough
surfaces with 2, 4 and 8 points on the shortest wave (H = 0.3 to 0.9, A = 1e-3 to 0.98), of
whose 191,000, 116,000 and 68,000 edges it takes 0.09, 0.011 and 0.0015 % for prescribed."""

# Sums may be reordered, and minima taken, by vector instructions. Infinities keep their
# meaning; a NaN still reaches the sums that the solver checks.
_FLAGS = {"reassoc", "contract", "arcp", "nsz", "nnan"}
_loop = compiled(nogil=True, error_model="numpy", fastmath=_FLAGS)
_inline = numba.njit(inline="always", error_model="numpy", fastmath=_FLAGS)

Blocks = Sequence[tuple[int, int]]


class Team:
    """Runs a loop over blocks on a fixed number of threads.

    The calling thread takes the last block. Idle threads sleep, they do not spin.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def split(self, rows: NDArray[np.int64]) -> tuple[Blocks, Blocks]:
        """Blocks of tile rows that share the tiles evenly, and the tiles of each."""
        targets = np.linspace(0, rows[-1], self.threads + 1)[1:-1]
        inner = np.searchsorted(rows, targets)
        ends = [0, *(int(i) for i in inner), len(rows) - 1]
        row_blocks = list(itertools.pairwise(ends))
        return row_blocks, [(int(rows[a]), int(rows[b])) for a, b in row_blocks]

    def even(self, n_rows: int) -> Blocks:
        """Blocks of equally many rows."""
        ends = np.linspace(0, n_rows, self.threads + 1).astype(int).tolist()
        return list(itertools.pairwise(ends))

    def run(self, loop: Callable[..., Any], blocks: Blocks, *args: Any) -> list[Any]:
        """Run ``loop(a, b, *args)`` for every block; results in block order."""
        if self._pool is None:
            return [loop(a, b, *args) for a, b in blocks]
        others = [self._pool.submit(loop, a, b, *args) for a, b in blocks[:-1]]
        last = loop(*blocks[-1], *args)
        return [*(other.result() for other in others), last]

    def sum(self, loop: Callable[..., Any], blocks: Blocks, *args: Any) -> NDArray[np.float64]:
        """Run ``loop`` and add its sums in block order."""
        return np.add.reduce(np.array(self.run(loop, blocks, *args), dtype=np.float64), axis=0)


def wrap_halo(scratch: NDArray[Any]) -> None:
    """Fill the halo periodically."""
    scratch[0] = scratch[-2]
    scratch[-1] = scratch[1]
    scratch[:, 0] = scratch[:, -2]
    scratch[:, -1] = scratch[:, 1]


# Loops over whole tiles go through views, and rows of eight through unsigned indices: of an
# index that cannot be negative the compiler makes vector instructions.
_1, _2, _TILE = np.uint64(1), np.uint64(2), np.uint64(TILE)


@_inline
def _copy(source, i, target, j, width):
    """target[j : j + width] = source[i : i + width], for at most eight values."""
    k, c = np.uint64(i), np.uint64(j)
    if width == TILE:
        for e in range(_TILE):
            target[c + e] = source[k + e]
    else:
        for e in range(np.uint64(width)):
            target[c + e] = source[k + e]


@_inline
def _stencil(north, here, south, c, w0, wx, wy, wd):
    """3 × 3 stencil around column c of a grid with a halo, where it is column c + 1."""
    return (
        w0 * here[c + _1]
        + wx * (here[c] + here[c + _2])
        + wy * (north[c + _1] + south[c + _1])
        + wd * (north[c] + north[c + _2] + south[c] + south[c + _2])
    )


@_inline
def _centred(p, r, k, alpha, mean, zero):
    """ρ minus its tile's mean if point k is free, else zero."""
    rho = r[k] - alpha
    free = (p[k] > 0) | (rho < 0)
    rho -= mean
    return rho if free else zero


# -- dense fields ------------------------------------------------------------------------


@_loop
def multiply_by_kernel(a, b, spectral, qy_squared, qx_squared, factor, exponent):
    """Multiply rows of a half spectrum by ``factor·|q|**exponent`` (±1), zero at q = 0."""
    for i in range(a, b):
        row = spectral[i]
        y = qy_squared[i]
        if exponent < 0:
            for j in range(row.shape[0]):
                row[j] *= factor / np.sqrt(y + qx_squared[j])
        else:
            for j in range(row.shape[0]):
                row[j] *= factor * np.sqrt(y + qx_squared[j])
    if a == 0:
        spectral[0, 0] = 0.0


@_loop
def traction_at_full_contact(a, b, field, heights, height_scale, datum):
    """Lowest value of the traction in ``field``, and its product sum with the heights."""
    lowest = np.inf
    product = 0.0
    for i in range(a, b):
        row = field[i]
        h_row = heights[i]
        for j in range(row.shape[0]):
            lowest = min(lowest, row[j])
            product += row[j] * height_scale * (h_row[j] - datum)
    return lowest, product


@_loop
def gap_at_full_contact(a, b, traction, field, heights, height_scale, datum):
    """Σσ, Σ|g|, Σσ|g| and max(−g) of the traction σ and the gap g = u − h; u = field."""
    total = 0.0
    gap = 0.0
    moment = 0.0
    deepest = 0.0
    for i in range(a, b):
        sigma, u_row, h_row = traction[i], field[i], heights[i]
        for j in range(h_row.shape[0]):
            g = u_row[j] - height_scale * (h_row[j] - datum)
            total += sigma[j]
            gap += abs(g)
            moment += sigma[j] * abs(g)
            deepest = max(deepest, -g)
    return total, gap, moment, deepest


@_loop
def overlap_sums(a, b, heights, height_scale, datum, plane):
    """Σmax(h − d, 0) for a plane at height d, and the number of points above it."""
    total = 0.0
    n = 0.0
    for i in range(a, b):
        row = heights[i]
        for j in range(row.shape[0]):
            overlap = height_scale * (row[j] - datum) - plane
            above = overlap > 0
            total += overlap if above else 0.0
            n += 1.0 if above else 0.0
    return total, n


@_loop
def dense_gap(a, b, field, heights, height_scale, datum, alpha, gap):
    """Dense gap u − h − α."""
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        g_row = gap[i]
        for j in range(h_row.shape[0]):
            g_row[j] = u_row[j] - height_scale * (h_row[j] - datum) - alpha


# -- between fields and working sets -------------------------------------------------------


@_loop
def scatter(a, b, height, rows, tiles, values, field):
    """Dense tile rows that are ``values`` on the working set and zero elsewhere."""
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
                _copy(values, k, row, j, min(TILE, m - j))
                k += height * TILE


@_loop
def gap_sums(a, b, height, rows, tiles, p, field, heights, height_scale, datum):
    """Σp, Σp(u − h) and Σpu over the working set; u = field."""
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
                    moment += pressure * (u - height_scale * (h_row[j + e] - datum))
                    energy += pressure * u
                k += height * TILE
    return mass, moment, energy


@_loop
def open_gap(a, b, height, rows, tiles, p, field, heights, height_scale, datum, alpha):
    """Σ of the gap u − h − α, where it is positive, over the points without pressure."""
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
                    total += max(u_row[j] - height_scale * (h_row[j] - datum) - alpha, 0.0)
    return (total,)


@_loop
def choose_tiles(
    a,
    b,
    height,
    rows,
    tiles,
    p,
    field,
    heights,
    height_scale,
    datum,
    alpha,
    chosen,
):
    """Mark the tiles with a point under pressure or of negative gap u − h − α.

    ``chosen`` has the shape of the tiles. Returns Σp|gap| and the most negative gap of
    all points.
    """
    n, m = field.shape
    total = 0.0
    worst = 0.0
    for tile_row in range(a, b):
        mark = chosen[tile_row]
        mark[:] = 0
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            u_row = field[i]
            h_row = heights[i]
            for tile in range(mark.shape[0]):
                j0 = tile * TILE
                lowest = np.inf
                for j in range(j0, min(j0 + TILE, m)):
                    gap = u_row[j] - height_scale * (h_row[j] - datum) - alpha
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
                        h = height_scale * (h_row[j + e] - datum)
                        total += pressure * abs(u_row[j + e] - h - alpha)
                        mark[tiles[t]] = 1
                k += height * TILE
    return total, worst


@_loop
def fill_tiles(
    a,
    b,
    height,
    rows,
    tiles,
    p,
    field,
    heights,
    height_scale,
    datum,
    alpha,
    new_rows,
    new_tiles,
    new_p,
    new_r,
):
    """Carry p over to the chosen tiles, and set r to the gap u − h − α there."""
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
                        h = height_scale * (heights[i, j + e] - datum)
                        new_r[k + e] = field[i, j + e] - h - alpha
                        new_p[k + e] = p[k_old + e] if known else 0
                    else:
                        new_r[k + e] = NEVER
                        new_p[k + e] = 0


@_loop
def clear(a, b, height, rows, tiles, scratch):
    """Set ``scratch`` to zero on the working set."""
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            row = scratch[i + 1]
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                row[j + 1 : min(j + TILE, m) + 1] = 0


@_loop
def spread_pressure(a, b, height, rows, tiles, p, scratch):
    """Write p to ``scratch`` on the working set."""
    n, m = scratch.shape[0] - 2, scratch.shape[1] - 2
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            row = scratch[i + 1]
            k = rows[tile_row] * height * TILE + (i - i0) * TILE
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j = tiles[t] * TILE
                _copy(p, k, row, j + 1, min(TILE, m - j))
                k += height * TILE


@_loop
def _is_free(i, j, di, dj, scratch, heights, height_scale):
    """Whether the edge between point (i, j) and (i + di, j + dj), outside, is free."""
    n, m = heights.shape
    p = scratch[i + 1, j + 1]
    behind = scratch[i + 1 - di, j + 1 - dj]
    if not (behind > 0 and p > STEEPEST * behind):
        return True
    beyond = scratch[(i - 2 * di) % n + 1, (j - 2 * dj) % m + 1]
    sides = max(scratch[i + 1 - dj, j + 1 - di], scratch[i + 1 + dj, j + 1 + di])
    h = np.float64(heights[i, j])
    inner = heights[(i - di) % n, (j - dj) % m]
    outer = heights[(i + di) % n, (j + dj) % m]
    bend = height_scale * ((h - inner) + (h - outer))
    least = STEP if beyond > 0 else NARROW_STEP
    return bend <= least * max(max(p, behind), max(sides, beyond))


@_loop
def boundary_edges(a, b, height, rows, tiles, scratch, heights, height_scale):
    """Points with p > 0, and free grid edges between these and others.

    ``scratch`` holds p, with its halo. For what is free see
    :meth:`.relaxation.Relaxation.count_edges`.
    """
    n, m = heights.shape
    contact = 0.0
    free = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        for i in range(i0, min(i0 + height, n)):
            north, here, south = scratch[i], scratch[i + 1], scratch[i + 2]
            for t in range(rows[tile_row], rows[tile_row + 1]):
                j0 = tiles[t] * TILE
                for j in range(j0, min(j0 + TILE, m)):
                    c = j + 1
                    if not here[c] > 0:
                        continue
                    contact += 1.0
                    if north[c] == 0 and _is_free(i, j, -1, 0, scratch, heights, height_scale):
                        free += 1.0
                    if south[c] == 0 and _is_free(i, j, 1, 0, scratch, heights, height_scale):
                        free += 1.0
                    if here[c - 1] == 0 and _is_free(
                        i, j, 0, -1, scratch, heights, height_scale
                    ):
                        free += 1.0
                    if here[c + 1] == 0 and _is_free(
                        i, j, 0, 1, scratch, heights, height_scale
                    ):
                        free += 1.0
    return contact, free


@_loop
def direct_sum(
    a, b, height, tops, lefts, source_rows, source_columns, values, n, m, shift, table, image
):
    """``image`` on tiles a … b = Σ values G over the source points.

    ``tops`` and ``lefts`` are the first grid rows and columns of the tiles. Entry (k, i, j)
    of ``table`` is G at i rows and 8k + j − ``shift`` columns from its source.
    """
    size = height * TILE
    for tile in range(a, b):
        total = image[tile * size : (tile + 1) * size]
        total[:] = 0
        for source in range(values.size):
            value = values[source]
            column = lefts[tile] - source_columns[source] + shift
            if column < 0:
                column += m
            elif column >= m:
                column -= m
            strip = table[column // TILE]
            c = np.uint64(column % TILE)
            for i in range(height):
                offset = abs(tops[tile] + i - source_rows[source])
                if offset >= n:
                    offset -= n
                row = strip[min(offset, n - offset)]
                k = np.uint64(i * TILE)
                for e in range(_TILE):
                    total[k + e] += value * row[c + e]


@_loop
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


# -- one iteration of the relaxation, in this order ------------------------------------------


@_loop
def advance(a, b, height, rows, tiles, one, t_p, t_r, alpha, p, r, s, y, count, force, scratch):
    """p += t_p s (not below zero), r += t_r y; split ρ = r − α on free points by tiles.

    The number of free points of each tile goes to ``count``, the sum of ρ over them to
    ``force``, and ρ minus its mean over them to ``scratch``. Returns Σp|ρ| and min ρ.
    """
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
                    for e in range(_TILE):
                        row[c + e] = _centred(p, r, k + e, alpha, mean, zero)
                else:
                    for e in range(np.uint64(m - j)):
                        row[c + e] = _centred(p, r, k + e, alpha, mean, zero)
    return total, np.float64(lowest.min())


@_loop
def precondition(
    a, b, height, rows, tiles, one, p, r, alpha, scratch, weights, count, coarse, y, d, z
):
    """z = (1 − Q) stencil (1 − Q) ρ + coarse solution, on free points.

    Q takes the mean over the free points of each tile; ``scratch`` holds (1 − Q)ρ and
    ``coarse`` one value per tile. Returns the number of free points and, over them,
    Σz, Σρ, Σy, Σd, Σzρ, Σzy.
    """
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
                    _copy(smooth[i], j, z, first, min(TILE, m - j))
                    continue
                north, here, south = scratch[i0 + i], scratch[i0 + i + 1], scratch[i0 + i + 2]
                c, k = np.uint64(j), np.uint64(first)
                if j + TILE <= m:
                    for e in range(_TILE):
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


@_loop
def use_residual(a, b, size, one, p, r, alpha, z):
    """z = ρ on free points, zero on the others; returns the number of these and Σz."""
    zero = one - one
    n_free = 0.0
    total = 0.0
    for tile in range(a, b):
        base = tile * size
        p_here, r_here = p[base : base + size], r[base : base + size]
        z_here = z[base : base + size]
        n_here = here = zero
        for k in range(size):
            rho = r_here[k] - alpha
            free = (p_here[k] > 0) | (rho < 0)
            rho = rho if free else zero
            z_here[k] = rho
            n_here += one if free else zero
            here += rho
        n_free += n_here
        total += here
    return n_free, total


@_loop
def turn(a, b, height, rows, tiles, p, r, alpha, z, beta, shift, tau, count, d):
    """d = −z + βd + shift on free points, zero on the others; Σ of the loads of the tiles.

    The load of a tile is Σ(p + τd), or zero where that is negative.
    """
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
    return total, 0.0


@_loop
def trial_load(a, b, size, p, d, tau):
    """Σ of the loads of the tiles, as :func:`turn` returns it."""
    zero = tau - tau
    total = 0.0
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        d_here = d[tile * size : (tile + 1) * size]
        load = zero
        for k in range(size):
            load += p_here[k] + tau * d_here[k]
        total += max(load, zero)
    return total, 0.0


@_loop
def trial_step(
    a, b, height, rows, tiles, one, p, r, alpha, d, tau, scale, count, s, dense, field
):
    """Step s to a trial pressure near p + τd that is nowhere negative.

    If ``dense``, the step is also written to ``field``.

    Within each tile the pressures that p + τd leaves positive are lowered by the same
    amount (and the rest of the excess in proportion), so that the tile's load is
    ``scale``·Σ(p + τd) as if nothing had been clipped. Returns Σsρ and the number of
    points that lose all their pressure.
    """
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
                _copy(s, base + i * TILE, field[i0 + i], j, width)
    return slope, clipped


@_loop
def gather_step(a, b, height, rows, tiles, one, dense, field, p, r, s, y):
    """Return Σsy, and over p > 0 the number of points, Σr and Σy.

    If ``dense``, y is first taken over from ``field``.
    """
    n, m = field.shape
    size = height * TILE
    zero = one - one
    curvature = contact = sum_r = sum_y = 0.0
    for tile_row in range(a, b):
        i0 = tile_row * height
        rows_here = min(height, n - i0)
        for tile in range(rows[tile_row], rows[tile_row + 1]):
            base = tile * size
            j = tiles[tile] * TILE
            for i in range(rows_here if dense else 0):
                _copy(field[i0 + i], j, y, base + i * TILE, min(TILE, m - j))
            p_here, r_here = p[base : base + size], r[base : base + size]
            s_here, y_here = s[base : base + size], y[base : base + size]
            tile_sy = tile_n = tile_r = tile_y = zero
            for k in range(size):
                loaded = p_here[k] > 0
                residual = r_here[k]
                image = y_here[k]
                tile_sy += s_here[k] * image
                tile_n += one if loaded else zero
                tile_r += residual if loaded else zero
                tile_y += image if loaded else zero
            curvature += tile_sy
            contact += tile_n
            sum_r += tile_r
            sum_y += tile_y
    return curvature, contact, sum_r, sum_y


@_loop
def mark_contact(a, b, size, p, value, r):
    """r = ``value`` where p > 0, ``NEVER`` elsewhere."""
    for k in range(a * size, b * size):
        r[k] = value if p[k] > 0 else NEVER


@_loop
def add(a, b, size, factor, values, total):
    """total += factor·values."""
    for tile in range(a, b):
        values_here = values[tile * size : (tile + 1) * size]
        total_here = total[tile * size : (tile + 1) * size]
        for k in range(size):
            total_here[k] += factor * values_here[k]


@_loop
def largest_step(a, b, size, one, p, s):
    """Largest t with p + ts ≥ 0."""
    far = one / (one - one)
    reach = np.full(size, far, p.dtype)
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        s_here = s[tile * size : (tile + 1) * size]
        for k in range(size):
            ratio = -p_here[k] / s_here[k]
            reach[k] = min(reach[k], ratio if s_here[k] < 0 else far)
    return np.float64(reach.min())


@_loop
def drop_residues(a, b, size, p, r, alpha, stiffness):
    """p = 0 where a gap ρ = r − α > 0 is more than p could close alone, p < ``stiffness``·ρ."""
    for k in range(a * size, b * size):
        if p[k] < stiffness * (r[k] - alpha):
            p[k] = 0


@_loop
def contact_sums(a, b, size, one, p, r):
    """Return the number of points with p > 0 and Σr over them."""
    zero = one - one
    n = 0.0
    total = 0.0
    for tile in range(a, b):
        p_here = p[tile * size : (tile + 1) * size]
        r_here = r[tile * size : (tile + 1) * size]
        n_here = here = zero
        for k in range(size):
            loaded = p_here[k] > 0
            n_here += one if loaded else zero
            residual = r_here[k]
            here += residual if loaded else zero
        n += n_here
        total += here
    return n, total
