"""The workers of a Dask cluster: what they must have, and what one does with a task."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import threading
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from roughbench.engines.base import TaskOutcome, carry_out
from roughbench.engines.cluster import Cluster
from roughbench.engines.cluster_watch import ClusterWatch, within
from roughbench.errors import RoughbenchError
from roughbench.planning.resources import memory_of
from roughbench.planning.tasks import Task
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.identity import code_digest, observing_digest, transforms
from roughbench.transform import fft_backend

if TYPE_CHECKING:
    from distributed import Client

RESOURCE = "MEMGB"
"""Key of a worker's memory: ``dask worker --resources MEMGB=16``."""
COMPILING = "compiling"
SECONDS_BETWEEN_CHECKS = 1.0
_SECONDS_FOR_ANSWERS = 10.0


def check_workers(
    client: Client, tasks: Sequence[Task], cluster: Cluster, watch: ClusterWatch
) -> bool:
    """Wait for workers and refuse what none can do; returns whether they declare their memory.

    Dask itself would wait for ever.
    """
    if cluster.kind == "slurm":
        return True  # its jobs are made for the tasks
    while not (workers := watch.workers()):
        watch.check()
        threading.Event().wait(SECONDS_BETWEEN_CHECKS / 10)
    _check_roughbench(client, list(workers))
    declared = [
        w["resources"][RESOURCE] for w in workers.values() if RESOURCE in w["resources"]
    ]
    limits = [w["memory_limit"] / 2**30 for w in workers.values() if w.get("memory_limit")]
    room = max(declared or limits or [math.inf])
    largest = max(tasks, key=memory_of)
    if gigabytes_of(largest) > room:
        raise RoughbenchError(
            f"{largest} needs about {gigabytes_of(largest)} GB, and the largest of "
            f"{len(workers)} workers has {room:g}; start one with more (--memory-limit, "
            f"--resources {RESOURCE}=…), or take a smaller grid"
        )
    return bool(declared)


def _check_roughbench(client: Client, workers: list[str]) -> None:
    """Refuse machines without roughbench: a worker ends at once when it is given a task."""
    find = importlib.util.find_spec  # every Python has it
    found: Mapping[str, Any] = {}
    with contextlib.suppress(TimeoutError):  # of workers that are stopped: see ClusterWatch
        found = within(
            _SECONDS_FOR_ANSWERS,
            lambda: client.run(find, "roughbench", workers=workers, on_error="return"),
        )
    without = [
        address
        for address, spec in found.items()
        if spec is None or isinstance(spec, ModuleNotFoundError)
    ]
    if without:
        raise RoughbenchError(
            f"roughbench is not installed where {len(without)} of {len(workers)} workers run "
            f"({', '.join(sorted(without)[:3])}{', …' * (len(without) > 3)}); install the same "
            "version everywhere and start the workers again"
        )


def code_of(task: Task) -> str:
    """Return digests of what makes the numbers of a task, and the library of its transforms."""
    model = type(task.cell.model)
    code = f"{code_digest(model)}-{observing_digest(task.cell.asked.observables)}"
    return f"{code}-{fft_backend()}" if transforms(model) else code


def gigabytes_of(task: Task) -> int:
    """Return the memory that a task needs by estimate, in whole GiB, as workers declare it."""
    return math.ceil(memory_of(task) / 2**30)


_one_at_a_time = threading.Lock()


def carry_out_there(
    number: int, task: Task, checkpoint: Checkpoint | None, code: str, topic: str
) -> TaskOutcome:
    """Compute a task on a worker, with the same code as here; its events go to a topic."""
    from distributed import get_worker

    worker = get_worker()
    if (here := code_of(task)) != code:
        is_same = here.split("-")[:2] == code.split("-")[:2]
        differs = "library of Fourier transforms" if is_same else "version of roughbench"
        return TaskOutcome(
            error=RoughbenchError(
                f"{task}: the worker {worker.address} has another {differs}; "
                "install the same one everywhere and start the workers again"
            )
        )
    with _one_at_a_time:
        outcome = carry_out(
            task,
            checkpoint,
            lambda done: worker.log_event(topic, (number, done)),
            lambda: worker.log_event(topic, (number, COMPILING)),
        )
    return outcome.portable()
