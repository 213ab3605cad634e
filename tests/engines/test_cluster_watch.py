"""A Dask cluster that cannot go on: what is missing is said, and some time the run ends."""

from __future__ import annotations

import logging
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import roughbench as rb
from roughbench.engines import cluster_watch
from roughbench.engines.cluster_watch import within
from roughbench.errors import IncompleteError
from roughbench.runner import Cluster, Progress
from tests.engines.dask_processes import SPEC, Processes, dask_processes
from tests.engines.test_cluster import fakes

pytest.importorskip("distributed")


@pytest.fixture
def message(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> Callable[[], str]:
    """Make half a minute two seconds; returns what was said."""
    monkeypatch.setattr(cluster_watch, "SECONDS_TO_TELL", 2.0)
    monkeypatch.setattr(cluster_watch, "_SECONDS_OF_SILENCE", 4.0)
    monkeypatch.setattr(cluster_watch, "_SECONDS_BETWEEN_LOOKS", 0.5)
    caplog.set_level(logging.WARNING, "roughbench.run")
    return lambda: caplog.text


def impatient(processes: Processes) -> Cluster:
    return Cluster("dask", scheduler_file=str(processes.file), patience=0.1)


@pytest.mark.slow
def test_a_cluster_without_workers(tmp_path: Path, message: Callable[[], str]) -> None:
    with dask_processes(tmp_path) as own:
        start = time.monotonic()
        with pytest.raises(
            IncompleteError,
            match=r"has no workers; start some with: .*; gave up after 0\.1 min",
        ):
            rb.run(SPEC, cluster=impatient(own))
        assert 6.0 < time.monotonic() - start < 20.0
    assert "; the run waits 0.1 minutes for it" in message()
    assert message().count("has no workers") == 1


@pytest.mark.slow
def test_workers_that_come_late_are_waited_for(tmp_path: Path) -> None:
    def start(news: Progress) -> None:
        if news.text == "starting":
            own.start_worker()

    with dask_processes(tmp_path) as own:
        results = rb.run(SPEC, cluster=own.here, progress=start)
    assert results["main"]["persson"].n_states == 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "whom", "missing"),
    [
        (signal.SIGKILL, "workers", "has no workers"),
        (
            signal.SIGSTOP,
            "workers",
            "none of the 1 workers of the Dask scheduler .* is heard of",
        ),
        (signal.SIGSTOP, "scheduler", "the Dask scheduler .* does not answer"),
    ],
)
def test_what_stops_in_mid_run(
    tmp_path: Path,
    message: Callable[[], str],
    monkeypatch: pytest.MonkeyPatch,
    number: signal.Signals,
    whom: str,
    missing: str,
) -> None:
    output = tmp_path / "r.h5"
    fakes(monkeypatch, 40, "wait")
    with dask_processes(tmp_path) as own:
        worker = own.start_worker("--memory-limit", "2GiB")
        victim = worker if whom == "workers" else own.scheduler
        assert victim is not None
        stopped: list[float] = []

        def stop(news: Progress) -> None:
            if news.done > 6 and not stopped:
                stopped.append(time.monotonic())
                victim.send_signal(number)

        with pytest.raises(IncompleteError, match=missing) as caught:
            rb.run(SPEC, output=output, cluster=impatient(own), progress=stop)
        assert time.monotonic() - stopped[0] < 40.0
    assert "states are kept in" in "".join(caught.value.__notes__)
    assert "; the run waits 0.1 minutes for it" in message()
    rb.run(SPEC, output=output, threads=1)
    rb.run(SPEC, output=tmp_path / "here.h5", threads=1)
    assert output.read_bytes() == (tmp_path / "here.h5").read_bytes()


@pytest.mark.slow
def test_workers_without_roughbench(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "class Nowhere:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.partition('.')[0] == 'roughbench':\n"
        "            raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, Nowhere())\n"
    )
    with dask_processes(tmp_path) as own:
        own.environment["PYTHONPATH"] = str(tmp_path)
        own.start_worker()
        start = time.monotonic()
        with pytest.raises(
            rb.RoughbenchError, match="roughbench is not installed where 1 of 1 workers run"
        ):
            rb.run(SPEC, cluster=own.here)
        assert time.monotonic() - start < 30.0


def test_a_question_that_is_never_answered() -> None:
    assert within(5.0, lambda: 7) == 7
    with pytest.raises(TimeoutError, match=r"no answer within 0\.1 s"):
        within(0.1, lambda: time.sleep(2.0))
    with pytest.raises(ZeroDivisionError):
        within(5.0, lambda: 1 // 0)
