"""Time and memory of preparing and checking a scan, and of filling its holes.

    python scripts/bench_scans.py [POINTS]

A self-affine scan of POINTS² (default 2048²), tilted, 5 % of it missing: as single points, as
holes of all sizes, as one hole and as columns at its border. Medians of five runs after one
that is not counted; memory in arrays of the scan's size, the scan itself included, by
tracemalloc in a run of its own.
"""

from __future__ import annotations

import statistics
import sys
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
from _machine import describe_machine
from numpy.typing import NDArray

from roughbench.scans.checks import doubts_of
from roughbench.scans.filling import fill_holes
from roughbench.scans.preparation import Preparation, prepare
from roughbench.scans.topography import Scan
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

SIZE, MISSING, REPEATS = 10e-6, 0.05, 5
Mask = NDArray[np.bool_]


def discs(points: int, count: int, generator: np.random.Generator) -> Mask:
    """Return discs that miss the wanted share of a square, less where they overlap."""
    y, x = np.ogrid[:points, :points]
    radius = points * np.sqrt(MISSING / count / np.pi)
    missing = np.zeros((points, points), bool)
    for row, column in generator.uniform(0, points, (count, 2)):
        missing |= (y - row) ** 2 + (x - column) ** 2 < radius**2
    return missing


def masks(points: int) -> dict[str, Mask]:
    """Return where points are missing, by name."""
    generator = np.random.default_rng(1)
    columns = np.zeros((points, points), bool)
    columns[:, points - int(MISSING * points) :] = True
    return {
        "single points": generator.random((points, points)) < MISSING,
        "1000 holes": discs(points, 1000, generator),
        "20 holes": discs(points, 20, generator),
        "one hole": discs(points, 1, np.random.default_rng(3)),
        "border": columns,
    }


def measure(name: str, work: Callable[[], object], array: int, held: float) -> None:
    """Print the median time of a piece of work and its peak memory in arrays."""
    work()
    times, busy = [], []
    for _ in range(REPEATS):
        start, start_busy = time.perf_counter(), time.process_time()
        work()
        times.append(time.perf_counter() - start)
        busy.append(time.process_time() - start_busy)
    tracemalloc.start()
    result = work()
    peak = tracemalloc.get_traced_memory()[1] / array + held
    tracemalloc.stop()
    del result
    print(
        f"{name:40s} {statistics.median(times):6.2f} s (from {min(times):.2f} to "
        f"{max(times):.2f}), processor {statistics.median(busy):.2f} s, {peak:.2f} arrays"
    )


def main() -> None:
    """Print machine, times and memory."""
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 2048
    print(describe_machine("numpy", "scipy"))
    spectrum = self_affine(hurst=0.8, q_min=1, q_rolloff=4, q_max=points // 4, rms_slope=0.1)
    heights = make_surface(spectrum, points, 2 * np.pi, realization_generator(1, 0))
    heights *= SIZE / (2 * np.pi)
    y, x = np.ogrid[:points, :points]
    heights += 0.02 * SIZE / points * y - 0.01 * SIZE / points * x
    print(f"\n{points} x {points} points\n")
    scans = {"complete": heights}
    for name, missing in masks(points).items():
        scans[name] = np.where(missing, np.nan, heights)
        share = f"{100 * missing.mean():.1f} %"

        def fill(holes: NDArray[np.float64] = scans[name]) -> None:
            fill_holes(holes.copy(), (1.0, 1.0))

        measure(f"fill, {name}, {share}", fill, heights.nbytes, 1.0)
    for name, preparation in {
        "complete": Preparation("plane", edges="mirror"),
        "single points": Preparation("plane", 0.06, "mirror"),
        "20 holes": Preparation("quadratic", 0.06, "taper"),
        "border": Preparation("plane", 0.06, "crop"),
    }.items():
        scan = Scan(scans[name], (SIZE, SIZE))
        options = f"{preparation.detrend}, {preparation.edges}"

        def work(scan: Scan = scan, preparation: Preparation = preparation) -> object:
            return prepare(scan, preparation)

        measure(f"prepare, {name}, {options}", work, heights.nbytes, 1.0)
        prepared = prepare(scan, preparation)

        def check(
            found: NDArray[np.float64] = prepared.heights,
            length: float = prepared.length,
            scan: Scan = scan,
            preparation: Preparation = preparation,
        ) -> object:
            return doubts_of(found, length, raw=scan, preparation=preparation)

        held = 1.0 + prepared.heights.nbytes / heights.nbytes
        measure(f"check, {name}, {options}", check, heights.nbytes, held)


if __name__ == "__main__":
    main()
