"""A plan cut into shares for processes that know nothing of each other.

Which share computes what follows from the plan alone: not from what is there already, nor from
the machine, so that all of them can start at any time and in any order.
"""

from __future__ import annotations

import heapq
import re
from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.errors import RoughbenchError
from roughbench.planning.cells import Cell
from roughbench.planning.tasks import cut
from roughbench.text import on_one_line

MOST_SHARES = 100_000


@dataclass(frozen=True, slots=True)
class Share:
    """One of several shares of a plan.

    Attributes
    ----------
    number, count : int
        Such as 3 of 40; the number from 1.
    """

    number: int
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def parse_share(text: str) -> Share:
    """Return the share that a text such as ``3/40`` means.

    Raises
    ------
    RoughbenchError
        If it means none.

    Examples
    --------
    >>> parse_share("3/40")
    Share(number=3, count=40)
    """
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text, re.ASCII)
    number, count = (int(found[1]), int(found[2])) if found else (0, 0)
    if not 1 <= number <= count <= MOST_SHARES:
        raise RoughbenchError(
            f"a share reads like 3/40, the third of forty, from 1/40 to 40/40 (at most "
            f"{MOST_SHARES} shares); got {on_one_line(text)!r}"
        )
    return Share(number, count)


def realizations_of_share(cells: Sequence[Cell], share: Share) -> dict[Cell, set[int]]:
    """Return the realizations of each cell that a share computes.

    The batches that tasks are cut into go one after the other, those with most work first, to
    the share that has least. Every realization is in one share.

    Parameters
    ----------
    cells : sequence of Cell
        Of the whole plan.
    share : Share
    """
    batches = [
        (task.work * task.n_states, cell, task.realizations)
        for cell in cells
        for task in cut(cell, range(cell.n_realizations), cell.pressures, parts=share.count)
    ]
    batches.sort(key=lambda batch: -batch[0])  # stable: the order of the plan decides on equals
    loads = [(0.0, number) for number in range(1, share.count + 1)]
    found: dict[Cell, set[int]] = {}
    for work, cell, realizations in batches:
        load, number = heapq.heappop(loads)
        heapq.heappush(loads, (load + work, number))
        if number == share.number:
            found.setdefault(cell, set()).update(realizations)
    return found
