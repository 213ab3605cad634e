"""What `make setup` does, with a Python that only notes what it is asked for."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

FAKE = """\
#!/bin/sh
echo "$@" >> {log}
if [ "$2" = venv ]; then mkdir -p .venv/bin; cp "$0" .venv/bin/python; fi
"""


class Checkout:
    """A folder with the Makefile, and a Python that installs nothing."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.log = folder / "log"
        self.python = folder / "python"
        self.python.write_text(FAKE.format(log=self.log))
        self.python.chmod(0o755)
        for name in ("Makefile", "pyproject.toml"):
            shutil.copy(ROOT / name, folder)

    def make(self, target: str) -> list[str]:
        """Run make; return what the Python was asked for, each as its first and last word."""
        self.log.write_text("")
        command = ["make", "-C", str(self.folder), target, f"PYTHON={self.python}"]
        subprocess.run(command, capture_output=True, check=True)
        lines = self.log.read_text().splitlines()
        return [line.split()[1] + " " + line.split()[-1] for line in lines]


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    return Checkout(tmp_path)


def test_setting_up_happens_once(checkout: Checkout) -> None:
    assert checkout.make("setup") == ["venv .venv", "pip ."]
    assert checkout.make("setup") == []


def test_the_tools_for_tests_come_on_top(checkout: Checkout) -> None:
    assert checkout.make("setup-dev") == ["venv .venv", "pip .", "pip .[dev]"]
    assert checkout.make("setup-dev") == []
    assert checkout.make("setup") == []


def test_again_when_the_project_changes(checkout: Checkout) -> None:
    checkout.make("setup-dev")
    later = (checkout.folder / ".venv" / "ready-dev").stat().st_mtime + 1
    os.utime(checkout.folder / "pyproject.toml", (later, later))
    assert checkout.make("setup-dev")[0] == "pip ."


def test_no_python_at_all_is_said(checkout: Checkout) -> None:
    command = ["make", "-C", str(checkout.folder), "setup", "PYTHON="]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "no Python 3.11 or newer with venv found" in done.stderr
