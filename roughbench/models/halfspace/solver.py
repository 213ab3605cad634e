r"""The exact solver: contact pressure of a rough wall on a periodic half-space.

Minimise ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0 with ⟨p⟩ = p̄. The optimality conditions are
p ≥ 0, gap g = Gp − h − α ≥ 0 and p·g = 0. Heights are counted from the highest point, so
that where little touches, h, α and u are all as small as the displacements are, and their
difference keeps its digits; the mean separation is ū = −⟨h⟩ − α.

Two nested loops. The *outer* one surveys the gap everywhere, in float64 from the
pressure alone; that either certifies the state or lists the *working set*: the points
under pressure and those whose gap is negative. The *inner* one (:mod:`.relaxation`)
minimises over the pressures of the working set, by default in float32: the residual it
starts from is exact, so its rounding errors shrink with it.

Either applies G by a transform pair, or, where few points carry pressure, by a direct
sum (:mod:`.direct`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace import loops
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.options import Correction
from roughbench.models.halfspace.relaxation import PENETRATION_SLACK, Relaxation
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid, tile_height

FLOAT32_FLOOR = 2e-7
"""Tolerances below this are iterated in float64 from the start."""

AIM_FLOOR = 1e-14
"""Smallest error aimed at near full contact, where float64 still can."""

SMALL_GAP = 1e-6
"""Mean gap, in h_rms, below which it is summed over the points without pressure: as a
difference of α and ⟨h⟩ it would be lost in their rounding errors."""

PREDICTION_REACH = 4.0
"""Largest step of the load, as a factor, over which the tangent predicts a start. Beyond
it the points in contact before carry what others should, and a cold start needs fewer
iterations: of seven loads on two surfaces of 512² points it does at a factor of 10 on
five and six, at a factor of 3 on one and two."""

TANGENT_TOLERANCE = 1e-5
"""Relative change of the stiffness in the last iteration of the tangent problem."""

DISPLACEMENTS = 4.0
"""Errors are measured against h_rms, or this many times the mean displacement of the loaded
points where that is less. With 1 the curves of the benchmarks take 1 to 3 % more transform
pairs, with 4 and more none."""

FEW = 5e-4
"""Share of points under pressure from which on a direct sum is not considered."""

PERIMETER_FACTOR = (math.pi - 1.0 + math.log(2.0)) / 24.0


@dataclass(frozen=True, slots=True)
class Certificate:
    """What a returned state violates, recomputed in float64 from its pressure.

    Attributes
    ----------
    complementarity : float
        Σ|p g| / (Σp · h_rms).
    penetration : float
        max(−g) / h_rms over all points.
    load_error : float
        |⟨p⟩/p̄ − 1|.
    displacement : float
        Σp u / (Σp · h_rms): how far the surface is displaced where it carries.
    """

    complementarity: float
    penetration: float
    load_error: float
    displacement: float

    @property
    def error(self) -> float:
        """Complementarity, or a tenth of the penetration if that is more.

        The penetration is a maximum over all points, the complementarity a mean.
        """
        return max(self.complementarity, self.penetration / PENETRATION_SLACK)

    @property
    def pressure_error(self) -> float:
        r"""Bound on the relative error of the pressures, ‖p − p*‖/‖p‖ with ‖p‖² = ⟨p·Gp⟩.

        For the exact pressures p*, ‖p − p*‖² ≤ ⟨g·(p − p*)⟩ ≤ ⟨pg⟩ + p̄ max(−g).
        """
        wrong = self.complementarity + self.penetration
        return math.sqrt(wrong / self.displacement) if wrong > 0.0 else 0.0

    def holds(self, tolerance: float) -> bool:
        """Whether a state may be called converged.

        Its error is at most ``tolerance``, in units of :attr:`scale`.
        """
        return self.error <= self.scale * tolerance and self.load_error <= max(tolerance, 1e-12)

    @property
    def scale(self) -> float:
        """Length, in h_rms, that errors are measured against."""
        return min(1.0, DISPLACEMENTS * self.displacement)


@dataclass(slots=True)
class Survey:
    """What a pressure leads to, in float64.

    Attributes
    ----------
    alpha, separation, energy, mass : float
        α = Σp(u − h)/Σp, the mean gap, ½⟨pu⟩ and Σp.
    moment, lowest : float
        Σp|g|, and the most negative gap of all points.
    fill : callable
        Makes the next working set, of a precision and a load Σp: tiles with pressure or
        negative gap, p carried over and r = gap. In float64, p and u are scaled to that
        load, which float32 holds to 1e-7 only: steps that had to mend it would not descend.
    """

    alpha: float
    separation: float
    energy: float
    mass: float
    moment: float
    lowest: float
    fill: Callable[[DTypeLike, float], WorkingSet]


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
        self.team = loops.Team(threads)
        self.size = heights.size
        self.mean = float(heights.mean(dtype=np.float64))
        self.rms = _rms(heights, self.mean)
        top = float(heights.max())
        self._even = self.team.even(heights.shape[0])
        self._double: Relaxation | None = None
        self._single: Relaxation | None = None
        self._use_single = not double and tolerance >= FLOAT32_FLOOR
        if self._use_single:
            self._single = Relaxation(heights.shape, np.float32, self.team)
            self.exact = HalfSpaceOperator(heights.shape, np.float64, self.team)
        else:
            self.exact = self._relaxation(double=True).operator
        self._full_gap: tuple[float, ...] | None = None
        self._direct: DirectOperator | None = None
        self._tops: NDArray[np.float64] | None = None
        # h = scale (heights − top), the dimensionless heights of the loops
        self._h = (heights, 1.0 / self.rms if self.rms > 0 else 0.0, top)
        self._depth = (top - self.mean) * self._h[1]  # −⟨h⟩
        # Contact is exactly full from p̄ = −min σ_fc on.
        _, (lowest, self.full_energy) = self.traction_at_full_contact()
        self.full_load = -lowest

    @property
    def pairs(self) -> int:
        """Transform pairs done so far."""
        operators = {id(self.exact): self.exact}
        for relaxation in (self._single, self._double):
            if relaxation is not None:
                operators[id(relaxation.operator)] = relaxation.operator
        return sum(operator.pairs for operator in operators.values())

    def _relaxation(self, *, double: bool) -> Relaxation:
        if not double and self._single is not None:
            return self._single
        if self._double is None:
            self._double = Relaxation(self.heights.shape, np.float64, self.team)
        return self._double

    def traction_at_full_contact(self) -> tuple[NDArray[np.floating], tuple[float, float]]:
        """σ_fc = S h, a field that the next transform overwrites; its minimum and ½⟨h σ_fc⟩."""
        field = self.exact.field
        heights, scale, _ = self._h
        np.subtract(heights, self.mean, out=field, dtype=np.float64)
        field *= scale
        self.exact.traction()
        parts = self.team.run(loops.traction_at_full_contact, self._even, field, *self._h)
        lowest = float(min(part[0] for part in parts))
        return field, (lowest, float(sum(part[1] for part in parts)) / (2 * self.size))

    def full_contact(self, load: float) -> Certificate:
        """Certificate of the pressure σ_fc + p̄, at a load of at least ``full_load``."""
        if self._full_gap is None:
            sigma = self.traction_at_full_contact()[0].copy()
            self.exact.field[...] = sigma
            self.exact.displace()
            parts = self.team.run(
                loops.gap_at_full_contact,
                self._even,
                *(sigma, self.exact.field, self.heights, self._h[1], self.mean),
            )
            sums = np.add.reduce([part[:3] for part in parts]) / self.size
            self._full_gap = *sums.tolist(), max(part[3] for part in parts)
        traction, gap, moment, penetration = self._full_gap
        return Certificate(
            complementarity=gap + moment / load,
            penetration=penetration,
            load_error=abs(traction) / load,
            displacement=2.0 * self.full_energy / load,
        )

    # -- starting points ---------------------------------------------------------------

    def cold_start(self, load: float) -> WorkingSet:
        """Pressure of independent springs k max(h − d, 0) at this load, k = U_full/M_0.

        That modulus, ½E*M_1/M_0, gives the springs the elastic energy of full contact.
        """
        modulus = 2.0 * self.full_energy
        shape = self.heights.shape
        dtype = self._relaxation(double=False).dtype
        points = self._overlap_of_few(load, modulus)
        if points is None:
            plane = _spring_plane(
                lambda plane: self.team.sum(loops.overlap_sums, self._even, *self._h, plane),
                -self._depth - load / modulus,  # there Σ(h − d) is the wanted sum already
                load / modulus * self.size,
            )
            self.exact.field[...] = 0.0
            none = WorkingSet.on(shape, np.zeros(tile_grid(shape), np.uint8), dtype)
            chosen, _, _ = self._choose(none, -plane)
            points = self._fill(none, -plane, chosen, dtype, 1.0)
            np.maximum(-points.r, 0, out=points.p)
        self._restore_load(points, load)
        return points

    def _overlap_of_few(self, load: float, modulus: float) -> WorkingSet | None:
        """Overlap max(h − d, 0) that carries the load, if the highest tiles suffice."""
        tops = self._tile_tops()
        n_tiles = max(64, tops.size // 64)
        if n_tiles >= tops.size:
            return None
        floor = float(np.partition(tops, tops.size - n_tiles, axis=None)[-n_tiles])
        # No other tile rises above the floor.
        points = WorkingSet.on(self.heights.shape, (tops > floor).view(np.uint8), np.float64)
        heights = self._heights_on(points)

        def overlap_sums(plane: float) -> NDArray[np.float64]:
            overlap = np.maximum(heights - plane, 0.0)
            return np.array([overlap.sum(), np.count_nonzero(overlap)])

        wanted = load / modulus * self.size
        if overlap_sums(floor)[0] < wanted:
            return None
        plane = _spring_plane(overlap_sums, floor, wanted)
        overlap = np.maximum(heights - plane, 0.0)
        points.p = overlap.astype(self._relaxation(double=False).dtype)
        return points.in_contact()

    def predict(
        self, solved: float, points: WorkingSet, rate: NDArray[np.floating], load: float
    ) -> WorkingSet | None:
        """Pressure at another load than ``solved``: p + Δp̄ ∂p/∂p̄ where that is positive.

        None where the other load is too far away for this to be a good start.
        """
        if load > PREDICTION_REACH * solved:
            return None
        rate *= rate.dtype.type(load - solved)
        points.p += rate
        np.maximum(points.p, 0, out=points.p)
        self._restore_load(points, load)
        return points

    def _restore_load(self, points: WorkingSet, load: float) -> None:
        points.p *= points.p.dtype.type(load * self.size / points.p.sum(dtype=np.float64))

    # -- outer loop --------------------------------------------------------------------

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
            survey = self._survey_directly(points) or self._survey(points)
            certificate = Certificate(
                complementarity=float(survey.moment / survey.mass),
                penetration=-float(survey.lowest),
                load_error=float(abs(survey.mass / total - 1.0)),
                displacement=float(2.0 * survey.energy * self.size / survey.mass),
            )
            if not math.isfinite(certificate.error + survey.mass):
                status = Status.NOT_FINITE
                break
            converged = certificate.holds(self.tolerance)
            aim = self.tolerance * certificate.scale
            if converged:
                # Near full contact the whole gap is smaller than the tolerance: aim at
                # 1 % of its mean, so that stiffness and area mean something there.
                aim = min(aim, max(0.01 * survey.separation, AIM_FLOOR))
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
            relaxation = self._relaxation(double=double)
            points = survey.fill(relaxation.dtype, total)
            del survey  # and with it the points before
            done, _ = relaxation.minimise(
                points,
                total,
                0.5 * aim,
                self.max_iterations - iterations,
                self._direct_for(points),
            )
            iterations += done
            self._restore_load(points, load)
        return Solution(
            load=load,
            points=points.in_contact(),
            alpha=survey.alpha,
            separation=survey.separation,
            energy=survey.energy,
            certificate=certificate,
            status=status,
            iterations=iterations,
            pairs=self.pairs - before,
        )

    def _survey(self, points: WorkingSet) -> Survey:
        """Survey of all points by one transform pair."""
        alpha, energy, mass = self._displace(points)
        chosen, moment, lowest = self._choose(points, alpha)
        separation = self._depth - alpha
        if separation < SMALL_GAP:
            blocks, _ = self.team.split(points.rows)
            (gap,) = self.team.sum(
                loops.open_gap,
                blocks,
                *points.layout,
                *(points.p, self.exact.field, *self._h, alpha),
            )
            separation = gap / self.size
        return Survey(
            *(alpha, separation, energy, mass, moment, lowest),
            fill=lambda dtype, total: self._fill(points, alpha, chosen, dtype, total / mass),
        )

    def _direct_for(self, points: WorkingSet) -> DirectOperator | None:
        """Return the direct sum, where it is cheaper than transforms on this working set."""
        n_sources = points.n_contact
        if n_sources >= FEW * self.size:
            self._direct = None  # its tables are not needed any more
            return None
        if self._direct is None:
            self._direct = DirectOperator(self.exact)
        return self._direct if self._direct.pays(n_sources, points.tiles.size) else None

    def _survey_directly(self, points: WorkingSet) -> Survey | None:
        """Survey by a direct sum, or None where a transform pair is cheaper.

        Where the pressure is on few points, a bound from below on u spares most others:
        a gap can be negative only at heights above it. Only tiles that reach so high are
        looked at.
        """
        if points.n_contact >= FEW * self.size:
            return None
        loaded = points.in_contact()
        direct = self._direct_for(loaded)
        if direct is None:
            return None
        p = loaded.p.astype(np.float64)
        u = np.empty_like(p)
        direct.apply(loaded, p, loaded, u)
        h = self._heights_on(loaded)
        contact = p > 0
        mass = float(p.sum())
        alpha = float((p[contact] * (u - h)[contact]).sum()) / mass
        tops = self._tile_tops()
        reaching = tops > mass * direct.lowest - alpha
        reaching[loaded.places] = False
        n_others = int(np.count_nonzero(reaching))
        if 4 * n_others > reaching.size or not direct.pays(loaded.n_contact, n_others):
            return None
        # Its p holds u here.
        others = WorkingSet.on(self.heights.shape, reaching.view(np.uint8), np.float64)
        direct.apply(loaded, p, others, others.p)
        np.subtract(others.p, self._heights_on(others), out=others.r)
        others.r -= alpha
        gap = u - h - alpha
        moment = float((p[contact] * np.abs(gap[contact])).sum())
        lowest = min(0.0, float(gap.min()), float(others.r.min(initial=0.0)))
        size = loaded.tile_size

        def fill(dtype: DTypeLike, total: float) -> WorkingSet:
            more = total / mass - 1.0 if np.dtype(dtype) == np.float64 else 0.0
            below = others.r.reshape(-1, size).min(axis=1, initial=0.0) < 0
            places = tuple(place[below] for place in others.places)
            chosen = np.zeros(reaching.shape, np.uint8)
            chosen[loaded.places] = chosen[places] = 1
            filled = WorkingSet.on(self.heights.shape, chosen, dtype)
            index = np.empty(chosen.shape, np.intp)
            index[filled.places] = np.arange(filled.tiles.size)
            p_tiles, r_tiles = filled.p.reshape(-1, size), filled.r.reshape(-1, size)
            p_tiles[:] = 0
            p_tiles[index[loaded.places]] = (p + more * p).reshape(-1, size)
            r_tiles[index[loaded.places]] = gaps(gap, u, more)
            r_tiles[index[places]] = gaps(others.r, others.p, more)[below]
            return filled

        def gaps(
            gap: NDArray[np.float64], u: NDArray[np.float64], more: float
        ) -> NDArray[np.float64]:
            return np.minimum(gap + more * u, loops.NEVER).reshape(-1, size)

        energy = float((p * u).sum()) / (2 * self.size)
        return Survey(alpha, self._depth - alpha, energy, mass, moment, lowest, fill)

    def _heights_on(self, points: WorkingSet) -> NDArray[np.float64]:
        """Dimensionless heights on a working set; −inf beyond the grid."""
        heights, scale, top = self._h
        n, m = heights.shape
        tops, lefts = points.corners
        rows = tops[:, None] + np.arange(points.height)
        columns = lefts[:, None] + np.arange(loops.TILE)
        values = heights[
            np.minimum(rows, n - 1)[:, :, None], np.minimum(columns, m - 1)[:, None, :]
        ].astype(np.float64)
        values -= top
        values *= scale
        values[(rows >= n)[:, :, None] | (columns >= m)[:, None, :]] = -np.inf
        return values.ravel()

    def _tile_tops(self) -> NDArray[np.float64]:
        """Largest dimensionless height of each tile."""
        if self._tops is None:
            heights, scale, top = self._h
            tops = np.empty(tile_grid(heights.shape))
            self.team.run(
                loops.tile_tops,
                self.team.even(tops.shape[0]),
                *(tile_height(heights.shape), heights, tops),
            )
            self._tops = (tops - top) * scale
        return self._tops

    def _displace(self, points: WorkingSet) -> tuple[float, float, float]:
        """Put u = G p into the exact field; return α = Σp(u − h)/Σp, ½⟨pu⟩ and Σp."""
        blocks, _ = self.team.split(points.rows)
        field = self.exact.field
        self.team.run(loops.scatter, blocks, *points.layout, points.p, field)
        self.exact.displace()
        mass, moment, energy = self.team.sum(
            loops.gap_sums, blocks, *points.layout, points.p, field, *self._h
        )
        return moment / mass, energy / (2 * self.size), mass

    def _choose(
        self, points: WorkingSet, alpha: float
    ) -> tuple[NDArray[np.uint8], float, float]:
        """Tiles with pressure or negative gap, Σp|g| and the most negative gap."""
        chosen = np.empty(tile_grid(self.heights.shape), np.uint8)
        parts = self.team.run(
            loops.choose_tiles,
            self.team.even(chosen.shape[0]),
            *points.layout,
            *(points.p, self.exact.field, *self._h, alpha, chosen),
        )
        return chosen, sum(part[0] for part in parts), min(part[1] for part in parts)

    def _fill(
        self,
        points: WorkingSet,
        alpha: float,
        chosen: NDArray[np.uint8],
        dtype: DTypeLike,
        factor: float,
    ) -> WorkingSet:
        """Working set of the chosen tiles, with p carried over and r = gap.

        In float64, p and u are multiplied by ``factor``.
        """
        filled = WorkingSet.on(self.heights.shape, chosen, dtype)
        exactly = filled.p.dtype == np.float64
        if exactly:
            self.exact.field[...] *= factor
        self.team.run(
            loops.fill_tiles,
            self.team.even(chosen.shape[0]),
            *points.layout,
            *(points.p, self.exact.field, *self._h, alpha),
            *(filled.rows, filled.tiles, filled.p, filled.r),
        )
        if exactly:
            filled.p *= factor
        return filled

    # -- what follows from a state -----------------------------------------------------

    def tangent(self, points: WorkingSet) -> tuple[float, NDArray[np.floating]]:
        """Stiffness −dp̄/dū at frozen contact, and ∂p/∂p̄ on the points."""
        if points.n_contact == self.size:
            return math.inf, np.ones_like(points.p)
        relaxation = self._relaxation(double=points.p.dtype == np.float64)
        compliance, rate, _ = relaxation.tangent(
            points, TANGENT_TOLERANCE, direct=self._direct_for(points)
        )
        return 1.0 / compliance, rate

    def area(self, points: WorkingSet, correction: Correction) -> tuple[float, float]:
        """A/A0, corrected for the perimeter or not, and points in contact / all points.

        Too many of the grid points next to a free edge of the contact count as contact; the
        excess is (π − 1 + ln 2)/24 of the grid edges there (Yastrebov, Anciaux and
        Molinari, 2017). The factor is that of edges in all directions on a surface; lines
        are not corrected.
        """
        if correction == "none" or self.heights.shape[0] == 1:
            raw = points.n_contact / self.size
            return raw, raw
        relaxation = self._relaxation(double=points.p.dtype == np.float64)
        heights, scale, _ = self._h
        contact, free = relaxation.count_edges(points, heights, scale)
        return (contact - PERIMETER_FACTOR * free) / self.size, contact / self.size

    def dense(self, solution: Solution) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Pressure and gap of a state as float64 fields, dimensionless."""
        self._displace(solution.points)
        shape = self.heights.shape
        pressure, gap = np.empty(shape), np.empty(shape)
        points = solution.points
        blocks, _ = self.team.split(points.rows)
        self.team.run(loops.scatter, blocks, *points.layout, points.p, pressure)
        self.team.run(
            loops.dense_gap, self._even, self.exact.field, *self._h, solution.alpha, gap
        )
        return pressure, gap


def _spring_plane(
    overlap_sums: Callable[[float], NDArray[np.float64]], plane: float, wanted: float
) -> float:
    """Height d < 0 of the plane, from the top, at which Σmax(h − d, 0) is ``wanted``.

    Newton's method from below: the sum is convex and falls with d, so that no step passes
    the answer, but for rounding. Where it passes the top itself, where nothing overlaps,
    the next try lies a thousand times closer to the top than the last.
    """
    for _ in range(200):
        overlap, count = overlap_sums(plane)
        if abs(overlap - wanted) <= 1e-9 * wanted:
            break
        higher = plane + (overlap - wanted) / count
        plane = float(higher) if higher < 0.0 else 1e-3 * plane
    return plane


def _rms(heights: NDArray[np.floating], mean: float) -> float:
    """Rms height in float64, row by row: no second array of the size of the heights."""
    total = 0.0
    for row in heights:
        deviation = row.astype(np.float64) - mean
        total += float((deviation * deviation).sum())
    return math.sqrt(total / heights.size)
