"""The one rule for all output: nothing is replaced but what roughbench wrote itself.

An output is a new file, or an empty one, or a regular file of the same kind that roughbench
wrote before; never an input, a folder or a device. Symbolic links are followed: what they
lead to is checked and replaced, the link stays. A file that is replaced keeps its permissions.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from roughbench.errors import StoreError, explained
from roughbench.publish import commit, temporary_of
from roughbench.system import is_read_only
from roughbench.text import on_one_line, unsafe_character

ENDS = 1 << 16
"""Bytes at either end of a file that its mark is looked for in."""

OutputPath = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file that roughbench writes.

    Attributes
    ----------
    name : str
        As in "is no …".
    is_one : callable
        Whether a file with this beginning and this end is one that roughbench wrote.
    """

    name: str
    is_one: Callable[[bytes, bytes], bool]


def check_output(path: OutputPath, kind: Kind, inputs: Iterable[OutputPath] = ()) -> Path:
    """Refuse an output before hours of work rather than after them; nothing is written.

    Parameters
    ----------
    path : path
    kind : Kind
        What is to be written.
    inputs : iterable of path
        Files that the output must not replace, whatever they are; also other outputs.

    Returns
    -------
    Path
        Where the file will stand: ``path``, or what it leads to as a symbolic link.

    Raises
    ------
    StoreError
        If ``path`` is an input, no regular file, or not one of this kind that roughbench
        wrote; or cannot be written: its folder is not writable, its name is too long.
    """
    given = Path(path)
    unsafe = unsafe_character(given.name)
    if unsafe is not None:
        raise _refusal(given, f"its name holds {unsafe[1]}; choose another")
    target = Path(os.path.realpath(given))
    try:
        _check_target(given, target, kind, inputs)
        _check_folder(given, target)
    except OSError as error:
        raise _refusal(given, explained(error, "choose another place")) from error
    return target


def write_output(
    data: bytes, path: OutputPath, kind: Kind, inputs: Iterable[OutputPath] = ()
) -> Path:
    """Write a file that passes :func:`check_output`, in one step.

    Parameters
    ----------
    data : bytes
    path, kind, inputs
        As for :func:`check_output`.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    StoreError
        If it does not pass, or the system refuses; what stood there before is still there.
    """
    commit(data, check_output(path, kind, inputs))
    return Path(path)


def _refusal(given: Path, reason: str) -> StoreError:
    return StoreError(f"cannot write {on_one_line(str(given))}: {reason}")


def _check_target(given: Path, target: Path, kind: Kind, inputs: Iterable[OutputPath]) -> None:
    status = _status(target)
    for name in inputs:
        other = Path(os.path.realpath(name))
        its_status = _status(other)
        same = status and its_status and os.path.samestat(status, its_status)
        if same or other == target:
            raise _refusal(given, "the same run needs it otherwise; choose another name")
    if status is None:
        return
    if stat.S_ISLNK(status.st_mode):
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    if stat.S_ISDIR(status.st_mode):
        raise _refusal(given, "it is a folder; give a file name in it")
    if not stat.S_ISREG(status.st_mode):
        raise _refusal(given, "it is no regular file; choose another name")
    if status.st_size == 0:
        return
    with target.open("rb") as file:
        ends = both_ends(file)
    if not kind.is_one(*ends):
        raise _refusal(
            given,
            f"it exists, and is no {kind.name} that roughbench wrote; choose another name, or "
            "move it away",
        )


def _check_folder(given: Path, target: Path) -> None:
    """Check that the file's folder, or the nearest one that is there, can be written."""
    _status(temporary_of(target))  # says if it would be too long
    folder = target.parent
    while _status(folder) is None:
        folder = folder.parent
    if not folder.is_dir():
        raise _refusal(given, f"{folder} is no folder; choose another place")
    if folder != target.parent and given.is_symlink():
        raise _refusal(given, f"it leads to {target}, and that folder is not there; make it")
    if is_read_only(folder):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise _refusal(given, f"no permission to write in {folder}; choose another place")


def _status(path: Path) -> os.stat_result | None:
    """Return the status of a file, None where there is none.

    Raises
    ------
    OSError
        If nobody can tell.
    """
    try:
        return path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return None


def both_ends(file: IO[bytes]) -> tuple[bytes, bytes]:
    """Return the first and the last bytes of a file, for :attr:`Kind.is_one`."""
    head = file.read(ENDS)
    file.seek(max(0, file.seek(0, os.SEEK_END) - ENDS))
    return head, file.read(ENDS)
