"""A curve state by state: each starts from the one before, and may be gone on from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.inputs import exactly_one, float_array
from roughbench.models.base import Fields, State, Status
from roughbench.models.halfspace.options import Boundary, Correction, Precision
from roughbench.models.halfspace.problem import Length, Problem
from roughbench.models.halfspace.solver import Solution
from roughbench.models.halfspace.working_set import WorkingSet


def solve_states(
    heights: ArrayLike,
    pressures: ArrayLike | None = None,
    *,
    forces: ArrayLike | None = None,
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
    finished: Mapping[str, NDArray[Any]] | None = None,
) -> Iterator[State]:
    """Yield the states of :func:`solve_curve` one by one, in the order of rising pressure.

    Parameters
    ----------
    heights, pressures, forces, length, modulus, tolerance, precision, threads, \
    max_iterations, correction, hardness, screening, boundary
        As in :func:`solve_curve`.
    finished : mapping of str to ndarray, optional
        Snapshot of a state of the same curve to go on from, to the bits it would have had.

    Yields
    ------
    State
        With fields and snapshots.
    """
    problem = Problem(
        *(heights, length, modulus, tolerance, precision, threads, max_iterations),
        *(correction, hardness, screening, boundary),
    )
    exactly_one(pressures=pressures, forces=forces)
    if pressures is None:
        pressures = float_array(forces, "forces") / problem.area  # type: ignore[arg-type]
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
        stiffness: float = math.inf
        if solver.is_full(load):
            before.clear()
        else:
            start = solver.predict(*before.pop(), load) if before else None
            latest.solution = solver.solve(
                load, solver.cold_start(load) if start is None else start
            )
            del start
            stiffness, rate = solver.tangent(latest.solution.points)
            before = [(load, latest.solution.points, rate)]
            del rate
        state = state_of(
            *(problem, float(nominal[i]), load, latest.solution, stiffness),
            pairs=solver.pairs - pairs,
        )
        yield replace(
            state,
            fields=partial(latest.fields, latest.done),
            snapshot=partial(latest.snapshot, latest.done),
        )


def state_of(
    problem: Problem,
    pressure: float,
    load: float,
    solution: Solution | None,
    stiffness: float,
    *,
    pairs: int,
) -> State:
    """Return the quantities of one state of a curve, in the units of the heights and E*.

    Parameters
    ----------
    problem : Problem
    pressure : float
        Nominal one, in the unit of the modulus.
    load : float
        The same, dimensionless.
    solution : Solution or None
        None in full contact.
    stiffness : float
        −dp̄/dū, without a period dp̄/dδ; dimensionless.
    pairs : int
        Transform pairs that the state took.
    """
    solver, unit = problem.solver, problem.height_unit
    if solution is None:
        area = raw = 1.0
        separation, depth = 0.0, 0.0
        energy, certificate = solver.full_energy, solver.full_contact(load)
        status, iterations = Status.CONVERGED, 0
    else:
        area, raw = solver.area(solution.points, problem.correction)
        separation, depth = solution.separation, solution.plastic_depth
        energy, certificate = solution.energy, solution.certificate
        status, iterations = solution.status, solution.iterations
    diagnostics: dict[str, float | np.number[Any]] = {
        "complementarity": certificate.complementarity,
        "penetration": certificate.penetration,
        "load_error": certificate.load_error,
        "iterations": np.int32(iterations),
        "transform_pairs": np.int32(pairs),
    }
    if problem.hardness is not None:
        diagnostics["plastic_depth"] = float(depth * unit)
    return State(
        pressure=pressure,
        area=float(area),
        separation=float(separation * unit),
        stiffness=float(stiffness * problem.pressure_unit / unit),
        energy=float(energy * problem.energy_unit),
        status=status,
        area_raw=float(raw),
        diagnostics=diagnostics,
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

    def __init__(self, problem: Problem) -> None:
        self.done = 0
        self.load = math.nan
        self.solution: Solution | None = None
        self._problem = problem
        self._resumed: WorkingSet | None = None

    @classmethod
    def since(cls, problem: Problem, finished: Mapping[str, NDArray[Any]]) -> _Latest:
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
