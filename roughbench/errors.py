"""Every error that roughbench raises on purpose; one base class to catch them all."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from dataclasses import dataclass


class RoughbenchError(Exception):
    """Base of all errors raised on purpose; the message names the remedy."""


class SurfaceError(RoughbenchError):
    """Heights, a grid or a spectrum that cannot be used."""


class UnitError(RoughbenchError):
    """A number with a unit that cannot be read, or is of another dimension.

    ``reason`` says what is wrong and what to write; the message also names what it is.
    """

    def __init__(self, reason: str, name: str = "") -> None:
        self.reason = reason
        super().__init__(f"{name}: {reason}" if name else reason)


class SolverError(RoughbenchError):
    """Input that a contact model cannot solve."""


class ModelError(RoughbenchError):
    """A contender from outside that cannot be found, loaded or used."""


class StoreError(RoughbenchError):
    """A results file that cannot be written, or read as one."""


class UnknownNameError(RoughbenchError, KeyError):
    """A name that results do not hold; a KeyError whose message is shown as it stands."""

    def __str__(self) -> str:
        return str(self.args[0])


class LockedError(RoughbenchError):
    """A run directory that another run works in."""


class IncompleteError(RoughbenchError):
    """A run that ended before its end; what it finished is kept, and it can be resumed."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of a spec: where it stands and what to do about it.

    ``line`` and ``column`` count from 1; 0 means that the place is not known
    (a spec given as a dict). ``path`` is the key path, such as
    ``surface.slope`` or ``models[1].springs``.
    """

    message: str
    path: str = ""
    line: int = 0
    column: int = 0
    source: str = ""

    def __str__(self) -> str:
        place = self.source or "spec"
        if self.line:
            place += f":{self.line}:{self.column}"
        subject = f"{self.path}: " if self.path else ""
        return f"{place}: error: {subject}{self.message}"


class SpecError(RoughbenchError):
    """A spec that cannot be used; ``faults`` holds all of its faults."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


_REMEDIES = {
    errno.EACCES: "check the permissions of it and of its folders",
    errno.EPERM: "check the permissions of it and of its folders",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "its symbolic links lead in circles",
    errno.ENOENT: "check the name",
    errno.ENOTDIR: "a part of its path is no folder; check the name",
    errno.ENOSPC: "make room there",
    errno.EDQUOT: "make room there",
    errno.EFBIG: "make room there",
    errno.EMFILE: "allow more open files (ulimit -n), or take fewer jobs (-j)",
    errno.ENFILE: "close other programs, or take fewer jobs (-j)",
    errno.EAGAIN: "allow more processes (ulimit -u), or take fewer jobs (-j)",
    errno.EIO: "the disk fails: save what is on it",
    errno.ESTALE: "the network disk was lost; mount it again",
}


def explained(error: OSError, way_out: str = "") -> str:
    """Return what the system says, and what to do about it.

    Parameters
    ----------
    error : OSError
    way_out : str
        Another thing to do about it, whatever it is.

    Examples
    --------
    >>> explained(OSError(errno.ENAMETOOLONG, "File name too long", "x" * 300))
    'File name too long; choose a shorter name'
    >>> explained(OSError(errno.EROFS, "Read-only file system"), "choose another place")
    'Read-only file system; choose another place'
    """
    reason = error.strerror or str(error)
    remedies = ", or ".join(filter(None, (_REMEDIES.get(error.errno or 0), way_out)))
    return f"{reason}; {remedies}" if remedies else reason
