"""Small JSON files in a run directory, each with its checksum."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from typing import Any

from roughbench.publish import commit

_CHECKSUM = "sha256"


def write_note(content: dict[str, Any], path: Path) -> None:
    """Write a note in one step."""
    sealed = content | {_CHECKSUM: _checksum(content)}
    commit(json.dumps(sealed, indent=1).encode(), path)


def read_note(path: Path) -> dict[str, Any]:
    """Return the content of a file; empty if it is missing or not as it was written."""
    with contextlib.suppress(OSError, ValueError, RecursionError):
        found = json.loads(path.read_bytes())
        if isinstance(found, dict) and found.pop(_CHECKSUM, "") == _checksum(found):
            return found
    return {}


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
