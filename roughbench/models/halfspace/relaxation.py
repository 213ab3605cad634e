"""Projected conjugate gradients for the pressure of a working set."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace import loops
from roughbench.models.halfspace.operator import HalfSpaceOperator, stiffness_stencil
from roughbench.models.halfspace.preconditioner import CellSolver
from roughbench.models.halfspace.working_set import WorkingSet

PENETRATION_SLACK = 10.0
"""Penetration allowed at convergence, in units of the tolerance."""


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
        self._step_guess = 0.3

    def minimise(
        self, points: WorkingSet, total: float, target: float, max_iterations: int
    ) -> tuple[int, bool]:
        r"""Lower ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0, Σp = ``total``, on ``points``, in place.

        Each iteration is one transform pair:

        1. α = mean of r over the contact; ρ = r − α on the free points
           (p > 0 or ρ < 0). Stop when Σp|ρ|/Σp and −min ρ are small enough.
        2. z = M ρ, mean free; d ← −z + β d on the free points, mean free, with
           Polak-Ribière β ≥ 0. Points that stay free keep their part of d: conjugacy
           is never reset because the contact changes.
        3. Trial step of the expected length τ: s = c·max(p + τd, 0) − p, where c
           restores the total. y = G s, and t = −⟨s,ρ⟩/⟨s,y⟩ is exact along s.
        4. p ← p + min(t, largest feasible) s, r ← r + the same of y. Where the exact
           step is below half the trial step, the trial step bent too far: shorten it
           and repeat 3.

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

        Returns
        -------
        (int, bool)
            Iterations done, and whether the target was reached.
        """
        number = self.dtype.type
        w = points
        blocks, entries = self.team.split(w.rows, self.cells.starts)
        w.d[:] = 0
        w.y[:] = 0
        n_contact, sum_r = self.team.sum(loops.contact_sums, entries, w.p, w.r)
        previous_power = 0.0
        length = 0.0
        best = math.inf
        since_best = 0
        reached = False
        iteration = 0
        while True:
            # 1. residual
            alpha = number(sum_r / n_contact)
            parts = self.team.run(
                loops.restrict_residual,
                blocks,
                *(w.rows, w.columns, w.p, w.r, alpha, self._scratch),
                *(self.cells.row_cells, self.cells.column_cells),
                *(self.cells.count, self.cells.force),
            )
            complementarity = sum(part[0] for part in parts) / total
            penetration = -min(part[1] for part in parts)
            error = max(complementarity, penetration / PENETRATION_SLACK)
            reached = error <= target
            if error < 0.9 * best:
                best, since_best = error, 0
            else:
                since_best += 1
            if reached or iteration >= max_iterations or since_best > 40:
                break
            # 2. direction
            loops.wrap_halo(self._scratch)
            n_free, sum_z, sum_rho, sum_y, sum_d, z_rho, z_y = self.team.sum(
                loops.precondition,
                blocks,
                *(w.rows, w.columns, w.p, w.r, alpha, self._scratch, self._weights),
                *(self.cells.row_cells, self.cells.column_cells, self.cells.count),
                *(self.cells.solve(), self.cells.work, w.y, w.d, w.z),
            )
            mean_z = sum_z / n_free
            power = z_rho - mean_z * sum_rho
            # ρ changed by length·y on the points that were free before.
            change = length * (z_y - mean_z * sum_y)
            beta = max(0.0, change / previous_power) if previous_power > 0.0 else 0.0
            # 3. step
            found = self._descend(w, blocks, entries, alpha, total, beta, mean_z, sum_d, n_free)
            if found is None:
                break
            length, step_length = found
            # 4. advance
            n_contact, sum_r = self.team.sum(
                loops.advance, entries, number(length), w.s, w.y, w.p, w.r
            )
            self._step_guess = step_length
            previous_power = power
            iteration += 1
        self.team.run(loops.clear, blocks, w.rows, w.columns, self._scratch)
        return iteration, reached

    def _descend(
        self,
        w: WorkingSet,
        blocks: loops.Blocks,
        entries: loops.Blocks,
        alpha: Any,
        total: float,
        beta: float,
        mean_z: float,
        sum_d: float,
        n_free: float,
    ) -> tuple[float, float] | None:
        """Set s and y = G s; return the step along s and the next τ, or None at the floor."""
        number = self.dtype.type
        field = self.operator.field
        tau = self._step_guess
        for attempt in range(8):
            if attempt == 1:
                beta = 0.0
            elif attempt > 1:
                self.team.run(loops.residual_vector, entries, w.p, w.r, alpha, w.z)
                n_free, mean_z = self._free_mean(w, alpha)
                tau *= 0.25
            shift = number(mean_z - beta * sum_d / n_free)
            _, trial = self.team.sum(
                loops.new_direction,
                entries,
                *(w.p, w.r, alpha, w.z, number(beta), shift, number(tau), w.d),
            )
            for _ in range(8):
                if not 0.0 < trial < math.inf:
                    return None
                parts = self.team.run(
                    loops.trial_step,
                    blocks,
                    *(w.rows, w.columns, w.p, w.r, alpha, w.d),
                    *(number(tau), number(total / trial), w.s, field),
                )
                slope = sum(part[0] for part in parts)
                clipped = sum(part[1] for part in parts)
                reach = min(part[2] for part in parts)
                if not slope < 0.0:
                    break
                self.operator.displace()
                curvature, _ = self.team.sum(
                    loops.gather_step, blocks, w.rows, w.columns, field, w.s, w.y
                )
                if not 0.0 < curvature < math.inf:
                    return None
                exact = -slope / curvature
                if exact >= 0.5 or clipped == 0:
                    return min(exact, reach), min(max(tau * min(exact, 3.0), 1e-6), 1e6)
                tau *= exact
                trial, _ = self.team.sum(loops.trial_sum, entries, w.p, w.d, number(tau))
        return None

    @staticmethod
    def _free_mean(w: WorkingSet, alpha: Any) -> tuple[float, float]:
        """Return the number of free points and the mean of z over them."""
        free = (w.p > 0) | (w.r - alpha < 0)
        n = int(np.count_nonzero(free))
        return float(n), float(w.z[free].sum(dtype=np.float64)) / n

    def tangent(
        self, points: WorkingSet, tolerance: float, max_iterations: int = 500
    ) -> tuple[float, NDArray[Any], int]:
        r"""Solve G x = const on the contact, x = 0 off it, Σx = number of grid points.

        Preconditioned conjugate gradients from x = M 1. The compliance const = ⟨x·Gx⟩ is
        minimal at the solution, so its error is the square of that of x; the iteration
        ends when the last step lowered it by less than ``tolerance`` times itself.

        Parameters
        ----------
        points : WorkingSet
            With p > 0 everywhere; d, z, s, y, r are overwritten.
        tolerance : float
            Relative error of the compliance, about.
        max_iterations : int

        Returns
        -------
        (float, ndarray, int)
            Compliance −dū/dp, the pressure x per unit nominal pressure on the points
            (shape (n,)), and the iterations done.
        """
        number = self.dtype.type
        w = points
        size = self.operator.field.size
        blocks, entries = self.team.split(w.rows, self.cells.starts)
        x = np.empty_like(w.p)
        w.d[:] = 0
        w.y[:] = 0
        w.r[:] = 1
        self._precondition_contact(w, blocks)
        x[:] = w.z
        x *= number(size / x.sum(dtype=np.float64))
        w.s[:] = x
        compliance = self._image(w, blocks) / size
        w.r[:] = w.y
        w.r -= number(w.r.mean(dtype=np.float64))
        power = self._precondition_contact(w, blocks)
        np.negative(w.z, out=w.d)
        iteration = 1
        while iteration < max_iterations and power > 0.0:
            w.s[:] = w.d
            curvature = self._image(w, blocks)
            if not curvature > 0.0:
                break
            length = power / curvature
            self.team.run(loops.axpy, entries, number(length), w.s, x)
            self.team.run(loops.axpy, entries, number(length), w.y, w.r)
            w.r -= number(w.r.mean(dtype=np.float64))
            gain = length * power / size
            compliance -= gain
            iteration += 1
            if gain <= tolerance * compliance:
                break
            previous, power = power, self._precondition_contact(w, blocks)
            w.d *= number(power / previous)
            w.d -= w.z
        self.team.run(loops.clear, blocks, w.rows, w.columns, self._scratch)
        return compliance, x, iteration

    def _image(self, w: WorkingSet, blocks: loops.Blocks) -> float:
        """y = G s on the points; returns Σsy."""
        field = self.operator.field
        self.team.run(loops.scatter, blocks, w.rows, w.columns, w.s, field)
        self.operator.displace()
        return float(
            self.team.sum(loops.gather_step, blocks, w.rows, w.columns, field, w.s, w.y)[0]
        )

    def _precondition_contact(self, w: WorkingSet, blocks: loops.Blocks) -> float:
        """z = M r on points that are all in contact, mean free; returns Σzr.

        For the constant r of the first call z is not made mean free: the mean is all of it.
        """
        self.team.run(
            loops.restrict_residual,
            blocks,
            *(w.rows, w.columns, w.p, w.r, self.dtype.type(0), self._scratch),
            *(self.cells.row_cells, self.cells.column_cells),
            *(self.cells.count, self.cells.force),
        )
        loops.wrap_halo(self._scratch)
        n, sum_z, sum_r, _, _, z_r, _ = self.team.sum(
            loops.precondition,
            blocks,
            *(w.rows, w.columns, w.p, w.r, self.dtype.type(0), self._scratch, self._weights),
            *(self.cells.row_cells, self.cells.column_cells, self.cells.count),
            *(self.cells.solve(), self.cells.work, w.y, w.d, w.z),
        )
        if abs(sum_r) > 0.5 * n:
            return float(z_r)
        w.z -= self.dtype.type(sum_z / n)
        return float(z_r - sum_z / n * sum_r)
