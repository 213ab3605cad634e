"""Tasks on the machines of a Dask cluster, one that exists or one that Slurm is asked for.

A finished task travels to this process, which commits it exactly as if it had been computed
here; Dask itself tries the tasks of lost workers again. A worker computes one task at a time,
however many threads Dask gives it.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import math
import os
import queue
from collections.abc import Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughbench.engines.base import CheckpointOf, TaskListener, TaskOutcome
from roughbench.engines.cluster import Cluster
from roughbench.engines.cluster_watch import ClusterWatch, within
from roughbench.errors import IncompleteError, RoughbenchError
from roughbench.planning.resources import memory_of
from roughbench.planning.tasks import Task

if TYPE_CHECKING:
    from distributed import Client, Future
from roughbench.engines.dask_scheduler import SECONDS_TO_CLOSE, connected
from roughbench.engines.dask_workers import (
    COMPILING,
    RESOURCE,
    SECONDS_BETWEEN_CHECKS,
    carry_out_there,
    check_workers,
    code_of,
    gigabytes_of,
)

_LOST = "the connection to the Dask scheduler is lost"


def compute_on_cluster(
    tasks: Sequence[Task],
    cluster: Cluster,
    *,
    checkpoint_of: CheckpointOf,
    listener: TaskListener,
    folder: Path,
) -> None:
    """Compute tasks on a cluster.

    Parameters
    ----------
    tasks : sequence of Task
    cluster : Cluster
    checkpoint_of : callable
    listener : TaskListener
    folder : Path
        Where jobs of Slurm find what they need.

    Raises
    ------
    RoughbenchError
        If Dask is not installed, the scheduler is not safe to use or does not answer, its
        workers have no roughbench, or none has the memory for a task.
    IncompleteError
        If the scheduler is lost, or nothing can be computed for longer than the cluster's
        patience.
    """
    if not tasks:
        return
    with connected(cluster, tasks, folder, listener) as (client, refusals):
        watch = ClusterWatch(client, cluster, refusals, listener.on_message)
        try:
            limited = check_workers(client, tasks, cluster, watch)
            _compute(client, tasks, limited, watch, checkpoint_of, listener)
        finally:
            watch.close()


def _compute(
    client: Client,
    tasks: Sequence[Task],
    limited: bool,  # noqa: FBT001  (whether workers declare their memory)
    watch: ClusterWatch,
    checkpoint_of: CheckpointOf,
    listener: TaskListener,
) -> None:
    events: queue.SimpleQueue[tuple[int, Future[Any] | int | str]] = queue.SimpleQueue()
    topic = f"roughbench-{os.getpid()}-{next(_numbers)}"
    client.subscribe_topic(topic, lambda event: events.put(event[1]))
    futures = [
        client.submit(
            carry_out_there,
            number,
            task,
            checkpoint_of(task),
            code_of(task),
            topic,
            key=f"{topic}-{number}",
            pure=False,
            resources={RESOURCE: gigabytes_of(task)} if limited else None,
        )
        for number, task in enumerate(tasks)
    ]
    for number, future in enumerate(futures):
        future.add_done_callback(_putting(events, number))
    try:
        _listen(client, tasks, events, watch, listener)
    finally:
        with contextlib.suppress(Exception):
            within(SECONDS_TO_CLOSE, lambda: client.cancel(futures, force=True))


_numbers = itertools.count()


def _putting(events: queue.SimpleQueue[Any], number: int) -> Any:
    return lambda future: events.put((number, future))


def _listen(
    client: Client,
    tasks: Sequence[Task],
    events: queue.SimpleQueue[Any],
    watch: ClusterWatch,
    listener: TaskListener,
) -> None:
    left = set(range(len(tasks)))
    while left:
        try:
            number, content = events.get(timeout=SECONDS_BETWEEN_CHECKS)
        except queue.Empty:
            if client.status != "running":
                raise IncompleteError(_LOST) from None
            most = max(gigabytes_of(tasks[number]) for number in left)
            watch.check(waits_for=f"they need {RESOURCE} of up to {most} where it is declared")
            continue
        watch.note_progress()
        if number not in left:
            continue
        if content == COMPILING:
            listener.on_compiling()
            continue
        if isinstance(content, int):
            listener.on_progress(tasks[number], content)
            continue
        left.discard(number)
        listener.on_end(tasks[number], _outcome(content, tasks[number], watch))
        content.release()


def _outcome(future: Future[Any], task: Task, watch: ClusterWatch) -> TaskOutcome:
    if future.status == "lost" or future.status == "cancelled":
        raise IncompleteError(_LOST)
    try:
        error = within(math.inf, future.exception, watch.check)
        if error is None:
            outcome: TaskOutcome = within(math.inf, future.result, watch.check)
            return outcome
    except (OSError, CancelledError, asyncio.CancelledError) as cause:  # on its way here
        raise IncompleteError(_LOST) from cause
    if type(error).__name__ == "KilledWorker":
        return TaskOutcome(
            error=RoughbenchError(
                f"{task}: all of the workers that Dask gave it to died; it was given up. It "
                f"needs about {memory_of(task) / 1e9:.1f} GB by estimate"
            )
        )
    return TaskOutcome(error=RoughbenchError(f"{task}: {error!r}"))
