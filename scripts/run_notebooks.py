"""Run the notebooks of examples/, and leave them with what they print and draw.

    python scripts/run_notebooks.py FOLDER [NAME ...]

Each runs from top to bottom in a copy of examples/ in FOLDER, with a kernel of its own, as many
at once as there are cores, and is left there; its source stays as it is, without output. Exits
with 1 where a cell fails, with the error.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

from roughbench.system import available_cores

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
LONGEST = 600
"""Seconds for one cell."""


def run(path: Path) -> tuple[str, float]:
    """Run a notebook in place; return what is wrong, if anything, and the seconds it took."""
    start = time.perf_counter()
    fault = fault_of(path)
    return fault, time.perf_counter() - start


def fault_of(path: Path) -> str:
    """Run a notebook in place; return what is wrong, or nothing."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=LONGEST,
        kernel_name="python3",
        coalesce_streams=True,  # of a line of progress its end alone
        extra_arguments=["--log-level=40"],
        resources={"metadata": {"path": str(path.parent)}},
    )
    try:
        client.execute()
    except CellExecutionError as error:
        return f"{error.ename}: {error.evalue}"
    except (CellTimeoutError, DeadKernelError) as error:
        return f"{type(error).__name__}: {error}"
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
    with ThreadPoolExecutor(available_cores()) as pool:
        found = pool.map(run, [arguments.folder / name for name in names])
        for name, (fault, seconds) in zip(names, found, strict=True):
            failed += bool(fault)
            print(f"{name}: {fault or 'runs'} ({seconds:.0f} s)", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
