r"""Two-level preconditioner of G restricted to a contact set that changes.

A pressure on the free points is split into its mean over the free points of each
cell (a tile of 8 × 8 grid points; Q takes these means) and the rest:

.. math:: M = (1 - Q)\, S_{3×3}\, (1 - Q) + Z E^{-1} Z^T .

The rest sees little of the long-range coupling; the 3×3 stencil of |q|/2 inverts it.
The cell pressures (Z spreads them over the free points) see
:math:`E = Z^T G Z \approx N G_c N + D`, with N the number n of free points per cell, G_c
the kernel averaged over cells, and D the energy that n free points have beyond n
spread evenly over the cell, tabulated for half-filled cells. Two iterations of conjugate
gradients on the cells, preconditioned by a Fourier multiplier, are enough.

Why not the stencil alone: on a pressure s(x) that is smooth but lives on the contact
set, G responds with 2s/q, the stencil with a constant, so a few long waves need ever
more iterations as the grid grows. Iterations for a residual of 1e-6 on the contact set
of one surface (H = 0.7, q1 at the Nyquist wavevector, A/A0 = 0.21): stencil 30, 38, 50 at
N = 512, 1024, 2048; full |q|/2 restricted to the contact, one more transform pair per
iteration, about 10 % fewer; two levels 15, 17, 16.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import TILE
from roughbench.models.halfspace.love import love_influence
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid, tile_height
from roughbench.transform import RealTransform

MATRIX_ITERATIONS = 6
"""On few tiles, where the problem is a small matrix and preconditioned by its diagonal."""

COARSE_ITERATIONS, COARSE_ITERATIONS_LINE = 2, 16
"""On surfaces 1 costs up to half as many iterations again on the fine grid, 3 gain little.
On lines contacts of all sizes compete at all distances: 410, 180, 102, 83 and 85
iterations with 2, 4, 8, 16 and 32 (2^16 points, p = 0.01 E*)."""


@dataclass(frozen=True, slots=True)
class _CellMatrix:
    """Kernel between few tiles as a matrix, and the places of these among the cells."""

    place: tuple[NDArray[np.int64], NDArray[np.int32]]
    kernel: NDArray[Any]


class CoarseSolver:
    """Solves (N G_c N + D) y = f for the pressure y of the cells, which are the tiles.

    Parameters
    ----------
    shape : (int, int)
        Grid.
    dtype : dtype
        float32 or float64.
    kernel : Kernel

    Attributes
    ----------
    count, force : ndarray, shape of the tiles
        Free points of each tile; the right-hand side f.
    """

    def __init__(
        self, shape: tuple[int, int], dtype: DTypeLike, kernel: Kernel = HALF_SPACE
    ) -> None:
        cells = tile_grid(shape)
        self.count, self.force = np.zeros(cells, dtype), np.zeros(cells, dtype)
        self._cells = np.s_[: cells[0], : cells[1]]
        # The cells of a free half-space are padded with zeros, as its points are.
        period = (2 * cells[0], 2 * cells[1]) if kernel.free else cells
        self._transform = RealTransform(period, dtype, threads=1)
        self._matrix: _CellMatrix | None = None
        self._matrix_max = math.isqrt(shape[0] * shape[1] // 16)
        self._iterations = COARSE_ITERATIONS_LINE if shape[0] == 1 else COARSE_ITERATIONS
        self._tables((tile_height(shape), TILE), cells, kernel)

    def _tables(self, size: tuple[int, int], cells: tuple[int, int], kernel: Kernel) -> None:
        """Kernel between cells, and energy of n points in a cell beyond an even spread."""
        # Kernel on the lattice of cells: mean of G over two cells, as the sum over the
        # aliases of each wavevector.
        average = free_averaged_kernel if kernel.free else averaged_kernel
        self._kernel = average(cells, size, kernel)
        cells = self._transform.shape
        n_cells = cells[0] * cells[1]
        half = 2.0 * np.ones_like(self._kernel)
        half[:, 0] = 1.0
        if cells[1] % 2 == 0:
            half[:, -1] = 1.0
        self._self_compliance = float((half * self._kernel).sum()) / n_cells
        near = kernel.near(size)
        points = size[0] * size[1]
        rows, columns = np.divmod(np.arange(points), size[1])
        pair = near[np.abs(rows[:, None] - rows), np.abs(columns[:, None] - columns)]
        energy = np.zeros(points + 1)
        for k in range(1, points + 1):
            energy[k] = energy[k - 1] + pair[k - 1, k - 1] + 2 * pair[k - 1, : k - 1].sum()
        n = np.arange(points + 1)
        excess = np.maximum(energy - n**2 * (energy[-1] / points**2), 0.02 * energy)
        excess[0] = 1.0
        self._excess = excess.astype(self.count.dtype)
        self._kernel = (self._kernel / n_cells).astype(self.count.dtype)

    def open(self, points: WorkingSet, *, dense: bool) -> None:
        """Start on the tiles of a working set; with ``dense``, by a matrix between them.

        Not where so many tiles are in it that the matrix would take more than a sixteenth
        of the memory of a field, and its products longer than transforms of the cells.
        """
        self.count[:] = 0
        self.force[:] = 0
        self._matrix = None
        if dense and points.tiles.size <= self._matrix_max:
            place = points.places
            unit = np.zeros_like(self.force)
            unit[0, 0] = 1
            kernel = self._multiply(unit, self._kernel)
            (rows, columns), (n, m) = place, kernel.shape
            row_offsets = (rows[:, None] - rows) % n
            column_offsets = (columns[:, None] - columns) % m
            self._matrix = _CellMatrix(place, kernel[row_offsets, column_offsets])

    def solve(self) -> NDArray[Any]:
        """Return y, shape of the cells; zero in cells without free points."""
        if self._matrix is not None:
            return self._solve_by_matrix(self._matrix)
        occupied = self.count > 0
        index = np.minimum(self.count, self._excess.size - 1).astype(np.intp)
        excess = self._excess[index]
        uniform = self.count**2 * self.count.dtype.type(self._self_compliance)
        diagonal = excess + uniform
        # Share of the even spread in the diagonal: how much of it is long-ranged.
        share = float(np.clip((uniform[occupied] / diagonal[occupied]).mean(), 0.2, 0.95))
        n_cells = self._transform.real.size
        relative = self._kernel * (n_cells / self._self_compliance)
        smoother = (1.0 / ((share * relative + (1.0 - share)) * n_cells)).astype(relative.dtype)
        scale = np.where(occupied, 1.0 / np.sqrt(diagonal), 0.0).astype(self.count.dtype)
        y = np.zeros_like(self.force)
        if not self._self_compliance > 0.0:  # a single cell has no coarse problem
            return y
        residual = self.force.copy()
        z = scale * self._multiply(scale * residual, smoother)
        direction = z
        power = _dot(z, residual)
        for step in range(self._iterations):
            if not power > 0.0:
                break
            image = self.count * self._multiply(self.count * direction, self._kernel)
            image += np.where(occupied, excess, 0) * direction
            curvature = _dot(direction, image)
            if not curvature > 0.0:
                break
            length = power / curvature
            y += residual.dtype.type(length) * direction
            if step == self._iterations - 1:
                break
            residual -= residual.dtype.type(length) * image
            z = scale * self._multiply(scale * residual, smoother)
            previous, power = power, _dot(z, residual)
            direction = z + residual.dtype.type(power / previous) * direction
        return y

    def _solve_by_matrix(self, matrix: _CellMatrix) -> NDArray[Any]:
        """As :meth:`solve`, on the tiles of the working set alone."""
        count, force = self.count[matrix.place], self.force[matrix.place]
        excess = self._excess[np.minimum(count, self._excess.size - 1).astype(np.intp)]
        diagonal = excess + count**2 * self.count.dtype.type(self._self_compliance)
        scale = np.where(count > 0, 1.0 / diagonal, 0.0).astype(force.dtype)
        y = np.zeros_like(force)
        residual = force
        direction = y
        previous = math.inf
        for _ in range(MATRIX_ITERATIONS):
            z = scale * residual
            power = _dot(z, residual)
            if not power > 0.0:
                break
            direction = z + force.dtype.type(power / previous) * direction
            image = (
                count * (np.einsum("ij,j->i", matrix.kernel, count * direction))
                + excess * direction
            )
            curvature = _dot(direction, image)
            if not curvature > 0.0:
                break
            length = force.dtype.type(power / curvature)
            y += length * direction
            residual = residual - length * image
            previous = power
        result = np.zeros_like(self.force)
        result[matrix.place] = y
        return result

    def _multiply(self, values: NDArray[Any], multiplier: NDArray[Any]) -> NDArray[Any]:
        """Multiply the transform of ``values``; the result is overwritten by the next call."""
        real = self._transform.real
        if real.shape != values.shape:
            real[...] = 0
        np.copyto(real[self._cells], values)
        self._transform.forward()
        self._transform.spectral *= multiplier
        self._transform.backward()
        return real[self._cells]


def _dot(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Return Σab without BLAS, whose threads would spin on the cores that transforms need."""
    return float(np.einsum("i,i->", a.ravel(), b.ravel()))


