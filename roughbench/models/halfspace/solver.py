r"""The exact solver: contact pressure of a rough wall on a periodic half-space.

Minimise ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0 with ⟨p⟩ = p̄. The optimality conditions are
p ≥ 0, gap g = Gp − h − α ≥ 0 and p·g = 0. Heights are counted from the highest point, so
that where little touches, h, α and u are all as small as the displacements are, and their
difference keeps its digits; the mean separation is ū = −⟨h⟩ − α.

Two nested loops. The *outer* one evaluates the gap everywhere, in float64 from the
pressure alone; that either certifies the state or lists the *working set*: the points
under pressure and those whose gap is negative. The *inner* one (:mod:`.relaxation`)
minimises over the pressures of the working set, by default in float32: the residual it
starts from is exact, so its rounding errors shrink with it.

Either applies G by a transform pair, or, where few points carry pressure, by a direct
sum (:mod:`.direct`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace.certificate import Certificate
from roughbench.models.halfspace.evaluation import GapEvaluator
from roughbench.models.halfspace.gap_form import GapSpace
from roughbench.models.halfspace.loops import gap, tiles
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.options import Correction
from roughbench.models.halfspace.perimeter import corrected_area, count_edges
from roughbench.models.halfspace.relaxation import minimise
from roughbench.models.halfspace.start import cold_start, predict, scale_to
from roughbench.models.halfspace.surface import ScaledHeights
from roughbench.models.halfspace.tangent import tangent
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet
from roughbench.models.halfspace.workspace import Workspace

FLOAT32_FLOOR = 2e-7
"""Tolerances below this are iterated in float64 from the start."""

AIM_FLOOR = 1e-14
"""Smallest error aimed at near full contact, where float64 still can."""

TANGENT_TOLERANCE = 1e-5
"""Relative change of the stiffness in the last iteration of the tangent problem."""


GAP_FORM_CONTACT = 0.25
"""Part of the points in contact from which on the gap may be the unknown."""

GAP_FORM_LOAD, GAP_TANGENT_LOAD = 0.45, 0.66
"""Load, in rms values of the traction at full contact, from which on it is: in the relaxation
and in the tangent problem. On rough surfaces A/A0 is 0.43 and 0.6 there."""


@dataclass(slots=True)
class Solution:
    """One state, dimensionless: pressures on a working set and what follows from them."""

    load: float
    points: WorkingSet
    alpha: float
    separation: float
    energy: float
    certificate: Certificate
    status: Status
    iterations: int
    pairs: int


class Solver:
    """Solves states on one set of heights.

    Dimensionless: lengths along the surface in grid spacings Δ, heights in their rms
    value h_s, pressures in E* h_s/Δ, energies per area in E* h_s²/Δ.

    Parameters
    ----------
    heights : ndarray, shape (n, m)
        Any unit and mean; (1, m) is a line. Kept as it is, not copied.
    tolerance : float
        See :meth:`Certificate.holds`.
    double : bool
        Iterate in float64, not float32. Certificates are float64 in either case.
    threads : int
    max_iterations : int
        Limit on the inner iterations of one state.
    """

    def __init__(
        self,
        heights: NDArray[np.floating],
        tolerance: float,
        *,
        double: bool = False,
        threads: int = 1,
        max_iterations: int = 3000,
    ) -> None:
        self.heights = heights
        self.tolerance = tolerance
        self.max_iterations = max_iterations
        self.team = ThreadTeam(threads)
        self.size = heights.size
        self._heights = ScaledHeights(heights, self.team)
        self.rms = self._heights.rms
        self._even = self.team.even(heights.shape[0])
        self._double: Workspace | None = None
        self._single: Workspace | None = None
        self._use_single = not double and tolerance >= FLOAT32_FLOOR
        if self._use_single:
            self._single = Workspace(heights.shape, np.float32, self.team)
            self.exact = HalfSpaceOperator(heights.shape, np.float64, self.team)
        else:
            self.exact = self._workspace(double=True).operator
        self._evaluator = GapEvaluator(self._heights, self.exact)
        self._gap_spaces: dict[np.dtype[Any], GapSpace] = {}
        self._full_gap: tuple[float, ...] | None = None
        # Contact is exactly full from p̄ = −min σ_fc on.
        _, (lowest, self.full_energy, self._rms_traction) = self.traction_at_full_contact()
        self.full_load = -lowest

    @property
    def pairs(self) -> int:
        """Transform pairs done so far."""
        operators = {id(self.exact): self.exact}
        for workspace in (self._single, self._double):
            if workspace is not None:
                operators[id(workspace.operator)] = workspace.operator
        return sum(operator.pairs for operator in operators.values())

    def _workspace(self, *, double: bool) -> Workspace:
        if not double and self._single is not None:
            return self._single
        if self._double is None:
            self._double = Workspace(self.heights.shape, np.float64, self.team)
        return self._double

    def _gap_space(self, workspace: Workspace) -> GapSpace:
        if self._gap_spaces.get(workspace.dtype) is None:
            self._gap_spaces[workspace.dtype] = GapSpace(workspace.operator, workspace.scratch)
        return self._gap_spaces[workspace.dtype]

    def _is_mostly_closed(self, points: WorkingSet, load: float, threshold: float) -> bool:
        """Whether the gap is the better unknown: by the load, and the points in contact.

        Not on a line, where what is left of w off the contact disturbs at all distances.
        """
        return (
            self.heights.shape[0] > 1
            and load >= threshold * self._rms_traction
            and points.n_contact >= GAP_FORM_CONTACT * self.size
        )

    def traction_at_full_contact(
        self,
    ) -> tuple[NDArray[np.floating], tuple[float, float, float]]:
        """σ_fc = S h, a field that the next transform overwrites.

        With it its minimum, ½⟨h σ_fc⟩ and its rms value.
        """
        field = self.exact.field
        np.subtract(self.heights, self._heights.mean, out=field, dtype=np.float64)
        field *= self._heights.scale
        self.exact.traction()
        parts = self.team.run(
            gap.traction_at_full_contact, self._even, field, self._heights.surface
        )
        lowest = float(min(part[0] for part in parts))
        product, squares = (float(sum(part[k] for part in parts)) for k in (1, 2))
        energy = product / (2 * self.size)
        return field, (lowest, energy, math.sqrt(squares / self.size))

    def full_contact(self, load: float) -> Certificate:
        """Certificate of the pressure σ_fc + p̄, at a load of at least ``full_load``."""
        if self._full_gap is None:
            sigma = self.traction_at_full_contact()[0].copy()
            self.exact.field[...] = sigma
            self.exact.displace()
            parts = self.team.run(
                gap.gap_at_full_contact,
                self._even,
                *(
                    sigma,
                    self.exact.field,
                    (self.heights, self._heights.scale, self._heights.mean),
                ),
            )
            sums = np.add.reduce([part[:3] for part in parts]) / self.size
            self._full_gap = *sums.tolist(), max(part[3] for part in parts)
        traction, mean_gap, moment, penetration = self._full_gap
        return Certificate(
            complementarity=mean_gap + moment / load,
            penetration=penetration,
            load_error=abs(traction) / load,
            displacement=2.0 * self.full_energy / load,
        )

    def cold_start(self, load: float) -> WorkingSet:
        """Pressure of independent springs k max(h − d, 0) at this load, k = U_full/M_0.

        That modulus, ½E*M_1/M_0, gives the springs the elastic energy of full contact.
        """
        dtype = self._workspace(double=False).dtype
        return cold_start(self._evaluator, load, 2.0 * self.full_energy, dtype)

    def predict(
        self, solved: float, points: WorkingSet, rate: NDArray[np.floating], load: float
    ) -> WorkingSet | None:
        """Pressure at another load than ``solved``, from its tangent; see :func:`.predict`."""
        return predict(solved, points, rate, load, self.size)

    def solve(self, load: float, points: WorkingSet) -> Solution:
        """Return the state at nominal pressure ``load``, starting from ``points``.

        Parameters
        ----------
        load : float
            0 < p̄ < ``full_load``.
        points : WorkingSet
            Pressures to start from.

        Returns
        -------
        Solution
            ``converged`` only with a certificate that holds.
        """
        before = self.pairs
        total = load * self.size
        iterations = 0
        double = not self._use_single
        previous_error = math.inf
        while True:
            state = self._evaluator.evaluate(points)
            certificate = Certificate(
                complementarity=float(state.sum_p_gap / state.sum_p),
                penetration=-float(state.lowest_gap),
                load_error=float(abs(state.sum_p / total - 1.0)),
                displacement=float(2.0 * state.energy * self.size / state.sum_p),
            )
            if not math.isfinite(certificate.error + state.sum_p):
                status = Status.NOT_FINITE
                break
            converged = certificate.holds(self.tolerance)
            aim = self.tolerance * certificate.scale
            if converged:
                # Near full contact the whole gap is smaller than the tolerance: aim at
                # 1 % of its mean, so that stiffness and area mean something there.
                aim = min(aim, max(0.01 * state.separation, AIM_FLOOR))
                if certificate.error <= aim:
                    status = Status.CONVERGED
                    break
            if iterations >= self.max_iterations:
                status = Status.CONVERGED if converged else Status.MAX_ITERATIONS
                break
            if certificate.error > 0.5 * previous_error:
                if double:
                    status = Status.CONVERGED if converged else Status.STAGNATED
                    break
                double = True  # float32 has reached its floor: go on in float64
            double |= aim < FLOAT32_FLOOR * certificate.scale
            previous_error = certificate.error
            workspace = self._workspace(double=double)
            left = self.max_iterations - iterations
            if self._is_mostly_closed(points, load, GAP_FORM_LOAD):
                points, done = self._gap_space(workspace).minimise(
                    points,
                    (self.exact.field, self._heights.surface, state.alpha),
                    total / state.sum_p,
                    total / certificate.displacement,
                    0.5 * aim,
                    left,
                )
            else:
                points = state.make_working_set(workspace.dtype, total)
                del state  # and with it the points before
                done, _ = minimise(
                    workspace,
                    points,
                    total,
                    0.5 * aim,
                    left,
                    self._evaluator.direct_for(points),
                )
            iterations += done
            scale_to(points, total)
        return Solution(
            load=load,
            points=points.in_contact(),
            alpha=state.alpha,
            separation=state.separation,
            energy=state.energy,
            certificate=certificate,
            status=status,
            iterations=iterations,
            pairs=self.pairs - before,
        )

    def tangent(self, points: WorkingSet) -> tuple[float, NDArray[np.floating]]:
        """Stiffness −dp̄/dū at frozen contact, and ∂p/∂p̄ on the points."""
        if points.n_contact == self.size:
            return math.inf, np.ones_like(points.p)
        workspace = self._workspace(double=points.p.dtype == np.float64)
        if self._is_mostly_closed(points, points.sum_p / self.size, GAP_TANGENT_LOAD):
            compliance, rate, _ = self._gap_space(workspace).tangent(points, TANGENT_TOLERANCE)
            return 1.0 / compliance, rate
        compliance, rate, _ = tangent(
            workspace, points, TANGENT_TOLERANCE, direct=self._evaluator.direct_for(points)
        )
        return 1.0 / compliance, rate

    def area(self, points: WorkingSet, correction: Correction) -> tuple[float, float]:
        """A/A0, corrected for the perimeter or not, and points in contact / all points.

        Lines are not corrected.
        """
        if correction == "none" or self.heights.shape[0] == 1:
            raw = points.n_contact / self.size
            return raw, raw
        scratch = self._workspace(double=points.p.dtype == np.float64).scratch
        contact, free = count_edges(points, self._heights.surface, scratch, self.team)
        return corrected_area(contact, free) / self.size, contact / self.size

    def dense(self, solution: Solution) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Pressure and gap of a state as float64 fields, dimensionless."""
        points = solution.points
        self._evaluator.displace(points)
        shape = self.heights.shape
        pressure, dense_gap = np.empty(shape), np.empty(shape)
        blocks, _ = self.team.split(points.rows)
        self.team.run(tiles.scatter, blocks, points.tiling, points.p, pressure)
        self.team.run(
            gap.dense_gap,
            self._even,
            *(self.exact.field, self._heights.surface, solution.alpha, dense_gap),
        )
        return pressure, dense_gap
