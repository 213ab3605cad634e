"""Time the foundation at the paper's size, and check it against a slow bisection.

    python scripts/bench_foundation.py

100 realizations × 8192 springs × 60 pressures from first contact to full contact, lines
made and solved in one thread, after one call that compiles the loops (timed apart). The
check solves F(d) = p by bisection with exactly rounded sums (``math.fsum``) and counts
the regions spring by spring.
"""

from __future__ import annotations

import itertools
import math
import time

import numpy as np
from _machine import describe_machine
from numpy.typing import NDArray

from roughbench.models.base import Curve, Sample
from roughbench.models.foundation import Foundation
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import make_profile, realization_generator

REALIZATIONS, SPRINGS, PRESSURES = 100, 8192, np.geomspace(1e-7, 5e-3, 60)
LENGTH, SEED, REPEATS = 2 * math.pi, 2013, 5
CHECKED = (0, 37, 99)  # realizations, each at every fifth pressure


def line(model: Foundation, spectrum: Spectrum, realization: int) -> NDArray[np.float64]:
    """Return the heights of one realization."""
    return make_profile(
        spectrum,
        model.grid_points(spectrum, LENGTH),
        LENGTH,
        realization_generator(SEED, realization),
        undersampled=model.undersampled,
    )


def slow_state(heights: NDArray[np.float64], pressure: float) -> tuple[float, float, float]:
    """Return A/A0, ū and K of the periodic line by bisection."""
    n = heights.size
    low, high = float(heights.min()) - 4 * LENGTH * pressure, float(heights.max())
    while True:
        plane = (low + high) / 2
        mean = math.fsum(np.maximum(heights - plane, 0.0)) / n
        if plane in (low, high):
            break
        low, high = (plane, high) if 4 / math.pi * mean / LENGTH > pressure else (low, plane)
    contact = (heights >= plane).tolist()
    c = sum(contact) / n
    if c == 1:
        return 1.0, 0.0, math.inf
    gap = contact.index(False)
    runs = itertools.groupby(contact[gap:] + contact[:gap])
    squares = sum(len(list(run)) ** 2 for touching, run in runs if touching)
    separation = math.fsum(np.maximum(plane - heights, 0.0)) / n
    return squares / n**2, separation, 4 / (math.pi * LENGTH) * c / (1 - c)


def solve_all(model: Foundation, spectrum: Spectrum) -> list[Curve]:
    """Make and solve every realization."""
    return [
        model.curve(Sample(line(model, spectrum, r), LENGTH, spectrum), PRESSURES)
        for r in range(REALIZATIONS)
    ]


def main() -> None:
    """Print machine, times and errors."""
    print(describe_machine("numpy", "numba"))
    print(
        f"{REALIZATIONS} realizations x {SPRINGS} springs x {PRESSURES.size} pressures, "
        "one thread, lines included"
    )
    model = Foundation(springs=SPRINGS, undersampled="truncate")
    start = time.perf_counter()
    model.curve(Sample(np.cos(np.arange(16.0)), LENGTH), PRESSURES)
    startup = time.perf_counter() - start
    print(f"start-up (import numba, compile or load the loops): {startup:.2f} s")
    for q_rolloff in (1.0, 8.0):
        spectrum = self_affine(
            hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=8192, rms_slope=0.1
        )
        times = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            curves = solve_all(model, spectrum)
            times.append(time.perf_counter() - start)
        errors = np.zeros(3)
        for r in CHECKED:
            heights = line(model, spectrum, r)
            for i in range(0, PRESSURES.size, 5):
                area, separation, stiffness = slow_state(heights, PRESSURES[i])
                curve = curves[r]
                difference = [
                    abs(curve.area[i] - area),
                    abs(curve.separation[i] - separation) / spectrum.rms_height,
                    0.0
                    if math.isinf(stiffness) and math.isinf(curve.stiffness[i])
                    else abs(curve.stiffness[i] / stiffness - 1),
                ]
                errors = np.maximum(errors, difference)
        full = np.mean([np.isinf(curve.stiffness) for curve in curves])
        print(
            f"q_rolloff {q_rolloff:g}: {min(times):.3f} s (best of {REPEATS}; worst "
            f"{max(times):.3f} s); {full:.0%} of the states in full contact; largest "
            f"deviation from bisection: A/A0 {errors[0]:.1e}, separation/h_rms "
            f"{errors[1]:.1e}, K (relative) {errors[2]:.1e}"
        )


if __name__ == "__main__":
    main()
