"""Files that appear under their name in one step: whole, or not at all."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import itertools
import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

from roughbench.errors import StoreError, explained
from roughbench.system import set_permissions, sync_folder

_LONGEST_STEM = 200
"""Bytes; file systems allow 255, and a temporary name has a process and a number too."""
_counter = itertools.count()


def publish(write: Callable[[IO[bytes]], object], path: Path) -> None:
    """Make what ``write`` writes the file ``path``, in one step that survives a power cut.

    A file that is replaced leaves its permissions to the new one.

    Raises
    ------
    OSError
        If the system refuses; what stood under ``path`` before is still there.
    """
    with written(write, path) as temporary:
        put(temporary, path)


@contextlib.contextmanager
def written(write: Callable[[IO[bytes]], object], path: Path) -> Iterator[Path]:
    """Have ``write`` write a file beside ``path``, on the disk when it is given out.

    It is gone afterwards, unless :func:`put` has made it the file that it is to be.

    Raises
    ------
    OSError
        If the system refuses.
    """
    temporary = temporary_of(path)
    try:
        with temporary.open("x+b") as file:
            _keep_mode(path, file.fileno())
            write(file)
            file.flush()
            os.fsync(file.fileno())
        yield temporary
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def put(temporary: Path, path: Path) -> None:
    """Give a written file its name, in one step that survives a power cut."""
    temporary.replace(path)
    sync_folder(path.parent)


def temporary_of(path: Path) -> Path:
    """Return a new name beside ``path``, for what is not whole yet; never too long a name."""
    return path.with_name(f".{_stem(path)}.{os.getpid()}.{next(_counter)}.tmp")


def _stem(path: Path) -> str:
    name = os.fsencode(path.name)
    return path.name if len(name) <= _LONGEST_STEM else hashlib.sha256(name).hexdigest()[:32]


def _keep_mode(path: Path, descriptor: int) -> None:
    with contextlib.suppress(OSError):
        before = path.lstat().st_mode
        if stat.S_ISREG(before):
            set_permissions(descriptor, before & 0o777)


def make_folder(folder: Path) -> None:
    """Make a folder for output, with its parents, where it does not exist.

    Raises
    ------
    StoreError
        If it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(
            f"cannot make the folder {folder}: {explained(error, 'choose another place')}"
        ) from error


def commit(
    data: bytes,
    path: str | os.PathLike[str],
    *,
    way_out: str = "choose another place with -o",
) -> Path:
    """Publish ``data`` as the file ``path``, see :func:`publish`.

    Parameters
    ----------
    data : bytes
    path : path
    way_out : str
        What a caller can do where the system refuses.

    Raises
    ------
    StoreError
        If the system refuses (no such folder, no permission, disk full); what stood
        under ``path`` before is still there.
    """
    target = Path(path)
    with refusals_named(target, way_out):
        publish(lambda file: file.write(data), target)
    return target


@contextlib.contextmanager
def refusals_named(
    target: Path, way_out: str = "choose another place with -o"
) -> Iterator[None]:
    """Turn a refusal of the system into a :class:`StoreError` that names the file."""
    try:
        yield
    except OSError as error:
        raise StoreError(f"cannot write {target}: {explained(error, way_out)}") from error


def remove_leftovers(path: Path) -> None:
    """Remove what a killed process left of a file that it was about to publish.

    Only for whom no other process can be publishing the same file.
    """
    path = Path(os.path.realpath(path))
    with contextlib.suppress(OSError):
        for leftover in path.parent.glob(f".{glob.escape(_stem(path))}.[0-9]*.[0-9]*.tmp"):
            leftover.unlink()
