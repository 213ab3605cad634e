"""How cores and memory are shared out among tasks."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from roughbench.errors import RoughbenchError
from roughbench.memory import available_memory, gigabytes
from roughbench.models.base import Model
from roughbench.planning.cells import NOTHING, Cell
from roughbench.planning.tasks import Task
from roughbench.system import available_cores

GRID_FOR_ALL_CORES = 1536
"""Points per side from which one task with all cores beats several with one each."""

_LARGEST_GRID = 1 << 17
"""Points per side that nobody asks for."""
_PROCESS = 300 * 2**20
"""Bytes of a process with its libraries; measured: 260 MB."""
_PER_POINT_OBSERVED = 60
"""Bytes per point to take observables from a state; measured: 43, beside its fields."""
_PER_POINT_OF_FIELD = 16
_PER_STATE = 300
"""Bytes of the numbers of a state; the exact solver has 14 of them, and their averages."""
_PER_STATE_OBSERVED = 3000
"""Bytes of one observable of a state; it has up to 200 bins."""
_FRACTION = 0.8
_SECONDS_WORTH_PROCESSES = 4.0

_UNITS = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40}


@dataclass(frozen=True, slots=True)
class ResourceLimits:
    """What a run may take.

    Attributes
    ----------
    jobs : int or None
        Tasks at once; None: as many as cores and memory allow.
    given_threads : int or None
        Threads of each task; None: see :meth:`threads`.
    memory : int
        Bytes that all tasks together may take.
    cores : int
    limit : str
        What sets the memory, in words; empty where it was given.
    """

    jobs: int | None
    given_threads: int | None
    memory: int
    cores: int
    limit: str = ""

    def threads(self, cell: Cell) -> int:
        """Return the threads of a cell's tasks.

        As given; with ``jobs`` given, cores / jobs; else all cores for surfaces of 1536²
        points and more, and one for smaller ones, of which several are computed at once.
        """
        if self.given_threads is not None:
            return self.given_threads
        if self.jobs is not None:
            return max(1, self.cores // self.jobs)
        large = cell.model.dimension == 2 and cell.n_points >= GRID_FOR_ALL_CORES**2
        return self.cores if large else 1

    @property
    def most_threads(self) -> int:
        """Threads that all tasks together may have: the cores, unless message to take more."""
        return max(self.cores, (self.jobs or 1) * (self.given_threads or 1))

    @property
    def parts(self) -> int:
        """Into how many tasks at least to cut long work, so that every core gets some."""
        return 2 * (self.jobs or self.cores)

    def choices(self, cell: Cell) -> list[int]:
        """Return :meth:`threads`, then the numbers that would do as well if none was given."""
        wanted = self.threads(cell)
        if self.given_threads is not None or not cell.model.iterative:
            return [wanted]
        return [wanted, *(n for n in range(1, self.cores + 1) if n != wanted)]

    def processes(self, tasks: Sequence[Task]) -> int:
        """Return how many processes to compute tasks in; 1 is this one."""
        if self.jobs is not None:
            return min(self.jobs, max(1, len(tasks)))
        seconds = sum(1e-6 * task.work * task.n_states for task in tasks)
        if seconds < _SECONDS_WORTH_PROCESSES:
            return 1
        threads = min((task.threads for task in tasks), default=1)
        return max(1, min(self.cores // threads, len(tasks)))


def resource_limits(
    jobs: int | None = None, threads: int | None = None, max_memory: int | str | None = None
) -> ResourceLimits:
    """Return what a run may take on this machine.

    Parameters
    ----------
    jobs, threads : int, optional
    max_memory : int or str, optional
        Bytes, or a text such as ``12G``; default: 80 % of what is available.

    Raises
    ------
    RoughbenchError
        If one of them is no positive number.
    """
    for name, value in (("jobs", jobs), ("threads", threads)):
        if value is not None and value < 1:
            raise RoughbenchError(f"{name} must be at least 1, got {value}")
    if max_memory is not None:
        return ResourceLimits(jobs, threads, in_bytes(max_memory), available_cores())
    here = available_memory()
    if here is None:
        return ResourceLimits(jobs, threads, 2**62, available_cores())
    # The rest is for what holds the run together, and assembles its results.
    memory = int(_FRACTION * here.size)
    limit = f"{_FRACTION:.0%} of what there is: {here}"
    return ResourceLimits(jobs, threads, memory, available_cores(), limit)


def in_bytes(text: int | str) -> int:
    """Return a number of bytes.

    Raises
    ------
    RoughbenchError
        If it is none.

    Examples
    --------
    >>> in_bytes("1.5G"), in_bytes("512 MB"), in_bytes(4096)
    (1610612736, 536870912, 4096)
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([KMGT]?)(?:i?B)?\s*", str(text), re.IGNORECASE)
    if found is None or float(found[1]) == 0.0:
        raise RoughbenchError(f"memory must read like 12G or 800M, got {text!r}")
    return int(float(found[1]) * _UNITS[found[2].upper()])


