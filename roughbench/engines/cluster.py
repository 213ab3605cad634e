"""Where tasks are computed, if not on this machine: which Dask cluster, and whether it is safe.

A Dask scheduler without TLS runs what anybody sends who reaches its port, on its workers and
in the processes of its other clients, as the user who started them. So one that is not on the
loopback needs TLS, or an explicit word.
"""

from __future__ import annotations

import contextlib
import ipaddress
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from roughbench.errors import RoughbenchError

MINUTES_FOR_DASK = 10.0
MINUTES_FOR_SLURM = 24 * 60.0
"""Jobs may stand in the queue for hours."""

_ENCRYPTED = ("tls", "wss")
_PLAIN = ("tcp", "ws")
_ADDRESS = re.compile(r"(?:(\w+)://)?(\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):(\d{1,5})/?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Cluster:
    """Where tasks are computed, if not on this machine.

    Attributes
    ----------
    kind : {"dask", "slurm"}
        A Dask scheduler that is running, or jobs of Slurm.
    scheduler : str
        Address of the scheduler, such as ``tls://host:8786``.
    scheduler_file : str
        File with its address, as ``dask scheduler --scheduler-file`` writes it.
    workers : int
        Most jobs of Slurm at a time; as many are asked for as there are tasks.
    walltime, partition, account : str
        Of each job; empty: as Slurm has it by default.
    insecure_scheduler : bool
        Take a scheduler of another machine although it has no TLS.
    dashboard : bool
        Open Dask's dashboard for jobs of Slurm, on the loopback of this machine.
    patience : float or None
        Minutes to wait while nothing can be computed, before the run ends, resumable; None:
        10 for Dask, a day for Slurm.
    """

    kind: Literal["dask", "slurm"]
    scheduler: str = ""
    scheduler_file: str = ""
    workers: int = 4
    walltime: str = "01:00:00"
    partition: str = ""
    account: str = ""
    insecure_scheduler: bool = False
    dashboard: bool = False
    patience: float | None = None

    def __post_init__(self) -> None:
        given = bool(self.scheduler) + bool(self.scheduler_file)
        if self.kind == "dask" and given != 1:
            raise RoughbenchError(
                "a Dask engine needs --scheduler tls://host:port or --scheduler-file FILE, "
                "one of the two"
            )
        if self.kind == "slurm" and given:
            raise RoughbenchError("--engine slurm starts its own scheduler; leave --scheduler")
        if self.kind == "dask" and self.dashboard:
            raise RoughbenchError(
                "--dashboard is for --engine slurm; a scheduler that is running has its own"
            )
        if self.patience is not None and not self.patience > 0.0:
            raise RoughbenchError(
                f"--patience must be a positive number of minutes, got {self.patience:g}"
            )
        if self.scheduler:
            split_address(self.scheduler, "--scheduler")

    @property
    def seconds_of_patience(self) -> float:
        """How long to wait while nothing can be computed."""
        default = MINUTES_FOR_SLURM if self.kind == "slurm" else MINUTES_FOR_DASK
        return 60.0 * (default if self.patience is None else self.patience)

    @property
    def name(self) -> str:
        """What messages call its scheduler."""
        return self.scheduler or self.scheduler_file or "of Slurm's jobs"

    @property
    def start_worker(self) -> str:
        """A command that starts a worker of a Dask cluster."""
        where = self.scheduler or f"--scheduler-file {self.scheduler_file}"
        return f"dask worker {where} --nthreads 1"

    def address(self) -> str:
        """Return the address of the scheduler that is running, if it is safe to use.

        Raises
        ------
        RoughbenchError
            If the scheduler file does not say it, or the scheduler has no TLS, is not on the
            loopback, and nobody said that this is wanted.
        """
        address = self.scheduler or _address_in(Path(self.scheduler_file))
        if not self.insecure_scheduler and not is_protected(address):
            raise RoughbenchError(
                f"the scheduler {address} has no TLS and is not on the loopback of this "
                "machine: whoever reaches its port can run programs as you. Start it and its "
                "workers with certificates and give tls://host:port (see docs/runs.md), or "
                "say --insecure-scheduler if you trust everybody on that network"
            )
        return address


def is_protected(address: str) -> bool:
    """Whether only those with a certificate, or on this machine, reach a scheduler.

    Examples
    --------
    >>> [is_protected(a) for a in ("tls://node7:8786", "127.0.0.1:8786", "tcp://node7:8786")]
    [True, True, False]
    """
    scheme, host, _ = split_address(address)
    if scheme in _ENCRYPTED or host == "localhost":
        return True
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return False


def split_address(
    address: str, name: str = "the address of the scheduler"
) -> tuple[str, str, int]:
    """Return protocol, host and port; Dask itself would try a malformed one for a minute.

    Raises
    ------
    RoughbenchError
        If it is none; says what ``name`` must read like.

    Examples
    --------
    >>> split_address("tls://[::1]:8786"), split_address("node7:8786")
    (('tls', '::1', 8786), ('tcp', 'node7', 8786))
    """
    found = _ADDRESS.fullmatch(address)
    scheme, host, port = (found[1] or "tcp", found[2], int(found[3])) if found else ("", "", 0)
    if scheme not in _ENCRYPTED + _PLAIN or not 0 < port < 2**16:
        raise RoughbenchError(
            f"{name} must read like tls://host:8786 (tls, tcp, wss or ws, a host, and a port "
            f"from 1 to 65535), got {address!r}"
        )
    return scheme, host.strip("[]"), port


def _address_in(file: Path) -> str:
    try:
        content = json.loads(file.read_bytes())
    except FileNotFoundError as error:
        raise RoughbenchError(f"{file}: no such scheduler file") from error
    except OSError as error:
        raise RoughbenchError(f"{file}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise RoughbenchError(f"{file}: is no scheduler file of Dask ({error})") from error
    if not isinstance(content, dict) or not isinstance(content.get("address"), str):
        raise RoughbenchError(f"{file}: is no scheduler file of Dask: it names no address")
    split_address(content["address"], f"{file}: the address of the scheduler")
    return content["address"]
