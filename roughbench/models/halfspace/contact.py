"""The exact solver's public face: states and curves of given heights."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from roughbench import labelled
from roughbench.errors import SolverError
from roughbench.inputs import exactly_one, float_array, real_number
from roughbench.labelled import NamedArray
from roughbench.models.base import CompleteCurve, FloatArray, State, Status
from roughbench.models.halfspace.approach import solve_approach
from roughbench.models.halfspace.options import Boundary, Correction, Precision
from roughbench.models.halfspace.problem import Length, Problem
from roughbench.models.halfspace.separation import (
    load_towards,
    no_contact,
    solve_at_separation,
)
from roughbench.models.halfspace.solver import Solution, Solver
from roughbench.models.halfspace.start import PREDICTION_REACH
from roughbench.models.halfspace.states import solve_states, state_of
from roughbench.models.halfspace.working_set import WorkingSet

if TYPE_CHECKING:
    from roughbench.labelled import Dataset


class ContactState:
    """One solved state: fields, averages and the certificate of the returned pressure.

    Attributes
    ----------
    area_fraction : float
        A/A0, by default corrected for the perimeter of the contact on the grid.
    area_fraction_raw : float
        Points in contact / all points.
    mean_separation : float
        ū, the unit of the heights. On a free half-space minus the approach, counted from the
        first contact.
    force : float
        Σ of the pressures over the points' areas, modulus · length²; of a line per length.
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
    size : tuple of float
        Sides of the cell along the axes of the heights, (y, x) or (x,), length.
    modulus : float
        E*.
    iterations, transform_pairs : int
        Work that the state took.
    history : list of IterationError, or None
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
        self.size, self.modulus = problem.size, problem.modulus
        self.force = load * problem.pressure_unit * problem.area
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
        """K = −dp/dū at frozen contact, modulus/length; inf at full contact.

        On a free half-space dF/dδ, modulus · length, of the force and the approach.
        """
        return math.inf if self._tangent is None else self._tangent.stiffness()

    def to_xarray(self) -> Dataset:
        """Return pressure and gap over x and y as a dataset of xarray, the rest as attributes.

        Raises
        ------
        RoughbenchError
            Without xarray.
        """
        axes = ("y", "x")[-self.pressure.ndim :]
        arrays = {
            axis: NamedArray(
                (axis,), side / n * np.arange(n), "length", f"position along {axis}"
            )
            for axis, side, n in zip(axes, self.size, self.pressure.shape, strict=True)
        }
        words = {"pressure": ("modulus", "contact pressure"), "gap": ("length", "gap")}
        for name, (unit, text) in words.items():
            arrays[name] = NamedArray(axes, getattr(self, name), unit, f"{text} at every point")
        numbers = ("area_fraction", "area_fraction_raw", "mean_separation", "force", "energy")
        return labelled.dataset(
            arrays,
            {
                **{
                    name: getattr(self, name) for name in (*numbers, "plastic_depth", "modulus")
                },
                "status": self.status.name.lower(),
                "complementarity": self.certificate.complementarity,
                "penetration": self.certificate.penetration,
                "load_error": self.certificate.load_error,
            },
        )


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
        self._area = problem.area if problem.free else 1.0
        self._value: float | None = None

    def stiffness(self) -> float:
        """K, modulus/length; computed once."""
        if self._value is None:
            # With the contact frozen the heights do not matter: flat ones will do.
            options = self._options | {"hardness": None}  # plastic points are left out
            solver = Solver(np.zeros(*self._heights), self._tolerance, **options)
            # Of a copy: the tangent problem needs room beside the pressures.
            value, _ = solver.tangent(self._points.in_contact())
            self._value = float(value * self._pressure_unit / self._rms * self._area)
        return self._value


