"""What the iterations on a working set share: G, its preconditioner, and the loops' buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.free import make_operator
from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import relaxation, tiles
from roughbench.models.halfspace.preconditioner import CoarseSolver
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet


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
        self.operator = make_operator(shape, dtype, team, kernel)
        self.coarse = CoarseSolver(shape, dtype, kernel)
        self.weights = kernel.stencil(shape, dtype)
        self._one = self.dtype.type(1)
        self.scratch = np.zeros((shape[0] + 2, shape[1] + 2), dtype)
        # The direct sum where it may be used, and where it is used in this iteration.
        self._available: DirectOperator | None = None
        self.direct: DirectOperator | None = None

    def open(self, points: WorkingSet, direct: DirectOperator | None) -> None:
        """Start on a working set, with all its vectors but p and r zero."""
        self.points = points
        self.blocks, self.tile_blocks = self.team.split(points.rows)
        self.coarse.open(points, dense=direct is not None)
        self._available = direct
        self.choose_operator(points.n_contact)
        points.open_vectors()
        self.tiling, self.vectors = points.tiling, points.vectors

    def close(self) -> None:
        """Leave the working set with its pressures alone."""
        self.team.run(tiles.clear, self.blocks, self.points.tiling, self.scratch)
        self.points.keep_pressure()
        self._available = self.direct = None
        del self.points, self.vectors

    def choose_operator(self, n_sources: int) -> None:
        """Sum directly over this many points, or transform: whichever is cheaper."""
        direct = self._available
        cheaper = direct is not None and direct.is_cheaper(n_sources, self.points.tiles.size)
        self.direct = direct if cheaper else None

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
