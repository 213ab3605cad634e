"""The finished states of a long curve, kept so that a kill costs no more than one.

A checkpoint is scratch: it is there from the first states of a curve until the shard of
the whole curve is. It ends with its checksum and knows its name; with any trouble, it is none,
which only costs time.
"""

from __future__ import annotations

import contextlib
import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib.npyio import NpzFile
from numpy.typing import NDArray

from roughbench.publish import publish
from roughbench.rundir.archive import write_arrays
from roughbench.seal import check_seal, seal_file

SECONDS_BETWEEN = 10.0
"""A state that took less is not worth a checkpoint of its own."""
COST = 0.05
"""Largest share of the time that goes into writing them."""

_DONE, _NAME = "roughbench_done", "roughbench_name"


@dataclass(slots=True)
class Checkpoint:
    """A file with the latest snapshot of one curve.

    Parameters
    ----------
    path : Path
        In a folder that exists.
    """

    path: Path
    _last: float = field(default_factory=time.monotonic)
    _cost: float = 0.0

    def offer(self, done: int, snapshot: Callable[[], Mapping[str, NDArray[Any]]]) -> None:
        """Keep a snapshot after ``done`` states, if it is time for one.

        A disk that is full or gone does not end the computation: it goes on without.
        """
        now = time.monotonic()
        if now - self._last < max(SECONDS_BETWEEN, self._cost / COST):
            return
        arrays = {_DONE: np.array(done), _NAME: self._name(), **snapshot()}

        def write(file: IO[bytes]) -> None:
            write_arrays(file, arrays)
            seal_file(file)

        with contextlib.suppress(OSError):
            publish(write, self.path)
        self._last = time.monotonic()
        self._cost = self._last - now

    def load(self) -> tuple[int, Mapping[str, NDArray[Any]]] | None:
        """Return the number of finished states and the snapshot, or None for none."""
        with contextlib.suppress(Exception), self._opened() as file:
            arrays = {name: file[name] for name in file.files}
            if np.array_equal(arrays.pop(_NAME), self._name()):
                return int(arrays.pop(_DONE)), arrays
        return None

    def done(self) -> int:
        """Return the number of states that a kill would not cost."""
        with contextlib.suppress(Exception), self._opened() as file:
            if np.array_equal(file[_NAME], self._name()):
                return int(file[_DONE])
        return 0

    @contextlib.contextmanager
    def _opened(self) -> Iterator[NpzFile]:
        with self.path.open("rb") as raw:
            check_seal(raw)
            raw.seek(0)
            with np.load(raw, allow_pickle=False) as file:
                yield file

    def _name(self) -> NDArray[np.uint8]:
        return np.frombuffer(self.path.name.encode(), np.uint8)

    def remove(self) -> None:
        """Remove the file, if there is one."""
        with contextlib.suppress(OSError):
            self.path.unlink()


def checkpoint_name(
    key: str, realization: int, pressures: Sequence[float], kept: Sequence[float]
) -> str:
    """Return the name of the file for a realization at these pressures, with kept fields."""
    content = hashlib.sha256(np.array([*pressures, *kept], np.float64).tobytes())
    return f"{key}-{realization}-{content.hexdigest()[:12]}.npz"
