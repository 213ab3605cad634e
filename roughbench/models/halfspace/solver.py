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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace.bounded import BoundedWorkspace
from roughbench.models.halfspace.certificate import Certificate
from roughbench.models.halfspace.evaluation import GapEvaluator
from roughbench.models.halfspace.free import make_operator
from roughbench.models.halfspace.gap_form import GapSpace
from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import NEVER_FREE, gap, tiles
from roughbench.models.halfspace.options import Correction
from roughbench.models.halfspace.perimeter import (
    corrected_area,
    corrected_width,
    count_edges,
)
from roughbench.models.halfspace.plastic import (
    BoundedEvaluator,
    bounded_cold_start,
    rounded_down,
)
from roughbench.models.halfspace.relaxation import minimise
from roughbench.models.halfspace.start import cold_start, from_field, predict, scale_to
from roughbench.models.halfspace.surface import ScaledHeights
from roughbench.models.halfspace.tangent import tangent
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid
from roughbench.models.halfspace.workspace import Workspace

FLOAT32_FLOOR = 2e-7
"""Tolerances below this are iterated in float64 from the start."""

AIM_FLOOR = 1e-14
"""Smallest error aimed at near full contact, where float64 still can."""

TANGENT_TOLERANCE = 1e-5
"""Relative change of the stiffness in the last iteration of the tangent problem."""


GAP_FORM_LOAD, GAP_FORM_LOAD_LARGE, LARGE = 0.6, 0.45, 2**21
GAP_FORM_CONTACT = 0.25
"""Load, in rms values of the traction at full contact, and part of the points in contact from
which on the gap is the unknown; the load is the second one from ``LARGE`` points on. On rough
surfaces A/A0 is 0.55 and 0.44 at these loads. Where a cold start puts pressure on too many
points, the load alone tells."""

WEAK_ROUNDS = 2
"""Relaxations in float64 that do not halve the error, after which a state is given
up."""

GAP_TANGENT_CONTACT = 0.6
"""Part of the points in contact from which on it is in the tangent problem."""


class IterationError(NamedTuple):
    """What an iteration still had wrong.

    Attributes
    ----------
    transform_pairs : int
        Done for the state up to here.
    error : float
        :attr:`Certificate.error` of the pressures, h_rms: complementarity, or a tenth of the
        penetration if that is more.
    is_certified : bool
        Whether it is of all points, in float64; else the iteration's own, on its working set.
    """

    transform_pairs: int
    error: float
    is_certified: bool


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
    plastic_depth: float = 0.0


