"""Worker processes: what they bring back, how their death is answered, who may start."""

from __future__ import annotations

import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.engines.base import TaskOutcome
from roughbench.engines.local import compute_here, compute_in_workers
from roughbench.engines.worker_pool import WorkerPool
from roughbench.memory import AvailableMemory
from roughbench.planning import resources
from roughbench.planning.cells import Cell
from roughbench.planning.resources import (
    ResourceLimits,
    check_memory,
    memory_of,
    resource_limits,
)
from roughbench.planning.tasks import Task
from roughbench.signals import signals_held_back
from roughbench.spec import load_spec
from tests.engines.fakes import Fake, Misdeed, StrangeError

PLENTY = ResourceLimits(jobs=2, given_threads=1, memory=2**50, cores=2)


@dataclass
class Spy:
    """Remembers what it is told, with times."""

    ends: dict[Task, TaskOutcome] = field(default_factory=dict)
    news: list[tuple[Task, int]] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    running: int = 0
    most: int = 0
    compiled: bool = False

    def on_progress(self, task: Task, done: int) -> None:
        self.news.append((task, done))

    def on_end(self, task: Task, outcome: TaskOutcome) -> None:
        assert task not in self.ends
        self.ends[task] = outcome

    def on_compiling(self) -> None:
        self.compiled = True

    def on_message(self, text: str) -> None:
        self.texts.append(text)


def tasks(
    small_spec: dict[str, Any], misdeed: Misdeed, n: int = 4, **options: Any
) -> list[Task]:
    spec = load_spec(small_spec)
    model = Fake(misdeed=misdeed, **options)
    cell = Cell("main", model, spec.surface, spec.pressures, n, spec.seed)
    return [Task(cell, range(i, i + 1), spec.pressures) for i in range(n)]


def worked(given: list[Task], limits: ResourceLimits = PLENTY, processes: int = 2) -> Spy:
    spy = Spy()
    compute_in_workers(
        given, processes=processes, limits=limits, checkpoint_of=lambda _: None, listener=spy
    )
    assert set(spy.ends) == set(given)
    return spy


def test_workers_bring_what_is_computed_here(small_spec: dict[str, Any]) -> None:
    given = tasks(small_spec, "none")
    here = Spy()
    compute_here(given, checkpoint_of=lambda _: None, listener=here)
    there = worked(given)
    for task in given:
        one, other = here.ends[task].block, there.ends[task].block
        assert one is not None
        assert other is not None
        assert {name: values.tolist() for name, values in one.items() if name != "energy"} == {
            name: values.tolist() for name, values in other.items() if name != "energy"
        }
        usage = there.ends[task].usage
        assert usage is not None
        assert usage.peak_memory > 10**7
        assert [done for known, done in there.news if known == task][-1] == 3


def test_errors_come_back_with_their_traceback(small_spec: dict[str, Any]) -> None:
    refused = worked(tasks(small_spec, "refuse", 1)).ends.popitem()[1]
    assert str(refused.error) == "main/fake: refused"
    assert isinstance(refused.error, rb.SolverError)
    crashed = worked(tasks(small_spec, "crash", 1)).ends.popitem()[1]
    assert isinstance(crashed.error, rb.ModelError)  # of a model that is not roughbench's
    assert re.fullmatch(
        r"main/fake: fakes\.py:\d+: ZeroDivisionError: a fault of the model", str(crashed.error)
    )
    assert "fakes.py" in crashed.trace
    strange = worked(tasks(small_spec, "strange", 1)).ends.popitem()[1]
    assert "StrangeError: 1 and 2" in str(strange.error)
    foreign = TaskOutcome(error=StrangeError(1, 2)).portable().error
    # Once Dask has been imported, exceptions of any kind can be pickled.
    assert "StrangeError('1 and 2')" in repr(pickle.loads(pickle.dumps(foreign)))  # noqa: S301


def test_the_task_of_a_dead_worker_is_tried_again(
    small_spec: dict[str, Any], tmp_path: Path
) -> None:
    given = tasks(small_spec, "die once", marker=str(tmp_path / "died"))
    spy = worked(given)
    assert all(outcome.block is not None for outcome in spy.ends.values())
    assert len(spy.texts) in (1, 2)  # two may have started before the first one died
    assert spy.texts[0].endswith("its worker was killed by signal 9; trying again")


def test_a_task_that_kills_its_worker_is_given_up_and_the_others_go_on(
    small_spec: dict[str, Any],
) -> None:
    deadly, harmless = tasks(small_spec, "die", 1), tasks(small_spec, "none", 3)
    spy = worked(deadly + harmless)
    assert all(spy.ends[task].block is not None for task in harmless)
    error = spy.ends[deadly[0]].error
    assert isinstance(error, rb.RoughbenchError)
    assert str(error).startswith(
        "main/fake: its worker was killed by signal 9, 3 times; it was given up. It needs ab"
    )
    assert len(spy.texts) == 2


