"""Memory that this process can still have: one rule for whatever asks, before it takes any."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from roughbench.errors import RoughbenchError, SolverError
from roughbench.system import entry, free_memory, memory_limits

_PROC = Path("/proc")
_CGROUP = Path("/sys/fs/cgroup")


@dataclass(frozen=True, slots=True)
class AvailableMemory:
    """Bytes that can be had.

    Attributes
    ----------
    size : int
    limit : str
        What sets it and who could raise it, in words; empty where it is the memory of the
        machine that is free.
    """

    size: int
    limit: str = ""

    def __str__(self) -> str:
        return f"{gigabytes(self.size)} are available" + (f" ({self.limit})" * bool(self.limit))


def gigabytes(size: float) -> str:
    """Return a size for people.

    Examples
    --------
    >>> gigabytes(11.8e9)
    '11.8 GB'
    """
    return f"{size / 1e9:.1f} GB"


def available_memory() -> AvailableMemory | None:
    """Return what can be had without swapping, and what limits it.

    The least of the machine's free memory, what the control groups of this process (v1 and
    v2, itself and those around it) have left, and what ``ulimit -v`` and ``-d`` leave it.
    None where the system does not say.
    """
    known = [*_machine(), *_control_groups(), *_process()]
    least = min(known, key=lambda room: room.size, default=None)
    return least and AvailableMemory(max(0, least.size), least.limit)


def check(
    needed: int,
    what: str,
    remedy: Callable[[int], str],
    error: type[RoughbenchError] = SolverError,
) -> None:
    """Refuse to take more memory than can be had.

    Parameters
    ----------
    needed : int
        Bytes.
    what : str
        What needs them and how many, a sentence.
    remedy : callable
        Returns what would help, given the bytes that can be had.
    error : type of RoughbenchError

    Raises
    ------
    RoughbenchError
        Of the class ``error``.
    """
    here = available_memory()
    if here is not None and needed > here.size:
        raise error(f"{what}, and {here}; {remedy(here.size)}")


def _machine() -> Iterator[AvailableMemory]:
    size = free_memory()
    if size is not None:
        yield AvailableMemory(size)


def _control_groups() -> Iterator[AvailableMemory]:
    """Yield the room in the control group of this process and in those around it."""
    try:
        lines = (_PROC / "self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return
    for line in lines:
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if not controllers:
            root, names = _CGROUP, ("memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            root = _CGROUP / "memory"
            names = (
                *("memory.limit_in_bytes", "memory.usage_in_bytes"),
                "total_inactive_file",
            )
        else:
            continue
        parts = [part for part in path.split("/") if part]
        if ".." in parts:  # a group outside of what this container sees
            parts = []
        for count in range(len(parts), -1, -1):
            folder = root.joinpath(*parts[:count])
            with contextlib.suppress(OSError, ValueError):  # also: no limit there
                limit = int((folder / names[0]).read_text())
                used = int((folder / names[1]).read_text())
                # Pages of files that were read count as used, and are given up at need.
                used -= entry(folder / "memory.stat", names[2]) or 0
                yield AvailableMemory(
                    limit - max(0, used),
                    "the memory limit of the control group: ask for more where the job or "
                    "container is started",
                )


def _process() -> Iterator[AvailableMemory]:
    """Yield what the limits of this process leave it."""
    for left, option in memory_limits():
        yield AvailableMemory(left, f"the limit set by ulimit {option}: raise it")
