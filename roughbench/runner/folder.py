"""The run directory beside a results file: durable shards, and a lock for one run at a time.

``quick.h5.rbrun/``
    ``README.txt``       that it is a run directory
    ``lock``             who works in it
    ``run.log``          what happened, of all runs
    ``run.json``         what the last run was asked for
    ``provenance.json``  where the results file comes from
    ``shards/KEY/``      finished tasks; KEY stands for what the numbers depend on
    ``checkpoints/``     finished states of long curves
    ``set-aside/``       shards that were damaged

The shards are the truth; all else may be deleted. A shard is an ``.npz`` file named after
its realizations and the SHA-256 of its bytes, published in one step.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import platform
import re
import shutil
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from roughbench.errors import LockedError, StoreError, explained
from roughbench.locks import open_lock, try_lock
from roughbench.models.base import FloatArray
from roughbench.publish import commit, remove_leftovers, temporary_of
from roughbench.runner.checkpoint import Checkpoint
from roughbench.runner.compute import Block
from roughbench.runner.identity import Identity, key_of
from roughbench.runner.journal import log
from roughbench.runner.mark import mark
from roughbench.runner.plan import Task
from roughbench.runner.usage import Usage, now
from roughbench.variables import STORABLE, fits

SUFFIX = ".rbrun"
FORMAT = "roughbench shard 1"

_NAME = re.compile(r"(\d+)-(\d+)\.([0-9a-f]{16})\.npz", re.ASCII)
_META = "roughbench"
_TRIES, _PAUSE, _GLANCE = 6, 0.1, 0.01


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
    first : int
        Realization of the first row.
    pressures : ndarray of float64, shape (pressures,)
        p/E*.
    block : dict of str to ndarray
        As :func:`roughbench.runner.compute.compute` returns it.
    identity : mapping
        What the numbers depend on.
    cell : str
        What it was computed for, such as ``main/bem``.
    usage : mapping
        What it took.
    """

    path: Path
    first: int
    pressures: FloatArray
    block: Block
    identity: Identity
    cell: str
    usage: dict[str, Any]


def folder_of(results: str | os.PathLike[str]) -> Path:
    """Return the run directory of a results file.

    Examples
    --------
    >>> folder_of("results/quick.h5").as_posix()
    'results/quick.h5.rbrun'
    """
    path = Path(results)
    return path.with_name(path.name + SUFFIX)


def realizations_of(shard: Path) -> range:
    """Return the realizations that a shard is named after; none if it is not named so."""
    name = _NAME.fullmatch(shard.name)
    return range(int(name[1]), int(name[2]) + 1) if name else range(0)


