"""What other systems than Linux lack, taken away one at a time."""

from __future__ import annotations

import ast
import errno
import io
import multiprocessing.resource_tracker
import ntpath
import os
import re
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from roughbench import publish, system
from roughbench.cli.interrupts import Interrupted, interrupts_get_through
from roughbench.rundir.folder import RunFolder
from roughbench.runner import clean
from roughbench.signals import signals_held_back

ELSEWHERE_MISSING = {
    *("fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"),
    *("psutil", "_posixsubprocess"),
    *("os.fchmod", "os.fchown", "os.fork", "os.forkpty", "os.getgid", "os.getloadavg"),
    *("os.getpgid", "os.geteuid", "os.getuid", "os.killpg", "os.mkfifo", "os.nice"),
    *("os.O_CLOEXEC", "os.O_DIRECTORY", "os.O_NOFOLLOW", "os.O_NONBLOCK", "os.pread"),
    *("os.pwrite", "os.sched_getaffinity", "os.setsid", "os.ST_RDONLY", "os.statvfs"),
    *("os.sysconf", "os.uname", "os.wait", "os.waitpid"),
    *("signal.alarm", "signal.ITIMER_REAL", "signal.pause", "signal.pthread_kill"),
    *("signal.pthread_sigmask", "signal.setitimer", "signal.SIGALRM", "signal.SIGCHLD"),
    *("signal.SIGHUP", "signal.SIGKILL", "signal.SIGUSR1", "signal.sigwait"),
}
"""Modules and names that Windows, or Linux without more, does not have."""


_mentioned = re.compile(r"\b({})\b".format("|".join(map(re.escape, ELSEWHERE_MISSING)))).search


def names_in(text: str) -> set[str]:
    """Return the modules that a text imports, and the names that it takes of them."""
    found: set[str] = set()
    if not (_mentioned(text) or re.search(r"from (os|signal) import", text)):
        return found  # to parse takes longer
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module or "", *(f"{node.module}.{a.name}" for a in node.names)}
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.add(f"{node.value.id}.{node.attr}")
    return found


def test_what_other_systems_lack_is_used_in_one_place() -> None:
    places = {
        path.name: missing
        for path in Path(system.__file__).parent.rglob("*.py")
        if (missing := names_in(path.read_text(encoding="utf-8")) & ELSEWHERE_MISSING)
    }
    assert set(places) == {"system.py"}
    assert {"os.statvfs", "resource", "signal.setitimer"} <= places["system.py"]
    assert names_in("from os import fork") & ELSEWHERE_MISSING == {"os.fork"}


def test_colons_of_drives_are_none_of_datasets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert system.split_dataset("C:/scan.npy") == ("C", "/scan.npy")  # a file C on POSIX
    monkeypatch.setattr(os.path, "splitdrive", ntpath.splitdrive)
    assert system.split_dataset("C:/scan.npy") == ("C:/scan.npy", "")
    assert system.split_dataset("C:/scan.h5:/a/b") == ("C:/scan.h5", "/a/b")
    assert system.split_dataset("scan.h5:/a") == ("scan.h5", "/a")


@pytest.mark.parametrize("fault", [errno.EINVAL, errno.EIO])
def test_a_folder_that_cannot_be_synced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: int
) -> None:
    """File systems without it do without; a broken disk is said."""

    def fsync(descriptor: int) -> None:
        if os.path.isdir(f"/proc/self/fd/{descriptor}"):  # noqa: PTH112
            raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr(os, "fsync", fsync)
    target = tmp_path / "file"
    if fault == errno.EIO:
        with pytest.raises(OSError, match=os.strerror(fault)):
            publish.publish(lambda file: file.write(b"x"), target)
    else:
        publish.publish(lambda file: file.write(b"x"), target)
        assert target.read_bytes() == b"x"


def test_memory_where_there_is_no_proc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """macOS counts the peak in bytes, Linux in kB; Windows has it from psutil."""
    peak = system.peak_memory()
    monkeypatch.setattr(system, "_PROC", tmp_path)
    assert system.free_memory() is None
    assert 0.5 < system.peak_memory() / peak < 2.0
    monkeypatch.setattr(sys, "platform", "darwin")
    assert 0.5 < 1024 * system.peak_memory() / peak < 2.0
    process = SimpleNamespace(memory_info=lambda: SimpleNamespace(peak_wset=7))
    psutil = SimpleNamespace(
        virtual_memory=lambda: SimpleNamespace(available=5), Process=lambda: process
    )
    monkeypatch.setitem(sys.modules, "psutil", psutil)
    assert system.free_memory() == 5
    monkeypatch.setitem(sys.modules, "resource", None)
    assert system.peak_memory() == 7
    assert list(system.memory_limits()) == []
    monkeypatch.setitem(sys.modules, "psutil", None)
    assert (system.free_memory(), system.peak_memory()) == (None, 0)


class FirstByteLocked(io.BytesIO):
    """A file of which another process has locked the first byte, as Windows does it."""

    def read(self, size: int | None = -1, /) -> bytes:
        if self.tell() == 0:
            raise PermissionError(errno.EACCES, "locked")
        return super().read(size)


def test_text_behind_a_locked_byte(tmp_path: Path) -> None:
    assert system.readable_text(io.BytesIO(b"\n{}")) == "\n{}"
    assert system.readable_text(FirstByteLocked(b"\n{}")) == "{}"
    folder = RunFolder(tmp_path / "r.h5")
    with folder.locked("a run"):
        text = (folder.path / "lock").read_bytes()
        assert text[:1] == b"\n"  # what is told stands behind the byte
        assert folder.holder()["command"] == "a run"


def test_a_run_directory_goes_where_open_files_cannot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("roughbench.runner.cleaning.removes_open_files", lambda: False)
    folder = RunFolder(tmp_path / "r.h5")
    with folder.locked("a run"):
        (folder.path / "shards" / "key").mkdir()
    clean(tmp_path / "r.h5")
    assert list(tmp_path.iterdir()) == []


def test_any_text_into_any_encoding() -> None:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="cp1252")
    system.write_any_text(stream, None, io.StringIO())
    stream.write("μ → ü")
    stream.flush()
    assert raw.getvalue().decode("cp1252") == "\\u03bc \\u2192 ü"


class Loses:
    """Interrupted in its destructor, where Python would lose the exception."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGINT)
        time.sleep(0.01)


def test_interrupts_where_signals_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without alarms and masks: in a destructor, and held back."""
    monkeypatch.delattr(signal, "setitimer")
    monkeypatch.delattr(signal, "pthread_sigmask")
    monkeypatch.setattr("roughbench.cli.interrupts.ALARM", signal.SIGINT)
    monkeypatch.setattr(system, "ALARM", signal.SIGINT)

    def work() -> None:
        victim = Loses()
        del victim
        for _ in range(500):
            time.sleep(0.01)

    with pytest.raises(Interrupted), interrupts_get_through():
        work()
    done = []

    def work_undisturbed() -> None:
        with signals_held_back():
            signal.raise_signal(signal.SIGINT)
            done.append("not disturbed")

    with pytest.raises(Interrupted), interrupts_get_through():
        work_undisturbed()
    assert done == ["not disturbed"]
    time.sleep(0.05)  # no alarm comes late


def test_the_resource_tracker_is_of_posix(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []
    monkeypatch.setattr(
        multiprocessing.resource_tracker, "ensure_running", lambda: started.append(1)
    )
    system.start_resource_tracker()
    monkeypatch.setattr(os, "name", "nt")
    system.start_resource_tracker()
    assert started == [1]
