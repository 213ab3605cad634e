"""What a run would do, or has done, in words and numbers: for ``run -n`` and ``status``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from roughbench.planning.cells import Cell
from roughbench.planning.resources import assembly_memory, memory_of
from roughbench.planning.tasks import Task
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.shards import realizations_of
from roughbench.runner.scan import CellState
from roughbench.runner.speed import Speeds


@dataclass(frozen=True, slots=True)
class PlanRow:
    """Realizations of one model that stand alike.

    Attributes
    ----------
    model : str
        Experiment and label, such as ``main/bem``.
    first, last : int
        Realizations, counted from 1.
    reason : str
        ``done``, ``new``, ``changed: surface.H: 0.7 → 0.8``, …
    states, done : int
        How many states there are in all, and how many of them are done.
    tasks : int
        How many tasks are to be computed.
    seconds : float
        Estimated time of what is missing, on one core; where a model is computed first with
        the time that a process takes to load it, and the first of all with that to start.
    memory : int
        Estimated bytes that a task needs, or that the results need to be put together.
    """

    model: str
    first: int
    last: int
    reason: str
    states: int
    done: int
    tasks: int
    seconds: float
    memory: int

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        where = self.model
        if self.last > 1:
            numbers = f"{self.first} to {self.last}" if self.last > self.first else self.first
            where += f", realization{'s' * (self.last > self.first)} {numbers}"
        if not self.tasks:
            return f"{where}: {self.reason}"
        return (
            f"{where}: {self.reason} ({self.states - self.done} states in {self.tasks} "
            f"task{'s' * (self.tasks > 1)}, about {self.seconds:.2g} s of one core, "
            f"{self.memory / 1e9:.1f} GB each)"
        )


def overview(
    cell_states: Sequence[CellState],
    tasks: Sequence[Task],
    folder: RunFolder | None,
    speeds: Speeds | None = None,
) -> list[PlanRow]:
    """Return how the realizations of each model stand, those alike together.

    Parameters
    ----------
    cell_states : sequence of CellState
    tasks : sequence of Task
        What is to be computed.
    folder : RunFolder or None
        Where finished states of unfinished curves may be.
    speeds : Speeds, optional
        How fast this machine is; default: as it was measured before.
    """
    speeds = speeds or Speeds()
    planned: dict[Cell, list[Task]] = {}
    for task in tasks:
        planned.setdefault(task.cell, []).append(task)
    parts = []
    starting = dict(zip(planned, speeds.starting(cell.model for cell in planned), strict=True))
    for cell_state in cell_states:
        own = planned.get(cell_state.cell, [])
        reasons = _reasons(cell_state, own, folder)
        start = 0
        for reason, group in groupby(reasons):
            stop = start + len(list(group))
            part = _part(cell_state, range(start, stop), reason, own, speeds)
            if part.tasks:
                part = replace(part, seconds=part.seconds + starting.pop(cell_state.cell, 0.0))
            parts.append(part)
            start = stop
    return parts


def _part(
    cell_state: CellState, rows: range, reason: str, tasks: Sequence[Task], speeds: Speeds
) -> PlanRow:
    own = [task for task in tasks if task.realizations.start < rows.stop]
    own = [task for task in own if task.realizations.stop > rows.start]
    return PlanRow(
        model=str(cell_state.cell),
        first=rows.start + 1,
        last=rows.stop,
        reason=reason,
        states=len(rows) * len(cell_state.cell.pressures),
        done=int(np.count_nonzero(cell_state.coverage.known[rows.start : rows.stop])),
        tasks=len(own),
        seconds=speeds.slowness(cell_state.cell.model)
        * sum(1e-6 * task.work * task.n_states for task in own),
        memory=max(*map(memory_of, own), assembly_memory(cell_state.cell)) if own else 0,
    )


def _reasons(
    cell_state: CellState, tasks: Sequence[Task], folder: RunFolder | None
) -> list[str]:
    known = cell_state.coverage.known
    n_pressures = known.shape[1]
    nothing = not known.any()
    reasons = []
    for row in known:
        n = int(np.count_nonzero(row))
        if n == n_pressures:
            reasons.append("done")
        elif n:
            reasons.append(f"{n_pressures - n} of {n_pressures} pressures are new")
        else:
            reasons.append(cell_state.reason if nothing else "new")
    for error in cell_state.damaged:
        for realization in realizations_of(error.path):
            if realization < len(reasons) and reasons[realization] != "done":
                reasons[realization] = f"damaged: {error}"
    for task in tasks:
        if folder is not None and len(task.realizations) == 1:
            done = folder.checkpoint(task, cell_state.key).done()
            if done:
                reasons[task.realizations[0]] = (
                    f"{done} of {len(task.pressures)} pressures done"
                )
    return reasons
