"""Cells cut into tasks: realizations and pressures that are computed in one go."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from roughbench.models.base import FloatArray
from roughbench.planning.cells import Cell
from roughbench.results import Array

Block = dict[str, Array]
"""What a task computes: variables by name, along the first axis its realizations, fields or
bins."""
SECONDS_PER_TASK = 1.0
"""Small realizations are batched to about this: to commit a task costs a hundredth of it."""


@dataclass(frozen=True, slots=True)
class Task:
    """Some realizations of one cell at some pressures, computed in one go by one process.

    Attributes
    ----------
    cell : Cell
    realizations : range
        Not empty.
    pressures : tuple of float
        p/E*, ascending; of the cell, or those of them that are missing.
    threads : int
        Threads that the model may use.
    """

    cell: Cell
    realizations: range
    pressures: tuple[float, ...]
    threads: int = 1

    def __hash__(self) -> int:
        return hash((self.cell.experiment, self.realizations, self.pressures[0]))

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return len(self.realizations) * len(self.pressures)

    @property
    def work(self) -> float:
        """Estimated work of one state, in microseconds."""
        return self.cell.work / len(self.cell.pressures)

    def pressure_array(self) -> FloatArray:
        """Return the pressures p/E*, shape (pressures,)."""
        return np.array(self.pressures, dtype=np.float64)

    def kept(self, realization: int) -> tuple[float, ...]:
        """Return the pressures of this task at which a realization's fields are kept."""
        asked = self.cell.asked
        if realization not in asked.realizations:
            return ()
        return tuple(p for p in self.pressures if p in asked.pressures)

    def only(self, realization: int) -> Task:
        """Return the part of one realization."""
        return replace(self, realizations=range(realization, realization + 1))

    def place(self, done: int) -> str:
        """Say where a computation stands that has done so many states of this task."""
        realization, pressure = divmod(done - 1, len(self.pressures))
        text = str(self.only(self.realizations[realization]))
        if pressure + 1 < len(self.pressures):
            text += f", pressure {pressure + 1} of {len(self.pressures)}"
        return text

    def __str__(self) -> str:
        first, last = self.realizations[0] + 1, self.realizations[-1] + 1
        if self.cell.n_realizations == 1:
            return str(self.cell)
        if first == last:
            return f"{self.cell}, realization {first} of {self.cell.n_realizations}"
        return f"{self.cell}, realizations {first} to {last} of {self.cell.n_realizations}"


def cut(
    cell: Cell,
    realizations: range,
    pressures: tuple[float, ...],
    *,
    threads: int = 1,
    parts: int = 1,
) -> list[Task]:
    """Cut realizations of a cell into tasks of about a second, or one of a realization.

    Parameters
    ----------
    cell, realizations, pressures, threads
        As in :class:`Task`.
    parts : int
        Make at least so many tasks, where they stay longer than a tenth of a second.

    Returns
    -------
    list of Task
        The numbers do not depend on the cut.
    """
    seconds = 1e-6 * cell.work * len(pressures) / len(cell.pressures)
    wanted = min(SECONDS_PER_TASK / seconds, len(realizations) / parts)
    size = max(1, math.ceil(max(wanted, 0.1 * SECONDS_PER_TASK / seconds)))
    return [
        Task(cell, realizations[start : start + size], pressures, threads)
        for start in range(0, len(realizations), size)
    ]
