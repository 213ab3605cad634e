"""Run the notebooks of examples/, and leave them with what they print and draw.

    python scripts/run_notebooks.py FOLDER [NAME ...]

Each runs from top to bottom in a copy of examples/ in FOLDER, with a kernel of its own, and is
left there; its source stays as it is, without output. Exits with 1 where a cell fails, with the
error.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
LONGEST = 300
"""Seconds for one cell."""


def run(path: Path) -> str:
    """Run a notebook in place; return what is wrong with it, or nothing."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=LONGEST,
        kernel_name="python3",
        extra_arguments=["--log-level=40"],
        resources={"metadata": {"path": str(path.parent)}},
    )
    try:
        client.execute()
    except CellExecutionError as error:
        return f"{error.ename}: {error.evalue}"
    finally:
        nbformat.write(notebook, path)
    return ""


def main() -> None:
    """Run them all, or those that are named."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", help="default: all")
    arguments = parser.parse_args()
    shutil.copytree(EXAMPLES, arguments.folder, dirs_exist_ok=True)
    names = arguments.names or sorted(path.name for path in EXAMPLES.glob("*.ipynb"))
    failed = 0
    for name in names:
        start = time.perf_counter()
        fault = run(arguments.folder / name)
        failed += bool(fault)
        print(f"{name}: {fault or 'runs'} ({time.perf_counter() - start:.0f} s)", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
