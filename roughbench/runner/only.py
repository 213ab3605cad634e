"""``--only``: some tasks of a plan, by name."""

from __future__ import annotations

import re
from collections.abc import Sequence

from roughbench.errors import RoughbenchError
from roughbench.runner.plan import Cell, Task
from roughbench.runner.survey import Stock


def label_of(task: Task) -> str:
    """Return what ``--only`` calls a task, such as ``main/bem:4``; realizations from 1."""
    if task.cell.n_realizations == 1:
        return str(task.cell)
    first, last = task.realizations[0] + 1, task.realizations[-1] + 1
    return f"{task.cell}:{first}" + (f"-{last}" if last > first else "")


def select(stocks: Sequence[Stock], only: Sequence[str], *, parts: int) -> list[Task]:
    """Return what is missing as tasks, or that part of it which ``only`` names.

    Parameters
    ----------
    stocks : sequence of Stock
    only : sequence of str
        ``main/bem``, ``main/bem:4`` or ``main/bem:4-7`` each; empty: everything.
    parts : int
        Into how many tasks at least to cut each model's realizations, if they are long.

    Raises
    ------
    RoughbenchError
        If a name means nothing in this plan; says what would.
    """
    if not only:
        return [task for stock in stocks for task in stock.tasks(parts)]
    wanted: dict[Cell, set[int]] = {}
    for name in only:
        cell, realizations = _parse(name, [stock.cell for stock in stocks])
        wanted.setdefault(cell, set()).update(realizations)
    return [
        task
        for stock in stocks
        if stock.cell in wanted
        for task in stock.tasks(parts, wanted[stock.cell])
    ]


def _parse(name: str, cells: Sequence[Cell]) -> tuple[Cell, range]:
    label, _, numbers = name.partition(":")
    cell = next((cell for cell in cells if str(cell) == label), None)
    if cell is None:
        known = ", ".join(str(cell) for cell in cells)
        raise RoughbenchError(f"--only {name}: no such model here; there are {known}")
    if not numbers:
        return cell, range(cell.n_realizations)
    found = re.fullmatch(r"(\d+)(?:-(\d+))?", numbers, re.ASCII)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
    if not 1 <= first <= last <= cell.n_realizations:
        raise RoughbenchError(
            f"--only {name}: {label} has the realizations 1 to {cell.n_realizations}; write "
            f"{label}:1 or {label}:1-{cell.n_realizations}"
        )
    return cell, range(first - 1, last)
