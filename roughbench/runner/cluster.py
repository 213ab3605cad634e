"""Tasks on the machines of a Dask cluster, one that exists or one that Slurm is asked for.

A finished task travels to this process, which commits it exactly as if it had been computed
here; Dask itself tries the tasks of lost workers again. A worker computes one task at a time,
however many threads Dask gives it.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import math
import os
import queue
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from roughbench.errors import IncompleteError, RoughbenchError
from roughbench.runner.checkpoint import Checkpoint
from roughbench.runner.engine import CheckpointOf, Listener, Outcome, carry_out
from roughbench.runner.identity import code_digest, observing_digest
from roughbench.runner.plan import Task
from roughbench.runner.resources import memory_of

if TYPE_CHECKING:
    from distributed import Client, Future

RESOURCE = "MEMGB"
"""Key of a worker's memory: ``dask worker --resources MEMGB=16``."""
SECONDS_FOR_WORKERS = 60.0
SECONDS_FOR_SCHEDULER = 20.0

_SECONDS_BETWEEN_LOOKS = 1.0
_SECONDS_TO_CLOSE = 5.0
_INSTALL = "install it with: pip install 'roughbench[dask]'"


@dataclass(frozen=True, slots=True)
class Cluster:
    """Where tasks are computed, if not on this machine.

    Attributes
    ----------
    kind : {"dask", "slurm"}
        A Dask scheduler that is running, or jobs of Slurm.
    scheduler : str
        Address of the scheduler, such as ``tcp://host:8786``.
    scheduler_file : str
        File with its address, as ``dask scheduler --scheduler-file`` writes it.
    workers : int
        Most jobs of Slurm at a time; as many are asked for as there are tasks.
    walltime, partition, account : str
        Of each job; empty: as Slurm has it by default.
    """

    kind: Literal["dask", "slurm"]
    scheduler: str = ""
    scheduler_file: str = ""
    workers: int = 4
    walltime: str = "01:00:00"
    partition: str = ""
    account: str = ""

    def __post_init__(self) -> None:
        given = bool(self.scheduler) + bool(self.scheduler_file)
        if self.kind == "dask" and given != 1:
            raise RoughbenchError(
                "a Dask engine needs --scheduler tcp://host:port or --scheduler-file FILE, "
                "one of the two"
            )
        if self.kind == "slurm" and given:
            raise RoughbenchError("--engine slurm starts its own scheduler; leave --scheduler")


def compute_on_cluster(
    tasks: Sequence[Task], cluster: Cluster, *, checkpoint_of: CheckpointOf, listener: Listener
) -> None:
    """Compute tasks on a cluster.

    Raises
    ------
    RoughbenchError
        If Dask is not installed, the scheduler does not answer, no worker comes, or none has
        the memory for a task.
    IncompleteError
        If the scheduler is lost.
    """
    if not tasks:
        return
    with _client(cluster, tasks) as client:
        limited = _check_workers(client, tasks, cluster)
        events: queue.SimpleQueue[tuple[int, Future[Any] | int]] = queue.SimpleQueue()
        topic = f"roughbench-{os.getpid()}-{next(_numbers)}"
        client.subscribe_topic(topic, lambda event: events.put(event[1]))
        futures = [
            client.submit(
                _carry_out_there,
                number,
                task,
                checkpoint_of(task),
                _code(task),
                topic,
                key=f"{topic}-{number}",
                pure=False,
                resources={RESOURCE: _gigabytes(task)} if limited else None,
            )
            for number, task in enumerate(tasks)
        ]
        for number, future in enumerate(futures):
            future.add_done_callback(_putting(events, number))
        try:
            _listen(client, tasks, events, listener)
        finally:
            with contextlib.suppress(Exception):
                client.cancel(futures, force=True)


_numbers = itertools.count()


def _putting(events: queue.SimpleQueue[Any], number: int) -> Any:
    return lambda future: events.put((number, future))


def _listen(
    client: Client, tasks: Sequence[Task], events: queue.SimpleQueue[Any], listener: Listener
) -> None:
    left = set(range(len(tasks)))
    while left:
        try:
            number, content = events.get(timeout=_SECONDS_BETWEEN_LOOKS)
        except queue.Empty:
            if client.status != "running":
                raise IncompleteError("the connection to the Dask scheduler is lost") from None
            continue
        if number not in left:
            continue
        if isinstance(content, int):
            listener.advanced(tasks[number], content)
            continue
        left.discard(number)
        listener.ended(tasks[number], _outcome(content, tasks[number]))
        content.release()


def _outcome(future: Future[Any], task: Task) -> Outcome:
    if future.status == "lost" or future.status == "cancelled":
        raise IncompleteError("the connection to the Dask scheduler is lost")
    error = future.exception()
    if error is None:
        outcome: Outcome = future.result()
        return outcome
    if type(error).__name__ == "KilledWorker":
        return Outcome(
            error=RoughbenchError(
                f"{task}: all of the workers that Dask gave it to died; it was given up. It "
                f"needs about {memory_of(task) / 1e9:.1f} GB by estimate"
            )
        )
    return Outcome(error=RoughbenchError(f"{task}: {error!r}"))


