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
    ``shares/``          who computes which share, and their logs
    ``jobs/``            what was submitted to a batch system

The shards are the truth (:mod:`roughbench.rundir.shards`); all else may be deleted. Every file
is published in one step and carries its checksum.
"""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from roughbench.errors import LockedError, StoreError, explained
from roughbench.planning.shares import Share
from roughbench.planning.tasks import Block, Task
from roughbench.publish import refusals_named, remove_leftovers, temporary_of
from roughbench.rundir.checkpoint import Checkpoint, checkpoint_name
from roughbench.rundir.identity import Identity, key_of
from roughbench.rundir.lock import FolderLock
from roughbench.rundir.notes import read_note, write_note
from roughbench.rundir.shards import Shard, read_identity, read_shard, write_shard
from roughbench.rundir.usage import Usage
from roughbench.seal import sha256_of

SUFFIX = ".rbrun"
_GLANCES, _PAUSE, _MOST_NAMED = 20, 0.1, 10


def folder_of(results: str | os.PathLike[str]) -> Path:
    """Return the run directory of a results file.

    Examples
    --------
    >>> folder_of("results/quick.h5").as_posix()
    'results/quick.h5.rbrun'
    """
    path = Path(results)
    return path.with_name(path.name + SUFFIX)


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
        self._lock = FolderLock(self.path)
        self._shards = self.path / "shards"
        self._checkpoints = self.path / "checkpoints"
        self._set_aside = self.path / "set-aside"

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
            file = self._lock.take(command)
            for folder in (self._shards, self._checkpoints):
                folder.mkdir(exist_ok=True)
            with contextlib.suppress(FileNotFoundError):  # too long a path is said now
                temporary_of(self._shards / ("0" * 20) / f"000000-000000.{'0' * 16}.npz").stat()
        except OSError as error:
            raise StoreError(
                f"cannot write {self.path}: {explained(error, 'choose another place with -o')}"
            ) from error
        with _given_back(file):
            if others := self.shares():
                shown = ", ".join(others[:_MOST_NAMED]) + ", …" * (len(others) > _MOST_NAMED)
                raise LockedError(
                    f"shares are being computed in {self.path}: {shown}; wait for them or stop "
                    "them, or choose another results file with -o"
                )
            self._remove_leftovers()
            yield

    @contextlib.contextmanager
    def shared(self, share: Share, command: str) -> Iterator[None]:
        """Make the folder and join those that compute other shares of the same plan.

        Keeps out whoever computes the same share, and a run of everything; what a killed
        process has left, and what is damaged, stays for the next such run.

        Raises
        ------
        LockedError
            If another process computes this share, or a run is in the folder.
        StoreError
            As :meth:`locked`.
        """
        try:
            file = self._lock_of(share_name(share)).take(command)
            for folder in (self._shards, self._checkpoints):
                folder.mkdir(exist_ok=True)
        except OSError as error:
            raise StoreError(
                f"cannot write {self.path}: {explained(error, 'choose another place with -o')}"
            ) from error
        with _given_back(file):
            for attempt in range(_GLANCES):  # many shares that start together look there
                time.sleep(_PAUSE * random.random() * (attempt > 0))  # noqa: S311
                if not self.holder():
                    break
            else:
                raise LockedError(self._lock.refusal())
            yield

    def share_log(self, share: Share) -> Path:
        """Return the log of a share."""
        return self.path / "shares" / f"{share_name(share)}.log"

    def shares(self) -> list[str]:
        """Return the shares that are being computed, such as ``3/40``."""
        places = [path for path in _entries(self.path / "shares") if path.suffix == ".lock"]
        return [
            "/".join(str(int(part)) for part in path.stem.split("-of-"))
            for path in sorted(places)
            if self._lock_of(path.stem).holder()
        ]

    def _lock_of(self, share: str) -> FolderLock:
        return FolderLock(self.path, f"shares/{share}.lock")

    def holder(self) -> dict[str, Any]:
        """Return what the run in the folder says of itself; empty for none."""
        return self._lock.holder()

    def _remove_leftovers(self) -> None:
        remove_leftovers(self.results)
        with contextlib.suppress(OSError):
            for leftover in self.path.rglob(".*.tmp"):
                leftover.unlink()

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

    def write(self, task: Task, block: Block, identity: Identity, usage: Usage) -> Shard:
        """Commit a finished task: when this returns, nothing short of a broken disk takes it.

        Raises
        ------
        StoreError
            If the system refuses.
        """
        folder = self._shards / key_of(identity)
        with refusals_named(folder):
            folder.mkdir(exist_ok=True)
            return write_shard(folder, task, block, identity, usage)

    def read(self, path: Path) -> Shard:
        """Return what is in a shard.

        Raises
        ------
        ShardError
            If it is damaged, or no shard of this folder: never a wrong number.
        """
        return read_shard(path)

    def identity(self, key: str) -> Identity | None:
        """Return the identity that a key stands for, for words only; None if unclear."""
        found = (read_identity(path) for path in self.shards(key))
        return next((identity for identity in found if identity is not None), None)

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

    def checkpoint(self, task: Task, key: str) -> Checkpoint:
        """Return the checkpoint of a task of one realization."""
        first = task.realizations[0]
        name = checkpoint_name(key, first, task.pressures, task.kept(first))
        return Checkpoint(self._checkpoints.absolute() / name)

    def drop_checkpoints(self, key: str, shards: Sequence[Shard]) -> None:
        """Remove what a kill has left of tasks that are committed."""
        committed = {
            checkpoint_name(
                key,
                shard.realizations[0],
                shard.pressures.tolist(),
                [pressure for _, pressure in shard.kept],
            )
            for shard in shards
            if len(shard.realizations) == 1
        }
        for path in _entries(self._checkpoints):
            if path.name in committed:
                Checkpoint(path).remove()

    def unfinished(self) -> set[str]:
        """Return the keys of all identities that the folder has checkpoints of."""
        return {path.name.partition("-")[0] for path in _entries(self._checkpoints)}

    def write_request(self, request: dict[str, Any]) -> None:
        """Note what the run was asked for, for ``status``."""
        write_note(request, self.path / "run.json")

    def write_provenance(self, provenance: dict[str, Any]) -> None:
        """Note where the results file comes from."""
        write_note(provenance, self.path / "provenance.json")

    def request(self) -> dict[str, Any]:
        """Return what the last run was asked for; empty if nobody knows."""
        return read_note(self.path / "run.json")

    def has_its_results(self) -> bool:
        """Whether the results file is there, and the one that the last run has written."""
        known = self.provenance().get("results_sha256")
        try:
            return known is not None and sha256_of(self.results) == known
        except OSError:
            return False

    def provenance(self) -> dict[str, Any]:
        """Return where the results file comes from; empty if nobody knows."""
        return read_note(self.path / "provenance.json")


def share_name(share: Share) -> str:
    """Return what the files of a share are called.

    Examples
    --------
    >>> from roughbench.planning.shares import Share
    >>> share_name(Share(3, 40))
    '03-of-40'
    """
    return f"{share.number:0{len(str(share.count))}d}-of-{share.count}"


@contextlib.contextmanager
def _given_back(file: IO[str]) -> Iterator[None]:
    """Empty and close the file of a lock in the end."""
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            file.truncate(0)
        file.close()


def _entries(folder: Path) -> list[Path]:
    """Return what is in a folder; nothing if there is none.

    Raises
    ------
    StoreError
        If it is there and cannot be read: what is in it is not gone.
    """
    try:
        return list(folder.iterdir())
    except FileNotFoundError:
        return []
    except OSError as error:
        raise StoreError(
            f"cannot read the folder {folder}: "
            f"{explained(error, 'or remove it to compute its content again')}"
        ) from error
