"""The log of a run, in its run directory and wherever else it is wanted."""

from __future__ import annotations

import contextlib
import logging
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from roughbench.errors import StoreError, explained
from roughbench.models.base import Status
from roughbench.outputs import Kind
from roughbench.planning.tasks import Block, Task
from roughbench.rundir.usage import Usage

log = logging.getLogger("roughbench.run")
"""INFO: a line per task. DEBUG: a line per state."""

_FORMAT = "%(asctime)s %(levelname)s %(message)s"
_LINE = re.compile(rb"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3} [A-Z]+ ")

LOG = Kind("log", lambda head, _: _LINE.match(head) is not None)
"""What a log may be appended to."""
_CERTIFICATE = ("complementarity", "penetration", "load_error", "iterations", "transform_pairs")


class _File(logging.FileHandler):
    """A log file; a full disk does not end the run that it is the log of."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802
        """Lose the record."""
        del record


@contextlib.contextmanager
def logged_to(paths: Sequence[Path]) -> Iterator[None]:
    """Append the log to files.

    Raises
    ------
    StoreError
        If one of them cannot be opened.
    """
    handlers: list[_File] = []
    try:
        for path in paths:
            try:
                handlers.append(_File(path, encoding="utf-8"))
            except OSError as error:
                raise StoreError(
                    f"cannot write the log {path}: "
                    f"{explained(error, 'choose another --log-file')}"
                ) from error
        for handler in handlers:
            handler.setFormatter(logging.Formatter(_FORMAT))
            handler.setLevel(logging.DEBUG)
            log.addHandler(handler)
        if handlers:
            log.setLevel(logging.DEBUG)
        yield
    finally:
        for handler in handlers:
            log.removeHandler(handler)
            with contextlib.suppress(OSError):
                handler.close()


def log_task(task: Task, block: Block, usage: Usage) -> None:
    """Log a finished task, and each of its states."""
    unconverged = int(np.count_nonzero(block["status"]))
    lost = f", {unconverged} states not converged" if unconverged else ""
    log.info(
        "%s: done in %.1f s (%.1f s of cores), peak memory %.2f GB, %s%s",
        task,
        usage.seconds,
        usage.cpu_seconds,
        usage.peak_memory / 1e9,
        usage.machine.get("host", ""),
        lost,
    )
    if not log.isEnabledFor(logging.DEBUG) or "iterations" not in block:
        return
    names = [name for name in _CERTIFICATE if name in block]
    for row, realization in enumerate(task.realizations):
        for column, pressure in enumerate(task.pressures):
            numbers = ", ".join(f"{name} {block[name][row, column]:.3g}" for name in names)
            log.debug(
                "%s, p/E* = %.6g: %s, %s",
                task.only(realization),
                pressure,
                Status(int(block["status"][row, column])).name.lower().replace("_", " "),
                numbers,
            )
