"""Files that end with the checksum of what stands before it, so that damage is found.

The checksum is a line of text behind the content, which HDF5 and zip ignore. Content is read
in blocks: a file may be larger than the memory.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO

_MARK = b"\nroughbench-sha256:"
_LENGTH = len(_MARK) + 65
_BLOCK = 2**20


def seal(content: bytes) -> bytes:
    r"""Return content with its checksum behind it.

    Examples
    --------
    >>> seal(b"text")[:39]
    b'text\nroughbench-sha256:982d9e3eb996f559'
    """
    return content + _line(hashlib.sha256(content).hexdigest())


def seal_file(file: IO[bytes]) -> None:
    """Put the checksum of a file, open to read and write, behind its content."""
    file.flush()
    file.seek(0)
    digest = hashlib.sha256()
    for block in _blocks(file):
        digest.update(block)
    file.write(_line(digest.hexdigest()))


def check_seal(file: IO[bytes]) -> int:
    """Return the length of the content of a file.

    Raises
    ------
    ValueError
        If it does not match its checksum, or there is none; see :func:`has_mark`.
    """
    length = file.seek(0, 2) - _LENGTH
    if length >= 0:
        file.seek(0)
        digest = hashlib.sha256()
        for block in _blocks(file, length):
            digest.update(block)
        if file.read() == _line(digest.hexdigest()):
            return length
    raise ValueError("its content does not match its checksum")


def has_mark(file: IO[bytes]) -> bool:
    """Return whether a file ends with something that looks like a checksum."""
    file.seek(max(0, file.seek(0, 2) - 2 * _LENGTH))
    return _MARK in file.read()


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of all bytes of a file, its checksum included, in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        for block in _blocks(file):
            digest.update(block)
    return digest.hexdigest()


def _blocks(file: IO[bytes], length: int | None = None) -> Iterator[bytes]:
    """Yield what follows in a file, at most so many bytes of it."""
    while length is None or length > 0:
        block = file.read(_BLOCK if length is None else min(_BLOCK, length))
        if not block:
            return
        if length is not None:
            length -= len(block)
        yield block


def _line(digest: str) -> bytes:
    return _MARK + digest.encode() + b"\n"
