"""Fused loops of the exact solver: one pass over memory each, sums in float64.

A *working set* lists the grid points that may carry pressure, row by row: the points of
row i are ``columns[rows[i]:rows[i + 1]]``, increasing. Vectors on it are compressed to
its length; ``field`` is a dense (n, m) array. Every loop works on rows ``a`` to ``b``
(vectors: entries ``a`` to ``b``), releases the interpreter lock and returns its sums, so
that :class:`Team` can run several row blocks at once and add the sums in block order.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

# Sums may be reordered for vector instructions; NaN and infinity keep their meaning.
_loop = numba.njit(
    nogil=True, cache=True, error_model="numpy", fastmath={"reassoc", "contract", "arcp", "nsz"}
)

Blocks = Sequence[tuple[int, int]]


class Team:
    """Runs a loop over row blocks on a fixed number of threads.

    The calling thread takes the last block. Idle threads sleep, they do not spin.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def split(
        self, rows: NDArray[np.int64], cell_starts: NDArray[np.int64]
    ) -> tuple[Blocks, Blocks]:
        """Row blocks that share the points of a working set evenly, and their entries.

        Blocks begin at ``cell_starts``, the first rows of the rows of cells.
        """
        targets = np.linspace(0, rows[-1], self.threads + 1)[1:-1]
        inner = cell_starts[np.searchsorted(rows[cell_starts[:-1]], targets)]
        ends = [0, *(int(i) for i in inner), len(rows) - 1]
        row_blocks = list(itertools.pairwise(ends))
        entries = [(int(rows[a]), int(rows[b])) for a, b in row_blocks]
        return row_blocks, entries

    def even(self, n_rows: int) -> Blocks:
        """Row blocks of equal height, for dense loops."""
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
def scatter(a, b, rows, columns, values, field):
    """Dense rows that are ``values`` on the working set and zero elsewhere."""
    for i in range(a, b):
        row = field[i]
        row[:] = 0.0
        for k in range(rows[i], rows[i + 1]):
            row[columns[k]] = values[k]


@_loop
def traction_at_full_contact(a, b, field, heights, height_scale, height_mean):
    """Lowest value of the traction in ``field``, and its product sum with the heights."""
    lowest = np.inf
    product = 0.0
    for i in range(a, b):
        row = field[i]
        h_row = heights[i]
        for j in range(row.shape[0]):
            lowest = min(lowest, row[j])
            product += row[j] * height_scale * (h_row[j] - height_mean)
    return lowest, product


@_loop
def contact_sums(a, b, p, r):
    """Return the number of points in contact and Σr over them."""
    n = 0
    total = 0.0
    for k in range(a, b):
        if p[k] > 0:
            n += 1
            total += r[k]
    return float(n), total


@_loop
def restrict_residual(
    a, b, rows, columns, p, r, alpha, scratch, row_cells, column_cells, count, force
):
    """Split ρ = r − α on free points into its mean per cell and the rest.

    Free points are those with p > 0 or ρ < 0. The number of free points of each cell goes
    to ``count``, the sum of ρ over them to ``force``, and ρ minus its cell mean to
    ``scratch``, which has a halo of one point and is zero everywhere else. The block
    ``a`` … ``b`` holds whole rows of cells. Returns Σp|ρ| and min ρ.
    """
    total = 0.0
    worst = 0.0
    i = a
    while i < b:
        cell = row_cells[i]
        end = i
        n_here = count[cell]
        sum_here = force[cell]
        n_here[:] = 0
        sum_here[:] = 0
        while end < b and row_cells[end] == cell:
            for k in range(rows[end], rows[end + 1]):
                rho = r[k] - alpha
                if p[k] > 0 or rho < 0:
                    c = column_cells[columns[k]]
                    n_here[c] += 1
                    sum_here[c] += rho
                    total += p[k] * abs(rho)
                    worst = min(worst, np.float64(rho))
            end += 1
        for row_index in range(i, end):
            row = scratch[row_index + 1]
            for k in range(rows[row_index], rows[row_index + 1]):
                rho = r[k] - alpha
                j = columns[k]
                if p[k] > 0 or rho < 0:
                    c = column_cells[j]
                    row[j + 1] = rho - sum_here[c] / n_here[c]
                else:
                    row[j + 1] = 0
        i = end
    return total, worst


@_loop
def clear(a, b, rows, columns, scratch):
    """Set ``scratch`` (with halo) to zero on the working set."""
    for i in range(a, b):
        row = scratch[i + 1]
        for k in range(rows[i], rows[i + 1]):
            row[columns[k] + 1] = 0


def wrap_halo(scratch: NDArray[Any]) -> None:
    """Fill the halo periodically."""
    scratch[0] = scratch[-2]
    scratch[-1] = scratch[1]
    scratch[:, 0] = scratch[:, -2]
    scratch[:, -1] = scratch[:, 1]


