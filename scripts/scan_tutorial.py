"""Run the commands of docs/scans.md on a scan made here, and compare what they print.

    python scripts/scan_tutorial.py            # exit 1 where the page says something else
    python scripts/scan_tutorial.py --write    # put what they print into the page
    python scripts/scan_tutorial.py --scan F   # only make the scan, as file F

The page's blocks marked ``console`` hold commands behind ``$`` and what each prints. They run
one after the other in one folder that at first holds plate.txt alone. A line ``…`` stands for
lines that are left out. Numbers may differ by one percent, or by one in their last digit:
other machines round elsewhere.
"""

from __future__ import annotations

import argparse
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

PAGE = Path(__file__).parents[1] / "docs" / "scans.md"
ROWS, COLUMNS, PIXEL = 120, 160, 62.5  # nm
TILT = 22.7  # nm/µm, which is 1.3 degrees
TOLERANCE = 0.01

GAP = "…\n"

_BLOCK = re.compile(r"^```console\n(.*?)^```", re.M | re.S)
_NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


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


def output_of(command: str, folder: Path) -> str:
    """Return what a command prints; ``cat`` prints a file."""
    words = shlex.split(command)
    if words[0] == "cat":
        return (folder / words[1]).read_text(encoding="utf-8")
    if words[0] != "roughbench":
        raise SystemExit(f"{PAGE.name}: only roughbench and cat are run, got {command!r}")
    done = subprocess.run(
        [sys.executable, "-m", "roughbench", *words[1:]],
        cwd=folder,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    return "".join(
        f"{line.rstrip()}\n"
        for line in (done.stdout + done.stderr).splitlines()
        if line.strip()
    )


def commands_of(block: str) -> list[tuple[str, str]]:
    """Return the commands of a block, and what it says that each prints."""
    parts = re.split(r"^\$ (.*)\n", block, flags=re.M)[1:]
    return list(zip(parts[::2], parts[1::2], strict=True))


def shortened(printed: str, said: str) -> str:
    """Return what is printed, with as many lines left out as the page leaves out."""
    head, gap, tail = said.partition(GAP)
    if not gap:
        return printed
    lines = printed.splitlines(keepends=True)
    first, last = head.count("\n"), tail.count("\n")
    return "".join([*lines[:first], GAP, *lines[len(lines) - last :]])


def agree(printed: str, said: str) -> bool:
    """Return whether two outputs are the same, but for the last digits of numbers."""
    if _NUMBER.sub("#", printed).split() != _NUMBER.sub("#", said).split():
        return False
    pairs = zip(_NUMBER.findall(printed), _NUMBER.findall(said), strict=True)
    return all(_close(one, other) for one, other in pairs)


def _close(one: str, other: str) -> bool:
    a, b = (float(text.replace("−", "-")) for text in (one, other))
    mantissa, _, exponent = other.partition("e")
    digits = len(mantissa.partition(".")[2])
    last = 10.0 ** (int(exponent or 0) - digits)
    return abs(a - b) <= max(TOLERANCE * abs(b), 1.01 * last)


def main() -> int:
    """Run the page's commands; returns how many print something else."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="correct the page")
    parser.add_argument("--scan", type=Path, help="only write the scan")
    options = parser.parse_args()
    if options.scan:
        write_scan(options.scan)
        return 0
    text = PAGE.read_text(encoding="utf-8")
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_scan(folder / "plate.txt")

        def run(found: re.Match[str]) -> str:
            nonlocal wrong
            lines = []
            for command, said in commands_of(found[1]):
                printed = shortened(output_of(command, folder), said)
                if not agree(printed, said):
                    wrong += 1
                    print(f"$ {command}\nthe page says:\n{said}\nit prints:\n{printed}")
                lines.append(f"$ {command}\n{printed if not agree(printed, said) else said}")
            return f"```console\n{''.join(lines)}```"

        corrected = _BLOCK.sub(run, text)
    if options.write:
        PAGE.write_text(corrected, encoding="utf-8")
        return 0
    count = sum(len(commands_of(block)) for block in _BLOCK.findall(text))
    print(f"{PAGE.name}: {count - wrong} of {count} commands print what it says")
    return int(wrong > 0 or count == 0)


if __name__ == "__main__":
    raise SystemExit(main())
