"""Zip archives whose bytes depend on their content alone: no times, no users."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO

from roughbench.outputs import Kind

_MARK = b"A bundle of roughbench"
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a zip archive knows."""
_UNIX, _MODE = 3, 0o100644 << 16

BUNDLE = Kind("bundle", lambda head, tail: head.startswith(b"PK") and tail.endswith(_MARK))


def write_archive(file: IO[bytes], content: Mapping[str, bytes | Path]) -> None:
    """Write an archive.

    Parameters
    ----------
    file : binary file
    content : mapping of str to bytes or Path
        Name in the archive → what is in it, or the file that holds it. In the order of the
        names, whatever theirs is here.

    Raises
    ------
    OSError
        If the system refuses.
    """
    with zipfile.ZipFile(file, "w") as archive:
        archive.comment = _MARK
        for name, source in sorted(content.items()):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system, info.external_attr = _UNIX, _MODE
            with archive.open(info, "w", force_zip64=True) as member:
                if isinstance(source, bytes):
                    member.write(source)
                    continue
                with source.open("rb") as stream:
                    shutil.copyfileobj(stream, member, 1 << 20)