@_loop
def precondition(
    a,
    b,
    rows,
    columns,
    p,
    r,
    alpha,
    scratch,
    weights,
    row_cells,
    column_cells,
    count,
    coarse,
    cell_sums,
    y,
    d,
    z,
):
    """z = (1 − Q) stencil (1 − Q) ρ + coarse solution, on free points.

    Q takes the mean over the free points of each cell; ``scratch`` holds (1 − Q)ρ and
    ``coarse`` one value per cell. Returns the number of free points and, over them,
    Σz, Σρ, Σy, Σd, Σzρ, Σzy.
    """
    w0, wx, wy, wd = weights[0], weights[1], weights[2], weights[3]
    n = 0
    sum_z = sum_rho = sum_y = sum_d = sum_zrho = sum_zy = 0.0
    i = a
    while i < b:
        cell = row_cells[i]
        end = i
        sum_here = cell_sums[cell]
        sum_here[:] = 0
        while end < b and row_cells[end] == cell:
            north, here, south = scratch[end], scratch[end + 1], scratch[end + 2]
            for k in range(rows[end], rows[end + 1]):
                if p[k] > 0 or r[k] - alpha < 0:
                    j = columns[k] + 1
                    value = (
                        w0 * here[j]
                        + wx * (here[j - 1] + here[j + 1])
                        + wy * (north[j] + south[j])
                        + wd * (north[j - 1] + north[j + 1] + south[j - 1] + south[j + 1])
                    )
                    z[k] = value
                    sum_here[column_cells[j - 1]] += value
            end += 1
        for row_index in range(i, end):
            for k in range(rows[row_index], rows[row_index + 1]):
                rho = r[k] - alpha
                if p[k] > 0 or rho < 0:
                    c = column_cells[columns[k]]
                    value = z[k] + (coarse[cell, c] - sum_here[c] / count[cell, c])
                    z[k] = value
                    n += 1
                    sum_z += value
                    sum_rho += rho
                    sum_y += y[k]
                    sum_d += d[k]
                    sum_zrho += np.float64(value) * rho
                    sum_zy += np.float64(value) * y[k]
                else:
                    z[k] = 0
        i = end
    return float(n), sum_z, sum_rho, sum_y, sum_d, sum_zrho, sum_zy


@_loop
def new_direction(a, b, p, r, alpha, z, beta, shift, tau, d):
    """d = −z + βd + shift on free points, zero on the others.

    Returns Σdρ and Σmax(p + τd, 0).
    """
    slope = 0.0
    total = 0.0
    for k in range(a, b):
        rho = r[k] - alpha
        if p[k] > 0 or rho < 0:
            value = beta * d[k] - z[k] + shift
            slope += np.float64(value) * rho
        else:
            value = 0 * rho
        d[k] = value
        trial = p[k] + tau * value
        if trial > 0:
            total += trial
    return slope, total


@_loop
def trial_sum(a, b, p, d, tau):
    """Σmax(p + τd, 0)."""
    total = 0.0
    for k in range(a, b):
        trial = p[k] + tau * d[k]
        if trial > 0:
            total += trial
    return total, 0.0


@_loop
def trial_step(a, b, rows, columns, p, r, alpha, d, tau, scale, s, field):
    """s = scale·max(p + τd, 0) − p, also as dense rows of ``field``.

    Returns Σsρ, the number of clipped points and the largest feasible step along s.
    """
    slope = 0.0
    clipped = 0
    reach = np.inf
    for i in range(a, b):
        row = field[i]
        row[:] = 0
        for k in range(rows[i], rows[i + 1]):
            trial = p[k] + tau * d[k]
            if trial > 0:
                value = scale * trial - p[k]
            else:
                value = -p[k]
                clipped += p[k] > 0
            s[k] = value
            row[columns[k]] = value
            slope += np.float64(value) * (r[k] - alpha)
            if value < 0:
                reach = min(reach, p[k] / -np.float64(value))
    return slope, float(clipped), reach


@_loop
def gather_step(a, b, rows, columns, field, s, y):
    """y = field on the working set; returns Σsy."""
    curvature = 0.0
    for i in range(a, b):
        row = field[i]
        for k in range(rows[i], rows[i + 1]):
            value = row[columns[k]]
            y[k] = value
            curvature += np.float64(s[k]) * value
    return curvature, 0.0


@_loop
def advance(a, b, t, s, y, p, r):
    """p += ts (not below zero), r += ty; returns the contact sums of the new state."""
    n = 0
    total = 0.0
    for k in range(a, b):
        pressure = p[k] + t * s[k]
        r[k] += t * y[k]
        # A point that the step empties keeps no rounding residue of pressure.
        if pressure > 1e-6 * p[k]:
            p[k] = pressure
            n += 1
            total += r[k]
        else:
            p[k] = 0
    return float(n), total


