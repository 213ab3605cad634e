r"""Disturb runs in every way, and check that nothing shows in what they leave.

One undisturbed run in a single process gives the reference. Then runs of the same spec, with
1 to 4 jobs or on a Dask cluster of three workers, are disturbed again and again until they
end: all of their processes killed (kill -9), single workers killed, SIGTERM, and a limit on
the size of files and a disk of 4 MB, both too small. Checked after every disturbance: no
traceback on stderr, the documented exit code, every shard sound, no realization committed
twice. In the end the results file has to be that of the reference, to the byte.

    python scripts/fault_campaign.py --groups 100 --workers 50 --terms 20 --full 20 --disks 20 \
        --dask-groups 10 --dask-workers 10
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from _machine import describe_machine

from roughbench.rundir.folder import RunFolder
from roughbench.rundir.shards import realizations_of
from roughbench.runner.verification import verify

SPEC = """\
surface: {{H: 0.7, q0: 1.0, qr: 2.0, q1: 24.0, slope: 0.1}}
pressures: {{min: 1.0e-3, max: 0.1, points: 8}}
realizations: {}
seed: 7
models:
  - {{kind: bem, grid: 96}}
  - {{kind: foundation, springs: 4096, realizations: 2000}}
  - {{kind: persson}}
sweep:
  surface.qr: [2.0, 4.0]
