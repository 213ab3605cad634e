"""Run the commands of docs/scans.md on a scan made here, and compare what they print.

    python scripts/scan_tutorial.py            # exit 1 where the page says something else
    python scripts/scan_tutorial.py --write    # put what they print into the page
    python scripts/scan_tutorial.py --scan F   # only make the scan, as file F

They run in a folder that at first holds plate.txt alone; scripts/_console.py says how.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from _console import check_page

from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

PAGE = Path(__file__).parents[1] / "docs" / "scans.md"
ROWS, COLUMNS, PIXEL = 120, 160, 62.5  # nm
TILT = 22.7  # nm/µm, which is 1.3 degrees


def write_scan(path: Path) -> None:
    """Write a tilted scan of 10 by 7.5 µm with two holes, as instruments export it.

    It is cut out of a larger surface: H = 0.8, from 0.25 µm to 4 µm, roll-off at 2.5 µm.
    """
    spectrum = self_affine(
        hurst=0.8,
        q_min=2 * np.pi / 20000.0,
        q_rolloff=2 * np.pi / 2500.0,
        q_max=2 * np.pi / 250.0,
        rms_slope=0.12,
    )
    surface = make_surface(spectrum, 320, 20000.0, realization_generator(8, 0))
    heights = surface[100 : 100 + ROWS, 30 : 30 + COLUMNS]
    heights = heights + TILT * PIXEL / 1000.0 * np.arange(COLUMNS)
    y, x = np.mgrid[:ROWS, :COLUMNS]
    for row, column, radius in ((30, 40, 4.5), (80, 120, 7.5)):
        heights[(y - row) ** 2 + (x - column) ** 2 < radius**2] = np.nan
    header = (
        "Channel: Topography\n"
        f"Width: {COLUMNS * PIXEL / 1000.0:g} µm\nHeight: {ROWS * PIXEL / 1000.0:g} µm\n"
        "Value units: nm"
    )
    with path.open("w", encoding="utf-8") as file:
        np.savetxt(file, heights, fmt="%.3f", delimiter="\t", header=header)


def main() -> int:
    """Run the page's commands; returns 1 if one prints something else."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="correct the page")
    parser.add_argument("--scan", type=Path, help="only write the scan")
    options = parser.parse_args()
    if options.scan:
        write_scan(options.scan)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        write_scan(Path(folder) / "plate.txt")
        return check_page(PAGE, Path(folder), write=options.write)


if __name__ == "__main__":
    raise SystemExit(main())
