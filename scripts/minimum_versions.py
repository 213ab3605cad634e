"""Print the oldest version of every dependency that pyproject.toml admits, for pip.

    python scripts/minimum_versions.py [EXTRA ...] > constraints.txt

Each ``name>=version`` becomes ``name==version``, of two for one name the newer; ``make
test-minimum`` runs the tests with just these.
"""

import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"


def minimum(requirement: str) -> str:
    """Return ``name==version`` of ``name>=version`` or ``name~=version``, with its marker.

    Raises
    ------
    ValueError
        If the requirement names no oldest version.
    """
    found = re.fullmatch(r"([\w.-]+)(?:\[[\w,-]+\])?\s*[>~]=\s*([\w.]+)\s*(;.*)?", requirement)
    if found is None:
        raise ValueError(f"{requirement!r} names no oldest version")
    return f"{found[1]}=={found[2]}{found[3] or ''}"


def newest(pinned: Iterable[str]) -> Iterable[str]:
    """Return the last of several versions of a package; an extra may need a newer one."""
    found: dict[str, str] = {}
    for line in pinned:
        name = line.partition("==")[0]
        before = found.get(name, line)
        found[name] = max(before, line, key=lambda one: _numbers(one.partition("==")[2]))
    return found.values()


def _numbers(version: str) -> list[int]:
    return [int(part) for part in version.partition(";")[0].split(".")]


def main(extras: list[str]) -> None:
    """Print one constraint per line."""
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    requirements = list(project["dependencies"])
    for extra in extras:
        requirements += project["optional-dependencies"][extra]
    print("\n".join(sorted(newest(map(minimum, requirements)))))


if __name__ == "__main__":
    main(sys.argv[1:])
