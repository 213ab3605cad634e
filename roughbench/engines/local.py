"""Tasks on the cores of this machine: one after the other here, or several in processes.

Workers are spawned, not forked: they start without the threads and locks of this
process. Each has a pipe of its own and shares no lock with anyone, so that one that is
killed takes nothing with it but its task, which is tried again. They leave signals to
this process, and end when it does, however it ends: each watches a pipe that only this
process holds open.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import current_process, get_context, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from roughbench.engines.base import CheckpointOf, TaskListener, TaskOutcome, carry_out
from roughbench.errors import RoughbenchError
from roughbench.planning.resources import ResourceLimits, memory_of
from roughbench.planning.tasks import Task
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.signals import SIGNALS, signals_held_back

ATTEMPTS = 3
"""How often a task is given to a worker before its death is taken for the task's fault."""

_WORKER = "roughbench worker"
_NO_GUARD = 88
"""Exit code of a worker that was message to run what had started it."""
_NEEDS_GUARD = (
    "worker processes import the script that calls run, and it calls run again there; put the "
    "call under the guard if __name__ == '__main__', or say jobs=1"
)


def refuse_in_a_new_worker() -> None:
    """End this process at once if it is a worker that imports the script of its parent.

    A worker imports the main script to find what is defined there. If that calls ``run``
    outside of a guard, each worker would start workers of its own; the parent says so.
    """
    if current_process().name == _WORKER and not _at_work:
        os._exit(_NO_GUARD)


def compute_here(
    tasks: Sequence[Task], *, checkpoint_of: CheckpointOf, listener: TaskListener
) -> None:
    """Compute tasks one after the other in this process."""
    for task in tasks:

        def advanced(done: int, task: Task = task) -> None:
            listener.on_progress(task, done)

        outcome = carry_out(task, checkpoint_of(task), advanced, listener.on_compiling)
        listener.on_end(task, outcome)


def compute_in_workers(
    tasks: Sequence[Task],
    *,
    processes: int,
    limits: ResourceLimits,
    checkpoint_of: CheckpointOf,
    listener: TaskListener,
) -> None:
    """Compute tasks in worker processes, the longest first.

    A task starts when there are a worker, cores and, by estimate, memory for it. If its
    worker dies, it is tried again, alone if the worker was killed (most likely for its
    memory), and given up after three attempts.

    Raises
    ------
    RoughbenchError
        If no worker can be started at all.
    """
    waiting = sorted(tasks, key=lambda task: -task.work * task.n_states)
    attempts: dict[Task, int] = {}
    alone: set[Task] = set()
    with _worker_pool() as pool:
        free = True  # whether something may have become free since the last look
        while waiting or pool.busy:
            for next_one in list(waiting) if free else ():
                if len(pool.busy) == processes:
                    break
                if _fits(next_one, pool, limits, alone):
                    waiting.remove(next_one)
                    attempts[next_one] = attempts.get(next_one, 0) + 1
                    pool.assign(next_one, checkpoint_of(next_one))
            free = False
            for worker in pool.ready_workers():
                task = worker.task
                try:
                    kind, content = worker.pipe.recv()
                except (EOFError, OSError, pickle.UnpicklingError):
                    death = pool.remove_dead(worker)
                    free = True
                    if task is not None and attempts[task] < ATTEMPTS:
                        listener.on_message(f"{task}: its worker {death}; trying again")
                        listener.on_progress(task, 0)
                        waiting.insert(0, task)
                        alone.add(task)
                    elif task is not None:
                        listener.on_end(task, TaskOutcome(error=_given_up(task, death)))
                    continue
                if kind == "advanced" and task is not None:
                    listener.on_progress(task, content)
                elif kind == "compiling":
                    listener.on_compiling()
                elif kind == "ended" and task is not None:
                    worker.task = None
                    free = True
                    listener.on_end(task, content)


def _fits(task: Task, pool: WorkerPool, limits: ResourceLimits, alone: set[Task]) -> bool:
    running = [worker.task for worker in pool.workers if worker.task is not None]
    if not running:
        return True
    if task in alone or not alone.isdisjoint(running):
        return False
    if task.threads + sum(other.threads for other in running) > limits.most_threads:
        return False
    return memory_of(task) + sum(memory_of(other) for other in running) <= limits.memory


def _given_up(task: Task, death: str) -> RoughbenchError:
    return RoughbenchError(
        f"{task}: its worker {death}, {ATTEMPTS} times; it was given up. It needs about "
        f"{memory_of(task) / 1e9:.1f} GB by estimate: if memory ran out, take a smaller grid "
        "or a larger machine"
    )


# -- workers, from outside ---------------------------------------------------------------


@dataclass(slots=True, eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    task: Task | None = None
    ready: bool = False


class WorkerPool:
    """Workers, started when there is something to do for them."""

    def __init__(self) -> None:
        self.workers: list[_Worker] = []
        self._context = get_context("spawn")
        resource_tracker.ensure_running()  # it would let signals through while workers start
        self._watched, self._alive = self._context.Pipe(duplex=False)
        self._one_was_ready = False

    @property
    def busy(self) -> list[_Worker]:
        """Workers with a task."""
        return [worker for worker in self.workers if worker.task is not None]

    def assign(self, task: Task, checkpoint: Checkpoint | None) -> None:
        """Have an idle worker compute a task, or a new one."""
        idle = [worker for worker in self.workers if worker.task is None]
        worker = idle[0] if idle else self._start_worker()
        worker.task = task
        with contextlib.suppress(OSError):  # dead: noticed when it is listened to
            worker.pipe.send((task, checkpoint))

    def _start_worker(self) -> _Worker:
        for _ in range(ATTEMPTS):
            pipe, theirs = self._context.Pipe()
            process = self._context.Process(
                target=_work, name=_WORKER, args=(theirs, self._watched), daemon=True
            )
            with signals_held_back(), contextlib.suppress(BrokenPipeError):  # dead already
                process.start()
                worker = _Worker(process, pipe)
                self.workers.append(worker)
                theirs.close()
                return worker
        raise RoughbenchError("worker processes die before they start; see the system's log")

    def ready_workers(self) -> Iterator[_Worker]:
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

    def remove_dead(self, worker: _Worker) -> str:
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


@contextlib.contextmanager
def _worker_pool() -> Iterator[WorkerPool]:
    pool = WorkerPool()
    try:
        yield pool
    finally:
        with signals_held_back():
            pool.close()


# -- workers, from inside ----------------------------------------------------------------


_at_work = False


def _work(pipe: Connection, watched: Connection) -> None:
    global _at_work
    _at_work = True
    for number in SIGNALS:
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
