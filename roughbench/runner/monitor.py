"""What happens while a run computes: finished tasks are kept, logged and counted."""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Callable, Iterator, Sequence

from roughbench.engines.base import TaskOutcome
from roughbench.errors import IncompleteError, RoughbenchError, StoreError
from roughbench.planning.cells import Cell
from roughbench.planning.tasks import Task
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import log, log_task
from roughbench.runner.progress import COMPILING, Progress, ProgressListener
from roughbench.runner.scan import CellState
from roughbench.runner.selection import label_of
from roughbench.runner.speed import Speeds


class RunMonitor:
    """Keeps finished tasks, logs them, counts them, and says how a run that stopped goes on."""

    def __init__(self, folder: RunFolder | None, command: str) -> None:
        self._folder = folder
        self._command = command
        self._cell_states: dict[tuple[str, str], CellState] = {}
        self._tasks: Sequence[Task] = ()
        self._failed: dict[Task, TaskOutcome] = {}
        self._keep_going = False
        self._count: Callable[[Task | None, int], None] = lambda _task, _done: None

    def open(
        self,
        cell_states: Sequence[CellState],
        tasks: Sequence[Task],
        progress: ProgressListener | None,
        *,
        keep_going: bool,
        of_tasks: bool = False,
    ) -> None:
        """Begin, with what there is of each cell and the tasks that are to be computed.

        Progress counts all states, or those ``of_tasks`` alone.
        """
        self._cell_states = {_place(cell_state.cell): cell_state for cell_state in cell_states}
        self._tasks = tasks
        self._keep_going = keep_going
        self._count = _counter(cell_states, progress, tasks if of_tasks else None)

    def checkpoint(self, task: Task) -> Checkpoint | None:
        """Return where the finished states of a task are kept, if anywhere."""
        if self._folder is None or len(task.realizations) > 1:
            return None
        return self._folder.checkpoint(task, self._cell_states[_place(task.cell)].key)

    def on_progress(self, task: Task, done: int) -> None:
        """Count the finished states of a running task."""
        self._count(task, done)

    def on_compiling(self) -> None:
        """Show that loops are being compiled."""
        self._count(None, 0)

    def on_message(self, text: str) -> None:
        """Log what an engine reports."""
        log.warning(text)

    def on_end(self, task: Task, outcome: TaskOutcome) -> None:
        """Keep the block of a task that was computed, or note its failure."""
        if outcome.block is None or outcome.usage is None:
            self._failed[task] = outcome
            log.info("failed: %s", outcome.error)
            log.debug("%s", outcome.trace)
            if not self._keep_going:
                self._raise(task, outcome)
            return
        cell_state = self._cell_states[_place(task.cell)]
        if self._folder is None:
            cell_state.add_block(task, outcome.block, outcome.usage.as_dict())
        else:
            try:
                shard = self._folder.write(
                    task, outcome.block, cell_state.identity, outcome.usage
                )
            except StoreError as error:
                raise IncompleteError(f"{error}; {task} is lost") from error
            checkpoint = self.checkpoint(task)
            if checkpoint is not None:
                checkpoint.remove()
            cell_state.add(shard)
        log_task(task, outcome.block, outcome.usage)
        self._count(task, task.n_states)

    def finish(self) -> None:
        """Raise unless everything is there.

        Raises
        ------
        RoughbenchError
            If tasks failed.
        IncompleteError
            If tasks were left out.
        """
        self.check_failures()
        if not all(cell_state.coverage.complete for cell_state in self._cell_states.values()):
            raise IncompleteError("the results file is not written yet: not all is computed")

    def check_failures(self) -> None:
        """Raise if tasks failed.

        Raises
        ------
        RoughbenchError
        """
        if len(self._failed) == 1:
            self._raise(*next(iter(self._failed.items())))
        if self._failed:
            lines = [f"{len(self._failed)} tasks failed:"]
            for task, outcome in self._failed.items():
                lines += [str(outcome.error), *self._rerun(task)]
            raise RoughbenchError("\n".join(lines))

    def _raise(self, task: Task, outcome: TaskOutcome) -> None:
        error = outcome.error or RoughbenchError(f"{task}: ended without a result")
        for line in self._rerun(task):
            error.add_note(line)
        if isinstance(error, RoughbenchError):
            raise error
        raise error from RemoteTraceback(outcome.trace)

    def _rerun(self, task: Task) -> list[str]:
        if not self._command:
            return []
        name = shlex.quote(label_of(task))
        options = f"--only {name} -j 1 --threads {task.threads}"
        return [f"rerun it alone: {self._command} {options}"]

    def kept(self) -> str:
        """Say what an end at this moment leaves, and how to go on."""
        known = sum(cell_state.n_known for cell_state in self._cell_states.values())
        total = sum(cell_state.cell.n_states for cell_state in self._cell_states.values())
        if self._folder is None or total == 0:
            return ""
        for task in self._tasks:  # those that are finished have none any more
            checkpoint = self.checkpoint(task)
            known += checkpoint.done() if checkpoint is not None else 0
        if known == 0 or not self._folder.path.is_dir():
            return f"run it again: {self._command}" if self._command else ""
        text = f"{known} of {total} states are kept in {self._folder.path}"
        return text + (f"; resume: {self._command}" if self._command else "")


