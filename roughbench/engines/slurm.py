"""Jobs of Slurm as the workers of a Dask cluster that this process starts, for itself alone.

Its scheduler has to listen where the jobs can reach it. So everything that is said between
scheduler, workers and this process is encrypted with a certificate made for this run, and only
who has its key is listened to: this process, and the jobs, which read it from a file that only
the user can read. The key is worth nothing once the run has ended.
"""

from __future__ import annotations

import contextlib
import copy
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughbench.engines.cluster import Cluster
from roughbench.errors import RoughbenchError

if TYPE_CHECKING:
    from distributed.security import Security

INSTALL = "install it with: pip install 'roughbench[dask]'"
LOOPBACK = "127.0.0.1"


@contextlib.contextmanager
def jobs_of_slurm(
    cluster: Cluster, *, threads: int, gigabytes: int, most: int, folder: Path, resource: str
) -> Iterator[tuple[Any, list[str]]]:
    """Start a scheduler that submits jobs as they are needed.

    Parameters
    ----------
    cluster : Cluster
    threads, gigabytes : int
        Of each job.
    most : int
        Jobs at a time that there is work for.
    folder : Path
        Where the jobs find the certificate, unless Dask is configured otherwise
        (``jobqueue.slurm.shared-temp-directory``); they have to share it.
    resource : str
        Key under which workers declare their memory.

    Yields
    ------
    cluster, list of str
        What a Dask client connects to; and what ``sbatch`` has said when it refused jobs.

    Raises
    ------
    RoughbenchError
        If Slurm, dask-jobqueue or cryptography are not there: it is never done without TLS.
    """
    if shutil.which("sbatch") is None:
        raise RoughbenchError(
            "--engine slurm needs Slurm's command sbatch, and it is not on the PATH; run it "
            "where jobs are submitted, or on this machine without --engine"
        )
    cluster_class = slurm_cluster()
    import dask

    refusals: list[str] = []
    pages: dict[str, Any] = {}
    if not cluster.dashboard:
        pages["distributed.scheduler.http.routes"] = []
    place = dask.config.get("jobqueue.slurm.shared-temp-directory", None) or folder
    options: dict[str, Any] = {
        "cores": threads,
        "processes": 1,
        "memory": f"{gigabytes + 1} GiB",  # an estimate, and beyond it the job is killed
        "walltime": cluster.walltime,
        "queue": cluster.partition or None,
        "account": cluster.account or None,
        "silence_logs": "critical",
        "scheduler_options": {
            "dashboard": cluster.dashboard,
            "dashboard_address": f"{LOOPBACK}:0",
        },
        "worker_extra_args": [
            *("--nthreads", "1", "--resources", f"{resource}={gigabytes}"),
            *("--no-dashboard", "--dashboard-address", f"{LOOPBACK}:0"),
        ],
    }
    with _certificate(Path(place).expanduser()) as security, dask.config.set(pages):
        made = cluster_class(
            **options,
            security=security,
            job_cls=_noting_refusals(cluster_class.job_cls, refusals),
        )
        with made as found:
            found.adapt(minimum=1, maximum=min(cluster.workers, most))
            yield found, refusals


@contextlib.contextmanager
def _certificate(folder: Path) -> Iterator[Security]:
    """Make a certificate, and files of it for the workers that are gone when the run has ended.

    Their names are those of temporary files in a run directory: what a killed run leaves is
    removed by the next.
    """
    from distributed.security import Security

    try:
        security = Security.temporary()
    except ImportError as error:
        raise RoughbenchError(
            f"--engine slurm needs cryptography for its certificates; {INSTALL}"
        ) from error
    security = copy.copy(security)
    with contextlib.ExitStack() as stack:
        for name in ("tls_ca_file", "tls_worker_cert", "tls_worker_key"):
            file = stack.enter_context(
                tempfile.NamedTemporaryFile(  # readable by the user alone
                    "w", encoding="ascii", prefix=f".{name}-", suffix=".tmp", dir=folder
                )
            )
            file.write(getattr(security, name))
            file.flush()
            setattr(security, name, str(Path(file.name).absolute()))
        yield security


def _noting_refusals(job_class: Any, refusals: list[str]) -> Any:
    """Return a class of jobs that notes why they were not submitted; Dask only tries again."""
    from distributed.core import Status

    async def start(self: Any) -> None:
        try:
            await job_class.start(self)
        except (RuntimeError, ValueError, OSError) as error:
            said = [line for line in str(error).splitlines() if line.strip()]
            refusals.append(said[-1] if said else repr(error))
            self.status = Status.failed  # Dask insists on it when the cluster is closed
            raise

    return type(job_class.__name__, (job_class,), {"start": start})


def slurm_cluster() -> Any:
    """Import the class; the import takes SIGINT over, which is given back."""
    before = signal.getsignal(signal.SIGINT)
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError as error:
        raise RoughbenchError(f"--engine slurm needs dask-jobqueue; {INSTALL}") from error
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, before)
    return SLURMCluster
