"""Tasks on the cores of this machine: one after the other here, or several in processes.

Workers are spawned, not forked: they start without the threads and locks of this
process. They leave Ctrl-C to this process, and end when it does, however it ends: each
watches a pipe that only this process holds open.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from multiprocessing.connection import Connection

from roughbench.errors import RoughbenchError
from roughbench.runner.compute import Block, compute
from roughbench.runner.plan import Task

Finished = Callable[[Task], None]
"""Called with the task, or the part of it, that has just been computed."""


def compute_all(
    tasks: Sequence[Task], *, jobs: int, threads: int, finished: Finished
) -> list[Block]:
    """Return the blocks of all tasks, in their order.

    Parameters
    ----------
    tasks : sequence of Task
    jobs : int
        Tasks at once; 1 computes in this process.
    threads : int
        Threads of each task.
    finished : callable
        Told in this process what has been computed; in-process after each realization,
        else after each task.

    Returns
    -------
    list of dict

    Raises
    ------
    SolverError
        From the first task that fails; the others are given up.
    RoughbenchError
        If a worker process dies.
    """
    if jobs == 1:
        return [_compute_here(task, threads, finished) for task in tasks]
    return _compute_in_workers(tasks, jobs, threads, finished)


def _compute_here(task: Task, threads: int, finished: Finished) -> Block:
    def report(realization: int) -> None:
        finished(Task(task.cell, range(realization, realization + 1)))

    return compute(task, threads, report)


def _compute_in_workers(
    tasks: Sequence[Task], jobs: int, threads: int, finished: Finished
) -> list[Block]:
    blocks: dict[int, Block] = {}
    with _workers(jobs) as pool:
        with _interrupts_held_back():
            futures = {pool.submit(compute, task, threads): i for i, task in enumerate(tasks)}
        try:
            for future in as_completed(futures):
                index = futures[future]
                blocks[index] = future.result()
                finished(tasks[index])
        except BrokenProcessPool as error:
            raise RoughbenchError(
                "a worker process died (out of memory, or killed); take fewer jobs (-j) or "
                "smaller grids. A script that calls run with jobs > 1 needs the guard "
                "if __name__ == '__main__'"
            ) from error
    return [blocks[index] for index in range(len(tasks))]


@contextlib.contextmanager
def _workers(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Start a pool; leaving it with an exception ends the workers at once."""
    context = get_context("spawn")
    watched, alive = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(jobs, context, initializer=_enter_worker, initargs=(watched,))
    try:
        yield pool
        pool.shutdown()
    finally:
        alive.close()
        pool.shutdown(cancel_futures=True)
        watched.close()


def _enter_worker(watched: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(watched,), daemon=True).start()


def _end_with_parent(watched: Connection) -> None:
    """Wait for the end of the pipe, which comes when the parent closes it or is gone."""
    with contextlib.suppress(EOFError, OSError):
        watched.recv_bytes()
    os._exit(1)


@contextlib.contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Hold SIGINT back while workers start: they inherit that, and so never see it.

    One that comes meanwhile is delivered here afterwards.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
