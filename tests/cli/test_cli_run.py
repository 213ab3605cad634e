"""``roughbench run``: its file, its streams, its exit codes, and Ctrl-C."""

from __future__ import annotations

import contextlib
import os
import pty
import shlex
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import Result

import roughbench as rb
from roughbench import runner
from roughbench.cli import progress as cli_progress
from roughbench.planning.tasks import Block
from roughbench.rundir.collected import Collected
from roughbench.runner import Progress
from roughbench.runner.pace import Pace

Invoke = Callable[..., Result]
Popen = subprocess.Popen[str]


def test_leaves_the_results_file_and_says_so(folder: Path, invoke: Invoke) -> None:
    done = invoke("run", "small.yaml", "--threads", 1)
    assert done.exit_code == 0
    assert done.stdout == "small.h5\n"
    assert "main/foundation: 20 × 3" in done.stderr
    assert "roughbench show small.h5" in done.stderr
    assert "roughbench plot small.h5" in done.stderr
    assert "did not converge" not in done.stderr
    loaded = rb.load("small.h5")
    assert list(loaded["main"]) == ["foundation", "persson"]
    assert loaded.spec_text == (folder / "small.yaml").read_text()
    assert sorted(entry.name for entry in folder.iterdir()) == [
        "small.h5",
        "small.h5.rbrun",
        "small.yaml",
    ]


def test_the_same_bytes_for_any_number_of_jobs(
    folder: Path, start: Callable[..., Popen]
) -> None:
    with (folder / "small.yaml").open("a") as file:
        file.write("  - {kind: bem, grid: 64, realizations: 4}\n")
    for jobs, name in ((2, "two.h5"), (1, "one.h5")):
        process = start("run", "small.yaml", "-j", jobs, "--threads", 1, "-o", name)
        stdout, stderr = process.communicate(timeout=120)
        assert (process.returncode, stdout) == (0, f"{name}\n"), stderr
    assert (folder / "one.h5").read_bytes() == (folder / "two.h5").read_bytes()


@pytest.mark.usefixtures("folder")
def test_models_without_fields_are_named(invoke: Invoke) -> None:
    done = invoke("run", "small.yaml", "--set", "observables=[clusters]", "-j", 1)
    assert done.exit_code == 0
    assert done.stderr.endswith("\nnote: no observables, as without fields: main/persson\n")
    assert "clusters_mean" in rb.load("small.h5")["main"]["foundation"]
    assert "note" not in invoke("run", "small.yaml").stderr


def test_set_and_output(folder: Path, invoke: Invoke) -> None:
    options = ("--set", "surface.H=0.8", "--set", "realizations=2", "-o", "h 08.h5")
    done = invoke("run", "small.yaml", *options)
    assert done.exit_code == 0
    assert "roughbench show 'h 08.h5'" in done.stderr
    foundation = rb.load(folder / "h 08.h5")["main"]["foundation"]
    assert (foundation.attributes["hurst"], foundation.n_realizations) == (0.8, 2)


def test_results_before_a_change_of_the_spec_are_replaced_and_that_is_said(
    results: Path, invoke: Invoke
) -> None:
    results = Path(results.name)
    before = results.read_bytes()
    assert invoke("run", "small.yaml", "-q").stderr == ""
    done = invoke("run", "small.yaml", "--set", "seed=8", "-q")
    assert done.exit_code == 0
    assert done.stderr == (
        "warning: small.h5 has the results of small before its spec was changed; they are "
        "replaced when all is computed (-o with another name keeps them)\n"
    )
    assert results.read_bytes() != before
    assert invoke("run", "small.yaml").exit_code == 0
    assert results.read_bytes() == before


