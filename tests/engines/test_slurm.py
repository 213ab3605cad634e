"""Jobs of Slurm, with a Slurm of two small scripts: its jobs run on this machine."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import stat
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.engines import cluster_watch, slurm
from roughbench.errors import IncompleteError
from roughbench.runner import Cluster, Progress
from tests.engines.dask_processes import SPEC

pytest.importorskip("dask_jobqueue")
pytest.importorskip("cryptography")

_SBATCH = """#!/bin/sh
cp "$1" "{folder}/job.$$"
setsid bash "{folder}/job.$$" < /dev/null > "{folder}/log.$$" 2>&1 &
echo "Submitted batch job $!"
echo $! >> {folder}/jobs
"""
_SCANCEL = "#!/bin/sh\nfor job; do kill -9 -- -$job; done\n"


def command(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.write_text(text)
    path.chmod(0o755)


@pytest.fixture
def slurm_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield the folder with ``sbatch`` and ``scancel``, on the PATH, and the jobs' scripts."""
    folder = tmp_path / "slurm"
    folder.mkdir()
    command(folder, "sbatch", _SBATCH.format(folder=folder))
    command(folder, "scancel", _SCANCEL)
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
    monkeypatch.setenv("PYTHONPATH", str(Path(rb.__file__).parents[1]))
    yield folder
    jobs = folder / "jobs"
    for job in jobs.read_text().split() if jobs.exists() else ():
        with contextlib.suppress(ProcessLookupError):
            os.killpg(int(job), signal.SIGKILL)


def said_by(address: str, security: Any) -> Any:
    """Return what a scheduler says of itself to a client that knows its port."""
    from distributed.core import rpc
    from distributed.utils import LoopRunner, sync

    async def ask() -> Any:
        arguments = security.get_connection_args("client")
        async with rpc(address, timeout=5, connection_args=arguments) as scheduler:
            return await scheduler.identity()

    runner = LoopRunner()
    runner.start()
    try:
        return sync(runner.loop, ask, callback_timeout=20)
    finally:
        runner.stop()


@pytest.mark.slow
def test_who_has_no_certificate_is_refused(slurm_folder: Path, tmp_path: Path) -> None:
    import psutil
    from distributed.security import Security

    output = tmp_path / "there.h5"
    keys: list[Path] = []

    def attack(news: Progress) -> None:
        if keys or news.done == 0:
            return
        script = next(slurm_folder.glob("job.*")).read_text()
        found = re.search(r"(tls://([\d.]+):(\d+))", script)
        assert found is not None, script
        address, host, port = found[1], found[2], int(found[3])
        files = dict(re.findall(r"--tls-(ca-file|cert|key) (\S+)", script))
        keys.extend(Path(path) for path in files.values())
        assert "BEGIN" not in script
        for path in keys:
            assert stat.S_IMODE(path.stat().st_mode) == 0o600

        # A control: with the certificate of the run, the scheduler answers.
        own = Security(
            require_encryption=True,
            tls_ca_file=files["ca-file"],
            tls_client_cert=files["cert"],
            tls_client_key=files["key"],
        )
        workers = said_by(address, own)["workers"]
        assert workers
        # Nobody else is answered: without TLS, or with a certificate of their own.
        for where in (address, *workers):
            assert where.startswith("tls://")
            for stranger, url in (
                (Security(), where.replace("tls://", "tcp://")),
                (Security.temporary(), where),
            ):
                with pytest.raises((OSError, TimeoutError)):
                    said_by(url, stranger)

        # Nothing else of this process can be reached from outside, no dashboard either.
        listening = [
            c.laddr
            for c in psutil.Process().net_connections("tcp")
            if c.status == psutil.CONN_LISTEN
        ]
        assert {a.port for a in listening if a.ip != "127.0.0.1"} == {port}
        for at in listening:
            where = at.ip if at.ip == "127.0.0.1" else host
            with socket.create_connection((where, at.port), 5) as s:
                s.sendall(b"GET /status HTTP/1.0\r\n\r\n")
                s.settimeout(5)
                with contextlib.suppress(OSError):
                    assert b"200 OK" not in s.recv(1000)

    rb.run(SPEC, output=output, cluster=Cluster("slurm", workers=2), progress=attack)
    assert len(keys) == 3
    assert not any(path.exists() for path in keys)
    rb.run(SPEC, output=tmp_path / "here.h5", threads=1)
    assert output.read_bytes() == (tmp_path / "here.h5").read_bytes()


