"""What a task took, and on what it was computed: recorded, never compared."""

from __future__ import annotations

import contextlib
import functools
import os
import platform
import time
from dataclasses import asdict, dataclass
from importlib import metadata
from typing import Any

from roughbench.system import kind_of_platform, peak_memory, processor, restart_peak_memory

PACKAGES = ("roughbench", "numpy", "scipy", "numba", "pyfftw", "h5py")


@dataclass(frozen=True, slots=True)
class Usage:
    """What one task took.

    Attributes
    ----------
    seconds, cpu_seconds : float
        By the clock, and of all cores.
    peak_memory : int
        Most bytes of memory that its process held meanwhile, libraries included; on other
        systems than Linux, since the process began.
    started : str
        Time at the start, ISO 8601 with time zone.
    machine : dict of str to str
        See :func:`machine`.
    """

    seconds: float
    cpu_seconds: float
    peak_memory: int
    started: str
    machine: dict[str, str]

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        return asdict(self)


class Meter:
    """Measures from where it is made to :meth:`read`."""

    def __init__(self) -> None:
        restart_peak_memory()
        self.started = now()
        self._clock = time.monotonic(), time.process_time()

    def read(self) -> Usage:
        """Return what it took so far."""
        return Usage(
            seconds=time.monotonic() - self._clock[0],
            cpu_seconds=time.process_time() - self._clock[1],
            peak_memory=peak_memory(),
            started=self.started,
            machine=machine(),
        )


def now() -> str:
    """Return the time, ISO 8601 with time zone."""
    return time.strftime("%Y-%m-%dT%H:%M:%S%z")


@functools.cache
def machine() -> dict[str, str]:
    """Return host, processor, system, and the versions of what the numbers come from."""
    versions = {"python": platform.python_version()}
    for package in PACKAGES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[package] = metadata.version(package)
    return {
        "host": platform.node(),
        "cpu": processor(),
        "cores": str(os.cpu_count()),
        "system": platform.platform(),
        "platform": kind_of_platform(),
    } | versions
