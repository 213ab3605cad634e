"""Tasks on the machines of a Dask cluster, one that exists or one that Slurm is asked for.

A finished task travels to this process, which commits it exactly as if it had been computed
here; Dask itself tries the tasks of lost workers again. A worker computes one task at a time,
however many threads Dask gives it.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import itertools
import logging
import math
import os
import queue
import socket
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from roughbench.engines.base import CheckpointOf, TaskListener, TaskOutcome, carry_out
from roughbench.engines.cluster import Cluster, split_address
from roughbench.engines.cluster_watch import ClusterWatch, within
from roughbench.engines.slurm import INSTALL, LOOPBACK, jobs_of_slurm
from roughbench.errors import IncompleteError, RoughbenchError
from roughbench.planning.plan import Task
from roughbench.planning.resources import memory_of
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.identity import code_digest, observing_digest

if TYPE_CHECKING:
    from distributed import Client, Future
    from distributed.security import Security

RESOURCE = "MEMGB"
"""Key of a worker's memory: ``dask worker --resources MEMGB=16``."""
SECONDS_FOR_SCHEDULER = 20.0

_COMPILING = "compiling"
_LOST = "the connection to the Dask scheduler is lost"
_SECONDS_BETWEEN_LOOKS = 1.0
_SECONDS_FOR_ANSWERS = 10.0
_SECONDS_TO_CLOSE = 5.0
_SECONDS_TO_SAY_WHY = 2.0


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
    with _client(cluster, tasks, folder, listener) as (client, refusals):
        watch = ClusterWatch(client, cluster, refusals, listener.on_message)
        try:
            limited = _check_workers(client, tasks, cluster, watch)
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
        _listen(client, tasks, events, watch, listener)
    finally:
        with contextlib.suppress(Exception):
            within(_SECONDS_TO_CLOSE, lambda: client.cancel(futures, force=True))


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
            number, content = events.get(timeout=_SECONDS_BETWEEN_LOOKS)
        except queue.Empty:
            if client.status != "running":
                raise IncompleteError(_LOST) from None
            most = max(_gigabytes(tasks[number]) for number in left)
            watch.check(waits_for=f"they need {RESOURCE} of up to {most} where it is declared")
            continue
        watch.note_progress()
        if number not in left:
            continue
        if content == _COMPILING:
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


# -- the cluster ---------------------------------------------------------------------------


@contextlib.contextmanager
def _client(
    cluster: Cluster, tasks: Sequence[Task], folder: Path, listener: TaskListener
) -> Iterator[tuple[Client, list[str]]]:
    """Yield a client, and what Slurm says against jobs."""
    try:
        from distributed import Client
    except ImportError as error:
        raise RoughbenchError(f"the Dask engine needs Dask; {INSTALL}") from error
    # What it reports with a traceback comes here as an error, too.
    for name in ("distributed", "distributed.client", "distributed.core", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        refusals: list[str] = []
        where: Any
        if cluster.kind == "slurm":
            where, refusals = stack.enter_context(
                jobs_of_slurm(
                    cluster,
                    threads=max(task.threads for task in tasks),
                    gigabytes=max(_gigabytes(task) for task in tasks),
                    most=len(tasks),
                    folder=folder,
                    resource=RESOURCE,
                )
            )
            if cluster.dashboard:
                port = urlsplit(where.dashboard_link).port
                listener.on_message(f"Dask's dashboard: http://{LOOPBACK}:{port}/status")
        else:
            where = cluster.address()
            _ask_identity(where, cluster)
        try:
            client = Client(where, set_as_default=False, timeout=SECONDS_FOR_SCHEDULER)
        except (OSError, ValueError, TimeoutError) as error:
            raise _no_answer(cluster, where, error) from error
        try:
            yield client, refusals
        finally:
            with contextlib.suppress(Exception):  # of a scheduler that is gone
                client.close(timeout=_SECONDS_TO_CLOSE)


def _ask_identity(address: str, cluster: Cluster) -> None:
    """Ask the scheduler who it is; a client that gets no answer takes a minute to say so.

    Raises
    ------
    RoughbenchError
    """
    from distributed.core import rpc
    from distributed.security import Security
    from distributed.utils import LoopRunner, sync

    security = Security()  # as Dask is configured, for TLS
    encrypted = address.startswith(("tls", "wss"))
    if encrypted and not _has_certificate(security):
        raise RoughbenchError(
            f"the scheduler {address} wants a certificate; name its files in "
            "DASK_DISTRIBUTED__COMM__TLS__CA_FILE, …__TLS__CLIENT__CERT and "
            "…__TLS__CLIENT__KEY (see docs/runs.md)"
        )

    async def ask() -> None:
        # Retried while nobody listens: it may just be starting.
        arguments = security.get_connection_args("client")
        async with rpc(
            address, timeout=SECONDS_FOR_SCHEDULER, connection_args=arguments
        ) as scheduler:
            await scheduler.identity()

    runner = LoopRunner()
    runner.start()
    try:
        sync(runner.loop, ask, callback_timeout=SECONDS_FOR_SCHEDULER + _SECONDS_TO_SAY_WHY)
    except (OSError, ValueError, TypeError, RuntimeError, TimeoutError) as error:
        raise _no_answer(cluster, address, error) from error
    finally:
        runner.stop()


def _has_certificate(security: Security) -> bool:
    return bool(security.tls_ca_file and security.tls_client_cert)


def _no_answer(cluster: Cluster, address: Any, error: Exception) -> RoughbenchError:
    # Whether Dask's own error names the cause depends on when its last attempt ended.
    causes = (error, _refusal(address) if isinstance(address, str) else None)
    reason = ": ".join(str(e) or type(e).__name__ for e in causes if e is not None)
    return RoughbenchError(
        f"the Dask scheduler {cluster.name} does not answer ({reason}); start one with: dask "
        "scheduler"
    )


def _refusal(address: str) -> OSError | None:
    _, host, port = split_address(address)
    try:
        socket.create_connection((host, port), _SECONDS_TO_SAY_WHY).close()
    except OSError as error:
        return error
    return None  # something listens


def _check_workers(
    client: Client, tasks: Sequence[Task], cluster: Cluster, watch: ClusterWatch
) -> bool:
    """Wait for workers and refuse what none can do; returns whether they declare their memory.

    Dask itself would wait for ever.
    """
    if cluster.kind == "slurm":
        return True  # its jobs are made for the tasks
    while not (workers := watch.workers()):
        watch.check()
        threading.Event().wait(_SECONDS_BETWEEN_LOOKS / 10)
    _check_roughbench(client, list(workers))
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


def _code(task: Task) -> str:
    """Return a digest of what makes the numbers of a task."""
    return (
        f"{code_digest(type(task.cell.model))}-{observing_digest(task.cell.asked.observables)}"
    )


def _gigabytes(task: Task) -> int:
    return math.ceil(memory_of(task) / 2**30)


# -- on a worker ---------------------------------------------------------------------------

_one_at_a_time = threading.Lock()


def _carry_out_there(
    number: int, task: Task, checkpoint: Checkpoint | None, code: str, topic: str
) -> TaskOutcome:
    from distributed import get_worker

    worker = get_worker()
    if _code(task) != code:
        return TaskOutcome(
            error=RoughbenchError(
                f"{task}: the worker {worker.address} has another version of roughbench; "
                "install the same one everywhere and start the workers again"
            )
        )
    with _one_at_a_time:
        outcome = carry_out(
            task,
            checkpoint,
            lambda done: worker.log_event(topic, (number, done)),
            lambda: worker.log_event(topic, (number, _COMPILING)),
        )
    return outcome.portable()
