"""A Dask scheduler and workers that are processes of their own, for tests."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.runner import Cluster

SPEC: dict[str, Any] = {
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
                process.send_signal(signal.SIGCONT)
                process.kill()
                process.wait()


@contextmanager
def dask_processes(folder: Path) -> Iterator[Processes]:
    """Yield a scheduler without workers; it and those that are started end in the end."""
    root = str(Path(rb.__file__).parents[1])
    found = Processes(folder, os.environ | {"PYTHONPATH": root})
    try:
        found.start_scheduler()
        yield found
    finally:
        found.end()
