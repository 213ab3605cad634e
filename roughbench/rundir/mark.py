"""The mark of a run directory: nothing without it is filled or removed."""

from __future__ import annotations

import contextlib
from pathlib import Path

from roughbench.errors import RoughbenchError, StoreError
from roughbench.publish import commit

NAME = "README.txt"
_MARK = b"This is a run directory of roughbench."
_TEXT = b"""
It keeps what a run has finished, so that the next one goes on from there. To remove it:
roughbench clean RESULTS, with the name of the results file beside it.
"""
_OWN = {"lock", "run.log", "run.json", "provenance.json", "shards", "checkpoints", "set-aside"}
_OWN |= {"shares", "jobs"}


def is_marked(folder: Path) -> bool:
    """Whether a folder says that it is a run directory."""
    with contextlib.suppress(OSError), (folder / NAME).open("rb") as file:
        return file.read(len(_MARK)) == _MARK
    return False


def mark(folder: Path) -> None:
    """Mark a folder that holds nothing of anybody else.

    Raises
    ------
    StoreError
        If it does.
    OSError
        If it cannot be read.
    """
    if is_marked(folder):
        return
    # A folder that lost its mark, or whose first run was killed before, may be used.
    foreign = sorted(entry.name for entry in folder.iterdir() if entry.name not in _OWN)
    foreign = [name for name in foreign if not (name.startswith(".") and name.endswith(".tmp"))]
    if foreign:
        raise StoreError(
            f"{folder} is no run directory of roughbench: it holds {foreign[0]!r}; choose "
            "another results file with -o, or move it away"
        )
    commit(_MARK + b"\n" + _TEXT, folder / NAME)


def check_marked(folder: Path) -> None:
    """Refuse to remove what is no run directory.

    Raises
    ------
    RoughbenchError
    """
    if not is_marked(folder):
        raise RoughbenchError(
            f"{folder} does not say in {NAME} that it is a run directory of roughbench; it "
            "stays as it is (if it is one, the next run writes that, or remove it by hand)"
        )
