"""The end of a run directory, or of what is no longer needed in it."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from roughbench.errors import RoughbenchError
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.lock import LOCK
from roughbench.rundir.mark import check_marked
from roughbench.runner.inspection import find, unknown_request
from roughbench.system import removes_open_files


def clean(path: str | os.PathLike[str], *, unused: bool = False) -> int:
    """Remove the run directory at ``path``; the results file stays.

    Parameters
    ----------
    path : path
    unused : bool
        Remove only shards that the last run did not need: of parameters that have changed
        since, and those set aside.

    Returns
    -------
    int
        Bytes that were freed.

    Raises
    ------
    LockedError
        If a run is in it.
    RoughbenchError
        If there is no run there, or a folder that is no run directory.
    """
    folder = find(path)
    check_marked(folder.path)
    with folder.locked("roughbench clean"):
        before = folder.size()
        if unused:
            needed = _needed(folder)
            for key in {*folder.computations(), *folder.unfinished()} - needed:
                folder.forget(key)
            folder.forget_set_aside()
            return before - folder.size()
        place = folder.path.resolve()
        if removes_open_files():
            shutil.rmtree(place)
        else:
            _remove_content(place)
    if not removes_open_files():
        with contextlib.suppress(OSError):  # the next run has it open already
            (place / LOCK).unlink()
            place.rmdir()
    if folder.path.is_symlink() and not place.exists():
        folder.path.unlink()
    return before


def _remove_content(folder: Path) -> None:
    """Remove all but the lock, which is held."""
    for entry in folder.iterdir():
        if entry.is_dir():
            shutil.rmtree(entry)
        elif entry.name != LOCK:
            entry.unlink()


def _needed(folder: RunFolder) -> set[str]:
    """Return the keys of the shards that the last run needed.

    As it noted them: what its spec would need now may be something else, after a change of
    the code or of heights in a file.
    """
    keys = folder.request().get("keys")
    if not isinstance(keys, list):
        raise RoughbenchError(unknown_request(folder))
    return {str(key) for key in keys}
