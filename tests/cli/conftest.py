"""A spec on disk, its results, and the command as a subprocess."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import roughbench as rb
from roughbench.cli import main

SPEC = """\
name: small
surface: {H: 0.7, q0: 1.0, qr: 4.0, q1: 32.0, slope: 0.1}
pressures: [1.0e-4, 1.0e-3, 1.0e-2]
realizations: 20
seed: 7
models:
  - kind: foundation
    springs: 128
  - kind: persson
"""

Invoke = Callable[..., Result]
Popen = subprocess.Popen[str]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with ``small.yaml`` in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.yaml").write_text(SPEC)
    return tmp_path


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a finished run of ``small.yaml``; to be copied, not used."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "small.yaml").write_text(SPEC)
    rb.run(folder / "small.yaml", output=folder / "small.h5", threads=1)
    return folder


@pytest.fixture
def results(folder: Path, finished: Path) -> Path:
    """Return the results file of ``small.yaml``, its run directory beside it."""
    shutil.copytree(finished, folder, dirs_exist_ok=True)
    return folder / "small.h5"


@pytest.fixture
def invoke() -> Invoke:
    """Return a callable that runs a command line in this process."""

    def run(*arguments: object) -> Result:
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    return run


@pytest.fixture
def program() -> str:
    """Return how hints of ``python -m roughbench`` call the program."""
    found = shutil.which("roughbench")
    ours = Path(sys.executable).with_name("roughbench")
    if found and ours.exists() and Path(found).samefile(ours):
        return "roughbench"
    return f"{shlex.quote(sys.executable)} -m roughbench"


@pytest.fixture
def start(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Popen]:
    """Return a callable that starts ``python -m roughbench`` in its own process group.

    The processes share a fresh cache, so that the first of them plans its transforms.
    """
    cache = tmp_path_factory.mktemp("cache")
    environment = {
        "PYTHONPATH": str(Path(rb.__file__).parents[1]),
        "ROUGHBENCH_CACHE": str(cache),
    }

    def popen(*arguments: object) -> Popen:
        return subprocess.Popen(
            [sys.executable, "-m", "roughbench", *map(str, arguments)],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            start_new_session=True,
            env=os.environ | environment,
        )

    return popen