def test_results_of_another_spec_are_replaced_by_force_only(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    before = results.read_bytes()
    other = (folder / "small.yaml").read_text().replace("name: small", "name: other")
    (folder / "other.yaml").write_text(other.replace("seed: 7", "seed: 8"))
    command = ("run", "other.yaml", "-o", "small.h5")
    for options in ((), ("-n",)):
        done = invoke(*command, *options)
        assert done.exit_code == 1
        assert "small.h5 has the results of another spec, small; choose" in done.stderr
        assert "or replace it with --force" in done.stderr
        assert results.read_bytes() == before
    assert invoke(*command, "--force").exit_code == 0
    assert rb.load("small.h5").name == "other"
    assert invoke(*command).exit_code == 0  # the same spec


def test_quiet_and_verbose(folder: Path, invoke: Invoke) -> None:
    assert invoke("run", "small.yaml", "-q").stderr == ""
    message = invoke("run", "small.yaml", "-v", "--force").stderr
    assert "2 tasks to compute, in 1 processes\n" in message
    assert "main/foundation, realizations 1 to 20 of 20: done in " in message
    assert "peak memory 0." in message
    assert (folder / "small.h5").exists()
    log = (folder / "small.h5.rbrun" / "run.log").read_text()
    assert log.count("INFO main/foundation, realizations 1 to 20 of 20: done in ") == 2


def test_a_second_log_with_every_state(folder: Path, invoke: Invoke) -> None:
    with (folder / "small.yaml").open("a") as file:
        file.write("  - {kind: bem, grid: 64, realizations: 2}\n")
    done = invoke("run", "small.yaml", "-q", "--log-file", "mine.log")
    assert (done.exit_code, done.stderr) == (0, "")
    log = (folder / "mine.log").read_text()
    assert log == (folder / "small.h5.rbrun" / "run.log").read_text()
    states = [
        line for line in log.splitlines() if " DEBUG main/bem, realization 2 of 2" in line
    ]
    assert len(states) == 3
    assert "p/E* = 0.0001: converged, complementarity " in states[0]
    assert "iterations " in states[0]
    missing = invoke("run", "small.yaml", "--log-file", "missing/x.log")
    assert missing.exit_code == 1
    assert "cannot write the log missing/x.log: No such file or directory" in missing.stderr


def test_a_line_in_thirty_seconds_without_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cli_progress, "SECONDS_BETWEEN_LINES", 0.05)
    with cli_progress.progress_shown(quiet=False, verbose=False) as report:
        assert report is not None
        report(Progress(1, 4, 0.25, "state 1"))
        time.sleep(0.3)  # and lines come while nothing is new
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) >= 3
    assert all(line.startswith("0.") for line in lines)
    assert all(line.endswith(" s, 25 %, 1/4 states: state 1") for line in lines)


@pytest.mark.parametrize("share", [0.0, 0.999999])
def test_the_percentage_is_that_of_the_counts_and_lines_are_short(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, share: float
) -> None:
    """It was 97 % at 33 of 63 states, in 110 columns."""
    monkeypatch.setattr(cli_progress, "SECONDS_BETWEEN_LINES", 0.05)
    text = "main/foundation, realizations 1 to 20 of 20, pressure 3 of 20"
    with cli_progress.progress_shown(quiet=False, verbose=False) as report:
        assert report is not None
        report(Progress(62999, 63000, share, text))
        time.sleep(0.2)
    lines = capsys.readouterr().err.splitlines()
    assert lines
    for line in lines:
        assert " s, 99 %, 62999/63000 states: main/foundation, " in line
        assert len(line) == 60


def test_the_time_left_settles(monkeypatch: pytest.MonkeyPatch) -> None:
    """It does not count what was compiled, nor jump, and counts down between news."""
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    pace = Pace()
    message = []
    for now, share, text in (
        (0.0, 0.2, "starting"),
        (1.0, 0.2, "compiling, once"),
        (100.0, 0.3, "a"),
        (101.0, 0.31, "a"),
        (102.0, 0.32, "a"),
        (104.0, 0.34, "a"),
        (110.0, 0.40, "a"),
        (130.0, 0.60, "a"),
    ):
        clock[0] = now
        pace.note(Progress(0, 10, share, text))
        message.append(pace.left())
    assert message == ["", "", "", "", "", ", 2 min left", ", 1 min left", ", 40 s left"]
    clock[0] = 150.0
    assert pace.left() == ", 20 s left"  # and no more than there was
    clock[0] = 200.0
    assert pace.left() == ", 1 s left"


