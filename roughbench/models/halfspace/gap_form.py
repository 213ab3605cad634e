r"""The same problem with the gap as unknown, for where contact prevails.

With S = G⁻¹ = \|q\|/2 and the displacement u = h + α + g the pressure is p = p̄ + S(h + g):
minimise ½⟨g·Sg⟩ + ⟨g·(p̄ + Sh)⟩ over gaps g ≥ 0. The traction w = p̄ + S(h + g) is the
pressure where g = 0, and has to vanish where g > 0. There is no constraint on the load,
which enters as a constant, and between the islands of open points S acts as 1/r³ and not as
1/r. So iterations hardly grow with the grid where many points touch; with the pressure as
unknown (:mod:`.relaxation`) the same holds where few do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.certificate import PENETRATION_SLACK
from roughbench.models.halfspace.gap_preconditioner import GapPreconditioner
from roughbench.models.halfspace.kernel import HALF_SPACE
from roughbench.models.halfspace.loops import gap_form as loops
from roughbench.models.halfspace.loops import tiles
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.relaxation import (
    FIRST_STEP,
    LONGEST_STEP,
    PATIENCE,
    SHORTEST_STEP,
)
from roughbench.models.halfspace.tangent import GainSeries
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid, tile_height

WEIGHED = (0, 2, 5, 10)
"""Iterations at which the weights are taken from the points that are free then."""

COMPLEMENTARITY = 0.5
"""Complementarity of the pressures that are returned, in √(Σwz / unit), about: 0.1 to 0.4 of
it was seen."""

FIRST_GAIN = 0.2
"""Part of its first error that a relaxation goes on to at least."""

FloatField = NDArray[np.floating]


class GapSpace:
    """S and its preconditioner at one precision, on dense fields.

    Parameters
    ----------
    operator : HalfSpaceOperator
        Its field is overwritten.
    scratch : ndarray, shape (n + 2, m + 2)
        Zero; zero again after each method.
    """

    def __init__(self, operator: HalfSpaceOperator, scratch: FloatField) -> None:
        self.operator = operator
        self.team: ThreadTeam = operator.team
        self.shape: tuple[int, int] = operator.transform.shape
        self.dtype: np.dtype[Any] = operator.transform.dtype
        self._masked = scratch
        self._preconditioner = GapPreconditioner(self.shape, self.dtype, self.team)
        self._stiffness = HALF_SPACE.stencil(self.shape, self.dtype)[0]
        self._one = self.dtype.type(1)
        self._blocks = self.team.even(-(-self.shape[0] // loops.CELL))

    def minimise(
        self,
        points: WorkingSet,
        displaced: tuple[FloatField, tuple[FloatField, float, float], float],
        factor: float,
        unit: float,
        target: float,
        max_iterations: int,
        record: Callable[[float], None] | None = None,
    ) -> tuple[WorkingSet, int]:
        r"""Lower the energy over g ≥ 0 from the gap that a pressure leads to.

        Each iteration is one transform pair:

        1. z = M w on the free points (g > 0 or w < 0), about the error of the gap. Stop when
           √(Σwz / ``unit``) and max \|z\| are small enough. Σwz is about the square of the
           error of the pressure in the norm ‖p‖² = Σp·Gp, ``unit`` that norm.
        2. d ← −z + βd on the free points, with Polak-Ribière β ≥ 0; points that stay free keep
           their part of d.
        3. Trial step s = max(g + τd, 0) − g, y = S s; t = −⟨s,w⟩/⟨s,y⟩ is exact along s. Where
           it is far below the trial step, that one bent too far: shorten it and repeat.
        4. g ← g + min(t, largest feasible) s, w the same with y.

        Parameters
        ----------
        points : WorkingSet
            Pressures to start from.
        displaced : (ndarray, tuple, float)
            Of these pressures: u = Gp in float64, the heights as the loops take them, and α.
        factor : float
            For p and u, to reach the load.
        unit : float
            Σp/D, where D is that of full contact, which is a bound on the displacement of the
            certificate.
        target : float
            Largest complementarity, as estimated by ``COMPLEMENTARITY`` √(Σwz / ``unit``);
            max \|z\| may be ``PENETRATION_SLACK`` times more. Where the error is near it from
            the start, it is lowered to ``FIRST_GAIN`` of that: without an iteration the
            pressure would only be changed, not improved.
        max_iterations : int
        record : callable, optional
            Told the estimated error of each iteration.

        Returns
        -------
        (WorkingSet, int)
            The pressures where g = 0, and the iterations done.
        """
        y = self.operator.field
        g, w, d, weight = (np.empty(self.shape, self.dtype) for _ in range(4))
        self._preconditioner.open(points.n_contact / y.size)
        self.team.run(
            tiles.scatter, self.team.split(points.rows)[0], points.tiling, points.p, w
        )
        u, surface, alpha = displaced
        self.team.run(loops.start, self._blocks, surface, u, alpha, factor, g, w, y)
        # S u = p, so that w = p + S (h + g − u): of a difference that is small.
        self.operator.traction()
        d.fill(0)
        weight.fill(1)
        fields = g, w, d, y
        tau, length, previous_power = FIRST_STEP, 1.0, 0.0
        best, since_best, iteration = math.inf, 0, 0
        step = 0.0
        while True:
            self._advance(fields, weight, step, length)
            if iteration in WEIGHED:
                tiles.wrap_halo(self._masked)
                self._weigh(weight)
                self._advance(fields, weight, 0.0, 0.0)
            power, product, largest = self._precondition(weight, y)
            error = max(
                COMPLEMENTARITY * math.sqrt(max(power, 0.0) / unit), largest / PENETRATION_SLACK
            )
            if record is not None:
                record(error)
            if iteration == 0:
                target = min(target, FIRST_GAIN * error)
            if error < 0.9 * best:
                best, since_best = error, 0
            else:
                since_best += 1
            if error <= target or iteration >= max_iterations or since_best > PATIENCE:
                break
            beta = max(0.0, length * product / previous_power) if previous_power > 0.0 else 0.0
            found = self._descend(fields, weight, beta, tau)
            if found is None:
                break
            step, length, tau = found
            previous_power = power
            iteration += 1
        del d, fields
        made = self._pressures(g, w)
        self._masked.fill(0)
        return made, iteration

    def _advance(
        self, fields: tuple[FloatField, ...], weight: FloatField, step: float, length: float
    ) -> None:
        number = self.dtype.type
        self.team.run(
            loops.advance,
            self._blocks,
            *(fields, weight, self._masked, self._preconditioner.cells, self._one),
            *(number(step), number(length)),
        )

    def _weigh(self, weight: FloatField) -> None:
        by_count = self._preconditioner.by_count
        self.team.run(loops.weigh, self._blocks, self._masked, by_count, weight)

    def _precondition(self, weight: FloatField, y: FloatField) -> tuple[float, float, float]:
        """z = M w in the place of y; Σwz and Σyz over the free points, and the largest |z|."""
        tiles.wrap_halo(self._masked)
        self._preconditioner.spread()
        parts = self.team.run(
            loops.precondition,
            self._blocks,
            *(self._masked, weight, self._preconditioner.cells, y),
            self._preconditioner.weights,
        )
        power, product, largest = zip(*parts, strict=True)
        return float(sum(power)), float(sum(product)), float(max(largest))

    def _descend(
        self, fields: tuple[FloatField, ...], weight: FloatField, beta: float, tau: float
    ) -> tuple[float, float, float] | None:
        """Set y = S s for a step that lowers the energy; τ of it, its length, and the next τ.

        None where no step of this precision descends.
        """
        number = self.dtype.type
        for attempt in range(8):
            if attempt == 1:  # without conjugacy
                self._precondition(weight, fields[3])
                beta = 0.0
            elif attempt > 1:
                tau *= 0.25
            if attempt < 2:
                parts = self.team.sum(
                    loops.turn,
                    self._blocks,
                    *(fields, self._masked, number(beta), number(tau)),
                )
            else:
                parts = self.team.sum(loops.try_step, self._blocks, fields, number(tau))
            for _ in range(8):
                slope, lost = parts
                if not slope < 0.0:
                    break
                curvature = self.operator.traction()
                if not 0.0 < curvature < math.inf:
                    return None
                exact = float(-slope / curvature)
                if exact >= SHORTEST_STEP or lost == 0.0:
                    length = exact
                    if exact > 1.0:
                        reach = self.team.run(
                            loops.largest_step, self._blocks, fields, number(tau)
                        )
                        length = min(exact, LONGEST_STEP, *reach)
                    return tau, length, min(max(tau * min(exact, 3.0), 1e-6), 1e6)
                tau *= exact
                parts = self.team.sum(loops.try_step, self._blocks, fields, number(tau))
        return None

    def _pressures(self, g: FloatField, w: FloatField) -> WorkingSet:
        """Working set of the points in contact."""
        marked = np.empty(tile_grid(self.shape), np.uint8)
        rows = self.team.even(marked.shape[0])
        height = tile_height(self.shape)
        self.team.run(loops.keep_pressure, rows, g, w, self._stiffness, height, marked)
        made = WorkingSet.on(self.shape, marked, self.dtype)
        self.team.run(loops.gather, self.team.split(made.rows)[0], made.tiling, w, made.p)
        made.keep_pressure()
        return made

    def tangent(
        self, points: WorkingSet, tolerance: float, max_iterations: int = 500
    ) -> tuple[float, NDArray[Any], int]:
        r"""Solve S v = −1 off the contact, v = 0 on it, v being ∂g/∂p̄.

        Preconditioned conjugate gradients from v = −M 1. −⟨v⟩ is the compliance, and twice
        the energy ½⟨v·Sv⟩ + ⟨v⟩ that the steps lower; the iteration ends as
        :func:`.tangent.tangent` does.

        Returns
        -------
        (float, ndarray, int)
            Compliance −dū/dp, the pressure 1 + S v per unit nominal pressure on the points
            (shape of p), and the iterations done.
        """
        number, y = self.dtype.type, self.operator.field
        size = y.size
        v, r, d, weight = (np.zeros(self.shape, self.dtype) for _ in range(4))
        self._preconditioner.open(points.n_contact / size)
        self.team.run(
            tiles.scatter, self.team.split(points.rows)[0], points.tiling, points.p, r
        )
        closed = r > 0
        r.fill(1)
        y.fill(0)
        fields = v, r, d, y
        weight.fill(1)
        self._advance_frozen(fields, closed, weight, 0.0)
        tiles.wrap_halo(self._masked)
        self._weigh(weight)
        length, previous, compliance, gains = 0.0, math.inf, 0.0, GainSeries(math.inf)
        iteration = 0
        while True:
            self._advance_frozen(fields, closed, weight, length)
            power, _, _ = self._precondition(weight, y)
            if not power > 0.0 or iteration >= max_iterations:
                break
            self.team.run(
                loops.turn_frozen,
                self._blocks,
                *(fields, self._masked, number(power / previous)),
            )
            curvature = self.operator.traction()
            if not curvature > 0.0:
                break
            length = power / curvature
            gain = length * power / size
            compliance += gain
            previous = power
            iteration += 1
            if gains.rest_after(gain) <= tolerance * compliance:
                break
        self._advance_frozen(fields, closed, weight, length)
        rate_of_change = np.empty_like(points.p)
        r[~closed] = 0
        self.team.run(
            loops.gather,
            self.team.split(points.rows)[0],
            *(points.tiling, r, rate_of_change),
        )
        self._masked.fill(0)
        return compliance, rate_of_change, iteration

    def _advance_frozen(
        self,
        fields: tuple[FloatField, ...],
        closed: NDArray[np.bool_],
        weight: FloatField,
        length: float,
    ) -> None:
        self.team.run(
            loops.advance_frozen,
            self._blocks,
            *(fields, closed, weight, self._masked, self._preconditioner.cells, self._one),
            self.dtype.type(length),
        )
