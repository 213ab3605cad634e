"""The lock of a run directory: one run at a time, and who it is."""

from __future__ import annotations

import contextlib
import json
import os
import platform
import time
from pathlib import Path
from typing import IO, Any

from roughbench.errors import LockedError
from roughbench.locks import open_lock, try_lock
from roughbench.rundir.journal import log
from roughbench.rundir.mark import mark
from roughbench.rundir.usage import now
from roughbench.system import readable_text

LOCK = "lock"
"""Name of the file in a run directory."""
_TRIES, _PAUSE, _GLANCE = 6, 0.1, 0.01


class FolderLock:
    """The lock of a run directory, and what the run that has it says of itself.

    Parameters
    ----------
    folder : Path
        Made, and marked as a run directory, when the lock is taken.
    name : str
        Of the file, in the folder or in one below it.
    """

    def __init__(self, folder: Path, name: str = LOCK) -> None:
        self._folder = folder
        self._path = folder / name

    def take(self, command: str) -> IO[str]:
        """Make the folder and lock it; the lock ends where the file is closed.

        Parameters
        ----------
        command : str
            What the process that has it does, for others.

        Raises
        ------
        LockedError
            If another process has it; says which and where.
        OSError
            If the folder cannot be made or written.
        """
        file = self._opened()
        self._write_holder(file, command)
        return file

    def _opened(self) -> IO[str]:
        self._folder.mkdir(exist_ok=True)
        mark(self._folder)
        path = self._path
        path.parent.mkdir(exist_ok=True)
        for attempt in range(_TRIES):
            time.sleep(_PAUSE * (attempt > 0))
            file = os.fdopen(open_lock(path), "r+", encoding="utf-8")
            try:
                held = try_lock(file.fileno())
                if held is None:
                    log.warning(
                        "the file system of %s knows no locks: a second run with the same "
                        "output would not be kept out; start none while this one works",
                        self._folder,
                    )
                    return file
                # Another process may have removed the folder between open and lock.
                if held and os.fstat(file.fileno()).st_ino == path.stat().st_ino:
                    return file
            except BaseException:
                file.close()
                raise
            file.close()  # of a run, or of someone who only looks who is there
        raise LockedError(self.refusal())

    def _write_holder(self, file: IO[str], command: str) -> None:
        holder = {
            "process": os.getpid(),
            "host": platform.node(),
            "since": now(),
            "command": command,
        }
        file.truncate(0)
        file.write("\n" + json.dumps(holder))  # a lock of Windows covers the first byte
        file.flush()

    def refusal(self) -> str:
        """Say who has the lock, to whom it is refused."""
        holder = self.holder()
        who = "another run"
        if holder:
            who = (
                f"process {holder.get('process')} on {holder.get('host')} since "
                f"{holder.get('since')} ({holder.get('command')})"
            )
        return (
            f"{self._path.parent} is locked by {who}; wait for it or stop it, or choose "
            "another results file with -o"
        )

    def holder(self) -> dict[str, Any]:
        """Return what the run in the folder says of itself; empty for none."""
        with contextlib.suppress(OSError, ValueError), self._path.open("rb") as file:
            for attempt in range(_TRIES):  # who only looks, as here, has it for a moment
                time.sleep(_GLANCE * (attempt > 0))
                if try_lock(file.fileno()) is not False:
                    return {}
            found = json.loads(readable_text(file).strip() or "{}")
            return found if isinstance(found, dict) and found else {"process": "?"}
        return {}
