r"""The load that leaves a prescribed mean gap ū: Newton's method on the load.

Each state solved says by its tangent, K = −dp̄/dū, at which load to go on. The method runs in

.. math:: y = \ln\frac{p̄}{p_f - p̄}, \qquad z = \ln\frac{ū}{ū_0 - ū},

with the load p_f of full contact (or the hardness, where that is less) and the gap ū₀ at first
contact. Where little touches, ū₀ − ū is a power of the load, and next to full contact ū is one
of p_f − p̄: in these variables both ends are straight lines. A step that leaves the bracket of
the loads solved so far halves it instead.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from roughbench.models.base import Status
from roughbench.models.halfspace.certificate import Certificate
from roughbench.models.halfspace.loops import gap
from roughbench.models.halfspace.solver import Solution, Solver
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid

MOST_STATES = 30
"""Loads tried at most; 3 to 6 are usual."""

GAP_SHARE = 0.01
"""Next to full contact ū is known to this part of it: nearer than that no load can be found."""


def solve_at_separation(
    solver: Solver, separation: float, start: NDArray[np.float64] | None = None
) -> Solution:
    """Return the state with the mean gap ū, in h_rms; its load is what was found.

    The certificate's load error is that against the load at ū, by the tangent: at most the
    tolerance in a ``converged`` state, or, next to full contact, what ``GAP_SHARE`` of ū makes.

    Parameters
    ----------
    solver : Solver
    separation : float
        0 < ū < depth of the mean below the highest point.
    start : ndarray, optional
        Pressures to start from, shape of the heights; their mean is the first load.
    """
    full = most_load(solver)
    low, high = 0.0, full
    load = _spring_load(solver, separation)
    if start is not None:
        load = float(start.mean())
    load = min(max(load, 1e-12 * full), (1.0 - 1e-6) * full)
    iterations, before = 0, solver.pairs
    points = solver.cold_start(load) if start is None else solver.start_from(start, load)
    best = math.inf
    for tried in range(MOST_STATES):
        solution = solver.solve(load, points)
        iterations += solution.iterations
        stiffness, rate = solver.tangent(solution.points)
        missed = solution.separation - separation
        error = abs(missed) * stiffness / load
        scale = solver.tolerance * solution.certificate.scale
        reached = error <= solver.tolerance and abs(missed) <= scale
        stalled = error > 0.5 * best and abs(missed) <= GAP_SHARE * separation
        best = min(best, error)
        if reached or stalled or solution.status is not Status.CONVERGED:
            break
        if missed > 0.0:
            low = load
        else:
            high = load
        before_this, load = (
            load,
            load_towards(
                solver,
                separation,
                from_load=load,
                separation=solution.separation,
                stiffness=stiffness,
            ),
        )
        if not low < load < high:
            load = 0.5 * (low + high) if low > 0.0 else 0.1 * high
        if not low < load < high or tried == MOST_STATES - 1:
            break
        points = solver.predict(before_this, solution.points, rate, load) or solver.cold_start(
            load
        )
    return replace(
        solution,
        certificate=replace(solution.certificate, load_error=error),
        status=solution.status
        if reached or stalled
        else max(solution.status, Status.STAGNATED),
        iterations=iterations,
        pairs=solver.pairs - before,
    )


def no_contact(solver: Solver, separation: float) -> Solution:
    """Return the state without contact, at a mean gap ū ≥ ū₀."""
    shape = solver.heights.shape
    return Solution(
        load=0.0,
        points=WorkingSet.on(shape, np.zeros(tile_grid(shape), np.uint8), np.float32),
        alpha=solver.depth - separation,
        separation=separation,
        energy=0.0,
        certificate=Certificate(0.0, 0.0, 0.0, 0.0),
        status=Status.CONVERGED,
        iterations=0,
        pairs=0,
    )


def load_towards(
    solver: Solver, wanted: float, *, from_load: float, separation: float, stiffness: float
) -> float:
    """Load for the mean gap ``wanted``: Newton's step in y and z from a state.

    Parameters
    ----------
    solver : Solver
    wanted : float
        ū in h_rms.
    from_load, separation, stiffness : float
        p̄ > 0, ū and K = −dp̄/dū of the state; dimensionless.

    Returns
    -------
    float
        nan where one of both ū is not between 0 and ū₀.
    """
    first, full = solver.depth, most_load(solver)
    if not (0.0 < separation < first and 0.0 < wanted < first and 0.0 < stiffness < math.inf):
        return math.nan
    z = math.log(separation / (first - separation))
    aim = math.log(wanted / (first - wanted))
    slope = (
        -(first / (separation * (first - separation)))
        * (from_load * (full - from_load) / full)
        / stiffness
    )
    y = math.log(from_load / (full - from_load)) + (aim - z) / slope
    return full / (1.0 + math.exp(-min(max(y, -700.0), 700.0)))


def most_load(solver: Solver) -> float:
    """p_f: the load of full contact, or the hardness, where that is less."""
    return min(solver.full_load, solver.hardness or math.inf)


def _spring_load(solver: Solver, separation: float) -> float:
    """Load of independent springs at this mean gap: ū = d − ⟨h⟩ + ⟨max(h − d, 0)⟩."""
    heights = solver.scaled_heights
    even = solver.team.even(solver.heights.shape[0])

    def overlap(plane: float) -> float:
        sums = solver.team.sum(gap.overlap_sums, even, heights.surface, plane)
        return float(sums[0]) / solver.size

    plane = brentq(
        lambda d: d + solver.depth + overlap(d) - separation,
        -solver.depth - solver.deepest,
        0.0,
        xtol=1e-12,
    )
    return 2.0 * solver.full_energy * overlap(plane)
