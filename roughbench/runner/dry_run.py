"""``run -n``: what a run would compute, and why."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from roughbench.engines.cluster import Cluster
from roughbench.planning.resources import check_memory, memory_of
from roughbench.planning.tasks import Task
from roughbench.runner.overview import PlanRow, overview
from roughbench.runner.preparation import prepare
from roughbench.runner.scan import scan
from roughbench.runner.selection import select
from roughbench.runner.speed import Speeds
from roughbench.spec import Source


def preview(
    spec: Source,
    *,
    output: str | os.PathLike[str] | None = None,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    force: bool = False,
    only: Sequence[str] = (),
    max_memory: int | str | None = None,
    cluster: Cluster | None = None,
    measuring: Callable[[str], None] | None = None,
) -> list[PlanRow]:
    """Return what :func:`run` would compute, and why, without computing or writing any of it.

    Parameters
    ----------
    spec, output, jobs, threads, overrides, force, only, max_memory, cluster
        As for :func:`roughbench.run`.
    measuring : callable, optional
        Measure how fast this machine is for models that were never measured, in some
        seconds, and keep it in the cache folder; message so. Default: by a formula.

    Raises
    ------
    SpecError, SurfaceError, RoughbenchError
        As :func:`run`.
    """
    run = prepare(
        spec,
        output,
        jobs=jobs,
        threads=threads,
        overrides=overrides,
        force=force,
        max_memory=max_memory,
        cluster=cluster,
    )
    cell_states = scan(run.cells, run.limits, run.folder, force=force)
    tasks = select(cell_states, only, parts=run.limits.parts)
    if cluster is None:
        check_memory(tasks, run.limits)
    return overview(cell_states, tasks, run.folder, _speeds(tasks, measuring))


@dataclass(frozen=True, slots=True)
class TimeEstimate:
    """What a spec takes on this machine, if nothing of it is there.

    Attributes
    ----------
    tasks : int
    core_seconds : float
        Time of one core that does nothing else.
    seconds : float
        By the clock, on all cores.
    memory : int
        Bytes of the largest task.
    """

    tasks: int
    core_seconds: float
    seconds: float
    memory: int


def estimate(spec: Source, *, measuring: Callable[[str], None] | None = None) -> TimeEstimate:
    """Return what a spec takes on this machine.

    By the clock it is the time of all tasks shared out over the cores, and at least that of
    the longest, after what a process takes to start and to load the models; what compiles and
    plans is left out.

    Parameters
    ----------
    spec, measuring
        As for :func:`preview`.

    Raises
    ------
    SpecError, SurfaceError, RoughbenchError
        As :func:`preview`.
    """
    run = prepare(spec, None, jobs=None)
    tasks = select(scan(run.cells, run.limits, None), (), parts=run.limits.parts)
    check_memory(tasks, run.limits)
    speeds = _speeds(tasks, measuring)
    seconds = [
        speeds.slowness(task.cell.model) * 1e-6 * task.work * task.n_states for task in tasks
    ]
    longest = max(
        (one / task.threads for one, task in zip(seconds, tasks, strict=True)), default=0.0
    )
    start = sum(speeds.starting(task.cell.model for task in tasks))
    return TimeEstimate(
        tasks=len(tasks),
        core_seconds=start + sum(seconds),
        seconds=start + max(sum(seconds) / run.limits.cores, longest),
        memory=max(map(memory_of, tasks), default=0),
    )


def _speeds(tasks: Sequence[Task], measuring: Callable[[str], None] | None) -> Speeds:
    speeds = Speeds()
    if measuring is not None:
        speeds.measure([task.cell.model for task in tasks], measuring)
    return speeds
