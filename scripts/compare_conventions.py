"""Check each line of docs/conventions.md against the code it is about.

    python scripts/compare_conventions.py

The codes run in an environment of their own, ``.venv-peers``, which this script makes; fields
go over as .npy files. Prints a Markdown table; exits with 1 if a line does not hold, or a code
is missing.
"""

from __future__ import annotations

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

import roughbench as rb
from roughbench.models.halfspace.perimeter import PERIMETER_FACTOR
from roughbench.surface import rms_height_and_slope

HERE = Path(__file__).resolve().parent
PEERS = ("SurfaceTopography", "ContactMechanics", "tamaas", "aspher")
MODULUS, PRESSURE, SIDE = 2.0, 0.02, 2.0


def edges(touching: Any) -> int:
    """Return the number of edges of the periodic grid between contact and gap."""
    return sum(int((touching != np.roll(touching, 1, axis)).sum()) for axis in (0, 1))


def free_edges(state: Any) -> int:
    """Return how many of them the area was corrected for: those that the solution found."""
    excess = (state.area_fraction_raw - state.area_fraction) * state.pressure.size
    return round(excess / PERIMETER_FACTOR)


def by_differences(heights: Any, size: list[float]) -> float:
    """Return the rms gradient of differences between neighbours."""
    parts = (
        (np.roll(heights, -1, axis) - heights) / (side / n)
        for axis, (side, n) in enumerate(zip(size, heights.shape, strict=True))
    )
    return float(np.sqrt(sum(part**2 for part in parts).mean()))


def write_case(folder: Path, name: str, part: slice) -> dict[str, Any]:
    """Solve a contact, leave its fields in a folder, and return its numbers."""
    q0 = 2 * math.pi / SIDE
    law = {"hurst": 0.7, "q_min": q0, "q_rolloff": 12 * q0, "q_max": 16 * q0}
    spectrum = rb.self_affine(**law, rms_slope=0.1)
    heights = np.ascontiguousarray(rb.make_surface(spectrum, 64, SIDE, 2013)[:, part])
    size = [SIDE, SIDE * heights.shape[1] / 64]
    state = rb.solve_contact(
        *(heights, PRESSURE),
        length=(size[0], size[1]),
        modulus=MODULUS,
        tolerance=1e-11,
        precision="double",
    )
    if state.status.name != "CONVERGED":
        raise SystemExit(f"{name}: roughbench did not converge")
    for field in ("pressure", "gap"):
        np.save(folder / f"{name}-{field}.npy", getattr(state, field))
    np.save(folder / f"{name}-heights.npy", heights)
    rms_height, rms_slope = rms_height_and_slope(heights, SIDE)
    profile = rb.make_profile(spectrum, 64, SIDE, 1)
    q_min, q_rolloff, q_max = (2 * math.pi * n for n in (4, 8, 64))
    other = rb.self_affine(
        hurst=0.7, q_min=q_min, q_rolloff=q_rolloff, q_max=q_max, rms_slope=1.0
    )
    return {
        "size": size,
        "modulus": MODULUS,
        "pressure": PRESSURE,
        "separation": state.mean_separation,
        "energy": state.energy,
        "area": state.area_fraction,
        "area_raw": state.area_fraction_raw,
        "edges": edges(state.pressure > 0.0),
        "free_edges": free_edges(state),
        "rms_height": rms_height,
        "rms_slope": rms_slope,
        "slope_by_differences": by_differences(heights, size),
        "flat": {"psd": float(spectrum.psd_2d(3 * q0)), **law},
        "line": profile.tolist(),
        "line_length": SIDE,
        "line_psd": spectrum.psd_1d(q0 * np.arange(1, 17)).tolist(),
        "height_per_slope": other.rms_height / other.rms_slope,
    }


def main() -> None:
    """Print the table; exit with 1 where a line does not hold."""
    print(describe_machine("numpy", "numba"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cases = {
            "square": write_case(folder, "square", slice(None)),
            "oblong": write_case(folder, "oblong", slice(32)),
        }
        (folder / "numbers.json").write_text(json.dumps(cases))
        environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
        done = subprocess.run(
            [peer_python(), HERE / "peers" / "conventions.py", folder],
            check=True,
            stdout=subprocess.PIPE,
            env=environment | {"PYTHONPATH": str(HERE.parent)},
        )
    answer = json.loads(done.stdout.splitlines()[-1])
    print(", ".join(f"{name} {version}" for name, version in answer["versions"].items()))
    print("\n| line | roughbench | converted | relative difference | holds |\n|" + "-|" * 5)
    holds = [name in answer["versions"] for name in PEERS]
    for key, ours, theirs, limit in answer["lines"]:
        apart = abs(theirs - ours) / abs(ours)
        holds.append(apart <= limit)
        print(
            f"| `{key}` | {ours:.9g} | {theirs:.9g} | {apart:.1e} | "
            f"{'yes' if holds[-1] else '**no**'} |"
        )
    missing = [name for name in PEERS if name not in answer["versions"]]
    print(f"\nNot installed: {', '.join(missing)}." if missing else "", end="")
    print(f"\n{sum(holds)} of {len(holds)} hold.")
    sys.exit(0 if all(holds) else 1)


if __name__ == "__main__":
    main()
