"""Run directories from outside: where they are, and how far."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughbench.errors import RoughbenchError
from roughbench.planning.plan import check, plan
from roughbench.planning.resources import ResourceLimits, resource_limits
from roughbench.program import command, program
from roughbench.rundir.folder import SUFFIX, RunFolder
from roughbench.runner.overview import PlanRow, overview
from roughbench.runner.scan import CellState, scan
from roughbench.runner.selection import select
from roughbench.spec import Spec, load_spec, parse_spec
from roughbench.store import whose

_SPECS = (".yaml", ".yml")


@dataclass(frozen=True, slots=True)
class RunState:
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
    parts : list of PlanRow
    note : str
        What is wrong with the results file, though all is done; else empty.
    shares : tuple of str
        Those that are being computed, such as ``3/40``.
    """

    results: Path
    state: str
    holder: dict[str, Any]
    command: str
    states: int
    done: int
    parts: list[PlanRow]
    note: str = ""
    shares: tuple[str, ...] = ()

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
            "note": self.note,
            "shares": [*self.shares],
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
    elif given.suffix in _SPECS:
        results = Path(f"{load_spec(given).name}.h5")
    else:
        results = given
    folder = RunFolder(results)
    if not folder.path.is_dir():
        raise RoughbenchError(_without_folder(given, folder))
    return folder


def _without_folder(given: Path, folder: RunFolder) -> str:
    """Return why there is no run directory, and what to do."""
    if whose(folder.results) is not None:
        return (
            f"{folder.results} has results, but the run directory that they came from, "
            f"{folder.path}, is not there; see them with: {command('show', folder.results)}"
        )
    if given.suffix in _SPECS and given.is_file():
        return (
            f"nothing of {given} has been computed here: there is no {folder.path}; give the "
            f"results file of its run (-o), or start one with: {command('run', given)}"
        )
    if given.is_file():
        return (
            f"{given} is no results file, run directory or spec; give the results file of a "
            "run (-o)"
        )
    return (
        f"{folder.path}: no such run directory; give the results file of a run (-o), or "
        f"start one with: {program()} run SPEC.yaml"
    )


def status(path: str | os.PathLike[str]) -> RunState:
    """Return how far the run at ``path`` is; it may be running.

    Raises
    ------
    RoughbenchError
        If there is no run there, or nobody knows what it was to compute.
    """
    folder = find(path)
    request = folder.request()
    _, limits, cell_states = requested(folder, request)
    holder = folder.holder()
    tasks = select(cell_states, (), parts=limits.parts)
    note = fault_of_results(folder) if not tasks else ""
    complete = not tasks and not note
    shares = tuple(folder.shares())
    return RunState(
        results=folder.results,
        state="running" if holder or shares else "complete" if complete else "incomplete",
        holder=holder,
        command=str(request.get("command", "")),
        states=sum(cell_state.cell.n_states for cell_state in cell_states),
        done=sum(cell_state.n_known for cell_state in cell_states),
        parts=overview(cell_states, tasks, folder),
        note=note,
        shares=shares,
    )


def fault_of_results(folder: RunFolder) -> str:
    """Return why the results file is not that of the run, though all is computed."""
    path = folder.results
    if folder.has_its_results():
        return ""
    if not path.exists():
        fault = "is not there"
    elif not path.is_file() or path.stat().st_size == 0:
        fault = "is empty, or no file"
    else:
        fault = "is not the file that the run has written"
    return f"{path}: {fault}; the same command writes it again from the shards"


def requested(
    folder: RunFolder, request: dict[str, Any]
) -> tuple[Spec, ResourceLimits, list[CellState]]:
    """Return what the last run in a folder was asked for, and what there is of it.

    Raises
    ------
    RoughbenchError
        If nobody knows what it was to compute.
    """
    spec = _spec_of(folder, request)
    cells = plan(spec)
    check(cells)
    limits = resource_limits(jobs=None)
    return spec, limits, scan(cells, limits, folder, threads=_threads(request))


def _threads(request: dict[str, Any]) -> dict[str, int]:
    """Return the threads that the last run gave each cell, which a guess need not meet."""
    found = request.get("threads")
    known = found.items() if isinstance(found, dict) else ()
    return {name: n for name, n in known if isinstance(n, int)}


def _spec_of(folder: RunFolder, request: dict[str, Any]) -> Spec:
    if not isinstance(request.get("spec"), str):
        raise RoughbenchError(unknown_request(folder))
    return parse_spec(request["spec"], folder=request.get("folder", "."))


def unknown_request(folder: RunFolder) -> str:
    """Say that nobody knows what a run was to compute."""
    return (
        f"{folder.path}: run.json is missing or damaged, which says what the run was to "
        "compute; the next run writes it again"
    )
