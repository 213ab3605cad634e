"""What the preparation of a scan does to the answer: a table, relative to the known one.

    python scripts/preparation_effects.py [SURFACES]

Periodic self-affine surfaces (H = 0.8, roll-off at 4 q0, q1 = 64 q0, slope 0.1, 256² points)
are solved exactly as they are. Then each is treated as scans are: tilted, windowed, cut to a
quarter of its area that is made periodic in several ways, holes made and filled, heights
rounded. The table holds the mean change of area A, separation ū and stiffness K of the exact
solution, and of Persson's area from the measured spectrum, in percent with its standard error
over the surfaces (default 16). It is printed as Markdown; docs/scans.md shows it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from roughbench import solve_curve
from roughbench.models.base import Sample
from roughbench.models.persson import Persson
from roughbench.scans.edges import STRIP
from roughbench.scans.preparation import Preparation, prepare
from roughbench.scans.topography import Scan
from roughbench.spectrum import measured_spectrum, self_affine
from roughbench.surface import make_surface, realization_generator

FloatArray = NDArray[np.float64]
Treated = tuple[FloatArray, float]
"""Heights of a periodic cell, and its length."""

POINTS, LENGTH, SEED = 256, 2.0 * math.pi, 2013
PRESSURES = [2e-3, 2e-2]
SPECTRUM = self_affine(hurst=0.8, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
TILT = math.tan(math.radians(1.3))


def prepared(heights: FloatArray, length: float, preparation: Preparation) -> Treated:
    """Prepare heights as a scan of this length."""
    result = prepare(Scan(heights, (length, length)), preparation)
    return result.heights, result.length


def tilted(heights: FloatArray) -> FloatArray:
    """Tilt along x."""
    return heights + TILT * LENGTH / POINTS * np.arange(POINTS)


def windowed(heights: FloatArray) -> Treated:
    """Multiply with Hann's window, scaled back to the rms height."""
    x = np.sin(np.pi * (np.arange(POINTS) + 0.5) / POINTS) ** 2
    pressed = heights * np.outer(x, x)
    pressed -= pressed.mean()
    return pressed * heights.std() / pressed.std(), LENGTH


def piece(heights: FloatArray, preparation: Preparation) -> Treated:
    """Cut a quarter out, and prepare it as a scan."""
    half = POINTS // 2
    return prepared(heights[:half, :half].copy(), LENGTH / 2, preparation)


def punctured(heights: FloatArray, share: float, radius: float, index: int) -> Treated:
    """Take points out, alone (radius 0) or in discs of a radius in points; fill them."""
    generator = realization_generator(SEED + 1, index)
    missing = np.zeros(heights.shape, bool)
    if radius == 0.0:
        order = generator.permutation(heights.size)
        missing.flat[order[: int(share * heights.size)]] = True
    y, x = np.ogrid[:POINTS, :POINTS]
    while radius > 0.0 and missing.mean() < share:
        row, column = generator.uniform(0, POINTS, 2)
        missing |= (y - row) ** 2 + (x - column) ** 2 < radius**2
    holes = np.where(missing, np.nan, heights)
    return prepared(holes, LENGTH, Preparation("none", 0.5, "periodic"))


def rounded(heights: FloatArray, share: float) -> Treated:
    """Round, so that rounding is this share of the rms difference of neighbours."""
    squares = [np.mean(np.diff(heights, axis=axis) ** 2) for axis in (0, 1)]
    step = share * math.sqrt(6.0 * float(np.mean(squares)))
    return step * np.round(heights / step), LENGTH


TREATMENTS: dict[str, Callable[[FloatArray, int], Treated]] = {
    "tilt of 1.3°, left": lambda h, _: (tilted(h), LENGTH),
    "tilt of 1.3°, `plane`, `periodic`": lambda h, _: prepared(
        tilted(h), LENGTH, Preparation("plane", edges="periodic")
    ),
    "tilt of 1.3°, `plane`, `mirror`": lambda h, _: prepared(
        tilted(h), LENGTH, Preparation("plane", edges="mirror")
    ),
    "Hann window at equal rms": lambda h, _: windowed(h),
    "a quarter of it, `periodic`": lambda h, _: piece(h, Preparation("mean", edges="periodic")),
    "a quarter of it, `crop`": lambda h, _: piece(h, Preparation("mean", edges="crop")),
    f"a quarter of it, `taper` ({STRIP:g} of each side)": lambda h, _: piece(
        h, Preparation("mean", edges="taper")
    ),
    "a quarter of it, `mirror`": lambda h, _: piece(h, Preparation("mean", edges="mirror")),
    "a quarter of it, `plane`, `mirror`": lambda h, _: piece(
        h, Preparation("plane", edges="mirror")
    ),
    "1 % missing in single points, filled": lambda h, i: punctured(h, 0.01, 0.0, i),
    "3 %": lambda h, i: punctured(h, 0.03, 0.0, i),
    "10 %": lambda h, i: punctured(h, 0.1, 0.0, i),
    "1 % missing in holes of 10 points across, filled": lambda h, i: punctured(h, 0.01, 5.0, i),
    "3 % so": lambda h, i: punctured(h, 0.03, 5.0, i),
    "10 % so": lambda h, i: punctured(h, 0.1, 5.0, i),
    "rounding 3 % of neighbours' difference": lambda h, _: rounded(h, 0.03),
    "rounding 10 %": lambda h, _: rounded(h, 0.1),
    "rounding 30 %": lambda h, _: rounded(h, 0.3),
}


def answers(heights: FloatArray, length: float) -> FloatArray:
    """Return A, ū and K of the exact solution and Persson's A, each at both pressures."""
    exact = solve_curve(heights, PRESSURES, length=length)
    sample = Sample(None, length, measured_spectrum(heights, length))
    theory = Persson().curve(sample, PRESSURES)
    return np.concatenate([exact.area, exact.separation, exact.stiffness, theory.area])


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    changes: dict[str, list[FloatArray]] = {name: [] for name in TREATMENTS}
    areas = []
    for index in range(count):
        generator = realization_generator(SEED, index)
        heights = make_surface(SPECTRUM, POINTS, LENGTH, generator)
        reference = answers(heights, LENGTH)
        areas.append(reference[:2])
        for name, treat in TREATMENTS.items():
            changes[name].append(100.0 * (answers(*treat(heights, index)) / reference - 1.0))
    shown = [f"{100.0 * area:.1f} %" for area in np.mean(areas, axis=0)]
    print(
        f"Change in percent, mean and standard error over {count} surfaces, at "
        f"p/E\\* = {PRESSURES[0]:g} and {PRESSURES[1]:g} (A/A₀ = {shown[0]} and {shown[1]}).\n"
    )
    print("| what was done | A | ū | K | Persson's A |\n|---|---|---|---|---|")
    for name, found in changes.items():
        mean = np.mean(found, axis=0)
        error = np.std(found, axis=0, ddof=1) / math.sqrt(count)
        pairs = [f"{m:+.1f} ± {e:.1f}" for m, e in zip(mean, error, strict=True)]
        cells = [f"{pairs[k]}, {pairs[k + 1]}" for k in range(0, len(pairs), 2)]
        print(f"| {name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
