"""Compare the exact solver with Tamaas 2.9 on the same heights.

    python scripts/compare_tamaas.py [--grid 256]

Tamaas (Frérot, Anciaux, Rey, Pham-Ba and Molinari, 2020) is an independent code. It runs
in an environment of its own, ``.venv-peers``, which this script makes; heights go over as
a .npy file. Tamaas solves to a tolerance of 1e-12, roughbench to its default of 1e-6.
Prints a Markdown table; exits with 1 unless, at every pressure, A (points in contact /
all points) agrees within 1e-4 and ū within 1e-6 h_rms.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from _machine import describe_machine
from _peers import peer_python
from numpy.typing import NDArray

from roughbench.models.halfspace.contact import solve_contact
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

HERE = Path(__file__).resolve().parent
LENGTH = 2 * math.pi
TAMAAS_TOLERANCE = 1e-12
AREA_LIMIT, SEPARATION_LIMIT = 1e-4, 1e-6
SEED = 2013
PRESSURES = (4e-4, 3e-3, 1.5e-2, 4.5e-2, 9e-2)
"""p/E*; A from about 1 % to 95 % at an rms slope of 0.1."""

SURFACES = {  # q_r/q0 and points on the shortest wave
    "q_r = 8 q0, 4 points on the shortest wave": (8.0, 4),
    "q_r = q0, q1 at the Nyquist wavevector": (1.0, 2),
}


def solve_with_tamaas(heights: NDArray[np.float64]) -> dict[str, Any]:
    """Return Tamaas' version and its states at the pressures."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "heights.npy"
        np.save(path, heights)
        arguments = [str(x) for x in (path, LENGTH, TAMAAS_TOLERANCE, *PRESSURES)]
        environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
        done = subprocess.run(
            [peer_python(), HERE / "peers" / "solve_tamaas.py", *arguments],
            check=True,
            stdout=subprocess.PIPE,
            env=environment,
        )
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def compare(title: str, q_rolloff: float, points: int, grid: int) -> bool:
    """Print the table of one surface; return whether all of it agrees."""
    spectrum = self_affine(
        hurst=0.7, q_min=1.0, q_rolloff=q_rolloff, q_max=grid / points, rms_slope=0.1
    )
    heights = make_surface(spectrum, grid, LENGTH, realization_generator(SEED, 0))
    h = float(heights.std())
    peer = solve_with_tamaas(heights)
    print(f"\n### {grid}², {title}\n\nTamaas {peer['version']}\n")
    print(
        "| p/E* | A, roughbench | A, Tamaas | difference | ū/h, roughbench | ū/h, Tamaas"
        " | difference | U, relative | complementarity | error of Tamaas | agree |"
    )
    print("|" + "-|" * 11)
    agree = True
    for pressure, other in zip(PRESSURES, peer["states"], strict=True):
        state = solve_contact(heights, pressure, length=LENGTH)
        area = state.area_fraction_raw - other["area"]
        separation = (state.mean_separation - other["separation"]) / h
        good = (
            state.status.name == "CONVERGED"
            and other["error"] <= TAMAAS_TOLERANCE
            and abs(area) <= AREA_LIMIT
            and abs(separation) <= SEPARATION_LIMIT
        )
        agree &= good
        print(
            f"| {pressure:g} | {state.area_fraction_raw:.6f} | {other['area']:.6f} "
            f"| {area:+.1e} | {state.mean_separation / h:.9f} | {other['separation'] / h:.9f} "
            f"| {separation:+.1e} | {state.energy / other['energy'] - 1:+.1e} "
            f"| {state.certificate.complementarity:.1e} | {other['error']:.1e} "
            f"| {'yes' if good else '**no**'} |"
        )
    return agree


def main() -> None:
    """Print the comparisons; exit with 1 where they fail."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--grid", type=int, default=256, help="points per side")
    grid = parser.parse_args().grid
    print(describe_machine("numpy", "numba", "pyfftw"))
    agree = [compare(title, *options, grid) for title, options in SURFACES.items()]
    print("\nAll states agree." if all(agree) else "\nSome states do not agree.")
    sys.exit(0 if all(agree) else 1)


if __name__ == "__main__":
    main()
