"""One task in this process."""

from __future__ import annotations

import ctypes
import signal
from typing import Any

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from roughbench.engines import compute
from roughbench.planning.plan import plan
from roughbench.planning.samples import make_sample
from roughbench.planning.tasks import Task
from roughbench.spec import load_spec


@pytest.fixture
def task(small_spec: dict[str, Any]) -> Task:
    """Return a task of the foundation."""
    cell = plan(load_spec(small_spec))[0]
    return Task(cell, range(2), cell.pressures, 1)


def test_ctrl_c_is_not_lost_while_libraries_are_looked_for(
    monkeypatch: pytest.MonkeyPatch, task: Task
) -> None:
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))

    def limits(*arguments: Any) -> threadpool_limits:
        callback()  # as the loader calls back for every library
        return threadpool_limits(*arguments)

    monkeypatch.setattr(compute, "threadpool_limits", limits)
    with pytest.raises(KeyboardInterrupt):
        compute.compute(task)


def test_blas_has_one_thread_for_the_time_of_a_task(
    monkeypatch: pytest.MonkeyPatch, task: Task
) -> None:
    def threads() -> set[int]:
        return {lib["num_threads"] for lib in threadpool_info() if lib["user_api"] == "blas"}

    compute.compute(task)  # loads whatever it needs
    seen = []
    before = threads()

    def spy(*arguments: Any) -> Any:
        seen.append(threads())
        return make_sample(*arguments)

    monkeypatch.setattr(compute, "make_sample", spy)
    compute.compute(task)
    assert seen == [{1}, {1}]
    assert threads() == before
