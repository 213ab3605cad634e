"""``--only``: some tasks of a plan, by name."""

from __future__ import annotations

import re
from collections.abc import Sequence

from roughbench.errors import RoughbenchError
from roughbench.planning.cells import Cell
from roughbench.planning.tasks import Task
from roughbench.runner.scan import CellState
from roughbench.text import on_one_line, suggestion


def label_of(task: Task) -> str:
    """Return what ``--only`` calls a task, such as ``main/bem:4``; realizations from 1."""
    if task.cell.n_realizations == 1:
        return str(task.cell)
    first, last = task.realizations[0] + 1, task.realizations[-1] + 1
    return f"{task.cell}:{first}" + (f"-{last}" if last > first else "")


def select(cell_states: Sequence[CellState], only: Sequence[str], *, parts: int) -> list[Task]:
    """Return what is missing as tasks, or that part of it which ``only`` names.

    Parameters
    ----------
    cell_states : sequence of CellState
    only : sequence of str
        ``main/bem``, ``main/bem:4`` or ``main/bem:4-7`` each; ``bem`` alone means that of
        every experiment. Empty: everything.
    parts : int
        Into how many tasks at least to cut each model's realizations, if they are long.

    Raises
    ------
    RoughbenchError
        If a name means nothing in this plan; says what would.
    """
    if not only:
        return [task for cell_state in cell_states for task in cell_state.tasks(parts)]
    wanted: dict[Cell, set[int]] = {}
    for name in only:
        for cell, realizations in _parse(name, [cell_state.cell for cell_state in cell_states]):
            wanted.setdefault(cell, set()).update(realizations)
    return [
        task
        for cell_state in cell_states
        if cell_state.cell in wanted
        for task in cell_state.tasks(parts, wanted[cell_state.cell])
    ]


def _parse(name: str, cells: Sequence[Cell]) -> list[tuple[Cell, range]]:
    label, _, numbers = name.partition(":")
    found = [cell for cell in cells if label in (str(cell), cell.model.name)]
    if not found:
        known = [str(cell) for cell in cells]
        near = suggestion(label, [*known, *dict.fromkeys(cell.model.name for cell in cells)])
        hint = f"did you mean {near}? There are" if near else "there are"
        raise RoughbenchError(
            f"--only {on_one_line(name)}: no such model here; {hint} {', '.join(known)}"
        )
    return [_realizations(name, cell, numbers) for cell in found]


def _realizations(name: str, cell: Cell, numbers: str) -> tuple[Cell, range]:
    if not numbers:
        return cell, range(cell.n_realizations)
    found = re.fullmatch(r"(\d+)(?:-(\d+))?", numbers, re.ASCII)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
    if not 1 <= first <= last <= cell.n_realizations:
        raise RoughbenchError(
            f"--only {on_one_line(name)}: {cell} has the realizations 1 to "
            f"{cell.n_realizations}; write {cell}:1 or {cell}:1-{cell.n_realizations}"
        )
    return cell, range(first - 1, last)
