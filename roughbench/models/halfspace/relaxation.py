"""Projected conjugate gradients for the pressure of a working set."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace import loops
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.operator import HalfSpaceOperator, stiffness_stencil
from roughbench.models.halfspace.preconditioner import CellSolver
from roughbench.models.halfspace.working_set import WorkingSet

PENETRATION_SLACK = 10.0
"""Penetration allowed at convergence, in units of the tolerance."""

PATIENCE, PATIENCE_LINE = 40, 400
"""Iterations without progress that end a relaxation. Long lines may pause for longer than
surfaces do: with 40, a line of 2^18 points started once more, 16 % more transform pairs."""

FIRST_STEP = 0.5
"""τ of the first trial step, on the scale set by the preconditioner; 0.2 and 1 cost 2 %."""

SHORTEST = 0.3
"""A trial step is repeated, shorter, where the exact step is below this part of it.
0.5 repeats more steps (3 % more transform pairs in all), 0.15 gains nothing more."""


LONGEST = 10.0
"""Longest step, in trial steps. Rounding errors of the load grow by as much, and where
nothing is left to gain, the exact step is a quotient of rounding errors: 1e7 was seen."""


class Relaxation:
    """Minimises over the pressures of a working set, at one precision.

    Parameters
    ----------
    shape : (int, int)
        Grid.
    dtype : dtype
        float32 or float64.
    team : Team
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike, team: loops.Team) -> None:
        self.team = team
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        self.operator = HalfSpaceOperator(shape, dtype, team)
        self.cells = CellSolver(shape, dtype)
        self._weights = stiffness_stencil(shape, dtype)
        self._scratch = np.zeros((shape[0] + 2, shape[1] + 2), dtype)
        self._one = self.dtype.type(1)
        self._patience = PATIENCE_LINE if shape[0] == 1 else PATIENCE
        self._step_guess = FIRST_STEP
        # The direct sum where it may be used, and where it is used in this iteration.
        self._near: DirectOperator | None = None
        self._direct: DirectOperator | None = None

    def minimise(
        self,
        points: WorkingSet,
        total: float,
        target: float,
        max_iterations: int,
        direct: DirectOperator | None = None,
    ) -> tuple[int, bool]:
        r"""Lower ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0, Σp = ``total``, on ``points``, in place.

        Each iteration is one transform pair:

        1. α = mean of r over the contact; ρ = r − α on the free points
           (p > 0 or ρ < 0). Stop when Σp|ρ|/Σp and −min ρ are small enough.
        2. z = M ρ, mean free; d ← −z + β d on the free points, mean free, with
           Polak-Ribière β ≥ 0. Points that stay free keep their part of d: conjugacy
           is never reset because the contact changes.
        3. Trial step s of the expected length τ, to a pressure near max(p + τd, 0). What
           clipping adds is taken from the other points of the same tile: a surplus
           left in place would be one of long waves, which only a short step can bear.
           y = G s, and t = −⟨s,ρ⟩/⟨s,y⟩ is exact along s.
        4. p ← p + min(t, largest feasible) s, r ← r + the same of y. Where the exact
           step is far below the trial step, that one bent too far: shorten it and
           repeat 3.

        Every step lowers the energy: it is exact along a descent direction. Where a
        clipped step does not descend, conjugacy is dropped, then the preconditioner,
        then τ shortened.

        Parameters
        ----------
        points : WorkingSet
            With p and r set; changed in place.
        total : float
            Σp.
        target : float
            Largest Σp|ρ|/Σp to stop at; −min ρ may be ``PENETRATION_SLACK`` times more.
        max_iterations : int
        direct : DirectOperator, optional
            Applies G, instead of transforms.

        Returns
        -------
        (int, bool)
            Iterations done, and whether the target was reached.
        """
        number = self.dtype.type
        w = points
        blocks, tiles = self.team.split(w.rows)
        self._open(w, direct)
        self._step_guess = FIRST_STEP
        n_contact, sum_r = self.team.sum(
            loops.contact_sums, tiles, w.tile_size, self._one, w.p, w.r
        )
        alpha = sum_r / n_contact
        previous_power = 0.0
        length = 0.0
        best = math.inf
        since_best = 0
        reached = False
        iteration = 0
        while True:
            # 4. of the last iteration, and 1. of this one
            parts = self.team.run(
                loops.advance,
                blocks,
                *w.layout,
                *(self._one, number(length), number(length), number(alpha)),
                *(w.p, w.r, w.s, w.y, self.cells.count, self.cells.force, self._scratch),
            )
            complementarity = sum(part[0] for part in parts) / total
            penetration = -min(part[1] for part in parts)
            error = max(complementarity, penetration / PENETRATION_SLACK)
            reached = error <= target
            if error < 0.9 * best:
                best, since_best = error, 0
            else:
                since_best += 1
            if reached or iteration >= max_iterations or since_best > self._patience:
                break
            # 2. direction
            n_free, sum_z, sum_rho, sum_y, sum_d, z_rho, z_y = self._precondition(
                w, blocks, alpha
            )
            self._choose_operator(w, int(n_free))
            mean_z = sum_z / n_free
            power = z_rho - mean_z * sum_rho
            # ρ changed by length·y on the points that were free before.
            change = length * (z_y - mean_z * sum_y)
            beta = max(0.0, change / previous_power) if previous_power > 0.0 else 0.0
            shift = mean_z - beta * sum_d / n_free
            # 3. step
            found = self._descend(w, blocks, tiles, alpha, total, beta, shift)
            if found is None:
                break
            length, alpha = found
            previous_power = power
            iteration += 1
        # What is left of pressures on their way to zero must not count as contact.
        self.team.run(
            loops.drop_residues,
            tiles,
            w.tile_size,
            *(w.p, w.r, number(alpha), self._weights[0]),
        )
        self.team.run(loops.clear, blocks, *w.layout, self._scratch)
        w.keep_pressure()
        self._near = self._direct = None
        return iteration, reached

    def _open(self, w: WorkingSet, direct: DirectOperator | None) -> None:
        """Start on a working set from zero."""
        self.cells.open(w, few=direct is not None)
        self._near = direct
        self._choose_operator(w, w.n_contact)
        w.open_workspace()

    def _choose_operator(self, w: WorkingSet, n_sources: int) -> None:
        """Sum directly over this many points, or transform: whichever is cheaper."""
        direct = self._near
        pays = direct is not None and direct.pays(n_sources, w.tiles.size)
        self._direct = direct if pays else None

    def _precondition(
        self, w: WorkingSet, blocks: loops.Blocks, alpha: float
    ) -> NDArray[np.float64]:
        """s = M ρ on free points; returns the sums of :func:`.loops.precondition`."""
        loops.wrap_halo(self._scratch)
        coarse = self.cells.solve()
        return self.team.sum(
            loops.precondition,
            blocks,
            *w.layout,
            *(self._one, w.p, w.r, self.dtype.type(alpha), self._scratch, self._weights),
            *(self.cells.count, coarse, w.y, w.d, w.s),
        )

    def _descend(
        self,
        w: WorkingSet,
        blocks: loops.Blocks,
        tiles: loops.Blocks,
        alpha: float,
        total: float,
        beta: float,
        shift: float,
    ) -> tuple[float, float] | None:
        """Find a step along which the energy falls, and set s and y = G s for it.

        Returns how far to go along s and α after that step, or None where no step of
        this precision descends.
        """
        number = self.dtype.type
        offset = number(alpha)
        field = self.operator.field
        tau = self._step_guess
        size = w.tile_size
        for attempt in range(8):
            if attempt == 1:  # without conjugacy
                n_free, sum_z, *_ = self._precondition(w, blocks, alpha)
                beta, shift = 0.0, sum_z / n_free
            elif attempt > 1:  # along the residual itself, ever shorter
                n_free, sum_z = self.team.sum(
                    loops.use_residual, tiles, size, self._one, w.p, w.r, offset, w.s
                )
                shift = sum_z / n_free
                tau *= 0.25
            trial, _ = self.team.sum(
                loops.turn,
                blocks,
                *w.layout,
                *(w.p, w.r, offset, w.s),
                *(number(beta), number(shift), number(tau), self.cells.count, w.d),
            )
            for _ in range(8):
                if not 0.0 < trial < math.inf:
                    return None
                slope, clipped = self.team.sum(
                    loops.trial_step,
                    blocks,
                    *w.layout,
                    *(self._one, w.p, w.r, offset, w.d),
                    *(number(tau), number(total / trial), self.cells.count, w.s),
                    *(self._direct is None, field),
                )
                if not slope < 0.0:
                    break
                if self._direct is None:
                    self.operator.displace()
                else:
                    self._direct.apply(w, w.s, w, w.y)
                curvature, n_contact, sum_r, sum_y = self._image_sums(w, blocks, w.s)
                if not 0.0 < curvature < math.inf:
                    return None
                exact = -slope / curvature
                if exact >= SHORTEST or clipped == 0:
                    self._step_guess = min(max(tau * min(exact, 3.0), 1e-6), 1e6)
                    length = exact
                    if exact > 1.0:
                        reach = self.team.run(
                            loops.largest_step, tiles, size, self._one, w.p, w.s
                        )
                        length = min(exact, LONGEST, *reach)
                    return length, (sum_r + length * sum_y) / n_contact
                tau *= exact
                trial, _ = self.team.sum(loops.trial_load, tiles, size, w.p, w.d, number(tau))
        return None

    def tangent(
        self,
        points: WorkingSet,
        tolerance: float,
        max_iterations: int = 500,
        direct: DirectOperator | None = None,
    ) -> tuple[float, NDArray[Any], int]:
        r"""Solve G x = const on the contact, x = 0 off it, Σx = number of grid points.

        Preconditioned conjugate gradients from x = M 1. The compliance const = ⟨x·Gx⟩ is
        minimal at the solution, so its error is the square of that of x. What the steps
        lower it by falls about geometrically; the iteration ends when the rest of that
        series is less than ``tolerance`` of it.

        Parameters
        ----------
        points : WorkingSet
            The contact is where p > 0; d, s, y, r are overwritten.
        tolerance : float
            Relative error of the compliance, about.
        max_iterations : int
        direct : DirectOperator, optional
            Applies G, instead of transforms.

        Returns
        -------
        (float, ndarray, int)
            Compliance −dū/dp, the pressure x per unit nominal pressure on the points
            (shape of p), and the iterations done.
        """
        number = self.dtype.type
        w = points
        size = self.operator.field.size
        blocks, tiles = self.team.split(w.rows)
        self._open(w, direct)
        # Off the contact r is out of reach for α, so these points are never free.
        self.team.run(loops.mark_contact, tiles, w.tile_size, w.p, number(1), w.r)
        self._split_residual(w, blocks, 0.0, 0.0)
        self._precondition(w, blocks, 0.0)
        x = w.s.copy()
        x *= number(size / x.sum(dtype=np.float64))
        work, n_contact, _, sum_y = self._image(w, blocks, x)
        compliance = work / size
        self.team.run(loops.mark_contact, tiles, w.tile_size, w.p, number(0), w.r)
        alpha, length = sum_y / n_contact, 1.0
        previous, previous_gain = math.inf, compliance
        rates = 0.9, 0.9
        iteration = 1
        while True:
            self._split_residual(w, blocks, length, alpha)
            _, sum_z, sum_r, _, _, z_r, _ = self._precondition(w, blocks, alpha)
            mean_z = sum_z / n_contact
            power = float(z_r - mean_z * sum_r)
            if not power > 0.0 or iteration >= max_iterations:
                break
            self.team.run(
                loops.turn,
                blocks,
                *w.layout,
                *(w.p, w.r, number(alpha), w.s),
                *(number(power / previous), number(mean_z), number(0)),
                *(self.cells.count, w.d),
            )
            curvature, _, sum_r, sum_y = self._image(w, blocks, w.d)
            if not curvature > 0.0:
                break
            length = power / curvature
            self.team.run(loops.add, tiles, w.tile_size, number(length), w.d, x)
            alpha = (sum_r + length * sum_y) / n_contact
            gain = length * power / size
            compliance -= gain
            previous = power
            iteration += 1
            # Of the last two steps the slower one, and never faster than 1/3.
            rates = rates[1], min(max(gain / previous_gain, 1.0 / 3.0), 0.9)
            previous_gain = gain
            rate = max(rates)
            if gain * rate / (1.0 - rate) <= tolerance * compliance:
                break
        self.team.run(loops.clear, blocks, *w.layout, self._scratch)
        w.keep_pressure()
        self._near = self._direct = None
        return compliance, x, iteration

    def _split_residual(
        self, w: WorkingSet, blocks: loops.Blocks, length: float, alpha: float
    ) -> None:
        """r += length·y, with its split by tiles; p stays as it is."""
        number = self.dtype.type
        self.team.run(
            loops.advance,
            blocks,
            *w.layout,
            *(self._one, number(0), number(length), number(alpha), w.p, w.r, w.s, w.y),
            *(self.cells.count, self.cells.force, self._scratch),
        )

    def _image(
        self, w: WorkingSet, blocks: loops.Blocks, x: NDArray[Any]
    ) -> NDArray[np.float64]:
        """y = G x on the tiles; returns Σxy, and over the contact its size, Σr and Σy."""
        if self._direct is None:
            self.team.run(loops.scatter, blocks, *w.layout, x, self.operator.field)
            self.operator.displace()
        else:
            self._direct.apply(w, x, w, w.y)
        return self._image_sums(w, blocks, x)

    def _image_sums(
        self, w: WorkingSet, blocks: loops.Blocks, x: NDArray[Any]
    ) -> NDArray[np.float64]:
        """Take y over from the field where transforms put it; sums as of :meth:`_image`."""
        return self.team.sum(
            loops.gather_step,
            blocks,
            *w.layout,
            *(self._one, self._direct is None, self.operator.field, w.p, w.r, x, w.y),
        )

    def count_edges(
        self, w: WorkingSet, heights: NDArray[np.floating], scale: float
    ) -> tuple[float, float]:
        r"""Points in contact, and grid edges around it that the solution has found.

        At a *free* edge the pressure vanishes like the square root of the distance. Where
        the heights end the contact, by a step or a kink, it does not. An edge counts as
        prescribed if the pressure p there is more than ``STEEPEST`` of that of the point
        behind it (away from the edge) and the heights bend down at that point by

        .. math:: 2h - h_{behind} - h_{outside} > c\, p_{max} \Delta / E^*,

        with the largest pressure of the point, its neighbours and the next point behind.
        A contact two points wide has no next one: c is ``STEP``, there ``NARROW_STEP``.
        A single point tells nothing; its edges are free.

        Parameters
        ----------
        w : WorkingSet
            With p, in E* h_s/Δ.
        heights : ndarray, shape of the grid
            With any mean.
        scale : float
            1/h_s.
        """
        blocks, _ = self.team.split(w.rows)
        self.team.run(loops.spread_pressure, blocks, *w.layout, w.p, self._scratch)
        loops.wrap_halo(self._scratch)
        contact, free = self.team.sum(
            loops.boundary_edges, blocks, *w.layout, self._scratch, heights, scale
        )
        self.team.run(loops.clear, blocks, *w.layout, self._scratch)
        return float(contact), float(free)