@pytest.mark.slow
@pytest.mark.usefixtures("slurm_folder")
def test_the_dashboard_is_on_the_loopback(caplog: pytest.LogCaptureFixture) -> None:
    import psutil

    seen: list[bytes] = []

    def look(news: Progress) -> None:
        if seen or news.done == 0:
            return
        for connection in psutil.Process().net_connections("tcp"):
            at = connection.laddr
            if connection.status == psutil.CONN_LISTEN and at.ip == "127.0.0.1":
                with socket.create_connection(at, 5) as s:
                    s.sendall(b"GET /health HTTP/1.0\r\n\r\n")
                    seen.append(s.recv(1000))

    rb.run(SPEC, cluster=Cluster("slurm", dashboard=True), progress=look)
    assert any(b"200 OK" in answer for answer in seen)
    assert re.search(r"Dask's dashboard: http://127\.0\.0\.1:\d+/status", caplog.text)


def test_jobs_that_are_refused(slurm_folder: Path) -> None:
    refusal = "sbatch: error: invalid partition specified: nope"
    command(slurm_folder, "sbatch", f"#!/bin/sh\necho '{refusal}' >&2\nexit 1\n")
    start = time.monotonic()
    with pytest.raises(
        rb.RoughbenchError, match=f"sbatch refused the job: {refusal}; see --pa"
    ):
        rb.run(SPEC, cluster=Cluster("slurm", partition="nope"))
    assert time.monotonic() - start < 30.0


def test_jobs_that_never_start(
    slurm_folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(cluster_watch, "SECONDS_TO_TELL", 1.0)
    command(slurm_folder, "sbatch", "#!/bin/sh\necho Submitted batch job 99999999\n")
    with pytest.raises(IncompleteError, match=r"no job of Slurm is at work \(squeue says what"):
        rb.run(SPEC, cluster=Cluster("slurm", patience=0.05))
    assert "the run waits 0.05 minutes for it" in caplog.text


def test_without_slurm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(
        rb.RoughbenchError, match="sbatch, and it is not on the PATH; run it wh"
    ):
        rb.run(SPEC, cluster=Cluster("slurm"))


@pytest.mark.parametrize("package", ["distributed", "dask_jobqueue", "cryptography"])
def test_without_a_package(
    slurm_folder: Path, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    assert slurm_folder.exists()
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(
        rb.RoughbenchError, match=r"install it with: pip install 'roughbench\[da"
    ):
        rb.run(SPEC, cluster=Cluster("slurm"))


def test_ctrl_c_stays_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("dask_jobqueue")]:
        monkeypatch.delitem(sys.modules, name)
    before = signal.getsignal(signal.SIGINT)
    assert slurm.slurm_cluster().__name__ == "SLURMCluster"
    assert signal.getsignal(signal.SIGINT) is before


def test_the_jobs_are_made_for_the_tasks(
    slurm_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert slurm_folder.exists()
    asked: dict[str, Any] = {}

    class RecordedError(Exception):
        pass

    class Recorded:
        job_cls = object

        def __init__(self, **options: Any) -> None:
            asked.update(options)
            raise RecordedError

    monkeypatch.setattr(slurm, "slurm_cluster", lambda: Recorded)
    where = Cluster("slurm", walltime="00:10:00", partition="short")
    with pytest.raises(RecordedError):
        rb.run(SPEC, threads=3, cluster=where, output=tmp_path / "r.h5")
    security, job = asked.pop("security"), asked.pop("job_cls")
    assert issubclass(job, object)
    assert security.require_encryption
    assert Path(security.tls_worker_key).parent == tmp_path / "r.h5.rbrun"
    assert asked == {
        "cores": 3,
        "processes": 1,
        "memory": "2 GiB",
        "walltime": "00:10:00",
        "worker_extra_args": [
            *("--nthreads", "1", "--resources", "MEMGB=1"),
            *("--no-dashboard", "--dashboard-address", "127.0.0.1:0"),
        ],
        "scheduler_options": {"dashboard": False, "dashboard_address": "127.0.0.1:0"},
        "silence_logs": "critical",
        "queue": "short",
        "account": None,
    }
    assert not list((tmp_path / "r.h5.rbrun").glob(".tls*"))  # gone with the run
