"""The Dask engine, on a scheduler and workers that are processes of their own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.errors import IncompleteError
from roughbench.runner import Cluster, Progress, cluster, driver
from roughbench.runner.plan import Cell
from roughbench.spec import load_spec
from tests.runner.fakes import Fake, Misdeed

pytest.importorskip("distributed")

SPEC = {
    "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 8.0, "slope": 0.1},
    "pressures": [0.001, 0.01, 0.1],
    "realizations": 4,
    "models": [{"kind": "bem", "grid": 32}, {"kind": "foundation"}, {"kind": "persson"}],
}


@dataclass
class Processes:
    """A scheduler and its workers on the loopback interface."""

    folder: Path
    environment: dict[str, str]
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)
    scheduler: subprocess.Popen[bytes] | None = None

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    @property
    def here(self) -> Cluster:
        return Cluster("dask", scheduler_file=str(self.file))

    def dask(self, *arguments: object) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "distributed.cli.dask_" + str(arguments[0])]
        return subprocess.Popen(
            [*command, *map(str, arguments[1:])],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=self.environment,
        )

    def start_scheduler(self) -> None:
        options = ("--host", "127.0.0.1", "--port", 0, "--no-dashboard")
        self.scheduler = self.dask("scheduler", *options, "--scheduler-file", self.file)
        for _ in range(300):
            if self.file.exists() and json.loads(self.file.read_text() or "{}"):
                return
            time.sleep(0.1)
        pytest.fail("no scheduler")

    def start_worker(self, *options: object) -> subprocess.Popen[bytes]:
        address = json.loads(self.file.read_text())["address"]
        fixed = ("--nthreads", 1, "--no-nanny", "--no-dashboard")
        worker = self.dask("worker", address, *fixed, *options)
        self.workers.append(worker)
        return worker

    def end(self) -> None:
        for process in (*self.workers, self.scheduler):
            if process is not None:
                process.kill()
                process.wait()


@pytest.fixture(scope="module")
def processes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Processes]:
    root = str(Path(rb.__file__).parents[1])
    folder = tmp_path_factory.mktemp("dask")
    found = Processes(folder, os.environ | {"PYTHONPATH": root})
    found.start_scheduler()
    found.start_worker("--memory-limit", "2GiB")
    found.start_worker("--memory-limit", "2GiB")
    yield found
    found.end()


def fakes(monkeypatch: pytest.MonkeyPatch, n: int, misdeed: Misdeed, **options: Any) -> Cell:
    spec = load_spec(SPEC)
    model = Fake(misdeed=misdeed, **options)
    cell = Cell("main", model, spec.surface, spec.pressures, n, spec.seed)
    monkeypatch.setattr(driver, "plan", lambda _: [cell])
    module = sys.modules[Cell.__module__]  # the package has a function of its name
    monkeypatch.setattr(module, "SECONDS_PER_TASK", 1e-9)  # one realization each
    return cell


@pytest.mark.slow
def test_the_bytes_are_those_of_this_machine(processes: Processes, tmp_path: Path) -> None:
    news: list[Progress] = []
    there, here = tmp_path / "there.h5", tmp_path / "here.h5"
    tree = SPEC | {"observables": ["clusters"], "save_fields": {"pressures": [0.01]}}
    rb.run(tree, output=there, cluster=processes.here, progress=news.append)
    rb.run(tree, output=here, threads=1)
    assert there.read_bytes() == here.read_bytes()
    assert (news[0].done, news[-1].done) == (0, 27)
    log = there.with_name("there.h5.rbrun") / "run.log"
    assert "tasks to compute, on a dask cluster" in log.read_text()
    rb.run(
        tree, output=there, cluster=Cluster("dask", scheduler="tcp://127.0.0.1:1")
    )  # nothing


@pytest.mark.slow
def test_a_lost_worker_is_survived(
    processes: Processes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fakes(monkeypatch, 20, "wait")
    rb.run(SPEC, output=tmp_path / "here.h5", threads=1)
    victim = processes.start_worker("--memory-limit", "2GiB")
    ended: list[int] = []

    def kill(news: Progress) -> None:
        ended.append(news.done)
        if len(ended) == 6:
            victim.send_signal(signal.SIGKILL)

    rb.run(SPEC, output=tmp_path / "there.h5", cluster=processes.here, progress=kill)
    assert victim.wait(10) == -signal.SIGKILL
    assert (tmp_path / "there.h5").read_bytes() == (tmp_path / "here.h5").read_bytes()


@pytest.mark.slow
def test_errors_come_back(processes: Processes, monkeypatch: pytest.MonkeyPatch) -> None:
    fakes(monkeypatch, 2, "refuse")
    with pytest.raises(rb.SolverError, match=r"main/fake, realization \d of 2: refused"):
        rb.run(SPEC, cluster=processes.here)
    fakes(monkeypatch, 1, "strange")
    with pytest.raises(rb.RoughbenchError, match="StrangeError"):
        rb.run(SPEC, cluster=processes.here)


@pytest.mark.slow
def test_a_deadly_task_is_given_up(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = [worker.pid for worker in processes.workers]
    fakes(monkeypatch, 1, "die")
    stop = threading.Event()

    def replace() -> None:
        while not stop.wait(0.2):
            if sum(worker.poll() is None for worker in processes.workers) < 2:
                processes.start_worker("--memory-limit", "2GiB")

    thread = threading.Thread(target=replace)
    thread.start()
    try:
        with pytest.raises(rb.RoughbenchError, match="main/fake: all of the workers that Dask"):
            rb.run(SPEC, cluster=processes.here)
    finally:
        stop.set()
        thread.join()
    assert len(processes.workers) > len(before)


@pytest.mark.slow
def test_workers_with_other_code_are_refused(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "code_digest", lambda _: "f" * 12)
    with pytest.raises(rb.RoughbenchError, match="has another version of roughbench; install"):
        rb.run(SPEC, cluster=processes.here)


@pytest.mark.slow
def test_what_no_worker_can_do_is_an_error_at_once(processes: Processes) -> None:
    models = [{"kind": "bem", "grid": 32768}]  # which nobody could begin with
    large = {**SPEC, "models": models}
    start = time.monotonic()
    with pytest.raises(
        rb.RoughbenchError, match=r"needs about 5. GB, and the largest of \d wor"
    ):
        rb.run(large, cluster=processes.here)
    assert time.monotonic() - start < 10.0


@pytest.mark.slow
def test_without_workers_and_without_their_scheduler(
    processes: Processes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = Processes(tmp_path, processes.environment)
    own.start_scheduler()
    monkeypatch.setattr(cluster, "SECONDS_FOR_WORKERS", 1.0)
    try:
        with pytest.raises(
            rb.RoughbenchError, match="has no workers; start some with: dask wo"
        ):
            rb.run(SPEC, cluster=own.here)
        own.start_worker("--resources", "MEMGB=0.1")
        monkeypatch.setattr(cluster, "SECONDS_FOR_WORKERS", 30.0)
        with pytest.raises(rb.RoughbenchError, match=r"1 workers has 0\.1; start"):
            rb.run(SPEC, cluster=own.here)
        own.start_worker("--resources", "MEMGB=1")
        time.sleep(5.0)
        fakes(monkeypatch, 40, "wait")
        scheduler = own.scheduler
        assert scheduler is not None

        def kill(news: Progress) -> None:
            if news.done > 6:
                scheduler.kill()

        with pytest.raises(IncompleteError, match="connection to the Dask scheduler is lost"):
            rb.run(SPEC, cluster=own.here, progress=kill)
    finally:
        own.end()


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "SECONDS_FOR_SCHEDULER", 0.5)
    with pytest.raises(rb.RoughbenchError, match=r"tcp://127\.0\.0\.1:1 does not answer"):
        rb.run(SPEC, cluster=Cluster("dask", scheduler="tcp://127.0.0.1:1"))
    with pytest.raises(rb.RoughbenchError, match="does not answer"):
        rb.run(SPEC, cluster=Cluster("dask", scheduler="what://is this"))
    missing = str(tmp_path / "s.json")
    with pytest.raises(rb.RoughbenchError, match=r"s\.json: no such scheduler file"):
        rb.run(SPEC, cluster=Cluster("dask", scheduler_file=missing))


def test_a_cluster_that_is_not_clear() -> None:
    with pytest.raises(rb.RoughbenchError, match="needs --scheduler tcp://host:port or"):
        Cluster("dask")
    with pytest.raises(rb.RoughbenchError, match="one of the two"):
        Cluster("dask", scheduler="tcp://a:1", scheduler_file="s.json")
    with pytest.raises(rb.RoughbenchError, match="starts its own scheduler"):
        Cluster("slurm", scheduler="tcp://a:1")


@pytest.mark.parametrize(
    ("kind", "package"), [("dask", "distributed"), ("slurm", "dask_jobqueue")]
)
def test_without_dask(monkeypatch: pytest.MonkeyPatch, kind: Any, package: str) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    where = Cluster(kind, scheduler="tcp://127.0.0.1:1" * (kind == "dask"))
    with pytest.raises(
        rb.RoughbenchError, match=r"install it with: pip install 'roughbench\[da"
    ):
        rb.run(SPEC, cluster=where)


def test_ctrl_c_stays_ours_with_slurm(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("dask_jobqueue")]:
        monkeypatch.delitem(sys.modules, name)
    before = signal.getsignal(signal.SIGINT)
    try:
        assert cluster._slurm_cluster().__name__ == "SLURMCluster"
    except rb.RoughbenchError:
        pytest.skip("dask-jobqueue is not installed")
    assert signal.getsignal(signal.SIGINT) is before


def test_the_jobs_of_slurm_are_made_for_the_tasks(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    asked: dict[str, Any] = {}

    class RecordedError(Exception):
        pass

    def record(**options: Any) -> None:
        asked.update(options)
        raise RecordedError

    monkeypatch.setattr(cluster, "_slurm_cluster", lambda: record)
    with pytest.raises(RecordedError):
        rb.run(
            SPEC, threads=3, cluster=Cluster("slurm", walltime="00:10:00", partition="short")
        )
    assert asked == {
        "cores": 3,
        "processes": 1,
        "memory": "2 GiB",
        "walltime": "00:10:00",
        "worker_extra_args": ["--nthreads", "1", "--resources", "MEMGB=1"],
        "queue": "short",
        "account": None,
    }
