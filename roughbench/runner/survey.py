"""What there is already of a plan, what is missing, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from roughbench.runner.collected import Collected
from roughbench.runner.folder import RunFolder, ShardError
from roughbench.runner.identity import Identity, changes, identity, key_of
from roughbench.runner.plan import Cell, Task, cut
from roughbench.runner.resources import Sharing

_MOST_CHANGES = 4


@dataclass(slots=True)
class Stock:
    """One cell, and what there is of it.

    Attributes
    ----------
    cell : Cell
    threads : int
        Of each of its tasks.
    identity, key
        What its numbers depend on, and what stands for that.
    collected : Collected
        The states that there are.
    reason : str
        Why states are missing.
    damaged : list of ShardError
        Shards of it that cannot be used.
    usages : list of dict
        What each of its tasks took.
    """

    cell: Cell
    threads: int
    identity: Identity
    key: str
    collected: Collected
    reason: str = "new"
    damaged: list[ShardError] = field(default_factory=list)
    usages: list[dict[str, Any]] = field(default_factory=list)

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
            for realizations, pressures in self.collected.missing(only)
            for task in cut(
                self.cell,
                realizations,
                pressures,
                threads=self.threads,
                parts=parts,
            )
        ]


def survey(
    cells: Sequence[Cell],
    sharing: Sharing,
    folder: RunFolder | None,
    *,
    force: bool = False,
    threads: Mapping[str, int] | None = None,
) -> list[Stock]:
    """Return what there is of each cell.

    Parameters
    ----------
    cells : sequence of Cell
    sharing : Sharing
        Says how many threads a task has.
    folder : RunFolder or None
        Where shards may be; None for nowhere. It is only read.
    force : bool
        Take no shard for a result.
    threads : mapping of str to int, optional
        Threads of the tasks of each cell, by its name; default: those that its shards or
        checkpoints were computed with, or as ``sharing`` says.

    Returns
    -------
    list of Stock
    """
    keys = folder.computations() if folder is not None else []
    kept = (keys, folder.unfinished()) if folder is not None else ()
    given = threads or {}
    stocks = [_stock(cell, sharing, kept, given.get(str(cell))) for cell in cells]
    if folder is None:
        return stocks
    in_use = {stock.key for stock in stocks}
    others = [key for key in keys if key not in in_use]
    for stock in stocks:
        if force and stock.key in keys:
            stock.reason = "forced"
        elif stock.key in keys:
            _collect(stock, folder)
        elif others:
            stock.reason = _what_changed(stock, others, folder)
    return stocks


def _stock(
    cell: Cell, sharing: Sharing, kept: Sequence[Collection[str]], given: int | None
) -> Stock:
    """Resume with the threads that something was kept with, unless told otherwise."""
    choices = sharing.choices(cell) if given is None else [given]
    found = [(n, identity(cell, n)) for n in choices]
    there = (pair for keys in kept for pair in found if key_of(pair[1]) in keys)
    threads, its_identity = next(there, found[0])
    return Stock(cell, threads, its_identity, key_of(its_identity), Collected(cell))


def _collect(stock: Stock, folder: RunFolder) -> None:
    for path in folder.shards(stock.key):
        try:
            shard = folder.read(path)
            stock.collected.add(shard.first, shard.pressures, shard.block)
        except ShardError as error:
            stock.damaged.append(error)
        except ValueError as error:
            stock.damaged.append(ShardError(path, error))
        else:
            stock.usages.append(shard.usage)


def _what_changed(stock: Stock, others: Sequence[str], folder: RunFolder) -> str:
    """Compare with the nearest identity that nobody uses any more."""
    nearest: list[str] | None = None
    for key in others:
        before = _identity_of(folder, key)
        if before is None or before.get("model.kind") != stock.identity["model.kind"]:
            continue
        differences = changes(before, stock.identity)
        if nearest is None or len(differences) < len(nearest):
            nearest = differences
    if not nearest:
        return "new"
    more = len(nearest) - _MOST_CHANGES
    shown = nearest[:_MOST_CHANGES] + ([f"and {more} more"] if more > 0 else [])
    return "changed: " + ", ".join(shown)


def _identity_of(folder: RunFolder, key: str) -> Identity | None:
    for path in folder.shards(key):
        try:
            return folder.read(path).identity
        except ShardError:
            continue
    return None
