"""Locks on files: between processes that would do the same work, or write the same files.

A lock ends with its process, however that ends. Some file systems know none.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path

import filelock

from roughbench.system import open_for_lock, touch

_PAUSE = 0.05


def open_lock(path: Path) -> int:
    """Return a descriptor of a lock file, made where there is none.

    Never opened through a symbolic link, and nothing in it is touched.

    Raises
    ------
    OSError
        If the system refuses.
    """
    return open_for_lock(path)


def try_lock(descriptor: int) -> bool | None:
    """Take a lock if it is free.

    Returns
    -------
    bool or None
        Whether it is held now; None where the file system knows no locks.
    """
    try:
        return filelock.lock_descriptor(descriptor, blocking=False)
    except OSError:
        return None


def show_life(descriptor: int) -> None:
    """Tell those who wait for a lock that work is going on: a new time stamp of its file."""
    with contextlib.suppress(OSError):
        touch(descriptor)


def wait_for_lock(
    descriptor: int, patience: float, silence: float, tell: Callable[[], None]
) -> bool | None:
    """Wait for a lock, as :func:`try_lock`, and call ``tell`` after ``silence`` seconds of it.

    Returns
    -------
    bool or None
        False if somebody else holds it and has shown no life for ``patience`` seconds.
    """
    start = alive = time.monotonic()
    stamp = os.fstat(descriptor).st_mtime_ns
    announced = False
    while (held := try_lock(descriptor)) is False:
        before, stamp = stamp, os.fstat(descriptor).st_mtime_ns
        now = time.monotonic()
        alive = now if stamp != before else alive
        if now - alive >= patience:
            break
        if now - start >= silence and not announced:
            announced = True
            tell()
        time.sleep(_PAUSE)
    return held