def solve_contact(
    heights: ArrayLike,
    pressure: float | None = None,
    *,
    separation: float | None = None,
    force: float | None = None,
    length: Length = 1.0,
    modulus: float = 1.0,
    boundary: Boundary = "periodic",
    tolerance: float = 1e-6,
    precision: Precision = "mixed",
    threads: int | None = None,
    max_iterations: int = 3000,
    correction: Correction = "perimeter",
    hardness: float | None = None,
    screening: float = 0.0,
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
        Nominal pressure p > 0, in the unit of ``modulus``: the force over the area of the
        heights. Exactly one of pressure, separation and force is given.
    separation : float, optional
        Mean gap ū > 0 instead, in the unit of the heights: the load that leaves it is found, by
        Newton's method with K as the tangent. Without contact (ū of at least the height of the
        highest point above the mean) the state has zero pressure. With ``boundary="free"``:
        minus the approach, counted from the first contact; negative.
    force : float, optional
        F > 0, modulus · length²; of a line per length.
    length : float or (float, float)
        Sides (y, x) of the periodic cell along both axes, in the unit of the heights; or of
        square points that along the first axis.
    modulus : float
        Contact modulus E* > 0.
    boundary : {"periodic", "free"}
        Whether the cell repeats, or the heights given are all there is, on a half-space
        without end. The wall then ends where the heights do, and displacements count from
        the undeformed surface far away. Not for lines: there they grow without bound.
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
        contact that the solution finds, or not; of a line 0.19 points an edge.
    hardness : float, optional
        Upper bound H ≥ p̄ on the pressure, in the unit of ``modulus``: elastic and perfectly
        plastic (Almqvist et al., 2007). Where p = H the gap is zero or negative. ``energy``
        is the elastic part, K is at points that go on to carry H. On the periodic half-space,
        with square points.
    screening : float
        q_c ≥ 0, 1/length: the half-space with G(q) = 2/(E*√(q² + q_c²)), where waves longer
        than 2π/q_c do not couple. G(0) stays 0, so that ū is the mean gap.
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

    A sphere on a half-space without end (Hertz, 1882): F = (4/3)E*√R δ^(3/2).

    >>> x = np.linspace(-0.5, 0.5, 128)
    >>> sphere = -(x[:, None]**2 + x**2) / (2 * 10.0)
    >>> state = solve_contact(sphere, separation=-0.01, boundary="free")
    >>> bool(abs(state.force / (4 / 3 * 10.0**0.5 * 0.01**1.5) - 1) < 2e-2)
    True
    """
    exactly_one(pressure=pressure, separation=separation, force=force)
    problem = Problem(
        *(heights, length, modulus, tolerance, precision, threads, max_iterations),
        *(correction, hardness, screening, boundary),
    )
    solver = problem.solver
    solver.history = [] if history else None
    first = None if start is None else problem.start(start)
    if separation is not None:
        solution = _at_separation(problem, separation, first)
        return ContactState(problem, solution, solution.load)
    if pressure is None:
        nominal = real_number(force, "force") / problem.area
    else:
        nominal = real_number(pressure, "pressure")
    load = float(problem.loads([nominal])[0])
    if solver.is_full(load):
        return ContactState(problem, None, load)
    points = solver.cold_start(load) if first is None else solver.start_from(first, load)
    return ContactState(problem, solver.solve(load, points), load)


def _at_separation(problem: Problem, separation: float, start: FloatArray | None) -> Solution:
    """Return the state at a mean gap or, without a period, minus an approach."""
    solver = problem.solver
    if problem.free:
        if start is not None:
            raise SolverError("start needs a pressure or a force with boundary: free")
        return solve_approach(solver, problem.approach_wanted(separation))
    wanted = problem.gap_wanted(separation)
    if wanted >= solver.depth:
        return no_contact(solver, wanted)
    return solve_at_separation(solver, wanted, start)


def solve_curve(
    heights: ArrayLike,
    pressures: ArrayLike | None = None,
    *,
    forces: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    length: Length = 1.0,
    modulus: float = 1.0,
    tolerance: float = 1e-6,
    precision: Precision = "mixed",
    threads: int | None = None,
    max_iterations: int = 3000,
    correction: Correction = "perimeter",
    hardness: float | None = None,
    screening: float = 0.0,
    boundary: Boundary = "periodic",
) -> CompleteCurve:
    """Solve states at many pressures on the same heights, each started from its neighbour.

    States are solved in the order of rising pressure (or falling separation), whatever order
    is asked for, so the result does not depend on that order. Parameters are those of
    :func:`solve_contact`.

    Parameters
    ----------
    heights : array_like of float, shape (n, m) or (n,)
        Length.
    pressures : array_like of float, shape (k,), optional
        Nominal pressures p > 0 in the unit of ``modulus``, in any order.
    forces : array_like of float, shape (k,), optional
        Instead of them: forces F > 0, modulus · length² (of a line per length).
    separations : array_like of float, shape (k,), optional
        Instead of them: mean gaps ū > 0 in the unit of the heights, or minus the approaches
        with ``boundary="free"``. The pressures of the curve are those that were found.
    length, modulus, tolerance, precision, threads, max_iterations, correction, \
    hardness, screening, boundary
        As in :func:`solve_contact`.

    Returns
    -------
    Curve
        In the order of what was given; its pressures are the forces over the area of the
        heights; stiffness in modulus/length, energy U/A0 in
        modulus · length. Diagnostics: complementarity, penetration, load_error,
        iterations, transform_pairs; with a hardness plastic_depth.

    Raises
    ------
    SolverError
        If an argument is out of its range, the heights are not finite, or the grid does
        not fit into memory.
    """
    exactly_one(pressures=pressures, forces=forces, separations=separations)
    if separations is not None:
        problem = Problem(
            *(heights, length, modulus, tolerance, precision, threads, max_iterations),
            *(correction, hardness, screening, boundary),
        )
        return _curve_at(problem, float_array(separations, "separations"))
    states = solve_states(
        heights,
        pressures,
        forces=forces,
        length=length,
        modulus=modulus,
        tolerance=tolerance,
        precision=precision,
        threads=threads,
        max_iterations=max_iterations,
        correction=correction,
        hardness=hardness,
        screening=screening,
        boundary=boundary,
    )
    # The states come first: they check the arguments.
    solved = list(states)
    wanted = np.array(forces if pressures is None else pressures, dtype=np.float64)
    nominal = np.empty(wanted.size)
    nominal[np.argsort(wanted, kind="stable")] = [state.pressure for state in solved]
    return CompleteCurve.from_states(solved, nominal)


def _curve_at(problem: Problem, separations: FloatArray) -> CompleteCurve:
    """Return the states at mean gaps or, without a period, minus approaches.

    A periodic state starts from the pressures of the one before it, at the load that its
    tangent says, where that is near.
    """
    if separations.ndim != 1 or separations.size == 0:
        raise SolverError(
            f"separations must be a list of one or more, got shape {separations.shape}"
        )
    solver = problem.solver
    order = np.argsort(-separations, kind="stable")
    nominal = np.empty(separations.size)
    states: dict[int, State] = {}
    start: FloatArray | None = None
    for i, following in zip(order, [*order[1:], None], strict=True):
        solution = _at_separation(problem, float(separations[i]), start)
        load = solution.load
        stiffness, _ = solver.tangent(solution.points)
        nominal[i] = load * problem.pressure_unit
        states[i] = state_of(
            problem, float(nominal[i]), load, solution, stiffness, pairs=solution.pairs
        )
        start = None
        if following is not None and load > 0.0 and not problem.free:
            wanted = float(separations[following]) / problem.height_unit
            load = load_towards(
                solver,
                wanted,
                from_load=load,
                separation=solution.separation,
                stiffness=stiffness,
            )
            if load <= PREDICTION_REACH * solution.load:
                start = solver.dense(solution)[0] * (load / solution.load)
    # By pressure: states without contact have the same, and need not be in the order solved.
    rising = [states[i] for i in np.argsort(nominal, kind="stable")]
    return CompleteCurve.from_states(rising, nominal)
