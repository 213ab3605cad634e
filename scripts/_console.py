"""Run the commands of a page as written, and compare what they print with what it says.

A page's blocks marked ``console`` hold commands behind ``$`` and what each prints. They run one
after the other in one folder. A line ``…`` stands for lines that are left out. Numbers may
differ by one percent, or by one in their last digit: other machines round elsewhere.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

TOLERANCE = 0.01
GAP = "…\n"

_BLOCK = re.compile(r"^```console\n(.*?)^```", re.M | re.S)
_NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def check_page(page: Path, folder: Path, *, write: bool) -> int:
    """Run a page's commands in a folder; returns 1 if one prints something else.

    Parameters
    ----------
    page, folder : Path
    write : bool
        Put what they print into the page instead.
    """
    text = page.read_text(encoding="utf-8")
    wrong = 0

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
    if write:
        page.write_text(corrected, encoding="utf-8")
        return 0
    count = sum(len(commands_of(block)) for block in _BLOCK.findall(text))
    print(f"{page.name}: {count - wrong} of {count} commands print what it says")
    return int(wrong > 0 or count == 0)


def output_of(command: str, folder: Path) -> str:
    """Return what a command prints; ``cat`` prints a file."""
    words = shlex.split(command)
    if words[0] == "cat":
        return (folder / words[1]).read_text(encoding="utf-8")
    if words[0] != "roughbench":
        raise SystemExit(f"only roughbench and cat are run, got {command!r}")
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