def test_killing_workers_at_random_changes_nothing(small_spec: dict[str, Any]) -> None:
    given = tasks(small_spec, "wait", 12)
    stop = threading.Event()
    victims: list[int] = []

    def kill() -> None:
        me = os.getpid()
        while not stop.wait(0.45):
            for stat in Path("/proc").glob("[0-9]*/stat"):
                try:
                    fields = stat.read_text().rpartition(")")[2].split()
                    command = (stat.parent / "cmdline").read_text()
                except OSError:
                    continue
                if int(fields[1]) == me and "spawn_main" in command and len(victims) < 6:
                    victims.append(int(stat.parent.name))
                    os.kill(victims[-1], signal.SIGKILL)
                    break

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        spy = worked(given)
    finally:
        stop.set()
        thread.join()
    lost = [outcome for outcome in spy.ends.values() if outcome.block is None]
    assert victims
    assert not lost


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_another_thread_takes_waits_too(number: signal.Signals) -> None:
    """Else a worker that is just being started reads half a message: EOFError."""

    class StoppedError(Exception):
        pass

    def handle(_number: int, _frame: object) -> None:
        raise StoppedError

    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)  # blocks no signals
    thread.start()
    before = signal.signal(number, handle)
    waited: list[bool] = []

    def start_a_worker() -> None:
        with signals_held_back():
            os.kill(os.getpid(), number)
            time.sleep(0.2)
            waited.append(True)

    try:
        with pytest.raises(StoppedError):
            start_a_worker()
        assert waited
        assert signal.getsignal(number) is handle
        assert number not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
    finally:
        signal.signal(number, before)
        stop.set()
        thread.join()


def test_a_worker_whose_parent_is_gone_says_nothing() -> None:
    """It ends without a word when it has news for nobody."""
    program = (
        "import os, threading\n"
        "from multiprocessing import Pipe\n"
        "from roughbench.engines import worker_pool\n"
        "ours, theirs = Pipe()\n"
        "watched, alive = Pipe(duplex=False)\n"
        "ours.close()\n"
        "worker_pool._work(theirs, watched)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])},
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")


def test_an_error_of_the_listener_ends_everything_at_once(small_spec: dict[str, Any]) -> None:
    class Full(Spy):
        def on_end(self, task: Task, outcome: TaskOutcome) -> None:
            del task, outcome
            raise rb.StoreError("disk full")

    start = time.monotonic()
    with pytest.raises(rb.StoreError, match="disk full"):
        compute_in_workers(
            tasks(small_spec, "wait", 40),
            processes=2,
            limits=PLENTY,
            checkpoint_of=lambda _: None,
            listener=Full(),
        )
    assert time.monotonic() - start < 10.0


SCRIPT = """\
import roughbench as rb
surface = {'H': 0.7, 'q0': 1.0, 'q1': 32.0, 'slope': 0.1}
models = [{'kind': 'persson'}, {'kind': 'foundation', 'springs': 64}]
spec = {'surface': surface, 'pressures': [0.1], 'models': models}
"""
OWN = """\
from typing import ClassVar, Literal
import numpy as np
class Half(rb.Model):
    needs: ClassVar[str] = 'spectrum'
    title: ClassVar[str] = 'half'
    kind: Literal['half'] = 'half'
    def curve(self, sample, pressures):
        return rb.Curve(pressure=pressures, area=np.full(pressures.size, 0.5))
from roughbench.spec import load_spec
spec = load_spec(spec)
spec = spec.model_copy(update={'models': (*spec.models, Half())})
"""
RUN = "print(len(rb.run(spec, jobs=2)['main']))\n"


def ended(folder: Path, text: str, *, piped: bool = False) -> tuple[int, str, str]:
    """Return how a script ends: its exit code, what it prints, and what it complains of."""
    script = folder / "script.py"
    script.write_text(text)
    done = subprocess.run(
        [sys.executable, *([] if piped else [script])],
        input=text if piped else "",
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])},
        cwd=folder,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("piped", [False, True])
def test_workers_leave_a_script_alone(tmp_path: Path, *, piped: bool) -> None:
    """One without a guard, that can be read or run only once: it was 44 lines and more."""
    once = "open('once', 'x').close()\n"
    assert ended(tmp_path, f"{SCRIPT}{once}{RUN}", piped=piped) == (0, "2\n", "")


def test_a_script_without_a_guard_is_told(tmp_path: Path) -> None:
    """Workers do need the model that it defines."""
    code, printed, said = ended(tmp_path, f"{SCRIPT}{OWN}{RUN}")
    assert (code, printed) == (1, "")
    assert said.count("Traceback") == 1  # that of the script; it was 92 lines
    message = "put the call under the guard if __name__ == '__main__', or say jobs=1"
    assert said.count(message) == 1
    assert len(said.splitlines()) < 20


def test_a_script_with_a_guard_runs(tmp_path: Path) -> None:
    guard = "if __name__ == '__main__':\n    "
    assert ended(tmp_path, f"{SCRIPT}{OWN}{guard}{RUN}") == (0, "3\n", "")


# -- who may start -------------------------------------------------------------------------


