"""The Dask engine, on a scheduler and workers that are processes of their own."""

from __future__ import annotations

import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.engines import dask_scheduler, dask_workers
from roughbench.errors import IncompleteError
from roughbench.planning.cells import Cell
from roughbench.runner import Cluster, Progress, preparation
from roughbench.spec import load_spec
from tests.engines.dask_processes import SPEC, Processes, dask_processes
from tests.engines.fakes import Fake, Misdeed
from tests.models.outside import spec_of, write_theory

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def processes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Processes]:
    with dask_processes(tmp_path_factory.mktemp("dask")) as found:
        found.start_worker("--memory-limit", "2GiB")
        found.start_worker("--memory-limit", "2GiB")
        yield found


def fakes(monkeypatch: pytest.MonkeyPatch, n: int, misdeed: Misdeed, **options: Any) -> Cell:
    spec = load_spec(SPEC)
    model = Fake(misdeed=misdeed, **options)
    cell = Cell("main", model, spec.surface, spec.pressures, n, spec.seed)
    monkeypatch.setattr(preparation, "plan", lambda _: [cell])
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
def test_a_model_in_a_file_travels_with_its_tasks(processes: Processes, tmp_path: Path) -> None:
    path = write_theory(tmp_path / "specs")
    tree = spec_of({"kind": f"{path}:Erf09"})
    spec = load_spec(tree)
    for file in path.parent.iterdir():  # as on a machine that has no part in this file system
        file.unlink()
    there, here = tmp_path / "there.h5", tmp_path / "here.h5"
    rb.run(spec, output=there, cluster=processes.here)
    rb.run(spec, output=here, threads=1)
    assert there.read_bytes() == here.read_bytes()


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
    monkeypatch.setattr(dask_workers, "code_digest", lambda _: "f" * 12)
    with pytest.raises(rb.RoughbenchError, match="has another version of roughbench; install"):
        rb.run(SPEC, cluster=processes.here)


@pytest.mark.slow
def test_workers_with_another_library_of_transforms_are_refused(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_workers, "transforms", lambda _: True)
    monkeypatch.setattr(dask_workers, "fft_backend", lambda: "another")
    with pytest.raises(rb.RoughbenchError, match="has another library of Fourier transforms"):
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
def test_too_small_workers_and_a_scheduler_that_dies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with dask_processes(tmp_path) as own:
        own.start_worker("--resources", "MEMGB=0.1")
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


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_scheduler, "SECONDS_FOR_SCHEDULER", 0.5)
    with pytest.raises(
        rb.RoughbenchError, match=r"tcp://127\.0\.0\.1:1 does not answer .*refused"
    ):
        rb.run(SPEC, cluster=Cluster("dask", scheduler="tcp://127.0.0.1:1"))
    file = tmp_path / "s.json"
    where = Cluster("dask", scheduler_file=str(file))
    with pytest.raises(rb.RoughbenchError, match=r"s\.json: no such scheduler file"):
        rb.run(SPEC, cluster=where)
    for content, fault in (
        ("{", "is no scheduler file of Dask"),
        ("[]", "names no address"),
        (
            '{"address": "inproc://127.0.0.1/1/1"}',
            "the address of the scheduler must read like",
        ),
        ('{"address": "tcp://10.0.0.7:8786"}', "has no TLS"),
    ):
        file.write_text(content)
        with pytest.raises(rb.RoughbenchError, match=fault):
            rb.run(SPEC, cluster=where)


def test_something_else_than_a_scheduler_is_not_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(dask_scheduler, "SECONDS_FOR_SCHEDULER", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as listening:  # it never says anything
        port = listening.getsockname()[1]
        start = time.monotonic()
        with pytest.raises(rb.RoughbenchError, match=f"{port} does not answer"):
            rb.run(SPEC, cluster=Cluster("dask", scheduler=f"127.0.0.1:{port}"))
    assert time.monotonic() - start < 20.0  # it was 41 s, and a traceback


@pytest.mark.parametrize(
    "address",
    ["foo", "what://is this", "http://a:1", "tcp://a", "tcp://a:0", "tcp://a:65536", "a:b:1"],
)
def test_a_malformed_address_is_refused_at_once(address: str) -> None:
    with pytest.raises(rb.RoughbenchError, match=r"must read like tls://host:8786 .*, got '"):
        Cluster("dask", scheduler=address)


@pytest.mark.parametrize(
    ("address", "protected"),
    [
        ("tcp://127.0.0.1:8786", True),
        ("127.8.9.10:8786", True),
        ("tcp://[::1]:8786", True),
        ("localhost:8786", True),
        ("tls://node7:8786", True),
        ("wss://node7:8786", True),
        ("tcp://node7:8786", False),
        ("node7:8786", False),
        ("tcp://10.0.0.7:8786", False),
        ("tcp://0.0.0.0:8786", False),
        ("ws://node7:8786", False),
        ("tcp://localhost.evil.example:8786", False),
    ],
)
def test_a_scheduler_without_tls_needs_a_word(
    address: str,
    protected: bool,  # noqa: FBT001
) -> None:
    where = Cluster("dask", scheduler=address)
    if protected:
        assert where.address() == address
        return
    with pytest.raises(rb.RoughbenchError, match="or say --insecure-scheduler if you trust"):
        where.address()
    with pytest.raises(rb.RoughbenchError, match="has no TLS and is not on the loopback"):
        rb.run(SPEC, cluster=where)
    assert Cluster("dask", scheduler=address, insecure_scheduler=True).address() == address


def test_tls_without_a_certificate_is_said_at_once() -> None:
    with pytest.raises(
        rb.RoughbenchError, match="wants a certificate; name its files in DASK_"
    ):
        rb.run(SPEC, cluster=Cluster("dask", scheduler="tls://127.0.0.1:1"))


def test_a_cluster_that_is_not_clear() -> None:
    with pytest.raises(rb.RoughbenchError, match="needs --scheduler tls://host:port or"):
        Cluster("dask")
    with pytest.raises(rb.RoughbenchError, match="one of the two"):
        Cluster("dask", scheduler="tcp://a:1", scheduler_file="s.json")
    with pytest.raises(rb.RoughbenchError, match="starts its own scheduler"):
        Cluster("slurm", scheduler="tcp://a:1")
    with pytest.raises(rb.RoughbenchError, match="--dashboard is for --engine slurm"):
        Cluster("dask", scheduler="tcp://a:1", dashboard=True)
    with pytest.raises(rb.RoughbenchError, match="positive number of minutes, got -1"):
        Cluster("slurm", patience=-1.0)


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(
        rb.RoughbenchError, match=r"install it with: pip install 'roughbench\[da"
    ):
        rb.run(SPEC, cluster=Cluster("dask", scheduler="tcp://127.0.0.1:1"))
