"""Archives of arrays: NumPy's own to the byte, and nothing left open where the disk ends."""

from __future__ import annotations

import gc
import io
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.rundir.archive import write_arrays

ARRAYS: dict[str, NDArray[Any]] = {
    "roughbench": np.frombuffer(b'{"format": 1}', np.uint8),
    "pressure": np.array([1e-4, 1e-3]),
    "area": np.arange(6.0).reshape(2, 3),
    "status": np.zeros((2, 3), np.int32),
    "transposed": np.arange(6.0).reshape(2, 3).T,
    "strided": np.arange(12.0, dtype=np.float32)[::2],
    "none": np.empty((0, 3)),
    "number": np.array(5),
    "ξ is a name": np.array([True, False]),
}


def test_the_bytes_are_those_of_savez() -> None:
    ours, numpys = io.BytesIO(), io.BytesIO()
    write_arrays(ours, ARRAYS)
    np.savez(numpys, **ARRAYS)  # type: ignore[arg-type]
    assert ours.getvalue() == numpys.getvalue()


class Disk(io.BytesIO):
    """Has room for so many bytes."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, data: Any) -> int:
        """Write, or refuse."""
        if self.tell() + memoryview(data).nbytes > self.room:
            raise OSError(28, "No space left on device")
        return super().write(data)


def test_a_disk_that_is_full_anywhere_is_one_error(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = io.BytesIO()
    write_arrays(whole, ARRAYS)
    ignored: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)
    for room in range(0, whole.tell(), 7):
        with pytest.raises(OSError, match="No space left"):
            write_arrays(Disk(room), ARRAYS)
    gc.collect()
    assert ignored == []
    write_arrays(Disk(whole.tell()), ARRAYS)
