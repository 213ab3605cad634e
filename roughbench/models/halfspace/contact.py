"""The exact solver's public face: states and curves of given heights."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SolverError
from roughbench.inputs import (
    check_heights,
    float_array,
    positive_number,
    real_array,
    real_number,
    whole_number,
)
from roughbench.models.base import CompleteCurve, Fields, FloatArray, State, Status
from roughbench.models.halfspace import memory
from roughbench.models.halfspace.options import Correction, Precision
from roughbench.models.halfspace.solver import (
    FLOAT32_FLOOR,
    Solution,
    Solver,
)
from roughbench.models.halfspace.working_set import WorkingSet

SMALLEST_LOAD = 1e-20
"""In E* h_rms/Δ. A single point of a grid carries its share of less; float32 does not."""


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
    pressure : ndarray of float64
        Contact pressure, shape of the heights, unit of the modulus.
    gap : ndarray of float64
        Local separation, shape of the heights, length; in contact it is zero up to the
        certificate.
    iterations, transform_pairs : int
        Work that the state took.

    Notes
    -----
    A state holds its two fields and the loaded points, nothing of the solver: it can be
    copied, pickled and sent to other processes.
    """

    def __init__(self, problem: _Problem, solution: Solution | None, load: float) -> None:
        solver = problem.solver
        self._tangent = None if solution is None else _Tangent(problem, solution.points)
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
            self.mean_separation = solution.separation * solver.rms
            self.energy = solution.energy * problem.energy_unit
            self.status = solution.status
            self.certificate = solution.certificate
            self.iterations, self.transform_pairs = solution.iterations, solution.pairs
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

    def __init__(self, problem: _Problem, points: WorkingSet) -> None:
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
            solver = Solver(np.zeros(*self._heights), self._tolerance, **self._options)
            # Of a copy: the tangent problem needs room beside the pressures.
            value, _ = solver.tangent(self._points.in_contact())
            self._value = float(value * self._pressure_unit / self._rms)
        return self._value


