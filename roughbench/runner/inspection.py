"""Run directories from outside: how far they are, whether they are sound, and their end."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughbench.errors import RoughbenchError, StoreError
from roughbench.runner.folder import SUFFIX, RunFolder, ShardError
from roughbench.runner.only import select
from roughbench.runner.overview import Part, overview
from roughbench.runner.plan import check, plan
from roughbench.runner.resources import Sharing, sharing
from roughbench.runner.survey import Stock, survey
from roughbench.spec import Spec, load_spec, parse_spec
from roughbench.store import load


@dataclass(frozen=True, slots=True)
class State:
    """How far a run is.

    Attributes
    ----------
    results : Path
        The results file, there or not.
    state : str
        ``running``, ``complete`` (and the results file is there), or ``incomplete``.
    holder : dict
        Which process runs, on which host, since when, with which command; else empty.
    command : str
        The last run.
    states, done : int
        How many states there are in all, and how many of them are done.
    parts : list of Part
    """

    results: Path
    state: str
    holder: dict[str, Any]
    command: str
    states: int
    done: int
    parts: list[Part]

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        return {
            "results": str(self.results),
            "state": self.state,
            "running": self.holder or None,
            "command": self.command,
            "states": self.states,
            "done": self.done,
            "parts": [part.as_dict() for part in self.parts],
        }


def find(path: str | os.PathLike[str]) -> RunFolder:
    """Return the run directory that ``path`` means.

    Parameters
    ----------
    path : path
        A results file (there or still to come), its run directory, or a spec, whose results
        are then looked for in the current folder.

    Raises
    ------
    RoughbenchError
        If there is no run directory.
    """
    given = Path(path)
    if given.suffix == SUFFIX:
        results = given.with_suffix("")
    elif given.suffix in {".yaml", ".yml"}:
        results = Path(f"{load_spec(given).name}.h5")
    else:
        results = given
    folder = RunFolder(results)
    if not folder.path.is_dir():
        raise RoughbenchError(
            f"{folder.path}: no such run directory; give the results file of a run (-o), or "
            "start one with: roughbench run SPEC.yaml"
        )
    return folder


def status(path: str | os.PathLike[str]) -> State:
    """Return how far the run at ``path`` is; it may be running.

    Raises
    ------
    RoughbenchError
        If there is no run there, or nobody knows what it was to compute.
    """
    folder = find(path)
    request = folder.request()
    limits, stocks = _stocks(folder, request)
    holder = folder.holder()
    tasks = select(stocks, (), parts=limits.parts)
    complete = not tasks and folder.results.exists()
    return State(
        results=folder.results,
        state="running" if holder else "complete" if complete else "incomplete",
        holder=holder,
        command=str(request.get("command", "")),
        states=sum(stock.cell.n_states for stock in stocks),
        done=sum(int(stock.collected.known.sum()) for stock in stocks),
        parts=overview(stocks, tasks, folder),
    )


def verify(path: str | os.PathLike[str]) -> tuple[int, list[str]]:
    """Read every shard at ``path``, and the results file, and check them.

    Returns
    -------
    (int, list of str)
        How many files are sound, and what is wrong with the others; nothing is changed.

    Raises
    ------
    RoughbenchError
        If there is no run there.
    """
    folder = find(path)
    sound, faults = 0, []
    for key in folder.computations():
        for shard in folder.shards(key):
            try:
                folder.read(shard)
                sound += 1
            except ShardError as error:
                faults.append(f"{error}; the next run computes it again")
    if folder.results.exists():
        try:
            load(folder.results)
            sound += 1
        except StoreError as error:
            faults.append(str(error))
    return sound, faults


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
        If there is no run there.
    """
    folder = find(path)
    with folder.locked("roughbench clean"):
        before = folder.size()
        if not unused:
            shutil.rmtree(folder.path)
            return before
        _, stocks = _stocks(folder, folder.request())
        needed = {stock.key for stock in stocks}
        for key in folder.computations():
            if key not in needed:
                folder.forget(key)
        folder.forget_set_aside()
        return before - folder.size()


def spent_on(results: str | os.PathLike[str]) -> dict[str, tuple[float, int]]:
    """Return the seconds of all tasks, and the most bytes of one, of each model.

    Empty where no run directory tells.
    """
    models = RunFolder(results).provenance().get("models", {})
    return {
        name: (float(model["seconds"]), int(model["peak_memory"]))
        for name, model in models.items()
    }


def _stocks(folder: RunFolder, request: dict[str, Any]) -> tuple[Sharing, list[Stock]]:
    spec = _requested(folder, request)
    cells = plan(spec)
    check(cells)
    limits = sharing(jobs=None)
    return limits, survey(cells, limits, folder, threads=_threads(request))


def _threads(request: dict[str, Any]) -> dict[str, int]:
    """Return the threads that the last run gave each cell, which a guess need not meet."""
    found = request.get("threads")
    known = found.items() if isinstance(found, dict) else ()
    return {name: n for name, n in known if isinstance(n, int)}


def _requested(folder: RunFolder, request: dict[str, Any]) -> Spec:
    if not isinstance(request.get("spec"), str):
        raise RoughbenchError(
            f"{folder.path}: run.json is missing or damaged, which says what the run was to "
            "compute; the next run writes it again"
        )
    return parse_spec(request["spec"], folder=request.get("folder", "."))
