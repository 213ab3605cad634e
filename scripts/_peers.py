"""The environment of the independent codes that benchmarks and comparisons run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ENVIRONMENT = HERE.parent / ".venv-peers"


def peer_python() -> Path:
    """Return the Python of the peers' environment, made if it is not there.

    A peer that cannot be installed (ASPHER is built from source: a C++17 compiler, CMake
    and Eigen) is named and left out.
    """
    python = ENVIRONMENT / "bin" / "python"
    stamp = ENVIRONMENT / "requirements.txt"
    wanted = HERE / "peers" / "requirements.txt"
    if stamp.exists() and stamp.read_text() == wanted.read_text():
        return python
    print(f"Making {ENVIRONMENT.name} for the peers", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", "--clear", ENVIRONMENT], check=True)
    for requirement in wanted.read_text().splitlines():
        if not requirement or requirement.startswith("#"):
            continue
        done = subprocess.run(
            [python, "-m", "pip", "install", "--quiet", requirement],
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            print(
                f"{requirement} cannot be installed (building it may need g++, cmake and "
                "libeigen3-dev)",
                file=sys.stderr,
            )
    stamp.write_text(wanted.read_text())
    return python
