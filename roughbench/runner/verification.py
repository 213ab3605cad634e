"""Whether all that is in a run directory is sound."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from roughbench.errors import StoreError
from roughbench.outputs import both_ends
from roughbench.rundir.folder import RunFolder, folder_of
from roughbench.rundir.shards import ShardError
from roughbench.runner.inspection import fault_of_results, find
from roughbench.store import HDF5_SIGNATURE, RESULTS, load, opened


def verify(path: str | os.PathLike[str]) -> tuple[int, list[str]]:
    """Read every shard at ``path``, and the results file, and check them.

    A results file alone, without its run directory, is checked alone: the checksum of the whole
    file, those of all arrays, and their shapes.

    Returns
    -------
    (int, list of str)
        How many files are sound, and what is wrong with the others; nothing is changed.

    Raises
    ------
    RoughbenchError
        If there is no run there, and no results file.
    """
    alone = Path(path)
    if alone.is_file() and not folder_of(alone).exists() and _may_be_results(alone):
        return _checked_alone(alone)
    folder = find(path)
    found = [*_shards_checked(folder), *_notes_checked(folder), *_results_checked(folder)]
    faults = [fault for fault in found if fault]
    return len(found) - len(faults), faults


def _may_be_results(path: Path) -> bool:
    """Whether a file is ours, or any in HDF5: one of ours that was cut short is."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        head, tail = both_ends(file)
        return head.startswith(HDF5_SIGNATURE) or RESULTS.is_one(head, tail)
    return False


def _checked_alone(path: Path) -> tuple[int, list[str]]:
    """Read all of a results file; a fault of it is the answer, and no error."""
    try:
        load(path)
    except StoreError as error:
        return 0, [str(error)]
    return 1, []


def _shards_checked(folder: RunFolder) -> Iterator[str]:
    """Yield for each shard what is wrong with it; nothing if it is sound."""
    try:
        keys = folder.computations()
    except StoreError as error:
        yield str(error)
        return
    for key in keys:
        try:
            shards = folder.shards(key)
        except StoreError as error:
            yield str(error)
            continue
        for shard in shards:
            try:
                folder.read(shard)
                yield ""
            except ShardError as error:
                yield f"{error}; the next run computes it again"


def _notes_checked(folder: RunFolder) -> Iterator[str]:
    """Yield what is wrong with what the runs have noted; sound notes are not counted."""
    for name, content in (
        ("run.json", folder.request()),
        ("provenance.json", folder.provenance()),
    ):
        path = folder.path / name
        if path.exists() and not content:
            yield f"{path}: is damaged; the next run writes it again"


def _results_checked(folder: RunFolder) -> Iterator[str]:
    """Yield what is wrong with the results file, if it is there; nothing if it is sound."""
    if not folder.results.exists():
        return
    try:
        with opened(folder.results):
            known = bool(folder.provenance())
        yield fault_of_results(folder) if known else ""
    except StoreError as error:
        yield str(error)
