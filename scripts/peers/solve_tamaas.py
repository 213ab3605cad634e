"""Solve contacts with Tamaas; runs in the peers' environment, knows nothing of roughbench.

    python solve_tamaas.py HEIGHTS.npy LENGTH TOLERANCE PRESSURE... > states.json

E* = 1. Prints one object per pressure: area (points in contact / all), separation
(mean gap), energy (half the mean of pressure times zero-mean displacement) and error
(what Tamaas says it reached).
"""

from __future__ import annotations

import json
import sys

import numpy as np
import tamaas as tm


def main() -> None:
    """Solve and print."""
    heights = np.ascontiguousarray(np.load(sys.argv[1]), dtype=np.float64)
    length, tolerance = float(sys.argv[2]), float(sys.argv[3])
    tm.set_log_level(tm.LogLevel.error)
    states = []
    for pressure in map(float, sys.argv[4:]):
        model = tm.ModelFactory.createModel(
            tm.model_type.basic_2d, [length, length], list(heights.shape)
        )
        model.E, model.nu = 1.0, 0.0
        solver = tm.PolonskyKeerRey(model, heights, tolerance)
        solver.max_iter = 100_000
        error = solver.solve(pressure)
        traction, displacement = np.asarray(model.traction), np.asarray(model.displacement)
        states.append(
            {
                "area": float((traction > 0.0).mean()),
                "separation": float(np.asarray(model["gap"]).mean()),
                "energy": 0.5 * float((traction * (displacement - displacement.mean())).mean()),
                "error": float(error),
            }
        )
    json.dump({"version": tm.__version__, "states": states}, sys.stdout)


if __name__ == "__main__":
    main()
