"""Relaxation with an upper bound on the pressure: the hardness H of a plastic material.

A point is empty (p = 0), elastic (0 < p < H) or plastic (p = H). Optimal are a gap of at least
zero at empty points, of zero at elastic ones, and of at most zero at plastic ones: by so much
the material has given way for good. Iterations, preconditioner and step search are those of
:mod:`.relaxation`; what differs is here and in :mod:`.loops.bounded`: which points are free,
that α is the mean over elastic points alone, and that a trial step is clipped on both sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.loops import bounded, tiles
from roughbench.models.halfspace.plastic import plane_between, scaled_within
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet
from roughbench.models.halfspace.workspace import Workspace


class BoundedWorkspace(Workspace):
    """A workspace on which pressures stay within 0 … H.

    Parameters
    ----------
    shape, dtype, team
        As of :class:`Workspace`.
    hardness : float
        H, a number that ``dtype`` holds exactly.
    """

    def __init__(
        self, shape: tuple[int, int], dtype: DTypeLike, team: ThreadTeam, hardness: float
    ) -> None:
        super().__init__(shape, dtype, team)
        self._hardness = self.dtype.type(hardness)
        almost = self._hardness * (1 - 4 * np.finfo(self.dtype).eps)
        self._bound = self._hardness, self.dtype.type(almost)
        self._n_held = 0.0

    def open(self, points: WorkingSet, direct: DirectOperator | None) -> None:
        """Start on a working set; :meth:`advance` finds the free points."""
        super().open(points, direct)
        self._free = np.zeros(points.p.size, np.uint8)
        self._loads = np.zeros(points.tiles.size, self.dtype)

    def close(self) -> None:
        """Leave the working set with its pressures alone."""
        super().close()
        del self._free, self._loads

    def advance(self, alpha: float, p_length: float, r_length: float) -> list[Any]:
        """As :meth:`Workspace.advance`; a plastic point is wrong only where it lifts off."""
        number = self.dtype.type
        parts = self.team.run(
            bounded.advance,
            self.blocks,
            *(self.tiling, self.vectors, self._free),
            *((self.coarse.count, self.coarse.force), self.scratch, self._bound),
            *(number(alpha), number(p_length), number(r_length)),
        )
        self._n_held = sum(part[2] for part in parts)
        return parts

    def precondition(self, alpha: float) -> NDArray[np.float64]:
        """s = M ρ on free points; returns the sums of :func:`.relaxation.precondition`."""
        tiles.wrap_halo(self.scratch)
        cells = self.coarse.count, self.coarse.solve()
        return self.team.sum(
            bounded.precondition,
            self.blocks,
            *(self.tiling, self.vectors, self._free, cells, self.scratch, self.weights),
            self.dtype.type(alpha),
        )

    def update_direction(self, alpha: float, beta: float, shift: float, tau: float) -> float:
        """d ← −s + βd + shift on free points; returns what :meth:`trial_load` does."""
        del alpha
        number = self.dtype.type
        self.team.run(
            bounded.update_direction,
            self.tile_blocks,
            *(self.points.tile_size, self.vectors, self._free, number(beta), number(shift)),
        )
        return self.trial_load(tau)

    def trial_load(self, tau: float) -> float:
        """Σ of the loads that the tiles can bear of p + τd, plastic points included."""
        self._find_loads(tau)
        return float(np.clip(self._loads, 0, self._capacities()).sum(dtype=np.float64)) + (
            self._n_held * float(self._hardness)
        )

    def trial_step(
        self, alpha: float, tau: float, trial: float, total: float
    ) -> tuple[float, float]:
        """As :meth:`Workspace.trial_step`, clipped at H as well, where points are lost too."""
        del trial
        number = self.dtype.type
        wanted = total - self._n_held * float(self._hardness)
        slope, clipped = self.team.sum(
            bounded.trial_step,
            self.blocks,
            *(self.tiling, self.vectors, self._free),
            *(self.operator.field, self.direct is None),
            *(self._hardness, number(alpha), number(tau), self._targets(wanted)),
        )
        return slope, clipped

    def use_residual(self, alpha: float) -> NDArray[np.float64]:
        """s = ρ on free points; returns the number of these and Σs."""
        return self.team.sum(
            bounded.use_residual,
            self.tile_blocks,
            *(self.points.tile_size, self.vectors, self._free, self.dtype.type(alpha)),
        )

    def largest_step(self) -> float:
        """Largest t for which 0 ≤ p + ts ≤ H everywhere."""
        w = self.points
        return min(
            self.team.run(
                bounded.largest_step,
                self.tile_blocks,
                *(w.tile_size, w.p, w.s, self._hardness),
            )
        )

    def contact_sums(self) -> NDArray[np.float64]:
        """Return the number of elastic points, and Σr over them."""
        return self._elastic_sums(self.points.y)[1:3]

    def plane(
        self, n_contact: float, sum_r: float, length: float = 0.0, sum_y: float = 0.0
    ) -> float:
        """α after a step, a mean over elastic points; without these, between the others."""
        if n_contact > 0:
            return super().plane(n_contact, sum_r, length, sum_y)
        w = self.points
        parts = self.team.run(
            bounded.plane_range,
            self.tile_blocks,
            *(w.tile_size, w.p, w.r, w.y, self.dtype.type(length), self._hardness),
        )
        return plane_between(parts)

    def drop_residues(self, alpha: float) -> None:
        """Empty, or fill, the points next to a bound that their gap takes to it.

        Not where the elastic points left could not make up for that load.
        """
        del alpha  # of the contact before the last step; here what counts is the present one
        w = self.points
        alpha = self.plane(*self.contact_sums())
        w.y[:] = w.p
        self.team.run(
            bounded.drop_residues,
            self.tile_blocks,
            *(w.tile_size, w.p, w.r, self.dtype.type(alpha), self.weights[0], self._hardness),
        )
        change = float((w.p - w.y).sum(dtype=np.float64))
        elastic = w.p[(w.p > 0) & (w.p < self._hardness)]
        load = float(elastic.sum(dtype=np.float64))
        if not -change <= 0.5 * (float(self._hardness) * elastic.size - load) or not (
            change <= 0.5 * load
        ):
            w.p[:] = w.y

    def _image(self, x: NDArray[Any]) -> NDArray[np.float64]:
        super()._image(x)
        return self._elastic_sums(x)

    def _elastic_sums(self, x: NDArray[Any]) -> NDArray[np.float64]:
        w = self.points
        return self.team.sum(
            bounded.elastic_sums,
            self.tile_blocks,
            *(w.tile_size, w.p, w.r, x, w.y, self._hardness),
        )

    def _find_loads(self, tau: float) -> None:
        """Σ(p + τd) over the free points of each tile."""
        w = self.points
        self.team.run(
            bounded.tile_loads,
            self.tile_blocks,
            *(w.tile_size, w.p, w.d, self._free, self.dtype.type(tau), self._loads),
        )

    def _capacities(self) -> NDArray[np.floating]:
        """Largest load of the free points of each tile."""
        capacities: NDArray[np.floating] = (
            self.coarse.count[self.points.places] * self._hardness
        )
        return capacities

    def _targets(self, wanted: float) -> NDArray[np.floating]:
        """Return loads near those found last, within the capacities, of this sum."""
        capacities = self._capacities()
        loads = np.clip(self._loads, 0, capacities)
        if not loads.any():  # the step would empty all: only shift pressure within tiles
            self._find_loads(0.0)
            loads = np.clip(self._loads, 0, capacities)
        targets = scaled_within(loads, capacities, wanted)
        missing = wanted - float(targets.sum(dtype=np.float64))
        room = capacities - targets
        available = float(room.sum(dtype=np.float64))
        if missing > 0.0 and available > 0.0:  # also to tiles that the step would empty
            targets += room * self.dtype.type(min(missing / available, 1.0))
        return targets