def averaged_kernel(
    cells: tuple[int, int], size: tuple[int, int], kernel: Kernel = HALF_SPACE
) -> NDArray[np.float64]:
    """Half spectrum of G between cells of ``size`` points, with zero mean.

    In real space: the displacement averaged over one cell by a unit force spread evenly
    over another.
    """

    # Σ over the aliases q + 2πk/size of G(q) |box(q)|², box being the mean over a cell.
    def axis(n: int, b: int, *, half: bool) -> tuple[NDArray[Any], NDArray[Any]]:
        k = np.arange(n // 2 + 1) if half else np.fft.fftfreq(n, 1 / n)
        q = 2 * math.pi * (k[None, :] / n + np.arange(b)[:, None]) / b
        q = (q + math.pi) % (2 * math.pi) - math.pi
        with np.errstate(invalid="ignore", divide="ignore"):
            box = np.where(q == 0, 1.0, np.sin(q * b / 2) / (b * np.sin(q / 2)))
        return np.abs(q), box**2

    qy, by = axis(cells[0], size[0], half=False)
    qx, bx = axis(cells[1], size[1], half=True)
    total = np.zeros((cells[0], cells[1] // 2 + 1))
    for i in range(size[0]):
        for j in range(size[1]):
            q = kernel.wavenumber(qy[i][:, None], qx[j])
            if i == j == 0:
                q[0, 0] = math.inf
            total += 2.0 / q * by[i][:, None] * bx[j]
    average: NDArray[np.float64] = total / (size[0] * size[1])
    return average


def free_averaged_kernel(
    cells: tuple[int, int], size: tuple[int, int], kernel: Kernel
) -> NDArray[np.float64]:
    """As :func:`averaged_kernel`, of a free half-space, for cells padded to twice as many.

    Exact for cells that are at most two apart. Beyond, the displacement in the centre of a
    cell stands for its mean: within 0.5 % on square points, 9 % on those of 1 × 10.
    """
    rows, columns = cells[0] + 1, cells[1] + 1
    # In points of the size of a cell; a unit force on one of them is spread over its area.
    aspect = kernel.aspect * size[1] / size[0]
    average = love_influence((rows, columns), aspect) / size[1]
    near = kernel.near((3 * size[0], 3 * size[1]))
    for i in range(min(3, rows)):
        for j in range(min(3, columns)):
            average[i, j] = _pair_mean(near, (i * size[0], j * size[1]), size)
    mirrored = [np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n)) for n in cells]
    spectrum: NDArray[np.float64] = np.fft.rfft2(average[np.ix_(*mirrored)]).real
    return np.maximum(spectrum, 0.0)


def _pair_mean(
    near: NDArray[np.float64], offset: tuple[int, int], size: tuple[int, int]
) -> float:
    """Mean of G between the points of two cells at an offset."""
    # As many pairs of points as cells overlap have each difference.
    weights = [1.0 - np.abs(np.arange(1 - n, n)) / n for n in size]
    places = [np.abs(at + np.arange(1 - n, n)) for at, n in zip(offset, size, strict=True)]
    total = weights[0] @ near[np.ix_(*places)] @ weights[1]
    return float(total) / (size[0] * size[1])