class RunFolder:
    """A run directory; reading needs no lock, writing does.

    Parameters
    ----------
    results : path
        The results file that it stands beside.
    """

    def __init__(self, results: str | os.PathLike[str]) -> None:
        self.results = Path(results)
        self.path = folder_of(results)
        self.log = self.path / "run.log"
        self._shards = self.path / "shards"
        self._checkpoints = self.path / "checkpoints"
        self._set_aside = self.path / "set-aside"

    # -- one run at a time -----------------------------------------------------------------

    @contextlib.contextmanager
    def locked(self, command: str) -> Iterator[None]:
        """Make the folder and keep other runs out of it.

        Raises
        ------
        LockedError
            If another run is in it; says which and where.
        StoreError
            If it cannot be made or written, or is a folder of somebody else.
        """
        try:
            file = self._lock()
            self._write_holder(file, command)
            for folder in (self._shards, self._checkpoints):
                folder.mkdir(exist_ok=True)
            with contextlib.suppress(FileNotFoundError):  # too long a path is told now
                temporary_of(self._shards / ("0" * 20) / _shard_name(0, 0, "0" * 16)).stat()
        except OSError as error:
            raise StoreError(
                f"cannot write {self.path}: {explained(error, 'choose another place with -o')}"
            ) from error
        try:
            self._remove_leftovers()
            yield
        finally:
            with contextlib.suppress(OSError):
                file.truncate(0)
            file.close()

    def _lock(self) -> IO[str]:
        self.path.mkdir(exist_ok=True)
        mark(self.path)
        path = self.path / "lock"
        for attempt in range(_TRIES):
            time.sleep(_PAUSE * (attempt > 0))
            file = os.fdopen(open_lock(path), "r+", encoding="utf-8")
            try:
                held = try_lock(file.fileno())
                if held is None:
                    log.warning(
                        "the file system of %s knows no locks: a second run with the same "
                        "output would not be kept out; start none while this one works",
                        self.path,
                    )
                    return file
                # Another process may have removed the folder between open and lock.
                if held and os.fstat(file.fileno()).st_ino == path.stat().st_ino:
                    return file
            except BaseException:
                file.close()
                raise
            file.close()  # of a run, or of someone who only looks who is there
        raise LockedError(self._locked_message())

    def _write_holder(self, file: IO[str], command: str) -> None:
        holder = {
            "process": os.getpid(),
            "host": platform.node(),
            "since": now(),
            "command": command,
        }
        file.truncate(0)
        file.write(json.dumps(holder))
        file.flush()

    def _locked_message(self) -> str:
        holder = self.holder()
        who = "another run"
        if holder:
            who = (
                f"process {holder.get('process')} on {holder.get('host')} since "
                f"{holder.get('since')} ({holder.get('command')})"
            )
        return (
            f"{self.path} is locked by {who}; wait for it or stop it, or choose another "
            "results file with -o"
        )

    def holder(self) -> dict[str, Any]:
        """Return what the run in the folder says of itself; empty for none."""
        with contextlib.suppress(OSError, ValueError), (self.path / "lock").open() as file:
            for attempt in range(_TRIES):  # who only looks, as here, has it for a moment
                time.sleep(_GLANCE * (attempt > 0))
                if try_lock(file.fileno()) is not False:
                    return {}
            found = json.loads(file.read() or "{}")
            return found if isinstance(found, dict) and found else {"process": "?"}
        return {}

    def _remove_leftovers(self) -> None:
        remove_leftovers(self.results)
        with contextlib.suppress(OSError):
            for leftover in self.path.rglob(".*.tmp"):
                leftover.unlink()

    # -- shards ----------------------------------------------------------------------------

    def computations(self) -> list[str]:
        """Return the keys of all identities that the folder has shards of."""
        return sorted(entry.name for entry in _entries(self._shards))

    def shards(self, key: str) -> list[Path]:
        """Return the files of the shards of one identity, in the order of their names."""
        return [
            entry
            for entry in sorted(_entries(self._shards / key))
            if not entry.name.startswith(".")
        ]

    def write(self, task: Task, block: Block, identity: Identity, usage: Usage) -> Path:
        """Commit a finished task: when this returns, nothing short of a broken disk takes it.

        Raises
        ------
        StoreError
            If the system refuses.
        """
        first, stop = task.realizations.start, task.realizations.stop
        meta = {
            "format": FORMAT,
            "identity": identity,
            "cell": str(task.cell),
            "usage": usage.as_dict(),
        }
        image = io.BytesIO()
        text = np.frombuffer(json.dumps(meta).encode(), np.uint8)
        arrays = {_META: text, "pressure": task.pressure_array(), **block}
        np.savez(image, **arrays)  # type: ignore[arg-type]
        data = image.getvalue()
        folder = self._shards / key_of(identity)
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise StoreError(f"cannot write {folder}: {explained(error)}") from error
        return commit(data, folder / _shard_name(first, stop - 1, _digest(data)))

    def read(self, path: Path) -> Shard:
        """Return a shard.

        Raises
        ------
        ShardError
            If it is damaged, or no shard of this folder: never a wrong number.
        """
        try:
            return _read(path)
        except OSError as error:
            reason = f"cannot be read: {explained(error)}"
            raise ShardError(path, reason) from error
        except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            raise ShardError(path, error) from error

    def set_aside(self, path: Path) -> None:
        """Move a damaged shard out of the way; its tasks will be computed again."""
        try:
            self._set_aside.mkdir(exist_ok=True)
            path.replace(self._set_aside / f"{path.parent.name}-{path.name}")
        except OSError as error:
            raise StoreError(
                f"cannot set {path} aside: {explained(error, 'remove it by hand')}"
            ) from error

    def forget(self, key: str) -> None:
        """Remove all shards of one identity, and its checkpoints."""
        shutil.rmtree(self._shards / key, ignore_errors=True)
        for path in _entries(self._checkpoints):
            if path.name.startswith(key):
                path.unlink()

    def forget_set_aside(self) -> None:
        """Remove the shards that were set aside."""
        shutil.rmtree(self._set_aside, ignore_errors=True)

    def size(self) -> int:
        """Bytes in all of its files."""
        return sum(path.stat().st_size for path in self.path.rglob("*") if path.is_file())

    # -- the rest --------------------------------------------------------------------------

    def checkpoint(self, task: Task, key: str) -> Checkpoint:
        """Return the checkpoint of a task of one realization."""
        first = task.realizations[0]
        content = hashlib.sha256(task.pressure_array().tobytes())
        for pressure in task.kept(first):
            content.update(np.float64(pressure).tobytes())
        name = f"{key}-{first}-{content.hexdigest()[:12]}.npz"
        return Checkpoint(self._checkpoints.absolute() / name)

    def unfinished(self) -> set[str]:
        """Return the keys of all identities that the folder has checkpoints of."""
        return {path.name.partition("-")[0] for path in _entries(self._checkpoints)}

    def write_request(self, request: dict[str, Any]) -> None:
        """Note what the run was asked for, for ``status``."""
        commit(json.dumps(request, indent=1).encode(), self.path / "run.json")

    def write_provenance(self, provenance: dict[str, Any]) -> None:
        """Note where the results file comes from."""
        commit(json.dumps(provenance, indent=1).encode(), self.path / "provenance.json")

    def request(self) -> dict[str, Any]:
        """Return what the last run was asked for; empty if nobody knows."""
        return _json(self.path / "run.json")

    def provenance(self) -> dict[str, Any]:
        """Return where the results file comes from; empty if nobody knows."""
        return _json(self.path / "provenance.json")


