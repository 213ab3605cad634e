"""FFTW's plans, measured once per machine and kept as its wisdom."""

from __future__ import annotations

import base64
import contextlib
import json
import logging
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from roughbench.locks import open_lock, show_life, wait_for_lock
from roughbench.publish import publish

_log = logging.getLogger("roughbench.run.plans")
_said: set[str] = set()
"""What this process has said already, or given up: once is enough."""

SILENCE = 3.0
"""Seconds that nothing is said; most plans take less than one, one for a line minutes."""
PATIENCE = 30.0
"""Seconds to wait for a process that keeps the plans locked and does not measure any."""


def cache_folder() -> Path:
    """Folder for what is measured once per machine."""
    own = os.environ.get("ROUGHBENCH_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "roughbench"


@contextlib.contextmanager
def kept_wisdom(shape: tuple[int, int]) -> Iterator[None]:
    """Plan with the wisdom of earlier plans, and add what this one learns to it.

    A lock makes processes that start together measure one after the other, so that all of
    them use the first one's plans. Where the file system knows no locks they may measure
    at once, and one's plans are kept. Without a writable cache folder, and where another
    process keeps the lock for too long, the plans are measured all the same, only not kept.
    """
    import pyfftw

    folder = cache_folder()
    path = folder / "fftw-wisdom.json"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = open_lock(folder / "fftw-wisdom.lock")
    except OSError:
        with _planning(shape, None):
            yield
        return
    try:
        mine = _wait_for(lock, folder) is not False
        kept = _read_wisdom(path)
        if kept is not None:
            pyfftw.import_wisdom(kept)
        with _planning(shape, lock if mine else None):
            yield
        learned = pyfftw.export_wisdom()
        if mine and learned != kept:
            text = json.dumps([base64.b64encode(part).decode("ascii") for part in learned])
            with contextlib.suppress(OSError):  # a full disk: they hold for this process
                publish(lambda file: file.write(text.encode()), path)
    finally:
        os.close(lock)  # and with it the lock


def _wait_for(lock: int, folder: Path) -> bool | None:
    """Wait for the lock on the kept plans; only once for one that nobody lets go of."""
    place = str(folder)
    held = wait_for_lock(
        lock,
        0.0 if f"gave up {place}" in _said else PATIENCE,
        SILENCE,
        lambda: _say(
            f"waiting {place}",
            f"waiting for another process that measures FFTW's plans ({folder}); if it does "
            f"not go on, for {PATIENCE:.0f} s",
        ),
    )
    if held is False:
        _say(
            f"gave up {place}",
            f"another process keeps {folder / 'fftw-wisdom.lock'} locked; going on with plans "
            "of this one's own, which are not kept and may change the last digits of results",
        )
    return held


@contextlib.contextmanager
def _planning(shape: tuple[int, int], lock: int | None) -> Iterator[None]:
    """Plan; meanwhile say that it takes long, and show those who wait that it goes on."""
    planned = threading.Event()
    size = " × ".join(str(n) for n in shape if n > 1)

    def watch() -> None:
        while not planned.wait(SILENCE):
            if lock is not None:
                show_life(lock)
            _say(
                "measuring",
                f"measuring FFTW's plans for {size} points, once on this machine; that can "
                "take minutes for long lines",
            )

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        planned.set()
        thread.join()


def _say(what: str, text: str) -> None:
    if what not in _said:
        _said.add(what)
        _log.warning(text)


def _read_wisdom(path: Path) -> tuple[bytes, ...] | None:
    """Kept wisdom, or None where there is none that can be read."""
    try:
        double, single, extended = (
            base64.b64decode(part) for part in json.loads(path.read_text(encoding="ascii"))
        )
    except (OSError, ValueError, TypeError):
        return None
    return double, single, extended
