"""Compare what roughbench reads from measured topographies with SurfaceTopography.

    python scripts/compare_scans.py FOLDER [--size "10 um" "10 um" --unit nm]

Reads every file of a folder by ``roughbench.scans.read_scan`` and by SurfaceTopography
itself (its default channel), both without any preparation, and prints a Markdown table of
Sq and Sdq beside ``rms_height_from_area`` and ``rms_gradient``. Size (x, y) and unit are
given only to files that do not say them; the table says to which. Exits with 1 if a number
differs by more than 1e-6 of itself, or if a file that SurfaceTopography reads is refused.

Where points are missing, SurfaceTopography leaves out more than the differences that need
them: its interpolation between the points reaches one step further, around the border of the
image too. So does this comparison.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from _machine import describe_machine
from numpy.typing import NDArray

from roughbench.errors import RoughbenchError, SurfaceError
from roughbench.scans.lengths import in_metres
from roughbench.scans.topography import Scan, read_scan
from roughbench.units import in_words, to_si

LIMIT = 1e-6
REACH = ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0))
"""Steps along (y, x) to the points that SurfaceTopography needs for the gradient at a place."""


@dataclass(frozen=True)
class Numbers:
    """Of one file, in m and 1."""

    Sq: float
    Sdq: float
    seconds: float


def gradient(scan: Scan) -> float:
    """Return the rms gradient by differences of neighbouring points."""
    h = scan.heights
    missing = np.isnan(h)
    left_out = np.zeros(h.shape, bool)
    for down, right in REACH:
        left_out |= np.roll(missing, (-down, -right), (0, 1))
    dy = np.diff(h, axis=0)[:, :-1] / scan.spacing[0]
    dx = np.diff(h, axis=1)[:-1] / scan.spacing[1]
    squares: NDArray[np.float64] = (dx * dx + dy * dy)[~left_out[:-1, :-1]]
    return math.sqrt(squares.mean())


def of_roughbench(path: Path, given: dict[str, Any]) -> tuple[Scan, Numbers, str]:
    """Read with as little as the file needs; return also what that was."""
    start = time.perf_counter()
    fault = SurfaceError("")
    for keys in ((), ("size",), ("unit",), ("size", "unit")):
        if not set(keys) <= set(given):
            continue
        try:
            scan = read_scan(path, **{key: given[key] for key in keys})
        except SurfaceError as error:
            fault = error
            continue
        seconds = time.perf_counter() - start
        numbers = Numbers(float(np.nanstd(scan.heights)), gradient(scan), seconds)
        return scan, numbers, " and ".join(keys) or "nothing"
    raise fault


def of_library(path: Path, scan: Scan) -> Numbers:
    """Read by SurfaceTopography; it is given what the file does not say."""
    from SurfaceTopography.IO import open_topography

    start = time.perf_counter()
    with open_topography(str(path)) as reader:
        channel = reader.default_channel
        given: dict[str, Any] = {}
        if channel.unit is None:
            given["unit"] = "m"
        if channel.physical_sizes is None:
            metres = in_metres(channel.unit or "m") or 1.0
            given["physical_sizes"] = (scan.size[1] / metres, scan.size[0] / metres)
        topography = reader.topography(**given)
    seconds = time.perf_counter() - start
    metres = in_metres(topography.unit) or math.nan
    return Numbers(
        float(topography.rms_height_from_area()) * metres,
        float(topography.rms_gradient()),
        seconds,
    )


def row(path: Path, given: dict[str, Any]) -> tuple[str, bool]:
    """Return a row of the table, and whether all is well."""
    try:
        scan, ours, needed = of_roughbench(path, given)
    except SurfaceError as error:
        try:
            of_library(path, Scan(np.zeros((1, 1)), (1.0, 1.0)))
        except Exception:
            return f"| {path.name} | no topography | | | | | |", True
        return f"| {path.name} | refused: {error} | | | | | |", False
    theirs = of_library(path, scan)
    off = [abs(a / b - 1.0) for a, b in ((ours.Sq, theirs.Sq), (ours.Sdq, theirs.Sdq))]
    size = f"{in_words(scan.size[0], 'm')} × {in_words(scan.size[1], 'm')}"
    cells = (
        path.name,
        f"{scan.shape[0]} × {scan.shape[1]}, {size}",
        f"{scan.missing:.2%}",
        needed,
        f"{in_words(ours.Sq, 'm', 6)} ({off[0]:.0e})",
        f"{ours.Sdq:.6g} ({off[1]:.0e})",
        f"{ours.seconds:.2f} s, {theirs.seconds:.2f} s",
    )
    return f"| {' | '.join(cells)} |", max(off) <= LIMIT


def main() -> int:
    """Print the table; return 1 if they disagree."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="a folder with files of topographies")
    parser.add_argument("--size", nargs=2, metavar=("X", "Y"), help="such as 10um 10um")
    parser.add_argument("--unit", help="of heights, such as nm")
    arguments = parser.parse_args()
    given: dict[str, Any] = {}
    try:
        if arguments.size:
            x, y = (to_si(side, "length", "--size") for side in arguments.size)
            given["size"] = (y, x)
        if arguments.unit:
            given["unit"] = to_si(f"1 {arguments.unit}", "length", "--unit")
    except RoughbenchError as error:
        parser.error(str(error))
    if not arguments.folder.is_dir():
        parser.error(f"{arguments.folder}: no such folder")
    print(describe_machine("numpy", "SurfaceTopography"))
    print()
    print("| file | rows × columns, size (y × x) | missing | given | Sq | Sdq | read in |")
    print("|---|---|---|---|---|---|---|")
    is_well = True
    for path in sorted(arguments.folder.iterdir()):
        if path.is_file():
            text, agrees = row(path, given)
            is_well &= agrees
            print(text, flush=True)
    print("\nIn brackets: how far from SurfaceTopography's own, relative; both reading times.")
    return 0 if is_well else 1


if __name__ == "__main__":
    sys.exit(main())
