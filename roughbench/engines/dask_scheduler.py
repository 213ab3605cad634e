"""The connection to a Dask scheduler, whether it is safe to use and answers."""

from __future__ import annotations

import contextlib
import logging
import socket
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from roughbench.engines.base import TaskListener
from roughbench.engines.cluster import Cluster, split_address
from roughbench.engines.slurm import INSTALL, LOOPBACK, jobs_of_slurm
from roughbench.errors import RoughbenchError
from roughbench.planning.tasks import Task

if TYPE_CHECKING:
    from distributed import Client
    from distributed.security import Security
from roughbench.engines.dask_workers import RESOURCE, gigabytes_of

SECONDS_FOR_SCHEDULER = 20.0
SECONDS_TO_CLOSE = 5.0
_SECONDS_TO_SAY_WHY = 2.0


@contextlib.contextmanager
def connected(
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
                    gigabytes=max(gigabytes_of(task) for task in tasks),
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
                client.close(timeout=SECONDS_TO_CLOSE)


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