class RemoteTraceback(Exception):  # noqa: N818
    """The traceback of an error in another process."""


def _place(cell: Cell) -> tuple[str, str]:
    return cell.experiment, cell.model.name


@contextlib.contextmanager
def monitored(folder: RunFolder | None, command: str) -> Iterator[RunMonitor]:
    """Yield the monitor of a run; an end before its end says what is kept."""
    monitor = RunMonitor(folder, command)
    log.info("run: %s", command or "a Python script")
    try:
        try:
            yield monitor
        except StoreError as error:
            raise IncompleteError(str(error)) from error
    except BaseException as error:
        kept = monitor.kept()
        if isinstance(error, KeyboardInterrupt | RoughbenchError | MemoryError) and kept:
            error.add_note(kept)
        log.debug("ended by %s: %s; %s", type(error).__name__, error, kept)
        raise


def _counter(
    cell_states: Sequence[CellState],
    progress: ProgressListener | None,
    tasks: Sequence[Task] | None = None,
) -> Callable[[Task | None, int], None]:
    """Return a callable that adds up finished states and tells ``progress``.

    Without a task it tells that loops are compiled. Of ``tasks``, where they are given: then
    what is there already does not count.
    """
    speeds = Speeds()
    works = {
        _place(cell_state.cell): speeds.slowness(cell_state.cell.model)
        * cell_state.cell.work
        / len(cell_state.cell.pressures)
        for cell_state in cell_states
    }
    wanted = [(s.cell, s.cell.n_states, s.n_known) for s in cell_states]
    if tasks is not None:
        wanted = [(task.cell, task.n_states, 0) for task in tasks]
    total = sum(states for _, states, _ in wanted)
    all_work = sum(works[_place(cell)] * states for cell, states, _ in wanted)
    done = sum(known for _, _, known in wanted)
    work = sum(works[_place(cell)] * known for cell, _, known in wanted)
    done_of: dict[Task, int] = {}
    if progress is not None:
        share = 1.0 if done == total else work / all_work
        progress(Progress(done, total, share, "starting"))

    def advanced(task: Task | None, done_here: int) -> None:
        nonlocal done, work
        if task is None:
            if progress is not None:
                progress(Progress(done, total, min(1.0, work / all_work), COMPILING))
            return
        n_states = done_here - done_of.get(task, 0)
        done_of[task] = done_here
        done += n_states
        work += n_states * works[_place(task.cell)]
        share = 1.0 if done == total else min(1.0, work / all_work)
        if progress is not None and n_states:
            progress(Progress(done, total, share, task.place(max(1, done_here))))

    return advanced
