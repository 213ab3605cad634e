"""``run -n``: what a run would compute, and why."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from roughbench.engines.cluster import Cluster
from roughbench.planning.resources import check_memory
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
    speeds = Speeds()
    if measuring is not None:
        speeds.measure([task.cell.model for task in tasks], measuring)
    return overview(cell_states, tasks, run.folder, speeds)
