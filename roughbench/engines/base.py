"""What every engine does with tasks: compute them, anywhere, and say how it went."""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from roughbench.engines.compute import compute
from roughbench.errors import RoughbenchError
from roughbench.models.compilation import compiling_told
from roughbench.planning.tasks import Block, Task
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.usage import Meter, Usage
from roughbench.source_files import blamed


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """How a task ended: with a block and what it took, or with an error and its traceback."""

    block: Block | None = None
    usage: Usage | None = None
    error: Exception | None = None
    trace: str = ""

    def portable(self) -> TaskOutcome:
        """Return it in a form that can go to another process."""
        try:
            pickle.loads(pickle.dumps(self.error))  # noqa: S301  (its own)
        except Exception:  # noqa: BLE001, RUF100  (whatever a foreign exception does)
            return TaskOutcome(error=RoughbenchError(repr(self.error)), trace=self.trace)
        return self


class TaskListener(Protocol):
    """What an engine calls, in the thread and process that started it."""

    def on_progress(self, task: Task, done: int) -> None:
        """So many states of a running task are done."""

    def on_compiling(self) -> None:
        """Loops are being compiled, once for all runs: it takes a while."""

    def on_end(self, task: Task, outcome: TaskOutcome) -> None:
        """Take the outcome of a task; what is raised here ends the engine."""

    def on_message(self, text: str) -> None:
        """Something happened that belongs into the log, such as the death of a worker."""


CheckpointOf = Callable[[Task], Checkpoint | None]
"""Where the finished states of a task are kept; None for nowhere."""


def carry_out(
    task: Task,
    checkpoint: Checkpoint | None,
    advanced: Callable[[int], None],
    compiling: Callable[[], None],
) -> TaskOutcome:
    """Compute a task in this process; says how many states are done, and when it compiles."""
    meter = Meter()
    of_listener: list[Exception] = []

    def report(done: int) -> None:
        try:
            advanced(done)
        except Exception as error:
            of_listener.append(error)
            raise

    try:
        with compiling_told(compiling):
            return TaskOutcome(compute(task, report, checkpoint), meter.read())
    except Exception as error:  # noqa: BLE001, RUF100  (whatever it is, it is this task's end)
        trace = "".join(traceback.format_exception(error))
        if error not in of_listener:
            error = blamed(task.cell.model, error, str(task))
        return TaskOutcome(error=error, trace=trace)