def solve_contact(
    heights: ArrayLike,
    pressure: float,
    *,
    length: float = 1.0,
    modulus: float = 1.0,
    tolerance: float = 1e-6,
    precision: Precision = "mixed",
    threads: int | None = None,
    max_iterations: int = 3000,
    correction: Correction = "perimeter",
) -> ContactState:
    r"""Press a hard rough wall against a periodic elastic half-space.

    Minimises ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0 with ⟨p⟩ = ``pressure`` on the grid of the
    heights, where G(q) = 2/(E*\|q\|) (Stanley and Kato, 1997).

    Parameters
    ----------
    heights : array_like of float, shape (n, m) or (n,)
        Heights of the wall, upwards into contact, length. Their mean is subtracted.
        One-dimensional heights are a line contact on a half-plane.
    pressure : float
        Nominal pressure p > 0, in the unit of ``modulus``.
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
    nominal = real_number(pressure, "pressure")
    problem = _Problem(
        heights, length, modulus, tolerance, precision, threads, max_iterations, correction
    )
    load = float(problem.loads([nominal])[0])
    solver = problem.solver
    if load >= solver.full_load:
        return ContactState(problem, None, load)
    return ContactState(problem, solver.solve(load, solver.cold_start(load)), load)


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
    length, modulus, tolerance, precision, threads, max_iterations, correction
        As in :func:`solve_contact`.

    Returns
    -------
    Curve
        In the order of ``pressures``; stiffness in modulus/length, energy U/A0 in
        modulus · length. Diagnostics: complementarity, penetration, load_error,
        iterations, transform_pairs.

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
    )
    # The states come first: they check the arguments.
    return CompleteCurve.from_states(list(states), np.array(pressures, dtype=np.float64))


def solve_states(
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
    finished: Mapping[str, NDArray[Any]] | None = None,
) -> Iterator[State]:
    """Yield the states of :func:`solve_curve` one by one, in the order of rising pressure.

    Parameters
    ----------
    heights, pressures, length, modulus, tolerance, precision, threads, max_iterations, \
    correction
        As in :func:`solve_curve`.
    finished : mapping of str to ndarray, optional
        Snapshot of a state of the same curve to go on from, to the bits it would have had.

    Yields
    ------
    State
        With fields and snapshots.
    """
    problem = _Problem(
        heights, length, modulus, tolerance, precision, threads, max_iterations, correction
    )
    loads, solver = problem.loads(pressures), problem.solver
    nominal = np.array(pressures, dtype=np.float64)
    latest = _Latest(problem) if finished is None else _Latest.since(problem, finished)
    finished = None  # its vectors are those of the state before
    # Of the state before, one at most: nothing else may keep its vectors while the next
    # one is solved.
    before: list[tuple[float, WorkingSet, NDArray[np.floating]]] = []
    if latest.points is not None:
        before.append((latest.load, latest.points, solver.tangent(latest.points)[1]))
    for i in np.argsort(nominal, kind="stable")[latest.done :]:
        load, pairs = float(loads[i]), solver.pairs
        latest.begin(load)
        if load >= solver.full_load:
            before.clear()
            area = raw = 1.0
            separation, stiffness = 0.0, math.inf
            energy, certificate = solver.full_energy, solver.full_contact(load)
            status, iterations = Status.CONVERGED, 0
        else:
            start = solver.predict(*before.pop(), load) if before else None
            solution = solver.solve(load, solver.cold_start(load) if start is None else start)
            del start
            area, raw = solver.area(solution.points, problem.correction)
            tangent, rate = solver.tangent(solution.points)
            before = [(load, solution.points, rate)]
            del rate
            separation = solution.separation * solver.rms
            stiffness = tangent * problem.pressure_unit / solver.rms
            energy, certificate = solution.energy, solution.certificate
            status, iterations = solution.status, solution.iterations
            latest.solution = solution
            del solution
        yield State(
            pressure=float(nominal[i]),
            area=float(area),
            separation=float(separation),
            stiffness=float(stiffness),
            energy=float(energy * problem.energy_unit),
            status=status,
            area_raw=float(raw),
            diagnostics={
                "complementarity": certificate.complementarity,
                "penetration": certificate.penetration,
                "load_error": certificate.load_error,
                "iterations": np.int32(iterations),
                "transform_pairs": np.int32(solver.pairs - pairs),
            },
            fields=partial(latest.fields, latest.done),
            snapshot=partial(latest.snapshot, latest.done),
        )


class _Latest:
    """The state that was solved last, and alone can be asked for fields or a snapshot.

    A :class:`State` refers to it instead of its vectors: whoever keeps one keeps no vectors.

    Attributes
    ----------
    done : int
        States begun, in the order of rising pressure.
    load : float
        Of the last one.
    solution : Solution or None
        Of the last one; None in full contact.
    """

    def __init__(self, problem: _Problem) -> None:
        self.done = 0
        self.load = math.nan
        self.solution: Solution | None = None
        self._problem = problem
        self._resumed: WorkingSet | None = None

    @classmethod
    def since(cls, problem: _Problem, finished: Mapping[str, NDArray[Any]]) -> _Latest:
        """Take up a snapshot."""
        latest = cls(problem)
        latest.done = int(finished["done"])
        if "load" in finished:
            latest.load = float(finished["load"])
            latest._resumed = WorkingSet.under_pressure(
                int(finished["height"]), *(finished[name] for name in ("rows", "tiles", "p"))
            )
        return latest

    @property
    def points(self) -> WorkingSet | None:
        """Pressures that the next state may start from."""
        return self._resumed if self.solution is None else self.solution.points

    def begin(self, load: float) -> None:
        """Drop the vectors of the state before: the next one needs the room."""
        self.done += 1
        self.load = load
        self.solution = self._resumed = None

    def fields(self, done: int) -> Fields:
        """Return the fields of the last state."""
        self._check(done)
        return self._problem.fields(self.solution, self.load)

    def snapshot(self, done: int) -> dict[str, NDArray[Any]]:
        """Arrays to go on from: the pressures that the next state starts from."""
        self._check(done)
        arrays = {"done": np.array(done)}
        if self.solution is not None:
            points = self.solution.points
            arrays |= {"load": np.array(self.load), "height": np.array(points.height)}
            arrays |= {"rows": points.rows, "tiles": points.tiles, "p": points.p}
        return arrays

    def _check(self, done: int) -> None:
        if done != self.done:
            raise RuntimeError("of an earlier state: ask before the next state is computed")


class _Options(TypedDict):
    """Those of :class:`Solver`."""

    double: bool
    threads: int
    max_iterations: int


class _Problem:
    """Checked arguments, the solver on them, and the units between the two."""

    def __init__(
        self,
        heights: ArrayLike,
        length: float,
        modulus: float,
        tolerance: float,
        precision: Precision,
        threads: int | None,
        max_iterations: int,
        correction: Correction,
    ) -> None:
        h = real_array(heights, "heights", kinds="buif")
        if h.ndim not in (1, 2) or min(h.shape, default=0) < 2:
            raise SolverError(
                "heights must be a line (n,) or a surface (n, m) of at least 2 points a "
                f"side, got shape {h.shape}"
            )
        length = positive_number(length, "length")
        modulus = positive_number(modulus, "modulus")
        tolerance = positive_number(tolerance, "tolerance")
        if tolerance > 0.1:
            raise SolverError(f"tolerance must be at most 0.1, got {tolerance}")
        if not (isinstance(precision, str) and precision in ("mixed", "double")):
            raise SolverError(f"precision must be 'mixed' or 'double', got {precision!r}")
        if not (isinstance(correction, str) and correction in ("perimeter", "none")):
            raise SolverError(f"correction must be 'perimeter' or 'none', got {correction!r}")
        if threads is not None:
            threads = whole_number(threads, "threads")
        max_iterations = whole_number(max_iterations, "max_iterations")
        # What makes the solver iterate in float64, and would have to be otherwise.
        reasons = ["precision: mixed"] * (precision == "double")
        reasons += [f"tolerance: {FLOAT32_FLOOR:g}"] * (tolerance < FLOAT32_FLOOR)
        memory.check(
            h.shape,
            double=bool(reasons),
            instead=" with ".join(reasons),
            converted=h.dtype not in (np.float32, np.float64),
        )
        check_heights(h, per_point=0)
        if h.dtype not in (np.float32, np.float64):
            h = h.astype(np.float64)
        self.shape = h.shape
        self.spacing = length / h.shape[0]
        self.modulus = modulus
        self.correction: Correction = correction
        self.options = _Options(
            double=precision == "double",
            threads=threads or len(os.sched_getaffinity(0)),
            max_iterations=max_iterations,
        )
        surface = h.reshape((1, -1)) if h.ndim == 1 else h
        self.solver = Solver(surface, tolerance, **self.options)
        rms = self.solver.rms
        if not (rms == 0.0 or 1e-152 < rms < 1e152) or (rms == 0.0 and np.ptp(h) > 0):
            raise SolverError(
                f"heights with an rms value of {rms:g} are out of the range of float64; "
                "choose another unit of length"
            )
        # A flat wall has no scale of its own; its only state is full contact.
        rms = self.solver.rms or 1.0
        self.pressure_unit = modulus * rms / self.spacing
        self.energy_unit = modulus * rms**2 / self.spacing
        for unit in (self.pressure_unit, self.energy_unit, self.pressure_unit / rms):
            if not np.finfo(np.float64).tiny <= unit < math.inf:
                raise SolverError(
                    f"with a length of {length:g}, a modulus of {modulus:g} and an rms height "
                    f"of {rms:g} the results leave the range of float64; choose units in which "
                    "they are nearer to 1"
                )

    def loads(self, pressures: ArrayLike) -> NDArray[np.float64]:
        """Dimensionless nominal pressures."""
        p: FloatArray = float_array(pressures, "pressures")
        if p.ndim != 1 or p.size == 0:
            raise SolverError(f"pressures must be a list of numbers, got shape {p.shape}")
        bad = ~((p > 0.0) & np.isfinite(p))
        if bad.any():
            raise SolverError(f"pressures must be positive and finite, got {p[bad][0]}")
        loads = p / self.pressure_unit
        low = p[loads < SMALLEST_LOAD]
        if low.size:
            raise SolverError(
                f"pressures must be at least {SMALLEST_LOAD * self.pressure_unit:.1e} on "
                f"these heights ({SMALLEST_LOAD:g} E* h_rms/Δ), got {low[0]}"
            )
        return loads

    def fields(self, solution: Solution | None, load: float) -> Fields:
        """Return pressure, in the unit of the modulus, and gap of a state, None for full."""
        if solution is None:
            sigma, _ = self.solver.traction_at_full_contact()
            pressure = (sigma + load) * self.pressure_unit
            gap = np.zeros_like(pressure)
        else:
            pressure, gap = self.solver.dense(solution)
            pressure *= self.pressure_unit
            gap *= self.solver.rms
        return Fields(pressure.reshape(self.shape), gap.reshape(self.shape))