def most_at_once(given: list[Task], limits: ResourceLimits, processes: int) -> int:
    """Return the largest number of tasks that were running together."""
    running: set[Task] = set()
    most = 0
    assign, on_end = WorkerPool.assign, Spy.on_end

    class Counting(Spy):
        def on_end(self, task: Task, outcome: TaskOutcome) -> None:
            running.discard(task)
            on_end(self, task, outcome)

    def counted(pool: WorkerPool, task: Task, checkpoint: Any) -> None:
        nonlocal most
        running.add(task)
        most = max(most, len(running))
        assign(pool, task, checkpoint)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(WorkerPool, "assign", counted)
        compute_in_workers(
            given,
            processes=processes,
            limits=limits,
            checkpoint_of=lambda _: None,
            listener=Counting(),
        )
    return most


def test_memory_cores_and_jobs_limit_how_many_run_at_once(small_spec: dict[str, Any]) -> None:
    given = tasks(small_spec, "none", 5)
    room = int(2.5 * memory_of(given[0]))
    assert most_at_once(given, ResourceLimits(None, None, room, cores=4), 3) == 2
    assert most_at_once(given, ResourceLimits(None, None, 1, cores=4), 3) == 1
    wide = [replace(task, threads=2) for task in given]
    assert most_at_once(wide, ResourceLimits(None, None, 2**50, cores=4), 3) == 2
    assert most_at_once(given, ResourceLimits(None, None, 2**50, cores=4), 3) == 3


def bem(grid: int, **options: Any) -> Task:
    surface = {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1}
    models = [{"kind": "bem", "grid": grid, **options}]
    spec = load_spec({"surface": surface, "pressures": [0.1, 0.2], "models": models})
    cell = Cell("main", spec.models[0], spec.surface, spec.pressures, 4, 0)
    return Task(cell, range(1), spec.pressures)


def test_memory_by_estimate() -> None:
    # Measured: 0.62 GB for 2048² points near full contact, 0.26 GB for any small grid.
    assert memory_of(bem(256)) == pytest.approx(0.32e9, rel=0.1)
    assert memory_of(bem(2048)) == pytest.approx(0.6e9, rel=0.2)
    assert memory_of(bem(2048, precision="double")) > memory_of(bem(2048))


def test_a_task_that_can_never_start_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def refusal(task: Task, limits: ResourceLimits) -> str:
        with pytest.raises(rb.RoughbenchError) as caught:
            check_memory([bem(64), task], limits)
        return str(caught.value)

    monkeypatch.setattr(resources, "available_memory", lambda: AvailableMemory(10**9))
    limits = resource_limits()
    assert limits.memory == 8 * 10**8
    check_memory([bem(64), bem(2048)], limits)
    assert re.search(
        r"needs about 1\.2 GB, and all tasks together may take 0\.8 GB, 80% of what there is: "
        r"1\.0 GB are available; take a smaller grid or a larger machine$",
        refusal(bem(4096), limits),
    )
    monkeypatch.setattr(
        resources, "available_memory", lambda: AvailableMemory(14 * 10**8, "the limit of a job")
    )
    limits = resource_limits()
    message = refusal(bem(4096), limits)
    assert "1.4 GB are available (the limit of a job); allow more with --max-memory" in message
    message = refusal(bem(4096, precision="double"), resource_limits(max_memory="1.3G"))
    assert "may take 1.4 GB; choose precision: mixed, or take a smaller grid" in message
    check_memory([bem(4096)], resource_limits(max_memory="2G"))
    monkeypatch.setattr(resources, "available_memory", lambda: None)
    check_memory([bem(4096)], resource_limits())


@pytest.mark.parametrize(
    ("jobs", "threads", "small", "large"),
    [
        (None, None, (1, 8), (8, 1)),
        (1, None, (8, 1), (8, 1)),
        (3, None, (2, 3), (2, 3)),
        (16, None, (1, 16), (1, 16)),
        (2, 5, (5, 2), (5, 2)),
        (None, 3, (3, 2), (3, 2)),
    ],
)
def test_threads_and_processes(
    monkeypatch: pytest.MonkeyPatch,
    jobs: int | None,
    threads: int | None,
    small: tuple[int, int],
    large: tuple[int, int],
) -> None:
    monkeypatch.setattr(resources, "available_cores", lambda: 8)
    limits = resource_limits(jobs, threads)
    for grid, wanted in ((1024, small), (2048, large)):
        one = bem(grid)
        given = replace(one, threads=limits.threads(one.cell), cell=replace(one.cell, seed=1))
        many = [replace(given, realizations=range(i, i + 1)) for i in range(40)]
        assert (given.threads, limits.processes(many)) == wanted


def test_little_work_is_not_worth_a_process(small_spec: dict[str, Any]) -> None:
    limits = resource_limits()
    assert limits.processes(tasks(small_spec, "none", 4)) == 1
    assert limits.processes([]) == 1
    assert resource_limits(jobs=3).processes(tasks(small_spec, "none", 2)) == 2