def memory_of(task: Task) -> int:
    """Estimate the bytes that a process needs for a task, its libraries included.

    Examples: 0.3 GB for 512² points, 0.5 GB for 2048² (measured: 0.4 and 0.6 GB).
    """
    n_points, model = task.cell.n_points, task.cell.model
    memory = _PROCESS + model.memory(n_points)
    if task.cell.asked.observables:
        memory += _PER_POINT_OBSERVED * n_points
    # Once as they come, once more in the block of the task and on the way to its shard.
    n_fields = sum(len(task.kept(realization)) for realization in task.realizations)
    return memory + 3 * n_fields * _PER_POINT_OF_FIELD * n_points


def largest_grid(model: Model, memory: int) -> int:
    """Return the points per side, a power of two, that a model of surfaces has the memory for.

    Parameters
    ----------
    model : Model
    memory : int
        Bytes that a run may take.

    Examples
    --------
    >>> from roughbench.models.winkler import Winkler
    >>> largest_grid(Winkler(), 2**30)
    2048
    """
    fitting, points = 0, 2
    while points <= _LARGEST_GRID and _PROCESS + model.memory(points**2) <= memory:
        fitting, points = points, 2 * points
    return fitting


def assembly_memory(cell: Cell) -> int:
    """Estimate the bytes that a process needs to put the results of a cell together.

    The values of the cell's states are there once, beside one variable of a shard as it is
    read, or one field as it is written; those of other cells are on the disk.
    """
    fields = len(cell.asked.kept) * _PER_POINT_OF_FIELD * cell.n_points
    of_a_shard = len(cell.asked.pressures) * _PER_POINT_OF_FIELD * cell.n_points // 2
    per_state = _PER_STATE + _PER_STATE_OBSERVED * len(cell.asked.observables)
    return _PROCESS + fields + of_a_shard + 2 * cell.n_states * per_state


def check_memory(tasks: Sequence[Task], limits: ResourceLimits) -> None:
    """Refuse tasks that would never get the memory they need, or their results.

    Raises
    ------
    RoughbenchError
        Names the largest, what may be had, and what would help.
    """
    largest = max(tasks, key=memory_of, default=None)
    if largest is not None and memory_of(largest) > limits.memory:
        limit = f", {limits.limit}" if limits.limit else ""
        raise RoughbenchError(
            f"{largest} needs about {gigabytes(memory_of(largest))}, and all tasks together "
            f"may take {gigabytes(limits.memory)}{limit}; "
            f"{', or '.join(_remedies(largest, limits))}"
        )
    for cell in dict.fromkeys(task.cell for task in tasks):
        if assembly_memory(cell) > limits.memory:
            raise RoughbenchError(
                f"{cell}: to put its results together takes about "
                f"{assembly_memory(cell) / 1e9:.1f} GB, and the run may take "
                f"{limits.memory / 1e9:.1f} GB; allow more with --max-memory, or keep fewer "
                "fields (save_fields)"
            )


def _remedies(task: Task, limits: ResourceLimits) -> Iterator[str]:
    """Yield what would make room for a task."""
    cell = task.cell
    here = available_memory()
    if here is None or memory_of(task) <= here.size:
        yield "allow more with --max-memory"
    if options := cell.model.thriftier():
        other = cell.model.model_copy(update=options)
        if memory_of(replace(task, cell=replace(cell, model=other))) <= limits.memory:
            yield f"choose {', '.join(f'{key}: {value}' for key, value in options.items())}"
    bare = replace(task, cell=replace(cell, asked=NOTHING))
    if memory_of(bare) < memory_of(task) and memory_of(bare) <= limits.memory:
        yield "ask for no observables and fields"
    yield "take a smaller grid or a larger machine"
