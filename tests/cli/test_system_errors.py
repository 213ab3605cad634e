"""What the system refuses is no fault of roughbench: one message with place and remedy."""

from __future__ import annotations

import errno
import importlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from click.testing import Result

import roughbench as rb
from roughbench import runner
from roughbench.cli import COMMANDS as ALL

Invoke = Callable[..., Result]
NOBODY = 65534
LONG = "x" * 300

READING = {
    "show": ("show", "{}.h5"),
    "fit": ("fit", "{}.h5"),
    "plot": ("plot", "{}.h5"),
    "report": ("report", "{}.h5"),
    "export": ("export", "{}.h5", "--csv", "tables"),
    "status": ("status", "{}.h5"),
    "verify": ("verify", "{}.h5"),
    "clean": ("clean", "{}.h5"),
    "run": ("run", "{}.yaml"),
    "validate": ("validate", "{}.yaml"),
}
WRITING = {
    "run": ("run", "small.yaml", "-o", "{}.h5"),
    "log": ("run", "small.yaml", "--log-file", "{}.log"),
    "plot": ("plot", "small.h5", "-o", "{}"),
    "report": ("report", "small.h5", "-o", "{}.html"),
    "export": ("export", "small.h5", "--csv", "{}"),
}
COMMANDS = [
    *(pytest.param(command, id=f"{name} reads") for name, command in READING.items()),
    *(pytest.param(command, id=f"{name} writes") for name, command in WRITING.items()),
]


def filled(command: tuple[str, ...], place: str) -> list[str]:
    return [word.format(place) for word in command]


def assert_clean(done: Result, place: str, reason: str) -> None:
    assert done.exit_code in (1, 2), done.output
    assert "fault of roughbench" not in done.stderr
    assert "Traceback" not in done.stderr
    assert place in done.stderr
    assert f"{reason}; " in done.stderr  # and what to do about it
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.usefixtures("results")
def test_names_that_are_too_long(invoke: Invoke, command: tuple[str, ...]) -> None:
    assert_clean(invoke(*filled(command, LONG)), LONG, "File name too long")


@pytest.fixture
def closed(results: Path, folder: Path, invoke: Invoke) -> Iterator[Path]:
    """Return a folder that may not be searched, nor by root: it works as somebody else."""
    place = folder / "closed"
    place.mkdir()
    for name in ("small.h5", "small.yaml"):
        (place / name).write_bytes((folder / name).read_bytes())
    for command in ALL:
        importlib.import_module(f"roughbench.cli.{command}")
    for command in ("show", "status", "verify", "clean"):
        invoke(command, "small.h5")  # so that all modules are there
    assert invoke("run", "small.yaml").exit_code == 0
    assert rb.load(results).name == "small"
    place.chmod(0)
    folder.chmod(0o777)
    is_root = os.geteuid() == 0
    if is_root:
        os.seteuid(NOBODY)
    yield place
    if is_root:
        os.seteuid(0)
    place.chmod(0o700)


def test_a_folder_that_may_not_be_searched(closed: Path, invoke: Invoke) -> None:
    for name, command in READING.items():
        if name in {"plot", "report", "export"}:  # their own output is looked at first
            continue
        done = invoke(*filled(command, "closed/small"))
        assert_clean(done, "closed/small", "Permission denied")
    for name in ("run", "report"):  # the others write beside, where this user has no right
        done = invoke(*filled(WRITING[name], "closed/new"))
        assert_clean(done, "closed/new", "Permission denied")
    assert closed.name == "closed"


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.EROFS, ""),
        (errno.EIO, "the disk fails"),
        (errno.EMFILE, "allow more open files (ulimit -n), or take fewer jobs (-j)"),
        (errno.EAGAIN, "allow more processes (ulimit -u)"),
        (errno.ENOSPC, "make room there"),
        (errno.ELOOP, "its symbolic links lead in circles"),
    ],
)
@pytest.mark.parametrize(
    ("place", "shown"),
    [
        ("/some/pla\nce", r"/some/pla\nce: "),
        (b"/some/place", "/some/place: "),
        (None, ""),
        (3, ""),  # a descriptor
    ],
)
@pytest.mark.usefixtures("folder")
def test_whatever_else_the_system_refuses(
    invoke: Invoke,
    monkeypatch: pytest.MonkeyPatch,
    number: int,
    remedy: str,
    place: object,
    shown: str,
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number), place)

    monkeypatch.setattr(runner, "run_to_file", fail)
    done = invoke("run", "small.yaml")
    message = f"error: {shown}{os.strerror(number)}"
    assert (done.exit_code, done.stderr.startswith(message)) == (1, True)
    assert remedy in done.stderr
    assert "fault of roughbench" not in done.stderr


def test_an_error_of_our_own_without_a_number_stays_one(
    folder: Path, invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError("unexpected")

    monkeypatch.setattr(runner, "run_to_file", fail)
    assert "fault of roughbench" in invoke("run", folder / "small.yaml").stderr


@pytest.mark.usefixtures("folder")
def test_few_file_descriptors() -> None:
    command = f"ulimit -n 12; exec {sys.executable} -m roughbench run small.yaml -j 2"
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, check=False, env=environment
    )
    assert done.returncode in (1, 3)
    assert "Too many open files; allow more open files (ulimit -n)" in done.stderr
    assert "fault of roughbench" not in done.stderr
    assert "Traceback" not in done.stderr
