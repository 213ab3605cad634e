"""A file that never refuses a write to a library that could not bear it.

HDF5 ends the process with a segmentation fault when a disk is full while one of its files is
open. It writes into a :class:`Sink` instead, which keeps the first refusal for later and takes
everything after it for written.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import IO, Any


class Sink:
    """What HDF5 needs of a file, without its refusals.

    Parameters
    ----------
    file : binary file
        Open to read and write, and empty.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._refusal: OSError | None = None

    def check(self) -> None:
        """Raise what has been refused, if anything was.

        Raises
        ------
        OSError
        """
        if self._refusal is not None:
            raise self._refusal

    def _attempt(self, action: Callable[[], Any], otherwise: int) -> Any:
        if self._refusal is None:
            try:
                return action()
            except OSError as error:
                # A new one: the traceback would keep HDF5's buffers beyond their end.
                self._refusal = OSError(error.errno, error.strerror or str(error))
        return otherwise

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place."""
        return int(self._attempt(lambda: self._file.seek(offset, whence), offset))

    def tell(self) -> int:
        """Return the place."""
        return int(self._attempt(self._file.tell, 0))

    def write(self, data: Any) -> int:
        """Write at the place."""
        size = memoryview(data).nbytes
        return int(self._attempt(lambda: self._file.write(data), size))

    def readinto(self, buffer: Any) -> int:
        """Read what was written before; zeros after a refusal, when nothing counts any more."""
        size = memoryview(buffer).nbytes
        found = int(self._attempt(lambda: self._file.readinto(buffer), -1))  # type: ignore[attr-defined]
        if found < 0:
            memoryview(buffer).cast("B")[:] = bytes(size)
        return size if found < 0 else found

    def read(self, size: int = -1) -> bytes:
        """Read what was written before."""
        return bytes(self._attempt(lambda: self._file.read(size), max(0, size)))

    def truncate(self, size: int) -> int:
        """Cut or lengthen the file."""
        return int(self._attempt(lambda: self._file.truncate(size), size))

    def flush(self) -> None:
        """Hand everything to the system."""
        self._attempt(self._file.flush, 0)
