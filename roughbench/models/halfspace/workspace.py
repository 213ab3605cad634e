"""What the iterations on a working set share: G, its preconditioner, and the loops' buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.direct import DirectOperator, cost_of_transforms
from roughbench.models.halfspace.free import make_operator
from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import relaxation, tiles, vectors
from roughbench.models.halfspace.preconditioner import CoarseSolver
from roughbench.models.halfspace.split import SMALLEST_GRID, SplitOperator
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet

SPLIT_MAX_FRACTION = 1e-2
"""Fraction of points under pressure from which on a split sum is not considered."""


class Workspace:
    """G and its preconditioner at one precision; between ``open`` and ``close`` on one set.

    Parameters
    ----------
    shape : (int, int)
        Grid.
    dtype : dtype
        float32 or float64.
    team : ThreadTeam
    kernel : Kernel
    """

    points: WorkingSet

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: DTypeLike,
        team: ThreadTeam,
        kernel: Kernel = HALF_SPACE,
    ) -> None:
        self.team = team
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        self.shape = shape
        self.kernel = kernel
        self.operator = make_operator(shape, dtype, team, kernel)
        self.coarse = CoarseSolver(shape, dtype, kernel)
        self.weights = kernel.stencil(shape, dtype)
        self._one = self.dtype.type(1)
        self.scratch = np.zeros((shape[0] + 2, shape[1] + 2), dtype)
        self._split: SplitOperator | None = None
        # The sums that may be used, and the one that is used in this iteration.
        self._sums: list[DirectOperator | SplitOperator] = []
        self.direct: DirectOperator | SplitOperator | None = None

    def open(self, points: WorkingSet, direct: DirectOperator | None) -> None:
        """Start on a working set, with all its vectors but p and r zero."""
        self.points = points
        self.blocks, self.tile_blocks = self.team.split(points.rows)
        split = self._open_split(points, direct)
        self._sums = [one for one in (direct, split) if one is not None]
        self.coarse.open(points, dense=bool(self._sums))
        self.choose_operator(points.n_contact)
        points.open_vectors()
        self.tiling, self.vectors = points.tiling, points.vectors

    def close(self) -> None:
        """Leave the working set with its pressures alone."""
        self.team.run(tiles.clear, self.blocks, self.points.tiling, self.scratch)
        self.points.keep_pressure()
        self._sums, self.direct = [], None
        del self.points, self.vectors

    def choose_operator(self, n_sources: int) -> None:
        """Sum over this many points in one way or the other, or transform: what is cheapest."""
        least, self.direct = cost_of_transforms(self.shape), None
        for one in self._sums:
            cost = one.cost(n_sources, self.points.tiles.size)
            if cost < least:
                least, self.direct = cost, one

    def _open_split(
        self, points: WorkingSet, direct: DirectOperator | None
    ) -> SplitOperator | None:
        """Return the split sum, where it is what is cheapest on this working set."""
        if (
            self.kernel != HALF_SPACE
            or self.dtype != np.float32
            or min(self.shape) < SMALLEST_GRID
            or points.n_contact >= SPLIT_MAX_FRACTION * self.operator.field.size
        ):
            return None
        if self._split is None:
            self._split = SplitOperator(self.shape, self.team)
        most = cost_of_transforms(self.shape)
        if direct is not None:
            most = min(most, direct.cost(points.n_contact, points.tiles.size))
        return self._split if self._split.open(points, most) else None

    def advance(self, alpha: float, p_length: float, r_length: float) -> list[Any]:
        """p += length·s, r += length·y; returns what :func:`.relaxation.advance` returns."""
        number = self.dtype.type
        return self.team.run(
            relaxation.advance,
            self.blocks,
            *(self.tiling, self.vectors, (self.coarse.count, self.coarse.force)),
            *(self.scratch, self._one, number(alpha), number(p_length), number(r_length)),
        )

    def precondition(self, alpha: float) -> NDArray[np.float64]:
        """s = M ρ on free points; returns the sums of :func:`.relaxation.precondition`."""
        if self.operator.periodic:
            tiles.wrap_halo(self.scratch)
        cells = self.coarse.count, self.coarse.solve()
        return self.team.sum(
            relaxation.precondition,
            self.blocks,
            *(self.tiling, self.vectors, cells, self.scratch, self.weights),
            self.dtype.type(alpha),
        )

    def update_direction(self, alpha: float, beta: float, shift: float, tau: float) -> float:
        """d ← −s + βd + shift on free points; returns Σ of the loads of the tiles at p + τd."""
        number = self.dtype.type
        loads = self.team.run(
            relaxation.update_direction,
            self.blocks,
            *(self.tiling, self.vectors, self.coarse.count),
            *(number(alpha), number(beta), number(shift), number(tau)),
        )
        return float(sum(loads))

    def trial_load(self, tau: float) -> float:
        """Σ of the loads of the tiles at p + τd, as :meth:`update_direction` returns it."""
        w = self.points
        return float(
            sum(
                self.team.run(
                    vectors.trial_load,
                    self.tile_blocks,
                    *(w.tile_size, w.p, w.d, self.dtype.type(tau)),
                )
            )
        )

    def trial_step(
        self, alpha: float, tau: float, trial: float, total: float
    ) -> tuple[float, float]:
        """Set s, and the field to it where G takes transforms; Σsρ and the points lost.

        ``trial`` is Σ of the loads of the tiles at p + τd, ``total`` what it has to be.
        """
        number = self.dtype.type
        slope, clipped = self.team.sum(
            relaxation.trial_step,
            self.blocks,
            *(self.tiling, self.vectors, self.coarse.count),
            *(self.operator.field, self.direct is None),
            *(number(alpha), number(tau), number(total / trial)),
        )
        return slope, clipped

    def use_residual(self, alpha: float) -> NDArray[np.float64]:
        """s = ρ on free points; returns the number of these and Σs."""
        number = self.dtype.type
        return self.team.sum(
            vectors.use_residual,
            self.tile_blocks,
            *(self.points.tile_size, self.vectors, number(1), number(alpha)),
        )

    def largest_step(self) -> float:
        """Largest t for which p + ts is allowed everywhere."""
        w = self.points
        return min(self.team.run(vectors.largest_step, self.tile_blocks, w.tile_size, w.p, w.s))

    def contact_sums(self) -> NDArray[np.float64]:
        """Return the number of points that α is a mean of, and Σr over them."""
        w = self.points
        return self.team.sum(vectors.contact_sums, self.tile_blocks, w.tile_size, w.p, w.r)

    def plane(
        self, n_contact: float, sum_r: float, length: float = 0.0, sum_y: float = 0.0
    ) -> float:
        """α after a step of this length along s, from sums over the contact before."""
        return (sum_r + length * sum_y) / n_contact

    def drop_residues(self, alpha: float) -> None:
        """Empty the points whose pressure is less than what their gap takes away."""
        w = self.points
        self.team.run(
            vectors.drop_residues,
            self.tile_blocks,
            *(w.tile_size, w.p, w.r, self.dtype.type(alpha), self.weights[0]),
        )

    def image(self, x: NDArray[Any]) -> NDArray[np.float64]:
        """y = G x on the tiles; returns Σxy, and over the contact its size, Σr and Σy."""
        if self.direct is None:
            self.team.run(tiles.scatter, self.blocks, self.tiling, x, self.operator.field)
        return self._image(x)

    def image_of_step(self) -> NDArray[np.float64]:
        """As :meth:`image`, of s, which the field holds already where G takes transforms."""
        return self._image(self.points.s)

    def _image(self, x: NDArray[Any]) -> NDArray[np.float64]:
        w = self.points
        if self.direct is None:
            self.operator.displace()
        else:
            self.direct.apply(w, x, w, w.y)
        return self.team.sum(
            relaxation.gather_step,
            self.blocks,
            *(self.tiling, self.vectors, x),
            *(self.operator.field, self.direct is None, self._one),
        )