"""
EXIT_CODES = {
    "group": {-9},
    "worker": {1},  # the same task lost its worker three times
    "term": {3},
    "full": {1, 3},  # 1: before the first task, while the run directory is made
    "dask-group": {-9},
    "dask-worker": {1},  # the same task lost four workers
}
"""Kind of disturbance → how a run may end by it, if it does not end with 0."""


class BrokenError(Exception):
    """What must not happen."""


class Dask:
    """A scheduler and three workers: processes of their own, on the loopback interface."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
        self.scheduler = self._start("scheduler", *options, "--scheduler-file", str(self.file))
        while not self.file.exists() or not self.file.read_text():
            time.sleep(0.1)
        self.workers = [self._worker() for _ in range(3)]

    def _start(self, name: str, *arguments: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{name}", *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def _worker(self) -> subprocess.Popen[bytes]:
        options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--resources", "MEMGB=4"]
        return self._start("worker", "--scheduler-file", str(self.file), *options)

    def kill_one(self, chosen: random.Random) -> None:
        """Kill a worker and start another."""
        victim = chosen.choice(self.workers)
        victim.kill()
        victim.wait()
        self.workers.remove(victim)
        self.workers.append(self._worker())

    def end(self) -> None:
        """Kill all of them."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@dataclass
class Campaign:
    """What is still to be done to runs, and what came of it."""

    folder: Path
    left: Counter[str]
    random: random.Random
    dask: Dask | None
    done: Counter[str] = field(default_factory=Counter)
    ends: Counter[tuple[str, int]] = field(default_factory=Counter)
    runs: int = 0

    def run(self, reference: bytes) -> None:
        """Run the spec to its end, however often it is disturbed."""
        output = self.folder / f"run{self.runs}.h5"
        on_dask = [kind.startswith("dask") for kind, n in self.left.items() if n > 0]
        jobs = 0 if self.random.choice(on_dask) else self.random.randint(1, 4)
        while not output.exists():
            kind = self._next(jobs)
            code = self._disturbed(output, jobs, kind)
            self.ends[kind, code] += 1
            check(output)
        if output.read_bytes() != reference:
            raise BrokenError(f"{output} is not the reference")
        self.runs += 1
        output.unlink()
        shutil.rmtree(output.with_name(output.name + ".rbrun"))

    def _next(self, jobs: int) -> str:
        kinds = [
            kind
            for kind, n in self.left.items()
            if n > 0 and kind.startswith("dask") == (jobs == 0)
        ]
        if jobs == 1:
            kinds = [kind for kind in kinds if kind != "worker"]
        # Now and then a run is left alone, or it might never end.
        if not kinds or self.random.random() < 0.1:
            return "none"
        return self.random.choice(kinds)

    def _disturbed(self, output: Path, jobs: int, kind: str) -> int:
        limit = self.random.choice([200, 4_000, 12_000]) if kind == "full" else None
        engine = ["-j", str(jobs)]
        if jobs == 0 and self.dask is not None:
            engine = ["--engine", "dask", "--scheduler-file", str(self.dask.file)]
        process = start(output, engine, limit)
        time.sleep(self.random.uniform(0.5, 5.0))
        if kind == "full":
            self._count(kind)
        elif kind.endswith("worker"):
            for _ in range(self.random.randint(1, 3)):
                self._kill_a_worker(kind, process.pid)
                time.sleep(self.random.uniform(0.2, 1.5))
        elif kind != "none" and process.poll() is None:
            number = signal.SIGTERM if kind == "term" else signal.SIGKILL
            os.killpg(process.pid, number)
            self._count(kind)
        _, stderr = process.communicate(timeout=3600)
        if "Traceback" in stderr:
            raise BrokenError(f"{kind}: a traceback is shown:\n{stderr}")
        if process.returncode not in EXIT_CODES.get(kind, set()) | {0}:
            raise BrokenError(f"{kind}: exit code {process.returncode}:\n{stderr}")
        return process.returncode

    def _kill_a_worker(self, kind: str, parent: int) -> None:
        if self.left[kind] <= 0:
            return
        if kind == "dask-worker" and self.dask is not None:
            self.dask.kill_one(self.random)
            self._count(kind)
            return
        found = workers_of(parent)
        if found:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.random.choice(found), signal.SIGKILL)
                self._count(kind)

    def _count(self, kind: str) -> None:
        self.left[kind] -= 1
        self.done[kind] += 1


def fill_disks(campaign: Campaign, times: int) -> None:
    """Run a smaller spec on a disk of 4 MB that is nearly full, and make room bit by bit."""
    smaller = ["--set", "models.foundation.realizations=100", "--set", "realizations=20"]
    reference = campaign.folder / "smaller.h5"
    if start(reference, ["-j", "1", *smaller], None).wait() != 0:
        raise BrokenError("the undisturbed smaller run failed")
    disk = campaign.folder / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        print("  mounting is not permitted: no disk of 4 MB, only limits on the size of files")
        return
    try:
        while campaign.done["disk"] < times:
            _fill_disk(campaign, disk, smaller, reference.read_bytes())
            print(f"  disks left: {times - campaign.done['disk']}", flush=True)
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def _fill_disk(campaign: Campaign, disk: Path, options: list[str], reference: bytes) -> None:
    shutil.copy(campaign.folder / "spec.yaml", disk)
    ballast, output = disk / "ballast", disk / "run.h5"
    free = shutil.disk_usage(disk).free
    room = campaign.random.choice([0, 8_192, 40_960, 163_840])
    while not output.exists():
        room = min(room + campaign.random.randrange(0, 200_000, 4096), free)
        ballast.write_bytes(bytes(free - room))
        process = start(output, ["-j", str(campaign.random.randint(1, 4)), *options], None)
        _, stderr = process.communicate(timeout=3600)
        if process.returncode not in {0, 1, 3} or "Traceback" in stderr:
            raise BrokenError(f"disk: exit code {process.returncode}:\n{stderr}")
        if process.returncode and "No space left on device" not in stderr:
            raise BrokenError(f"disk: what is wrong is not said:\n{stderr}")
        campaign.done["disk"] += 1
        campaign.ends["disk", process.returncode] += 1
        ballast.unlink()
        check(output)
    if output.read_bytes() != reference:
        raise BrokenError(f"{output} is not the reference")
    for path in disk.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    campaign.runs += 1


def check(output: Path) -> None:
    """Check that every shard is sound, and no realization committed twice."""
    folder = RunFolder(output)
    if not folder.path.is_dir():
        return
    _, faults = verify(output)
    if faults:
        raise BrokenError("\n".join(faults))
    for key in folder.computations():
        committed = Counter(i for path in folder.shards(key) for i in realizations_of(path))
        if any(n > 1 for n in committed.values()):
            raise BrokenError(f"{key}: realizations committed twice: {committed}")


def start(output: Path, engine: list[str], limit: int | None) -> subprocess.Popen[str]:
    """Start a run in a process group of its own; with a limit on the bytes of a file."""

    def restrict() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    command = ["run", "spec.yaml", "-o", output.name, "--threads", "1", "-q", *engine]
    return subprocess.Popen(
        [sys.executable, "-m", "roughbench", *command],
        cwd=output.parent,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # Of bytecode a limit would leave half a file, which later runs would stumble on.
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=restrict,  # noqa: PLW1509, RUF100  (no threads here)
    )


def workers_of(parent: int) -> list[int]:
    """Return the worker processes of a run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            its_parent = int(stat.read_text().rpartition(")")[2].split()[1])
            command = (stat.parent / "cmdline").read_text()
            if its_parent == parent and "spawn_main" in command:
                found.append(int(stat.parent.name))
    return found


def main() -> None:
    """Run the campaign and print the table of outcomes."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    for kind, default, message in (
        ("groups", 100, "kill -9 of all processes of a run"),
        ("workers", 50, "kill -9 of a worker"),
        ("terms", 20, "SIGTERM"),
        ("full", 20, "limits on the size of files"),
        ("disks", 20, "runs on a disk of 4 MB that is full (needs the right to mount)"),
        ("dask-groups", 10, "kill -9 of a run on a Dask cluster"),
        ("dask-workers", 10, "kill -9 of a Dask worker"),
    ):
        parser.add_argument(f"--{kind}", type=int, default=default, help=message)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--realizations", type=int, default=120, help="of the exact solver")
    options = vars(parser.parse_args())
    kinds = ("groups", "workers", "terms", "full", "dask_groups", "dask_workers")
    left = Counter({kind.rstrip("s").replace("_", "-"): options[kind] for kind in kinds})
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        (folder / "spec.yaml").write_text(SPEC.format(options["realizations"]))
        reference = folder / "reference.h5"
        if start(reference, ["-j", "1"], None).wait() != 0:
            raise SystemExit("the undisturbed run failed")
        dask = None
        if left["dask-group"] + left["dask-worker"] > 0:
            dask = Dask(folder)
            stack.callback(dask.end)
        campaign = Campaign(folder, left, random.Random(options["seed"]), dask)  # noqa: S311
        while +left:
            campaign.run(reference.read_bytes())
            print(f"  left: {dict(+left)}", flush=True)
        if options["disks"]:
            fill_disks(campaign, options["disks"])
    print(describe_machine("numpy", "numba", "pyfftw"))
    print(
        f"{campaign.runs} runs, {time.monotonic() - begun:.0f} s; all ended with the bytes of"
    )
    print("the undisturbed one, every realization committed once, no traceback shown\n")
    print("| disturbance | times | how the disturbed runs ended |\n|---|---|---|")
    for kind in campaign.done:
        ends = {code: n for (its, code), n in sorted(campaign.ends.items()) if its == kind}
        message = ", ".join(f"{n} × {code}" for code, n in ends.items())
        print(f"| {kind} | {campaign.done[kind]} | {message} |")


if __name__ == "__main__":
    try:
        main()
    except BrokenError as error:
        raise SystemExit(f"BROKEN: {error}") from None
