"""The exact solver's public face: states and curves of given heights."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError
from roughbench.inputs import real_number
from roughbench.models.base import CompleteCurve, Status
from roughbench.models.halfspace.options import Correction, Precision
from roughbench.models.halfspace.problem import Problem
from roughbench.models.halfspace.separation import no_contact, solve_at_separation
from roughbench.models.halfspace.solver import Solution, Solver
from roughbench.models.halfspace.states import solve_states
from roughbench.models.halfspace.working_set import WorkingSet


class ContactState:
    """One solved state: fields, averages and the certificate of the returned pressure.

    Attributes
    ----------
    area_fraction : float
        A/A0, by default corrected for the perimeter of the contact on the grid.
    area_fraction_raw : float
        Points in contact / all points.
    mean_separation : float
        ū, the unit of the heights.
    energy : float
        Elastic energy per nominal area U/A0, modulus · length.
    status : Status
        ``CONVERGED`` only if the certificate holds for the tolerance.
    certificate : Certificate
        Complementarity, penetration and load error, recomputed in float64.
    plastic_depth : float
        Mean of −gap over plastic points, per point of the grid, length; 0 without a hardness.
        The mean gap that is left is ``mean_separation + plastic_depth``.
    pressure : ndarray of float64
        Contact pressure, shape of the heights, unit of the modulus.
    gap : ndarray of float64
        Local separation, shape of the heights, length; in contact it is zero up to the
        certificate, and at plastic points negative: so far the material has given way.
    iterations, transform_pairs : int
        Work that the state took.
    history : list of Progress, or None
        Where it was asked for: ``transform_pairs``, ``error`` and ``is_certified`` of each
        iteration and evaluation. With a prescribed separation those of all loads tried, each
        counted from zero.

    Notes
    -----
    A state holds its two fields and the loaded points, nothing of the solver: it can be
    copied, pickled and sent to other processes.
    """

    def __init__(self, problem: Problem, solution: Solution | None, load: float) -> None:
        solver = problem.solver
        self._tangent = (
            None if solution is None else _Tangent(problem, solver.elastic(solution.points))
        )
        self.plastic_depth = 0.0 if solution is None else solution.plastic_depth * solver.rms
        if solution is None:
            self.area_fraction = self.area_fraction_raw = 1.0
            self.mean_separation = 0.0
            self.energy = solver.full_energy * problem.energy_unit
            self.status = Status.CONVERGED
            self.certificate = solver.full_contact(load)
            self.iterations = self.transform_pairs = 0
        else:
            self.area_fraction, self.area_fraction_raw = solver.area(
                solution.points, problem.correction
            )
            self.mean_separation = solution.separation * problem.height_unit
            self.energy = solution.energy * problem.energy_unit
            self.status = solution.status
            self.certificate = solution.certificate
            self.iterations, self.transform_pairs = solution.iterations, solution.pairs
        self.history = solver.history
        fields = problem.fields(solution, load)
        self.pressure, self.gap = fields.pressure, fields.gap

    def stiffness(self) -> float:
        """K = −dp/dū at frozen contact, modulus/length; inf at full contact."""
        return math.inf if self._tangent is None else self._tangent.stiffness()


class _Tangent:
    """What the stiffness of a state follows from: the loaded points and the grid.

    The solver would be large, and bound to its process; another one is made when it is
    asked for.
    """

    def __init__(self, problem: Problem, points: WorkingSet) -> None:
        solver = problem.solver
        self._points = points
        self._heights = solver.heights.shape, solver.heights.dtype
        self._tolerance = solver.tolerance
        self._options = problem.options
        self._pressure_unit, self._rms = problem.pressure_unit, solver.rms
        self._value: float | None = None

    def stiffness(self) -> float:
        """K, modulus/length; computed once."""
        if self._value is None:
            # With the contact frozen the heights do not matter: flat ones will do.
            options = self._options | {"hardness": None}  # plastic points are left out
            solver = Solver(np.zeros(*self._heights), self._tolerance, **options)
            # Of a copy: the tangent problem needs room beside the pressures.
            value, _ = solver.tangent(self._points.in_contact())
            self._value = float(value * self._pressure_unit / self._rms)
        return self._value


def solve_contact(
    heights: ArrayLike,
    pressure: float | None = None,
    *,
    separation: float | None = None,
    length: float = 1.0,
    modulus: float = 1.0,
    tolerance: float = 1e-6,
    precision: Precision = "mixed",
    threads: int | None = None,
    max_iterations: int = 3000,
    correction: Correction = "perimeter",
    hardness: float | None = None,
    start: ArrayLike | None = None,
    history: bool = False,
) -> ContactState:
    r"""Press a hard rough wall against a periodic elastic half-space.

    Minimises ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0 with ⟨p⟩ = ``pressure`` on the grid of the
    heights, where G(q) = 2/(E*\|q\|) (Stanley and Kato, 1997).

    Parameters
    ----------
    heights : array_like of float, shape (n, m) or (n,)
        Heights of the wall, upwards into contact, length. Their mean is subtracted.
        One-dimensional heights are a line contact on a half-plane.
    pressure : float, optional
        Nominal pressure p > 0, in the unit of ``modulus``. Either this or ``separation``.
    separation : float, optional
        Mean gap ū > 0 instead, in the unit of the heights: the load that leaves it is found, by
        Newton's method with K as the tangent. Without contact (ū of at least the height of the
        highest point above the mean) the state has zero pressure.
    length : float
        Side of the periodic cell along the first axis, in the unit of the heights;
        pixels are square.
    modulus : float
        Contact modulus E* > 0.
    tolerance : float
        Largest relative complementarity Σ|p g|/(Σp h_rms) of a converged state;
        its penetration max(−g)/h_rms may be ten times as large.
    precision : {"mixed", "double"}
        Iterate in float32 (and in float64 where that does not suffice) or float64.
        The certificate is computed in float64 either way.
    threads : int, optional
        Threads of transforms and loops; default: all cores available.
    max_iterations : int
        Limit on the inner iterations.
    correction : {"perimeter", "none"}
        Correct the area for the points that a grid counts too many along those edges of the
        contact that the solution finds, or not. Lines are not corrected.
    hardness : float, optional
        Upper bound H ≥ p̄ on the pressure, in the unit of ``modulus``: elastic and perfectly
        plastic (Almqvist et al., 2007). Where p = H the gap is zero or negative. ``energy``
        is the elastic part, K is at points that go on to carry H.
    start : array_like of float, shape of the heights, optional
        Contact pressures to start the iteration from, in the unit of ``modulus``; they are
        multiplied to the load. Those of a similar state save iterations; the result is the same
        within the tolerance. With ``separation`` their mean is the first load.
    history : bool
        Whether to keep what each iteration had reached, as ``state.history``.

    Raises
    ------
    SolverError
        If an argument is out of its range, the heights are not finite, or the grid does
        not fit into memory.

    Examples
    --------
    A sinusoidal wall at half the pressure of full contact (Westergaard, 1939):

    >>> import numpy as np
    >>> x = np.arange(1024) / 1024
    >>> state = solve_contact(0.01 * np.cos(2 * np.pi * x), np.pi * 0.01 / 2)
    >>> state.status.name
    'CONVERGED'
    >>> bool(abs(state.area_fraction_raw - 0.5) < 2e-3)
    True
    """
    if (pressure is None) == (separation is None):
        raise SolverError("give exactly one of pressure and separation")
    problem = Problem(
        *(heights, length, modulus, tolerance, precision, threads, max_iterations),
        *(correction, hardness),
    )
    solver = problem.solver
    solver.history = [] if history else None
    given = None if start is None else problem.start(start)
    if separation is not None:
        wanted = problem.gap_wanted(separation)
        if wanted >= solver.depth:
            solution = no_contact(solver, wanted)
        else:
            solution = solve_at_separation(solver, wanted, given)
        return ContactState(problem, solution, solution.load)
    load = float(problem.loads([real_number(pressure, "pressure")])[0])
    if solver.is_full(load):
        return ContactState(problem, None, load)
    points = solver.cold_start(load) if given is None else solver.start_from(given, load)
    return ContactState(problem, solver.solve(load, points), load)


def solve_curve(
    heights: ArrayLike,
    pressures: ArrayLike,
    *,
    length: float = 1.0,
    modulus: float = 1.0,
    tolerance: float = 1e-6,
    precision: Precision = "mixed",
    threads: int | None = None,
    max_iterations: int = 3000,
    correction: Correction = "perimeter",
    hardness: float | None = None,
) -> CompleteCurve:
    """Solve states at many pressures on the same heights, each started from its neighbour.

    States are solved in the order of rising pressure, whatever order is asked for, so the
    result does not depend on that order. Parameters are those of :func:`solve_contact`.

    Parameters
    ----------
    heights : array_like of float, shape (n, m) or (n,)
        Length.
    pressures : array_like of float, shape (k,)
        Nominal pressures p > 0 in the unit of ``modulus``, in any order.
    length, modulus, tolerance, precision, threads, max_iterations, correction, hardness
        As in :func:`solve_contact`.

    Returns
    -------
    Curve
        In the order of ``pressures``; stiffness in modulus/length, energy U/A0 in
        modulus · length. Diagnostics: complementarity, penetration, load_error,
        iterations, transform_pairs; with a hardness plastic_depth.

    Raises
    ------
    SolverError
        If an argument is out of its range, the heights are not finite, or the grid does
        not fit into memory.
    """
    states = solve_states(
        heights,
        pressures,
        length=length,
        modulus=modulus,
        tolerance=tolerance,
        precision=precision,
        threads=threads,
        max_iterations=max_iterations,
        correction=correction,
        hardness=hardness,
    )
    # The states come first: they check the arguments.
    return CompleteCurve.from_states(list(states), np.array(pressures, dtype=np.float64))