def _json(path: Path) -> dict[str, Any]:
    with contextlib.suppress(OSError, ValueError):
        found = json.loads(path.read_bytes())
        return found if isinstance(found, dict) else {}
    return {}


def _entries(folder: Path) -> list[Path]:
    try:
        return list(folder.iterdir())
    except OSError:
        return []


def _shard_name(first: int, last: int, digest: str) -> str:
    return f"{first:06d}-{last:06d}.{digest}.npz"


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _read(path: Path) -> Shard:
    name = _NAME.fullmatch(path.name)
    if name is None:
        raise ValueError("is no shard of roughbench")
    data = path.read_bytes()
    if _digest(data) != name[3]:
        raise ValueError("is damaged: its content does not match the checksum in its name")
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = {key: file[key] for key in file.files}
    meta = json.loads(arrays.pop(_META).tobytes())
    if meta["format"] != FORMAT:
        raise ValueError(f"has the format {meta['format']!r}, not {FORMAT!r}")
    if key_of(meta["identity"]) != path.parent.name:
        raise ValueError("belongs to another computation than the folder it is in")
    pressures = arrays.pop("pressure")
    lengths = {"realization": int(name[2]) - int(name[1]) + 1, "pressure": len(pressures)}
    for key, values in arrays.items():
        suits, wanted = fits(key, values.shape, lengths)
        if not suits or values.dtype not in STORABLE:
            raise ValueError(f"{key} has the shape {values.shape}, not {wanted}")
    if "status" not in arrays:
        raise ValueError("has no status")
    return Shard(
        path,
        int(name[1]),
        pressures,
        arrays,
        meta["identity"],
        str(meta["cell"]),
        dict(meta["usage"]),
    )