class Solver:
    """Solves states on one set of heights.

    Dimensionless: lengths along the surface in grid spacings Δ of the first axis, heights in
    their rms value h_s, pressures in E* h_s/Δ, energies per area in E* h_s²/Δ.

    Parameters
    ----------
    heights : ndarray, shape (n, m)
        In C order, of any unit and mean; (1, m) is a line. Kept as it is, not copied.
    tolerance : float
        See :meth:`Certificate.holds`.
    double : bool
        Iterate in float64, not float32. Certificates are float64 in either case.
    threads : int
    max_iterations : int
        Limit on the inner iterations of one state.
    kernel : Kernel
        Spacings, screening and boundary.
    flat : float
        The unit of heights that are flat, for which there is no rms value.
    hardness : float, optional
        Largest pressure, in E* times the unit of the heights over Δ.
    """

    def __init__(
        self,
        heights: NDArray[np.floating],
        tolerance: float,
        *,
        double: bool = False,
        threads: int = 1,
        max_iterations: int = 3000,
        kernel: Kernel = HALF_SPACE,
        flat: float = 0.0,
        hardness: float | None = None,
    ) -> None:
        self.heights = heights
        self.kernel = kernel
        self.tolerance = tolerance
        self.max_iterations = max_iterations
        self.team = ThreadTeam(threads)
        self.size = heights.size
        self._heights = ScaledHeights(heights, self.team, flat)
        self.rms = self._heights.rms
        self._even = self.team.even(heights.shape[0])
        self._double: Workspace | None = None
        self._single: Workspace | None = None
        self._use_single = not double and tolerance >= FLOAT32_FLOOR
        self.hardness: float | None = None
        if hardness is not None and self.rms > 0.0:
            # What float32 holds of it, so that both precisions mean the same.
            single = np.float32 if self._use_single else np.float64
            self.hardness = rounded_down(hardness / self.rms, single)
        if self._use_single:
            self._single = self._make_workspace(np.float32)
            self.exact = make_operator(heights.shape, np.float64, self.team, kernel)
        else:
            self.exact = self._workspace(double=True).operator
        self._evaluator = (
            GapEvaluator(self._heights, self.exact)
            if self.hardness is None
            else BoundedEvaluator(self._heights, self.exact, self.hardness)
        )
        self._gap_spaces: dict[np.dtype[Any], GapSpace] = {}
        self.history: list[IterationError] | None = None
        """Where each iteration is noted, if it is a list."""
        self._full_gap: tuple[float, ...] | None = None
        # Contact is exactly full from p̄ = −min σ_fc on. On a free half-space it is full
        # where all points carry, with a pressure that no closed form knows.
        self.full_load = self._most_full_load = self._rms_traction = math.inf
        if not kernel.free:
            field, (lowest, self.full_energy, self._rms_traction) = (
                self.traction_at_full_contact()
            )
            self.full_load = -lowest
            # A hardness may be reached before; then full contact has no closed form.
            if self.hardness is not None:
                self._most_full_load = self.hardness - float(field.max())

    @property
    def scaled_heights(self) -> ScaledHeights:
        """The heights as the loops take them."""
        return self._heights

    @property
    def depth(self) -> float:
        """Mean gap at first contact: of the mean below the highest point, in h_rms."""
        return self._heights.depth

    @property
    def deepest(self) -> float:
        """Depth of the lowest point below the mean, in h_rms."""
        return float(self._heights.mean - self.heights.min()) * self._heights.scale

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
            self._double = self._make_workspace(np.float64)
        return self._double

    def _make_workspace(self, dtype: DTypeLike) -> Workspace:
        if self.hardness is None:
            return Workspace(self.heights.shape, dtype, self.team, self.kernel)
        return BoundedWorkspace(self.heights.shape, dtype, self.team, self.hardness)

    def _gap_space(self, workspace: Workspace) -> GapSpace:
        if self._gap_spaces.get(workspace.dtype) is None:
            self._gap_spaces[workspace.dtype] = GapSpace(workspace.operator, workspace.scratch)
        return self._gap_spaces[workspace.dtype]

    def _has_gap_form(self, n_contact: int, fraction: float) -> bool:
        """Whether the gap may be the unknown, and so many points are in contact.

        It may not on a line, where what is left of w off the contact disturbs at all
        distances; its preconditioner is that of the plain half-space, and a hardness bounds
        pressures, not gaps.
        """
        return (
            self.kernel == HALF_SPACE
            and self.hardness is None
            and self.heights.shape[0] > 1
            and n_contact >= fraction * self.size
        )

    def _prefers_gap(self, load: float, n_contact: int) -> bool:
        """Whether the gap as unknown is the shorter way to the state at this load."""
        limit = GAP_FORM_LOAD if self.size < LARGE else GAP_FORM_LOAD_LARGE
        return load >= limit * self._rms_traction and self._has_gap_form(
            n_contact, GAP_FORM_CONTACT
        )

    def is_full(self, load: float) -> bool:
        """Whether contact is full, and elastic, at this load."""
        return self.full_load <= load <= self._most_full_load

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

        That modulus, ½E*M_1/M_0, gives the springs the elastic energy of full contact. On a
        free half-space it is estimated.
        """
        dtype = self._workspace(double=False).dtype
        if self.hardness is not None:
            return bounded_cold_start(
                self._evaluator, load, 2.0 * self.full_energy, self.hardness, dtype
            )
        free = self.kernel.free
        modulus = self._heights.spring_modulus if free else 2.0 * self.full_energy
        return cold_start(self._evaluator, load, modulus, dtype)

    def spring_load(self, approach: float) -> float:
        """Load of the springs of :meth:`cold_start` on a free half-space at this approach."""
        overlap, _ = self.team.sum(
            gap.overlap_sums, self._even, self._heights.surface, -approach
        )
        return float(overlap) * self._heights.spring_modulus / self.size

    def start_from(self, pressure: NDArray[np.float64], load: float) -> WorkingSet:
        """Pressures of a dense field, scaled to this load, to start from.

        A cold start where these points cannot carry it, each up to the hardness.
        """
        points = from_field(pressure, self._workspace(double=False).dtype)
        scale_to(points, load * self.size, self.hardness)
        carried = float(points.p.sum(dtype=np.float64))
        return points if carried > (1 - 1e-4) * load * self.size else self.cold_start(load)

    def predict(
        self, solved: float, points: WorkingSet, rate: NDArray[np.floating], load: float
    ) -> WorkingSet | None:
        """Pressure at another load than ``solved``, from its tangent; see :func:`.predict`."""
        return predict(solved, points, rate, load, self.size, self.hardness)

    def solve(self, load: float, points: WorkingSet) -> Solution:
        """Return the state at nominal pressure ``load``, starting from ``points``.

        Parameters
        ----------
        load : float
            p̄ > 0; where :meth:`is_full` there is nothing to solve.
        points : WorkingSet
            Pressures to start from.

        Returns
        -------
        Solution
            ``converged`` only with a certificate that holds.
        """
        if self.hardness is not None and load >= self.hardness * (1.0 - 1e-15):
            return self._all_plastic(load)
        before = self.pairs

        def note(error: float, *, is_certified: bool = False) -> None:
            if self.history is not None:
                self.history.append(IterationError(self.pairs - before, error, is_certified))

        total = load * self.size
        iterations = 0
        double = not self._use_single
        previous_error, aim = math.inf, math.inf
        by_gap, may_use_gap, weak_rounds = False, True, 0
        while True:
            state = self._evaluator.evaluate(points)
            certificate = Certificate(
                complementarity=float(state.sum_p_gap / state.sum_p),
                penetration=-float(state.lowest_gap),
                load_error=float(abs(state.sum_p / total - 1.0)),
                displacement=float(
                    (2.0 * state.energy + (self.hardness or 0.0) * state.plastic_depth)
                    * self.size
                    / state.sum_p
                ),
            )
            note(certificate.error, is_certified=True)
            if not math.isfinite(certificate.error + state.sum_p):
                status = Status.NOT_FINITE
                break
            converged = certificate.holds(self.tolerance)
            # With the gap as unknown the error is only estimated, from short waves for the
            # most part: where long ones prevail the estimate misses them.
            may_use_gap &= not (by_gap and certificate.complementarity > aim)
            aim = self.tolerance * certificate.scale
            if converged and self.exact.periodic:
                # Near full contact the whole gap is smaller than the tolerance: aim at
                # 1 % of its mean, so that stiffness and area mean something there.
                aim = min(aim, max(0.01 * state.open_gap, AIM_FLOOR))
            if converged and certificate.error <= aim:
                status = Status.CONVERGED
                break
            if iterations >= self.max_iterations:
                status = Status.CONVERGED if converged else Status.MAX_ITERATIONS
                break
            if certificate.error >= 0.5 * previous_error:
                weak_rounds += double
                if weak_rounds >= (1 if converged else WEAK_ROUNDS):
                    status = Status.CONVERGED if converged else Status.STAGNATED
                    break
                double = True  # float32 has reached its floor: go on in float64
            double |= aim < FLOAT32_FLOOR * certificate.scale
            previous_error = certificate.error
            workspace = self._workspace(double=double)
            left = self.max_iterations - iterations
            by_gap = may_use_gap and self._prefers_gap(load, points.n_contact)
            if by_gap:
                points.keep_pressure()
                points, done = self._gap_space(workspace).minimise(
                    points,
                    (self.exact.field, self._heights.surface, state.alpha),
                    total / state.sum_p,
                    total * load / (2.0 * self.full_energy),
                    0.5 * aim,
                    left,
                    note,
                )
            else:
                points = state.make_working_set(workspace.dtype, total)
                del state  # and with it the points before
                done, _ = minimise(
                    workspace,
                    points,
                    # Up to a hardness, Σp is mended between relaxations alone.
                    total if self.hardness is None else float(points.p.sum(dtype=np.float64)),
                    0.5 * aim,
                    left,
                    self._evaluator.direct_for(points),
                    note,
                )
            iterations += done
            scale_to(points, total, self.hardness)
        return Solution(
            load=load,
            points=points.in_contact(),
            alpha=state.alpha,
            separation=state.separation,
            energy=state.energy,
            plastic_depth=state.plastic_depth,
            certificate=certificate,
            status=status,
            iterations=iterations,
            pairs=self.pairs - before,
        )

    def _all_plastic(self, load: float) -> Solution:
        """Return the state at the hardness: everywhere; no gap at the lowest point."""
        shape = self.heights.shape
        dtype = self._workspace(double=False).dtype
        alpha = self._heights.depth + self.deepest
        self.exact.field[...] = 0.0
        none = WorkingSet.on(shape, np.zeros(tile_grid(shape), np.uint8), dtype)
        everywhere = np.ones(tile_grid(shape), np.uint8)
        points = self._evaluator.make_working_set(none, alpha, everywhere, dtype, 1.0)
        points.p[points.r < 0.5 * NEVER_FREE] = self.hardness or load
        points.keep_pressure()
        depth = alpha - self._heights.depth
        return Solution(
            load=load,
            points=points,
            alpha=alpha,
            separation=-depth,
            energy=0.0,
            plastic_depth=depth,
            certificate=Certificate(0.0, 0.0, 0.0, depth),
            status=Status.CONVERGED,
            iterations=0,
            pairs=0,
        )

    def tangent(self, points: WorkingSet) -> tuple[float, NDArray[np.floating]]:
        """Stiffness −dp̄/dū at frozen contact, and ∂p/∂p̄ on the points.

        On a free half-space that is dp̄/dδ. Plastic points go on to carry the hardness: the
        others alone are stiff.
        """
        points = self.elastic(points)
        n_contact = points.n_contact
        if n_contact == self.size and self.exact.periodic:
            return math.inf, np.ones_like(points.p)
        if n_contact == 0:
            return 0.0, np.zeros_like(points.p)
        workspace = self._workspace(double=points.p.dtype == np.float64)
        if self._has_gap_form(n_contact, GAP_TANGENT_CONTACT):
            compliance, rate, _ = self._gap_space(workspace).tangent(points, TANGENT_TOLERANCE)
            return 1.0 / compliance, rate
        compliance, rate, _ = tangent(
            workspace, points, TANGENT_TOLERANCE, direct=self._evaluator.direct_for(points)
        )
        return 1.0 / compliance, rate

    def elastic(self, points: WorkingSet) -> WorkingSet:
        """Return the points without the pressure of plastic ones; itself without a hardness."""
        if self.hardness is None:
            return points
        p = np.where(points.p < self.hardness, points.p, points.p.dtype.type(0))
        return WorkingSet.under_pressure(points.height, points.rows, points.tiles, p)

    def area(self, points: WorkingSet, correction: Correction) -> tuple[float, float]:
        """A/A0, corrected for the perimeter or not, and points in contact / all points."""
        if correction == "none":
            raw = points.n_contact / self.size
            return raw, raw
        scratch = self._workspace(double=points.p.dtype == np.float64).scratch
        contact, free = count_edges(
            *(points, self._heights.surface, scratch, self.team, self.kernel, self.hardness)
        )
        corrected = corrected_width if self.heights.shape[0] == 1 else corrected_area
        return corrected(contact, free, self.kernel) / self.size, contact / self.size

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
