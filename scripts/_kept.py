"""Results that are kept in the repository: compressed, NAME.h5.xz."""

from __future__ import annotations

import lzma
import tempfile
from pathlib import Path

import roughbench as rb
from roughbench.results import Results


def keep(path: Path, packed: Path) -> None:
    """Compress a results file, unless its content is kept already."""
    content = path.read_bytes()
    if not packed.is_file() or lzma.decompress(packed.read_bytes()) != content:
        packed.write_bytes(lzma.compress(content, preset=6))


def load(packed: Path) -> Results:
    """Return kept results, whose arrays are read at once."""
    with tempfile.TemporaryDirectory() as folder:
        unpacked = Path(folder) / packed.name.removesuffix(".xz")
        unpacked.write_bytes(lzma.decompress(packed.read_bytes()))
        return rb.load(unpacked)
