"""Worker processes on this machine, each with a pipe of its own.

They are spawned, not forked: they start without the threads and locks of this process. They
share no lock with anyone, so that one that is killed takes nothing with it but its task, which
is tried again. They leave signals to this process, and end when it does, however it ends: each
watches a pipe that only this process holds open. They import the script that calls ``run`` only
where a task holds something that is defined there: a script may have other things to do, or be
none that can be read again (``python < script.py``).
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import current_process, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any

from roughbench.engines.base import carry_out
from roughbench.errors import RoughbenchError
from roughbench.planning.tasks import Task
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.signals import signals_held_back
from roughbench.system import ENDING_SIGNALS, start_resource_tracker

ATTEMPTS = 3
"""How often a task is given to a worker before its death is taken for the task's fault."""
_WORKER = "roughbench worker"
_NO_GUARD = 88
"""Exit code of a worker that was told to run what had started it."""
_NEEDS_GUARD = (
    "worker processes import the script that calls run, for what it defines, and it calls run "
    "again there; put the call under the guard if __name__ == '__main__', or say jobs=1"
)


def refuse_in_a_new_worker() -> None:
    """End this process at once if it is a worker that imports the script of its parent.

    A worker imports the main script to find what its tasks need of it. If that calls ``run``
    outside of a guard, each worker would start workers of its own; the parent says so.
    """
    if current_process().name == _WORKER and not _at_work:
        os._exit(_NO_GUARD)


@dataclass(slots=True, eq=False)
class Worker:
    """A process, the pipe to it, and what it computes."""

    process: BaseProcess
    pipe: Connection
    task: Task | None = None
    ready: bool = False


class WorkerPool:
    """Workers, started when there is something to do for them.

    Parameters
    ----------
    with_script : bool
        Whether they import the main script, and find what it defines.
    """

    def __init__(self, *, with_script: bool = True) -> None:
        self.workers: list[Worker] = []
        self._started = contextlib.nullcontext if with_script else _without_script
        self._context = get_context("spawn")
        start_resource_tracker()  # it would let signals through while workers start
        self._watched, self._alive = self._context.Pipe(duplex=False)
        self._one_was_ready = False

    @property
    def busy(self) -> list[Worker]:
        """Workers with a task."""
        return [worker for worker in self.workers if worker.task is not None]

    def assign(self, task: Task, checkpoint: Checkpoint | None) -> None:
        """Have an idle worker compute a task, or a new one."""
        idle = [worker for worker in self.workers if worker.task is None]
        worker = idle[0] if idle else self._start_worker()
        worker.task = task
        with contextlib.suppress(OSError):  # dead: noticed when it is listened to
            worker.pipe.send((task, checkpoint))

    def _start_worker(self) -> Worker:
        for _ in range(ATTEMPTS):
            pipe, theirs = self._context.Pipe()
            process = self._context.Process(
                target=_work, name=_WORKER, args=(theirs, self._watched), daemon=True
            )
            # It may be dead already.
            with signals_held_back(), self._started(), contextlib.suppress(BrokenPipeError):
                process.start()
                worker = Worker(process, pipe)
                self.workers.append(worker)
                theirs.close()
                return worker
        raise RoughbenchError("worker processes die before they start; see the system's log")

    def ready_workers(self) -> Iterator[Worker]:
        """Yield the workers that have something to say, or are dead; waits for one."""
        by_pipe = {worker.pipe: worker for worker in self.workers}
        for pipe in wait(list(by_pipe)):
            worker = by_pipe[pipe]  # type: ignore[index]
            if not worker.ready and worker.pipe.poll():
                with contextlib.suppress(EOFError, OSError):
                    worker.pipe.recv()
                    worker.ready = self._one_was_ready = True
                    continue
            yield worker

    def remove_dead(self, worker: Worker) -> str:
        """Take a dead worker out; returns how it died."""
        self.workers.remove(worker)
        worker.process.kill()  # if it only closed its pipe
        worker.process.join()
        worker.pipe.close()
        code = worker.process.exitcode or 0
        if code == _NO_GUARD and not worker.ready:
            raise RoughbenchError(_NEEDS_GUARD) from None
        if code >= 0 and not worker.ready and not self._one_was_ready:
            raise RoughbenchError(
                f"no worker process could be started: it ended with exit code {code} while it "
                "imported the script that calls run, or roughbench; say jobs=1 to do without"
            ) from None
        return f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"

    def close(self) -> None:
        """End all workers at once."""
        self._alive.close()
        for worker in self.workers:
            worker.process.kill()
        for worker in self.workers:
            worker.process.join()
            worker.pipe.close()
        self._watched.close()


def need_script(tasks: Sequence[Task]) -> bool:
    """Whether tasks hold something that the main script defines, as a model of its own."""
    try:
        return b"__main__" in pickle.dumps(
            [*{id(task.cell): task.cell for task in tasks}.values()]
        )
    except (pickle.PicklingError, AttributeError, TypeError):  # the worker's pipe says why
        return True


@contextlib.contextmanager
def _without_script() -> Iterator[None]:
    """Hide the main script from a process that is started, which would import it."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextlib.contextmanager
def worker_pool(tasks: Sequence[Task]) -> Iterator[WorkerPool]:
    """Yield workers for some tasks, that end with the block."""
    pool = WorkerPool(with_script=need_script(tasks))
    try:
        yield pool
    finally:
        with signals_held_back():
            pool.close()


_at_work = False


def _work(pipe: Connection, watched: Connection) -> None:
    global _at_work
    _at_work = True
    for number in ENDING_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(watched,), daemon=True).start()

    def tell(kind: str, content: Any) -> None:
        try:
            pipe.send((kind, content))
        except OSError:  # the parent is gone, and nobody wants to know any more
            os._exit(1)

    tell("ready", None)
    while True:
        try:
            task, checkpoint = pipe.recv()
        except (EOFError, OSError):
            return
        outcome = carry_out(
            task,
            checkpoint,
            lambda done: tell("advanced", done),
            lambda: tell("compiling", None),
        )
        tell("ended", outcome.portable())


def _end_with_parent(watched: Connection) -> None:
    """Wait for the end of the pipe, which comes when the parent closes it or is gone."""
    with contextlib.suppress(EOFError, OSError):
        watched.recv_bytes()
    os._exit(1)
