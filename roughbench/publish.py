"""Files that appear under their name in one step: whole, or not at all."""

from __future__ import annotations

import contextlib
import itertools
import os
from pathlib import Path

from roughbench.errors import StoreError

_counter = itertools.count()


def commit(data: bytes, path: str | os.PathLike[str]) -> Path:
    """Publish ``data`` as the file ``path``, in one step that survives a power cut.

    Raises
    ------
    StoreError
        If the system refuses (no such folder, no permission, disk full); what stood
        under ``path`` before is still there.
    """
    target = Path(path)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.{next(_counter)}.tmp")
    try:
        try:
            with temporary.open("xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(target)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
        _sync_folder(target.parent)
    except OSError as error:
        raise StoreError(
            f"cannot write {target}: {error.strerror or error}; "
            "choose another place with -o, or make room and permission there"
        ) from error
    return target


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
