"""Tasks on the cores of this machine: one after the other here, or several in processes."""

from __future__ import annotations

import pickle
from collections.abc import Sequence

from roughbench.engines.base import CheckpointOf, TaskListener, TaskOutcome, carry_out
from roughbench.engines.worker_pool import ATTEMPTS, WorkerPool, worker_pool
from roughbench.errors import RoughbenchError
from roughbench.planning.resources import ResourceLimits, memory_of
from roughbench.planning.tasks import Task


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
    with worker_pool(tasks) as pool:
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
