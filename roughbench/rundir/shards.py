"""Shards: finished tasks as files, named after their realizations and their checksum.

A shard is an ``.npz`` file. Its values stay on the disk until somebody asks for them, one
variable at a time: a run needs to know of a shard what is in it, and only the assembly of
the results needs the numbers.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import math
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from roughbench.errors import StoreError, explained
from roughbench.models.base import FloatArray
from roughbench.planning.tasks import Block, Task
from roughbench.publish import put, written
from roughbench.results import Array
from roughbench.rundir.archive import write_arrays
from roughbench.rundir.collected import Place, places_of
from roughbench.rundir.identity import Identity, key_of
from roughbench.rundir.usage import Usage
from roughbench.seal import sha256_of
from roughbench.variables import STORABLE, compare_shape

FORMAT = "roughbench shard 1"

_NAME = re.compile(r"(\d+)-(\d+)\.([0-9a-f]{16})\.npz", re.ASCII)
_META = "roughbench"
_DAMAGED = (
    *(OSError, ValueError, KeyError, TypeError, EOFError, OverflowError),
    *(RuntimeError, zipfile.BadZipFile),
)
"""What a file that is no zip file of arrays may make the readers raise."""


class ShardError(StoreError):
    """A shard that cannot be used; the message names it, and ``path`` is where it is."""

    def __init__(self, path: Path, reason: object) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = path


@dataclass(frozen=True, slots=True)
class Shard:
    """One finished task, as it is on disk.

    Attributes
    ----------
    path : Path
    realizations : range
        Of its rows.
    pressures : ndarray of float64, shape (pressures,)
        p/E*.
    names : tuple of str
        Of its variables.
    kept : tuple of Place
        Its fields.
    identity : mapping
        What the numbers depend on.
    cell : str
        What it was computed for, such as ``main/bem``.
    usage : mapping
        What it took.
    """

    path: Path
    realizations: range
    pressures: FloatArray
    names: tuple[str, ...]
    kept: tuple[Place, ...]
    identity: Identity
    cell: str
    usage: dict[str, Any]

    @contextlib.contextmanager
    def opened(self) -> Iterator[Mapping[str, Array]]:
        """Give the variables, each of which is read when it is asked for.

        Raises
        ------
        ShardError
            If the file is not what it was any more.
        """
        with _named(self.path), np.load(self.path, allow_pickle=False) as file:
            yield _Variables(file, self.names)

    @property
    def block(self) -> Block:
        """All variables, as :func:`roughbench.engines.compute.compute` returns them."""
        with self.opened() as variables:
            return dict(variables)


class _Variables(Mapping[str, Array]):
    def __init__(self, file: Mapping[str, Array], names: tuple[str, ...]) -> None:
        self._file, self._names = file, names

    def __getitem__(self, name: str) -> Array:
        return self._file[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def realizations_of(shard: Path) -> range:
    """Return the realizations that a shard is named after; none if it is not named so."""
    name = _NAME.fullmatch(shard.name)
    return range(int(name[1]), int(name[2]) + 1) if name else range(0)


def write_shard(
    folder: Path, task: Task, block: Block, identity: Identity, usage: Usage
) -> Shard:
    """Commit a finished task, straight to the disk.

    Raises
    ------
    OSError
        If the system refuses.
    """
    meta = {
        "format": FORMAT,
        "identity": identity,
        "cell": str(task.cell),
        "usage": usage.as_dict(),
    }
    text = np.frombuffer(json.dumps(meta).encode(), np.uint8)
    arrays: dict[str, Array] = {_META: text, "pressure": task.pressure_array(), **block}
    stem = f"{task.realizations[0]:06d}-{task.realizations[-1]:06d}"

    def write(file: IO[bytes]) -> None:
        write_arrays(file, arrays)

    with written(write, folder / stem) as temporary:
        target = folder / f"{stem}.{sha256_of(temporary)[:16]}.npz"
        put(temporary, target)
    return Shard(
        target,
        task.realizations,
        task.pressure_array(),
        tuple(block),
        places_of(block),
        identity,
        str(task.cell),
        usage.as_dict(),
    )


def read_shard(path: Path) -> Shard:
    """Return what is in a shard, after a look at every byte of it.

    Raises
    ------
    ShardError
        If it is damaged, or no shard of its folder.
    """
    with _named(path):
        name = _NAME.fullmatch(path.name)
        if name is None:
            raise ValueError("is no shard of roughbench")
        if sha256_of(path)[:16] != name[3]:
            raise ValueError("is damaged: its content does not match the checksum in its name")
        with np.load(path, allow_pickle=False) as file:
            return _understood(path, file)


def read_identity(path: Path) -> Identity | None:
    """Return what the numbers of a shard depend on, without looking at them; None if unclear.

    For words only: nothing is checked.
    """
    with contextlib.suppress(*_DAMAGED, MemoryError), np.load(path, allow_pickle=False) as file:
        found = json.loads(file[_META].tobytes())["identity"]
        return found if isinstance(found, dict) else None
    return None


@contextlib.contextmanager
def _named(path: Path) -> Iterator[None]:
    """Turn whatever the readers raise into an error that names the shard."""
    try:
        yield
    except OSError as error:
        reason = f"cannot be read: {explained(error)}"
        raise ShardError(path, reason) from error
    except _DAMAGED as error:
        raise ShardError(path, error) from error


def _understood(path: Path, file: Any) -> Shard:
    rows = realizations_of(path)
    headers = {name: _header(file.zip, name) for name in file.files}
    meta = json.loads(file[_META].tobytes())
    if meta["format"] != FORMAT:
        raise ValueError(f"has the format {meta['format']!r}, not {FORMAT!r}")
    if key_of(meta["identity"]) != path.parent.name:
        raise ValueError("belongs to another computation than the folder it is in")
    pressures = file["pressure"]
    lengths = {"realization": len(rows), "pressure": len(pressures)}
    names = tuple(name for name in file.files if name not in (_META, "pressure"))
    for name in names:
        shape, dtype = headers[name]
        suits, wanted = compare_shape(name, shape, lengths)
        if not suits or dtype not in STORABLE:
            raise ValueError(f"{name} has the shape {shape} of {dtype}, not {wanted}")
    if "status" not in names:
        raise ValueError("has no status")
    return Shard(
        path,
        rows,
        pressures,
        names,
        places_of(file),
        meta["identity"],
        str(meta["cell"]),
        dict(meta["usage"]),
    )


def _header(archive: zipfile.ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and type of a variable, which must fill its place in the file."""
    info = archive.getinfo(f"{name}.npy")
    with archive.open(info) as member:
        start = member.read(10)
        if start[:8] != b"\x93NUMPY\x01\x00":
            raise ValueError(f"{name} is no array as roughbench writes them")
        length = int.from_bytes(start[8:], "little")
        shape, dtype = _parsed(start[8:] + member.read(length))
    size = 10 + length + math.prod(shape) * dtype.itemsize
    if info.compress_type != zipfile.ZIP_STORED or info.file_size != size:
        raise ValueError(f"{name} claims {size} bytes and has {info.file_size}")
    return shape, dtype


@functools.lru_cache(maxsize=4096)  # the same ones in every shard
def _parsed(header: bytes) -> tuple[tuple[int, ...], np.dtype[Any]]:
    shape, _, dtype = np.lib.format.read_array_header_1_0(io.BytesIO(header))
    return shape, dtype
