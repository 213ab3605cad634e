"""What this machine offers, and what a run would miss: for ``roughbench doctor``."""

from __future__ import annotations

import contextlib
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from roughbench.locks import open_lock, try_lock
from roughbench.memory import available_memory
from roughbench.models.registry import BUILT_IN, declared, is_reference
from roughbench.planning.resources import largest_grid, resource_limits
from roughbench.rundir.usage import machine
from roughbench.runner.dry_run import TimeEstimate, estimate
from roughbench.spec import Source
from roughbench.transform import RealTransform, cache_folder, fft_backend

_POINTS = 1024
_TIMES = 10


@dataclass(frozen=True, slots=True)
class FolderState:
    """What can be done in a folder.

    Attributes
    ----------
    path : Path
    writable : bool
    locks : bool or None
        Whether a lock keeps others out; None where nobody can tell, as nothing can be written.
    free : int
        Bytes on its disk.
    """

    path: Path
    writable: bool
    locks: bool | None
    free: int


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What this machine offers.

    Attributes
    ----------
    machine : dict of str to str
        Host, processor, system, versions.
    cores : int
        That this process may use.
    memory : int or None
        Bytes that tasks may take together; None where the system does not say.
    memory_limit : str
        What sets it, in words.
    transforms : str
        The library of the Fourier transforms: ``pyfftw`` or ``scipy``.
    transform_seconds : dict of int to float
        Threads → time of a pair of transforms at 1024² points in single precision.
    cache, working : FolderState
    largest_grid : int
        Points per side, a power of two, that the exact solver has the memory for.
    estimate : TimeEstimate or None
        Of the spec that was given.
    """

    machine: dict[str, str]
    cores: int
    memory: int | None
    memory_limit: str
    transforms: str
    transform_seconds: dict[int, float]
    cache: FolderState
    working: FolderState
    largest_grid: int
    estimate: TimeEstimate | None = None

    @property
    def faults(self) -> list[str]:
        """What would stop a run, or make it unsafe, with a remedy each."""
        found = []
        if not self.working.writable:
            found.append(f"{self.working.path} cannot be written: run elsewhere, or use -o")
        elif self.working.locks is False:
            found.append(
                f"{self.working.path} knows no locks: start no two runs with the same output"
            )
        if not self.cache.writable:
            found.append(
                f"the cache folder {self.cache.path} cannot be written: plans of transforms "
                "are measured in every process; set ROUGHBENCH_CACHE to a folder of yours"
            )
        elif self.cache.locks is False:
            found.append(
                f"the cache folder {self.cache.path} knows no locks: processes that start "
                "together may measure different plans; set ROUGHBENCH_CACHE to a local folder"
            )
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for JSON."""
        found = asdict(self) | {"faults": self.faults}
        for name in ("cache", "working"):
            found[name]["path"] = str(found[name]["path"])
        return found


def diagnose(
    spec: Source | None = None, *, measuring: Callable[[str], None] | None = None
) -> Diagnosis:
    """Return what this machine offers, and what a spec would take on it.

    Transforms are timed, which measures their plans where nobody did before, and so is each
    model of the spec that was never timed here. What is measured is kept in the cache folder.

    Parameters
    ----------
    spec : optional
        As for :func:`roughbench.run`.
    measuring : callable, optional
        Told what is measured.

    Raises
    ------
    RoughbenchError
        As :func:`roughbench.runner.preview`, if there is a spec.
    """
    limits = resource_limits()
    here = available_memory()
    return Diagnosis(
        machine=machine(),
        cores=limits.cores,
        memory=None if here is None else limits.memory,
        memory_limit=limits.limit,
        transforms=fft_backend(),
        transform_seconds={n: _pair(n) for n in dict.fromkeys((1, limits.cores))},
        cache=folder_state(cache_folder()),
        working=folder_state(Path.cwd()),
        largest_grid=_largest_grid(limits.memory),
        estimate=None if spec is None else estimate(spec, measuring=measuring),
    )


def folder_state(folder: Path) -> FolderState:
    """Return what can be done in a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(folder).free
    except OSError:
        return FolderState(folder, writable=False, locks=None, free=0)
    path = folder / f".roughbench-doctor-{os.getpid()}.lock"
    try:
        first, second = open_lock(path), open_lock(path)
    except OSError:
        return FolderState(folder, writable=False, locks=None, free=free)
    try:
        locks = try_lock(first) is True and try_lock(second) is False
    finally:
        for descriptor in (second, first):
            os.close(descriptor)
        with contextlib.suppress(OSError):
            path.unlink()
    return FolderState(folder, writable=True, locks=locks, free=free)


def _largest_grid(memory: int) -> int:
    """Return the points per side, a power of two, that the exact solver has the memory for."""
    exact = [model for kind in BUILT_IN if is_reference(kind) and (model := declared(kind))]
    return max(largest_grid(model.model_validate({}), memory) for model in exact)


def _pair(threads: int) -> float:
    """Return the time of a pair of transforms, the shortest of several."""
    transform = RealTransform((_POINTS, _POINTS), np.float32, threads)
    transform.real[...] = 0.0
    times = []
    for _ in range(_TIMES):
        start = time.perf_counter()
        transform.forward()
        transform.backward()
        times.append(time.perf_counter() - start)
    return min(times)