def test_a_bar_on_a_terminal(folder: Path) -> None:
    outer, inner = pty.openpty()
    termios.tcsetwinsize(inner, (24, 80))
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
    with subprocess.Popen(
        [sys.executable, "-m", "roughbench", "run", "small.yaml"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=inner,
        env=environment,
    ) as process:
        os.close(inner)
        message = b""
        while True:
            try:
                piece = os.read(outer, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            message += piece
    os.close(outer)
    assert process.returncode == 0
    assert b"/63 states: main/foundation" in message


def test_unconverged_states_are_reported(
    folder: Path, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Collected.block

    def spoiled(collected: Collected) -> Block:
        block = real(collected)
        if block["status"].shape == (20, 3):
            block["status"][3:5, 2] = 1
        return block

    monkeypatch.setattr(Collected, "block", spoiled)
    done = invoke("run", "small.yaml", "-q")
    assert done.exit_code == 0
    assert done.stderr == (
        "warning: main/foundation: 2 of 60 states did not converge; "
        "they are left out of the averages\n"
    )
    assert (folder / "small.h5").exists()


def test_an_invalid_spec_exits_2(folder: Path, invoke: Invoke) -> None:
    (folder / "bad.yaml").write_text(
        "surface: {H: 7, q0: 1, q1: 32, slope: 0.1}\npressures: [1e-3]\nmodels: [{kind: bam}]\n"
    )
    done = invoke("run", "bad.yaml")
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "bad.yaml:1:14: error: surface.H" in done.stderr
    assert "bad.yaml:3:" in done.stderr
    assert "Traceback" not in done.stderr
    assert invoke("run", "missing.yaml").exit_code == 2
    assert invoke("run", "small.yaml", "--set", "surface.H").exit_code == 2
    assert invoke("run").exit_code == 2
    assert invoke("run", "small.yaml", "-j", 0).exit_code == 2


def test_unusable_heights_exit_2(folder: Path, invoke: Invoke) -> None:
    np.save(folder / "line.npy", 0.01 * np.cos(np.arange(64.0)))
    (folder / "file.yaml").write_text(
        "surface: {kind: file, path: line.npy, length: 1.0}\n"
        "pressures: [1e-3]\nmodels: [{kind: bem}]\n"
    )
    for command in ("run", "validate"):
        done = invoke(command, "file.yaml")
        assert done.exit_code == 2
        assert "error: main/bem: line.npy: its shape is (64,)" in done.stderr


def test_the_folder_of_the_output_is_made(folder: Path, invoke: Invoke) -> None:
    assert invoke("run", "small.yaml", "-o", "new/er/r.h5", "-n").exit_code == 0
    assert not (folder / "new").exists()
    done = invoke("run", "small.yaml", "-o", "new/er/r.h5")
    assert (done.exit_code, done.stdout) == (0, "new/er/r.h5\n")
    refused = invoke("run", "small.yaml", "-o", "small.yaml/r.h5")
    assert refused.exit_code == 1
    assert refused.stderr.startswith("error: cannot write small.yaml/r.h5: ")
    assert "small.yaml is no folder; choose another place" in refused.stderr


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (rb.SolverError("refused"), "error: refused\n"),
        (MemoryError("8 GB"), "error: out of memory (8 GB); take a smaller grid"),
        (ZeroDivisionError("oops"), "error: ZeroDivisionError: oops\nThis is a fault of rough"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_failure_exits_1_with_one_clean_message(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, error: Exception, message: str
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(runner, "run_to_file", fail)
    done = invoke("run", "small.yaml")
    assert done.exit_code == 1
    assert done.stderr.startswith(message)
    assert "Traceback" not in done.stderr
    debugged = invoke("run", "small.yaml", "--debug")
    assert debugged.exit_code == 1
    assert "Traceback" in debugged.stderr
    assert message in debugged.stderr


@pytest.mark.usefixtures("folder")
def test_click_has_its_own_way_out(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise click.FileError("x", "hint")

    monkeypatch.setattr(runner, "run_to_file", fail)
    assert invoke("run", "small.yaml").exit_code == 1


LONG = ("--set", "realizations=100000", "--set", "models.foundation.springs=16384")


def started(start: Callable[..., Popen], jobs: int) -> Popen:
    """Return a run of some minutes that has finished a task."""
    process = start("run", "small.yaml", "-v", "-j", jobs, "--threads", 1, *LONG)
    assert process.stderr is not None
    while ": done in " not in process.stderr.readline():
        assert process.poll() is None
    return process


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize(
    ("number", "code", "message"),
    [
        (signal.SIGINT, 130, "interrupted"),
        (signal.SIGTERM, 3, "stopped by SIGTERM"),
        (signal.SIGHUP, 3, "stopped by SIGHUP"),
    ],
)
def test_a_signal_ends_it_cleanly(
    results: Path,
    start: Callable[..., Popen],
    invoke: Invoke,
    jobs: int,
    number: signal.Signals,
    code: int,
    message: str,
    program: str,
) -> None:
    before = results.read_bytes()
    process = started(start, jobs)
    # A terminal sends the signal to the whole group: to the workers as well.
    os.killpg(process.pid, number)
    sent = time.monotonic()
    stdout, stderr = process.communicate(timeout=60)
    assert time.monotonic() - sent < 10.0
    assert (process.returncode, stdout) == (code, "")
    *_, first, second = stderr.splitlines()
    assert first == message
    assert f" of 300003 states are kept in small.h5.rbrun; resume: {program} run" in second
    assert "Traceback" not in stderr
    assert results.read_bytes() == before
    assert_no_process_left(process.pid)
    again = shlex.split(second.partition(f"resume: {program} ")[2])
    assert again[:2] == ["run", "small.yaml"]
    planned = invoke(*again, "-n").stdout.splitlines()
    assert any(line.endswith(": done") for line in planned)
    assert any(": new (" in line for line in planned)


def test_a_terminal_that_is_closed_ends_it_cleanly(folder: Path, invoke: Invoke) -> None:
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "roughbench", "run", "small.yaml", "-j", "2", *LONG]
    process = subprocess.Popen(
        ["setsid", "--ctty", *command],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])},
    )
    os.close(theirs)
    shards = folder / "small.h5.rbrun" / "shards"
    for _ in range(600):
        if len(list(shards.rglob("*.npz"))) > 1:  # so the first of them is counted
            break
        os.set_blocking(ours, False)
        with contextlib.suppress(BlockingIOError):
            os.read(ours, 100000)
        time.sleep(0.1)
    os.close(ours)
    assert process.wait(30) == 3
    assert_no_process_left(process.pid)
    log = (folder / "small.h5.rbrun" / "run.log").read_text()
    assert "ended by HungUp" in log
    assert " of 300003 states are kept in small.h5.rbrun; resume: " in log
    planned = invoke("run", "small.yaml", "-n", *LONG).stdout.splitlines()
    assert any(line.endswith(": done") for line in planned)


@pytest.mark.usefixtures("no_bytecode")
def test_a_full_disk_leaves_a_run_to_resume(folder: Path, invoke: Invoke, program: str) -> None:
    """Files may have 2 kB, as if the disk were full then: less than a shard."""
    command = f"ulimit -f 2; exec {sys.executable} -m roughbench run small.yaml"
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, check=False, env=environment
    )
    assert (done.returncode, done.stdout) == (3, "")
    first, second = done.stderr.splitlines()
    assert first.startswith("error: cannot write small.h5.rbrun/shards/")
    assert "File too large; make room there, or choose another place with -o" in first
    assert first.endswith("main/foundation, realizations 1 to 20 of 20 is lost")
    assert second == f"run it again: {program} run small.yaml"
    assert not (folder / "small.h5").exists()
    assert not list(folder.rglob("*.tmp"))
    assert invoke("run", "small.yaml").exit_code == 0


def test_workers_end_with_a_killed_parent(start: Callable[..., Popen]) -> None:
    process = started(start, 2)
    assert len(processes_of(process.pid)) >= 3  # the workers are there
    process.kill()
    process.communicate(timeout=60)
    assert_no_process_left(process.pid)


def assert_no_process_left(group: int) -> None:
    """Wait until no process of the group is alive; fails after ten seconds."""
    for _ in range(100):
        if not processes_of(group):
            return
        time.sleep(0.1)
    pytest.fail(f"processes of group {group} are still there: {processes_of(group)}")


def processes_of(group: int) -> list[str]:
    """Return the ids of a group's processes, without the dead that nobody has collected."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # gone meanwhile
            state, _parent, its_group = status.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                found.append(status.parent.name)
    return found
