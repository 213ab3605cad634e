"""Solve a curve with one code and say, load by load, what it took.

    python curve.py CODE HEIGHTS.npy LENGTH TOLERANCE SECONDS LOAD... > states.json

CODE is roughbench, aspher, aspher-double, tamaas or contactmechanics; each runs where it
is installed. Loads are solved in the order given until SECONDS are used up (roughbench
solves all of them, in one curve with the stiffness at every load). E* = 1. Certificates
are computed outside the timed part.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from importlib import metadata
from typing import Any

import numpy as np
from certify import certify, peak_memory
from numpy.typing import NDArray

Heights = NDArray[np.float64]
Solve = Callable[[float], tuple[Any, int]]


def aspher(precision: str) -> Callable[[Heights, float, float], Solve]:
    """Nested grids, periodic, automatic preconditioner."""

    def prepare(heights: Heights, length: float, tolerance: float) -> Solve:
        import aspher as code

        n = heights.shape[0]
        gap = -heights.ravel()

        def solve(load: float) -> tuple[Any, int]:
            result = code.solve_nested(
                grid_size=n,
                gap=gap,
                p_nominal=load,
                domain_size=length,
                E_star=1.0,
                backend="periodic",
                tol=tolerance,
                precision=precision,
            )
            return result.pressure, int(result.iterations)

        return solve

    return prepare


def tamaas(heights: Heights, length: float, tolerance: float) -> Solve:
    """Polonsky-Keer, as documented."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(
        tm.model_type.basic_2d, [length, length], list(heights.shape)
    )
    model.E, model.nu = 1.0, 0.0
    solver = tm.PolonskyKeerRey(model, heights, tolerance)
    solver.max_iter = 100_000

    def solve(load: float) -> tuple[Any, int]:
        solver.solve(load)
        return np.array(model.traction), 0

    return solve


def contactmechanics(heights: Heights, length: float, tolerance: float) -> Solve:
    """Constrained conjugate gradients on a periodic half-space, as documented."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    n, m = heights.shape
    substrate = PeriodicFFTElasticHalfSpace((n, m), 1.0, (length, length))
    system = NonSmoothContactSystem(
        substrate=substrate, surface=Topography(heights, (length, length), periodic=True)
    )
    scale = float(heights.std())

    def solve(load: float) -> tuple[Any, int]:
        result = system.minimize_proxy(
            external_force=load * length**2,
            pentol=tolerance * scale,
            maxiter=10_000,
        )
        return np.asarray(result.jac) * (n * m / length**2), int(result.nit)

    return solve


PEERS = {
    "aspher": ("aspher", aspher("float_then_double")),
    "aspher-double": ("aspher", aspher("double")),
    "tamaas": ("tamaas", tamaas),
    "contactmechanics": ("ContactMechanics", contactmechanics),
}


def run_peer(code: str, heights: Heights, arguments: list[float]) -> dict[str, Any]:
    """Solve load by load."""
    length, tolerance, seconds, *loads = arguments
    package, prepare = PEERS[code]
    solve = prepare(heights, length, tolerance)
    states: list[dict[str, float]] = []
    used = 0.0
    for load in loads:
        if used > seconds:
            break
        start = time.perf_counter()
        pressure, iterations = solve(load)
        elapsed = time.perf_counter() - start
        used += elapsed
        state = {"asked": load, "seconds": elapsed, "iterations": iterations, "pairs": 0}
        states.append(state | certify(heights, pressure, length))
    return {"version": metadata.version(package), "states": states, "memory": peak_memory()}


def run_roughbench(heights: Heights, arguments: list[float]) -> dict[str, Any]:
    """Solve the curve; a short one first, so that nothing is compiled in the timed one."""
    import roughbench as rb
    from roughbench.models.halfspace.states import solve_states

    length, tolerance, _, *loads = arguments
    rb.solve_curve(heights, loads[:1], length=length, tolerance=tolerance)
    states = []
    start = time.perf_counter()
    for state in solve_states(heights, loads, length=length, tolerance=tolerance):
        end = time.perf_counter()
        found = state.diagnostics
        states.append(
            {
                "asked": state.pressure,
                "seconds": end - start,
                "iterations": int(found["iterations"]),
                "pairs": int(found["transform_pairs"]),
                "complementarity": float(found["complementarity"]),
                "penetration": float(found["penetration"]),
                "load": state.pressure * (1 + found["load_error"]),
                "area": state.area_raw,
                "separation": state.separation,
            }
        )
        start = end
    return {"version": rb.__version__, "states": states, "memory": peak_memory()}


def main() -> None:
    """Solve and print."""
    code, path = sys.argv[1:3]
    heights = np.ascontiguousarray(np.load(path), dtype=np.float64)
    arguments = [float(x) for x in sys.argv[3:]]
    if code == "roughbench":
        answer = run_roughbench(heights, arguments)
    else:
        answer = run_peer(code, heights, arguments)
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
