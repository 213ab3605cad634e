"""The state at a given approach of a free half-space, by Newton's method in the force."""

from __future__ import annotations

from dataclasses import replace

from roughbench.models.base import Status
from roughbench.models.halfspace.solver import Solution, Solver

MAX_STEPS = 40

LARGEST_FACTOR = 8.0
"""By which the force changes in one step, at most."""


def solve_approach(solver: Solver, approach: float) -> Solution:
    r"""Return the state at the approach δ > 0, counted from the first contact.

    The force F(δ) rises like a power of δ, 3/2 for a sphere and 1 for a punch, and the
    tangent of each state gives the exponent β = (dF/dδ) δ/F. So F ← F (δ_wanted/δ)^β
    converges like Newton's method does; each state starts from the one before.

    Parameters
    ----------
    solver : Solver
        Of a free half-space.
    approach : float
        δ > 0, in the unit of the solver's heights.

    Returns
    -------
    Solution
        Converged if its certificate holds and δ is within the solver's tolerance of the
        wanted one, in the unit that the certificate has (:attr:`.Certificate.scale`).
    """
    # Half of it, for springs do not pull their neighbours along.
    load = solver.spring_load(0.5 * approach)
    points = solver.cold_start(load)
    iterations = pairs = 0
    for _ in range(MAX_STEPS):
        solution = solver.solve(load, points)
        iterations, pairs = iterations + solution.iterations, pairs + solution.pairs
        solution = replace(solution, iterations=iterations, pairs=pairs)
        off = abs(solution.alpha - approach)
        found = off <= solver.tolerance * solution.certificate.scale
        if found or solution.status is not Status.CONVERGED:
            return solution
        before = solver.pairs
        stiffness, rate = solver.tangent(solution.points)
        pairs += solver.pairs - before
        exponent = stiffness * solution.alpha / load
        factor = (approach / solution.alpha) ** exponent
        following = load * min(max(factor, 1.0 / LARGEST_FACTOR), LARGEST_FACTOR)
        start = solver.predict(load, solution.points, rate, following)
        load = following
        points = solver.cold_start(load) if start is None else start
    return replace(solution, points=solution.points, status=Status.MAX_ITERATIONS)
