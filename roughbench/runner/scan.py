"""What there is already of a plan, what is missing, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from roughbench.errors import RoughbenchError
from roughbench.planning.cells import Cell
from roughbench.planning.resources import ResourceLimits
from roughbench.planning.tasks import Block, Task, cut
from roughbench.rundir.collected import Collected, Coverage, places_of
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.former import FormerIdentities
from roughbench.rundir.identity import Identity, identity, key_of
from roughbench.rundir.journal import log
from roughbench.rundir.shards import Shard, ShardError


@dataclass(slots=True)
class CellState:
    """One cell, and what there is of it.

    Attributes
    ----------
    cell : Cell
    threads : int
        Of each of its tasks.
    identity, key
        What its numbers depend on, and what stands for that.
    coverage : Coverage
        The states that there are.
    reason : str
        Why states are missing.
    shards : list of Shard
        Where their values are.
    blocks : list of (Task, dict of str to ndarray)
        The values themselves, in a run without a run directory.
    damaged : list of ShardError
        Shards of it that cannot be used.
    usages : list of dict
        What each of its tasks took.
    n_unconverged : int
        Number of states that did not converge, once they are collected.
    """

    cell: Cell
    threads: int
    identity: Identity
    key: str
    coverage: Coverage
    reason: str = "new"
    shards: list[Shard] = field(default_factory=list)
    blocks: list[tuple[Task, Block]] = field(default_factory=list)
    damaged: list[ShardError] = field(default_factory=list)
    usages: list[dict[str, Any]] = field(default_factory=list)
    n_unconverged: int = 0

    @property
    def n_known(self) -> int:
        """Number of states that there are."""
        return int(np.count_nonzero(self.coverage.known))

    def add(self, shard: Shard) -> None:
        """Take a shard for a result.

        Raises
        ------
        ShardError
            If it does not fit the others.
        """
        try:
            self.coverage.take(shard.realizations, shard.pressures, shard.names, shard.kept)
        except ValueError as error:
            raise ShardError(shard.path, error) from error
        self.shards.append(shard)
        self.usages.append(shard.usage)

    def add_block(self, task: Task, block: Block, usage: Mapping[str, Any]) -> None:
        """Take what a task has computed for a result, without a shard."""
        try:
            self.coverage.take(
                task.realizations, task.pressure_array(), block, places_of(block)
            )
        except ValueError as error:
            raise RoughbenchError(f"{task}: {error}") from error
        self.blocks.append((task, block))
        self.usages.append(dict(usage))

    def collect(self) -> Block:
        """Return the values of all states, from the shards or the blocks.

        Raises
        ------
        ShardError
            If a shard is not what it was any more.
        """
        collected = Collected(self.cell)
        for shard in sorted(self.shards, key=lambda shard: shard.path.name):
            with shard.opened() as variables:
                collected.add(shard.realizations, shard.pressures, variables, shard.kept)
        for task, block in self.blocks:
            collected.add(task.realizations, task.pressure_array(), block, places_of(block))
        found = collected.block()
        self.n_unconverged = int(np.count_nonzero(found["status"]))
        return found

    def tasks(self, parts: int, only: Collection[int] | None = None) -> list[Task]:
        """Return what is missing as tasks.

        Parameters
        ----------
        parts : int
            Make at least so many, if they are long.
        only : collection of int, optional
            Realizations to take; default: all.
        """
        return [
            task
            for realizations, pressures in self.coverage.missing(only)
            for task in cut(
                self.cell,
                realizations,
                pressures,
                threads=self.threads,
                parts=parts,
            )
        ]


def scan(
    cells: Sequence[Cell],
    limits: ResourceLimits,
    folder: RunFolder | None,
    *,
    force: bool = False,
    threads: Mapping[str, int] | None = None,
) -> list[CellState]:
    """Return what there is of each cell.

    Parameters
    ----------
    cells : sequence of Cell
    limits : ResourceLimits
        Says how many threads a task has.
    folder : RunFolder or None
        Where shards may be; None for nowhere. It is only read.
    force : bool
        Take no shard for a result.
    threads : mapping of str to int, optional
        Threads of the tasks of each cell, by its name; default: those that its shards or
        checkpoints were computed with, or as ``limits`` says.
    """
    keys = set(folder.computations()) if folder is not None else set()
    kept = (keys, folder.unfinished()) if folder is not None else ()
    given = threads or {}
    cell_states = [_cell_state(cell, limits, kept, given.get(str(cell))) for cell in cells]
    if folder is None:
        return cell_states
    others = FormerIdentities(
        folder, keys.difference(cell_state.key for cell_state in cell_states)
    )
    for cell_state in cell_states:
        if force and cell_state.key in keys:
            cell_state.reason = "forced"
        elif cell_state.key in keys:
            _collect(cell_state, folder)
        else:
            cell_state.reason = others.what_changed(cell_state.identity)
    return cell_states


def refresh(cell_states: Sequence[CellState], folder: RunFolder) -> None:
    """Take up the shards that other processes have written meanwhile."""
    for cell_state in cell_states:
        seen = {shard.path for shard in cell_state.shards}
        seen |= {error.path for error in cell_state.damaged}
        for path in folder.shards(cell_state.key):
            if path not in seen:
                _take(cell_state, folder, path)


def scan_cleared(
    cells: Sequence[Cell], limits: ResourceLimits, folder: RunFolder | None, *, force: bool
) -> list[CellState]:
    """Return what there is of cells, after putting aside what is damaged or not wanted."""
    cell_states = scan(cells, limits, folder, force=force)
    if folder is not None:
        for cell_state in cell_states:
            for error in cell_state.damaged:
                log.warning("%s; set aside, to be computed again", error)
                folder.set_aside(error.path)
            if force:
                folder.forget(cell_state.key)
            folder.drop_checkpoints(cell_state.key, cell_state.shards)
    return cell_states


def _cell_state(
    cell: Cell, limits: ResourceLimits, kept: Sequence[Collection[str]], given: int | None
) -> CellState:
    """Resume with the threads that something was kept with, unless message otherwise."""
    choices = limits.choices(cell) if given is None else [given]
    found = [(n, identity(cell, n)) for n in choices]
    there = (pair for keys in kept for pair in found if key_of(pair[1]) in keys)
    threads, its_identity = next(there, found[0])
    return CellState(cell, threads, its_identity, key_of(its_identity), Coverage(cell))


def _collect(cell_state: CellState, folder: RunFolder) -> None:
    for path in folder.shards(cell_state.key):
        _take(cell_state, folder, path)


def _take(cell_state: CellState, folder: RunFolder, path: Path) -> None:
    try:
        cell_state.add(folder.read(path))
    except ShardError as error:
        cell_state.damaged.append(error)
