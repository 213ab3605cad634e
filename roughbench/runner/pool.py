"""Tasks on the cores of this machine: one after the other here, or several in processes.

Workers are spawned, not forked: they start without the threads and locks of this
process. They leave Ctrl-C to this process, and end when it does, however it ends: each
watches a pipe that only this process holds open.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import Empty, SimpleQueue
from typing import Any

from roughbench.errors import RoughbenchError
from roughbench.runner.compute import Block, compute
from roughbench.runner.plan import Task

Advanced = Callable[[Task, int], None]
"""Called with a task and how many of its states are done, whenever there are more."""

SECONDS_BETWEEN_LOOKS = 0.2


def compute_all(
    tasks: Sequence[Task], *, jobs: int, threads: int, advanced: Advanced
) -> list[Block]:
    """Return the blocks of all tasks, in their order.

    Parameters
    ----------
    tasks : sequence of Task
    jobs : int
        Tasks at once; 1 computes in this process.
    threads : int
        Threads of each task.
    advanced : callable
        Told in this process what has been computed.

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
        return [_compute_here(task, threads, advanced) for task in tasks]
    return _compute_in_workers(tasks, jobs, threads, advanced)


def _compute_here(task: Task, threads: int, advanced: Advanced) -> Block:
    return compute(task, threads, lambda done: advanced(task, done))


def _compute_in_workers(
    tasks: Sequence[Task], jobs: int, threads: int, advanced: Advanced
) -> list[Block]:
    blocks: dict[int, Block] = {}
    known = [0] * len(tasks)
    with _workers(jobs, len(tasks)) as (pool, done):

        def look() -> None:
            for index, count in enumerate(done):
                if count > known[index]:
                    advanced(tasks[index], count)
                    known[index] = count

        with _interrupts_held_back():
            futures = {
                pool.submit(_compute_in_worker, i, task, threads): i
                for i, task in enumerate(tasks)
            }
            ended: SimpleQueue[Future[Block]] = SimpleQueue()
            for future in futures:
                future.add_done_callback(ended.put)
        try:
            while len(blocks) < len(tasks):
                # Not concurrent.futures.wait: an interrupt while it takes the locks of
                # all futures leaves them locked, and the pool would never shut down.
                with contextlib.suppress(Empty):
                    future = ended.get(timeout=SECONDS_BETWEEN_LOOKS)
                    blocks[futures[future]] = future.result()
                look()
        except BrokenProcessPool as error:
            raise RoughbenchError(
                "a worker process died (out of memory, or killed); take fewer jobs (-j) or "
                "smaller grids. A script that calls run with jobs > 1 needs the guard "
                "if __name__ == '__main__'"
            ) from error
    return [blocks[index] for index in range(len(tasks))]


@contextlib.contextmanager
def _workers(
    jobs: int, n_tasks: int
) -> Iterator[tuple[ProcessPoolExecutor, ctypes.Array[Any]]]:
    """Start a pool; leaving it with an exception ends the workers at once.

    Yields the pool, and the number of states done of each task. The worker of a task alone
    writes its number, without a lock that it could take to its grave.
    """
    context = get_context("spawn")
    watched, alive = context.Pipe(duplex=False)
    done: ctypes.Array[Any] = context.RawArray("q", n_tasks)
    pool = ProcessPoolExecutor(
        jobs, context, initializer=_enter_worker, initargs=(watched, done)
    )
    try:
        yield pool, done
        pool.shutdown()
    finally:
        alive.close()
        pool.shutdown(cancel_futures=True)
        watched.close()


def _enter_worker(watched: Connection, done: ctypes.Array[Any]) -> None:
    global _done
    _done = done
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, args=(watched,), daemon=True).start()


_done: ctypes.Array[Any] | None = None
"""In a worker: the number of states done of each task."""


def _compute_in_worker(index: int, task: Task, threads: int) -> Block:
    def solved(done: int) -> None:
        if _done is not None:
            _done[index] = done

    return compute(task, threads, solved)


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