@_loop
def axpy(a, b, factor, x, y):
    """y += factor·x."""
    for k in range(a, b):
        y[k] += factor * x[k]


@_loop
def overlap_sums(a, b, heights, height_scale, height_mean, plane):
    """Σmax(h − d, 0) for a plane at height d, and the number of points above it."""
    total = 0.0
    n = 0
    for i in range(a, b):
        row = heights[i]
        for j in range(row.shape[0]):
            overlap = height_scale * (row[j] - height_mean) - plane
            if overlap > 0:
                total += overlap
                n += 1
    return total, float(n)


@_loop
def sparse_gap_sums(a, b, rows, columns, p, field, heights, height_scale, height_mean):
    """Σp, Σp(u − h) and Σpu over the working set; u = field."""
    mass = 0.0
    moment = 0.0
    energy = 0.0
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        for k in range(rows[i], rows[i + 1]):
            j = columns[k]
            u = np.float64(u_row[j])
            mass += p[k]
            moment += p[k] * (u - height_scale * (h_row[j] - height_mean))
            energy += p[k] * u
    return mass, moment, energy


@_loop
def count_working_set(
    a, b, rows, columns, p, field, heights, height_scale, height_mean, alpha, counts
):
    """Count, per row, the points with p > 0 or gap u − h − α < 0.

    Returns Σ p|gap| and the most negative gap of all points.
    """
    total = 0.0
    worst = 0.0
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        n = 0
        for j in range(h_row.shape[0]):
            gap = u_row[j] - height_scale * (h_row[j] - height_mean) - alpha
            n += gap < 0
            worst = min(worst, np.float64(gap))
        for k in range(rows[i], rows[i + 1]):
            if p[k] > 0:
                j = columns[k]
                gap = u_row[j] - height_scale * (h_row[j] - height_mean) - alpha
                n += not gap < 0
                total += p[k] * abs(gap)
        counts[i] = n
    return total, worst


@_loop
def fill_working_set(
    a,
    b,
    rows,
    columns,
    p,
    field,
    heights,
    height_scale,
    height_mean,
    alpha,
    new_rows,
    new_columns,
    new_p,
    new_r,
):
    """List the points that :func:`count_working_set` counted; carry p over.

    ``new_r`` becomes u − h − α, the gap above the plane, at these points.
    """
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        old = rows[i]
        end = rows[i + 1]
        k = new_rows[i]
        for j in range(h_row.shape[0]):
            gap = u_row[j] - height_scale * (h_row[j] - height_mean) - alpha
            listed = old < end and columns[old] == j
            if gap < 0 or (listed and p[old] > 0):
                new_columns[k] = j
                new_r[k] = gap
                new_p[k] = p[old] if listed else 0
                k += 1
            if listed:
                old += 1
    return 0.0, 0.0


@_loop
def boundary_edges(a, b, rows, columns, p, n_columns, vertical):
    """Grid edges between contact (p > 0) and no contact, in rows ``a`` to ``b``.

    Horizontal neighbours are compared within a row, and each row with the next one if
    ``vertical``; both periodic. Returns the number of points in contact and of edges.
    """
    n_rows = rows.shape[0] - 1
    n_contact = 0
    joined = 0
    for i in range(a, b):
        previous = -2
        first = -2
        for k in range(rows[i], rows[i + 1]):
            if p[k] > 0:
                j = columns[k]
                n_contact += 1
                joined += j == previous + 1
                if first < 0:
                    first = j
                previous = j
        joined += first == 0 and previous == n_columns - 1
        if vertical:
            i_next = (i + 1) % n_rows
            m = rows[i_next]
            for k in range(rows[i], rows[i + 1]):
                if p[k] > 0:
                    while m < rows[i_next + 1] and columns[m] < columns[k]:
                        m += 1
                    if m < rows[i_next + 1] and columns[m] == columns[k]:
                        joined += p[m] > 0
    sides = 4 if vertical else 2
    return float(n_contact), float(sides * n_contact - 2 * joined)


@_loop
def residual_vector(a, b, p, r, alpha, z):
    """z = ρ on free points, zero on the others."""
    for k in range(a, b):
        rho = r[k] - alpha
        z[k] = rho if p[k] > 0 or rho < 0 else 0 * rho


@_loop
def dense_gap(a, b, field, heights, height_scale, height_mean, alpha, gap):
    """Dense gap u − h − α."""
    for i in range(a, b):
        u_row = field[i]
        h_row = heights[i]
        g_row = gap[i]
        for j in range(h_row.shape[0]):
            g_row[j] = u_row[j] - height_scale * (h_row[j] - height_mean) - alpha