# -- the cluster ---------------------------------------------------------------------------


@contextlib.contextmanager
def _client(cluster: Cluster, tasks: Sequence[Task]) -> Iterator[Client]:
    try:
        from distributed import Client
    except ImportError as error:
        raise RoughbenchError(f"the Dask engine needs Dask; {_INSTALL}") from error
    # What it reports with a traceback comes here as an error, too.
    for name in ("distributed", "distributed.client", "distributed.core", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        options: dict[str, Any] = {"timeout": SECONDS_FOR_SCHEDULER}
        if cluster.kind == "slurm":
            options["address"] = stack.enter_context(_slurm(cluster, tasks))
        elif cluster.scheduler_file:
            if not Path(cluster.scheduler_file).is_file():
                raise RoughbenchError(f"{cluster.scheduler_file}: no such scheduler file")
            options["scheduler_file"] = cluster.scheduler_file
        else:
            options["address"] = cluster.scheduler
        try:
            client = Client(set_as_default=False, **options)
        except (OSError, ValueError, TimeoutError) as error:
            where = cluster.scheduler or cluster.scheduler_file or "Slurm's"
            raise RoughbenchError(
                f"the Dask scheduler {where} does not answer ({error}); start one with: "
                "dask scheduler"
            ) from error
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # of a scheduler that is gone
                client.close(timeout=_SECONDS_TO_CLOSE)


@contextlib.contextmanager
def _slurm(cluster: Cluster, tasks: Sequence[Task]) -> Iterator[Any]:
    gigabytes = max(_gigabytes(task) for task in tasks)
    options: dict[str, Any] = {
        "cores": max(task.threads for task in tasks),
        "processes": 1,
        "memory": f"{gigabytes + 1} GiB",  # an estimate, and beyond it the job is killed
        "walltime": cluster.walltime,
        "worker_extra_args": ["--nthreads", "1", "--resources", f"{RESOURCE}={gigabytes}"],
        "queue": cluster.partition or None,
        "account": cluster.account or None,
    }
    with _slurm_cluster()(**options) as found:
        found.adapt(minimum=1, maximum=min(cluster.workers, len(tasks)))
        yield found


def _slurm_cluster() -> Any:
    """Import the class; the import takes SIGINT over, which is given back."""
    before = signal.getsignal(signal.SIGINT)
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError as error:
        raise RoughbenchError(f"--engine slurm needs dask-jobqueue; {_INSTALL}") from error
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, before)
    return SLURMCluster


def _check_workers(client: Client, tasks: Sequence[Task], cluster: Cluster) -> bool:
    """Refuse what no worker can do; returns whether the workers declare their memory.

    Dask itself would wait for ever.
    """
    if cluster.kind == "slurm":
        return True  # its jobs are made for the tasks
    try:
        client.wait_for_workers(1, timeout=SECONDS_FOR_WORKERS)
    except TimeoutError as error:
        raise RoughbenchError(
            "the Dask scheduler has no workers; start some with: dask worker "
            f"{cluster.scheduler or '--scheduler-file ' + cluster.scheduler_file} --nthreads 1"
        ) from error
    workers: Mapping[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    declared = [
        w["resources"][RESOURCE] for w in workers.values() if RESOURCE in w["resources"]
    ]
    limits = [w["memory_limit"] / 2**30 for w in workers.values() if w.get("memory_limit")]
    room = max(declared or limits or [math.inf])
    largest = max(tasks, key=memory_of)
    if _gigabytes(largest) > room:
        raise RoughbenchError(
            f"{largest} needs about {_gigabytes(largest)} GB, and the largest of "
            f"{len(workers)} workers has {room:g}; start one with more (--memory-limit, "
            f"--resources {RESOURCE}=…), or take a smaller grid"
        )
    return bool(declared)


def _code(task: Task) -> str:
    """Return a digest of what makes the numbers of a task."""
    return f"{code_digest(type(task.cell.model))}-{observing_digest()}"


def _gigabytes(task: Task) -> int:
    return math.ceil(memory_of(task) / 2**30)


# -- on a worker ---------------------------------------------------------------------------

_one_at_a_time = threading.Lock()


def _carry_out_there(
    number: int, task: Task, checkpoint: Checkpoint | None, code: str, topic: str
) -> Outcome:
    from distributed import get_worker

    worker = get_worker()
    if _code(task) != code:
        return Outcome(
            error=RoughbenchError(
                f"{task}: the worker {worker.address} has another version of roughbench; "
                "install the same one everywhere and start the workers again"
            )
        )
    with _one_at_a_time:
        outcome = carry_out(
            task, checkpoint, lambda done: worker.log_event(topic, (number, done))
        )
    return outcome.portable()
