"""Run the commands of docs/first-run.md in an empty folder, and compare what they print.

    python scripts/spec_tutorial.py            # exit 1 where the page says something else
    python scripts/spec_tutorial.py --write    # put what they print into the page

scripts/_console.py says how.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from _console import check_page

PAGE = Path(__file__).parents[1] / "docs" / "first-run.md"


def main() -> int:
    """Run the page's commands; returns 1 if one prints something else."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="correct the page")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        return check_page(PAGE, Path(folder), write=options.write)


if __name__ == "__main__":
    raise SystemExit(main())
