"""Files that appear under their name in one step: whole, or not at all."""

from __future__ import annotations

import contextlib
import glob
import itertools
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

from roughbench.errors import StoreError

_counter = itertools.count()


def publish(write: Callable[[IO[bytes]], object], path: Path) -> None:
    """Make what ``write`` writes the file ``path``, in one step that survives a power cut.

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
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{next(_counter)}.tmp")
    try:
        with temporary.open("x+b") as file:
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
    _sync_folder(path.parent)


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
            f"cannot make the folder {folder}: {error.strerror or error}; "
            "choose another place with -o"
        ) from error


def commit(data: bytes, path: str | os.PathLike[str]) -> Path:
    """Publish ``data`` as the file ``path``, see :func:`publish`.

    Raises
    ------
    StoreError
        If the system refuses (no such folder, no permission, disk full); what stood
        under ``path`` before is still there.
    """
    target = Path(path)
    with refusals_named(target):
        publish(lambda file: file.write(data), target)
    return target


@contextlib.contextmanager
def refusals_named(target: Path) -> Iterator[None]:
    """Turn a refusal of the system into a :class:`StoreError` that names the file."""
    try:
        yield
    except OSError as error:
        raise StoreError(
            f"cannot write {target}: {error.strerror or error}; "
            "choose another place with -o, or make room and permission there"
        ) from error


def remove_leftovers(path: Path) -> None:
    """Remove what a killed process left of a file that it was about to publish.

    Only for whom no other process can be publishing the same file.
    """
    with contextlib.suppress(OSError):
        for leftover in path.parent.glob(f".{glob.escape(path.name)}.[0-9]*.[0-9]*.tmp"):
            leftover.unlink()


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse an output path before hours of work rather than after them.

    Raises
    ------
    StoreError
        If ``path`` is a folder, or its folder is missing or not writable.
    """
    target = Path(path)
    if target.is_dir():
        raise StoreError(f"cannot write {target}: it is a folder; give a file name in it")
    if not target.parent.is_dir():
        raise StoreError(
            f"cannot write {target}: no such folder {target.parent}; create it first"
        )
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise StoreError(
            f"cannot write {target}: no permission in {target.parent}; choose another place"
        )


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
