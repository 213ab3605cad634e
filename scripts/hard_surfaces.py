"""Solve contacts of surfaces that are hard for solvers, and count what does not converge.

    python scripts/hard_surfaces.py [--points 256] [--seed 1] [--tolerance 1e-6] [--only steps]

Forty surfaces are drawn: dimples, steps, scratches, few levels of height, single points far
off the rest, and self-affine roughness down to two points on a wave, with H from 0.1 to 1.
Each is pressed at 17 loads from 1e-7 to 0.99 of that of full contact, once along a curve, where
a state starts from the one before, and once for each load alone. A table says how many states
did not converge and what the others cost; those that did not are listed, and the exit code
is 1.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from _machine import describe_machine
from numpy.typing import NDArray

from roughbench.models.base import State, Status
from roughbench.models.halfspace.states import solve_states
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface

Heights = NDArray[np.float64]

LENGTH = 2 * math.pi
LOADS = np.concatenate(
    (np.geomspace(1e-7, 1e-2, 6), [0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 0.9, 0.97, 0.99])
)
"""In units of the load of full contact."""

HURST = (0.1, 0.3, 0.55, 0.8, 0.999)


def rough(
    n: int, random: np.random.Generator, *, hurst: float, rolloff: float, per_wave: int
) -> Heights:
    """Self-affine heights of slope 0.1."""
    spectrum = self_affine(
        hurst=hurst, q_min=1.0, q_rolloff=rolloff, q_max=n // per_wave, rms_slope=0.1
    )
    return make_surface(spectrum, n, LENGTH, random)


def base(n: int, random: np.random.Generator) -> Heights:
    """Roughness on which a texture is put, of rms height 1."""
    heights = rough(
        n,
        random,
        hurst=float(random.uniform(0.3, 0.95)),
        rolloff=float(random.choice([1.0, 4.0])),
        per_wave=int(random.choice([2, 4, 8])),
    )
    return heights / heights.std()


def distance(n: int, centre: NDArray[np.float64]) -> Heights:
    """Distance of every point from ``centre`` on the periodic grid, in grid points."""
    along = [np.abs(np.arange(n) - c) for c in centre]
    y, x = (np.minimum(d, n - d) for d in along)
    return np.hypot(y[:, None], x)


def dimples(n: int, random: np.random.Generator, _: int) -> Heights:
    """Spherical holes of several sizes in a wall with a little roughness."""
    heights = base(n, random) * random.choice([0.0, 1e-3, 0.1])
    for _ in range(int(random.integers(5, 40))):
        radius = random.uniform(0.01, 0.1) * n
        depth = random.uniform(0.2, 3.0)
        r = distance(n, random.uniform(0, n, 2)) / radius
        heights -= depth * np.maximum(0.0, 1.0 - r**2)
    return heights


def steps(n: int, random: np.random.Generator, _: int) -> Heights:
    """Terraces: a smooth landscape cut to few heights, some with roughness on them."""
    smooth = rough(n, random, hurst=0.9, rolloff=1.0, per_wave=max(n // 16, 2))
    levels = int(random.integers(2, 7))
    terraces = np.floor(levels * (smooth - smooth.min()) / np.ptp(smooth) * (1 - 1e-12))
    return terraces + base(n, random) * random.choice([0.0, 1e-6, 1e-2])


def scratches(n: int, random: np.random.Generator, _: int) -> Heights:
    """Straight narrow grooves with ridges beside them, in all directions."""
    heights = base(n, random) * random.choice([0.01, 0.1])
    for _ in range(int(random.integers(10, 60))):
        # Along wavevectors of the cell, so that the grooves meet at its borders.
        direction = random.integers(-3, 4, 2)
        if not direction.any():
            direction[:] = 1, 0
        phase = (direction[0] * np.arange(n)[:, None] + direction[1] * np.arange(n)) / n
        across = (phase - random.uniform()) % 1.0 - 0.5
        across *= n / math.hypot(*direction)  # grid points
        width = random.uniform(0.7, 4.0)
        heights += random.uniform(0.1, 1.0) * (
            0.3 * np.exp(-(((np.abs(across) - 2 * width) / width) ** 2))
            - np.exp(-((across / width) ** 2))
        )
    return heights


def quantized(n: int, random: np.random.Generator, number: int) -> Heights:
    """Roughness rounded to 3 to 3000 levels."""
    heights = base(n, random)
    step = np.ptp(heights) / [3, 10, 30, 300, 3000][number % 5]
    rounded: Heights = np.round(heights / step) * step
    return rounded


def outliers(n: int, random: np.random.Generator, _: int) -> Heights:
    """Roughness with single points far above and below."""
    heights = base(n, random)
    for sign in (1.0, -1.0):
        count = int(random.integers(1, 12))
        rows, columns = random.integers(0, n, (2, count))
        heights[rows, columns] += sign * random.uniform(3.0, 100.0, count)
    return heights


def nyquist(n: int, random: np.random.Generator, number: int) -> Heights:
    """Roughness with two points on the shortest wave, H from 0.1 to 1."""
    rolloff = (1.0, 8.0, 1.0)[number // len(HURST) % 3]
    hurst = HURST[number % len(HURST)]
    return rough(n, random, hurst=hurst, rolloff=rolloff, per_wave=2)


KINDS: dict[str, tuple[Callable[[int, np.random.Generator, int], Heights], int]] = {
    "dimples": (dimples, 5),
    "steps": (steps, 5),
    "scratches": (scratches, 5),
    "quantized": (quantized, 5),
    "outliers": (outliers, 5),
    "nyquist": (nyquist, 15),
}
"""Kind → what draws one, and how many."""


def draw(kind: str, number: int, n: int, seed: int) -> Heights:
    """Return the heights of one of the surfaces."""
    make, _ = KINDS[kind]
    place = list(KINDS).index(kind)
    return make(n, np.random.default_rng([seed, place, number]), number)


def full_contact_load(heights: Heights) -> float:
    """−min of E*|q|/2 h: the load from which on all points touch, in E*."""
    n = heights.shape[0]
    q = 2 * math.pi / LENGTH * n * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    traction = np.fft.irfft2(q / 2 * np.fft.rfft2(heights - heights.mean()), s=heights.shape)
    return -float(traction.min())


@dataclass(frozen=True)
class Solved:
    """A state, how it was reached, and how long that took."""

    place: str
    load: float
    state: State
    seconds: float

    @property
    def converged(self) -> bool:
        """Whether it is one that counts."""
        return self.state.status is Status.CONVERGED

    def describe(self) -> str:
        """One line with all that there is to know of it."""
        state, known = self.state, self.state.diagnostics
        return (
            f"{self.place}, {self.load:g} of full contact: {state.status.name}, "
            f"A/A0 = {state.area_raw:.3g}, complementarity {known['complementarity']:.1e}, "
            f"penetration {known['penetration']:.1e}, load error {known['load_error']:.1e}, "
            f"{known['iterations']} iterations"
        )


def solve(heights: Heights, place: str, tolerance: float) -> Iterator[Solved]:
    """Solve all loads along a curve, then each alone."""
    full = full_contact_load(heights)
    runs = [("curve", LOADS), *(("alone", LOADS[i : i + 1]) for i in range(LOADS.size))]
    for name, loads in runs:
        begin = time.perf_counter()
        found = solve_states(
            heights, full * loads, length=LENGTH, tolerance=tolerance, threads=1
        )
        for load, state in zip(loads, found, strict=True):
            end = time.perf_counter()
            yield Solved(f"{place}, {name}", float(load), state, end - begin)
            begin = end


def main() -> int:
    """Print the table and what did not converge."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=256, help="points per side")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--only", choices=list(KINDS))
    options = parser.parse_args()
    print(describe_machine("numpy", "numba", "pyfftw"))
    print(f"\n{options.points} × {options.points} points, tolerance {options.tolerance:g}\n")
    print(
        "| surfaces | | states | not converged | iterations, median | most "
        "| worst complementarity | s |"
    )
    print("|" + "-|" * 8)
    failures: list[Solved] = []
    total = 0
    for kind in [options.only] if options.only else KINDS:
        _, count = KINDS[kind]
        states = [
            solved
            for number in range(count)
            for solved in solve(
                draw(kind, number, options.points, options.seed),
                f"{kind} {number}",
                options.tolerance,
            )
        ]
        failed = [solved for solved in states if not solved.converged]
        failures += failed
        total += len(states)
        done = [solved.state.diagnostics for solved in states if solved.converged]
        iterations = [known["iterations"] for known in done]
        print(
            f"| {kind} | {count} | {len(states)} | {len(failed)} | {np.median(iterations):.0f} "
            f"| {max(iterations)} | {max(known['complementarity'] for known in done):.1e} "
            f"| {sum(solved.seconds for solved in states):.0f} |",
            flush=True,
        )
    for solved in failures:
        print(solved.describe())
    print(f"\n{len(failures)} of {total} states did not converge")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
