"""The tasks of a run handed to the engine that computes them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from roughbench.engines.cluster import Cluster
from roughbench.engines.dask_cluster import compute_on_cluster
from roughbench.engines.local import compute_here, compute_in_workers
from roughbench.planning.resources import ResourceLimits, check_memory
from roughbench.planning.tasks import Task
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import log
from roughbench.runner.monitor import RunMonitor


def compute_tasks(
    tasks: Sequence[Task],
    limits: ResourceLimits,
    monitor: RunMonitor,
    folder: RunFolder | None,
    cluster: Cluster | None = None,
) -> None:
    """Compute tasks here, in processes or on a cluster; the monitor takes what comes.

    Raises
    ------
    RoughbenchError
        If there is no room for one of them, or as the monitor.
    """
    if cluster is not None:
        log.info("%d tasks to compute, on a %s cluster", len(tasks), cluster.kind)
        compute_on_cluster(
            tasks,
            cluster,
            checkpoint_of=monitor.checkpoint,
            listener=monitor,
            folder=folder.path if folder is not None else Path.cwd(),
        )
        return
    check_memory(tasks, limits)
    processes = limits.processes(tasks)
    log.info("%d tasks to compute, in %d processes", len(tasks), processes)
    if processes == 1:
        compute_here(tasks, checkpoint_of=monitor.checkpoint, listener=monitor)
        return
    compute_in_workers(
        tasks,
        processes=processes,
        limits=limits,
        checkpoint_of=monitor.checkpoint,
        listener=monitor,
    )
