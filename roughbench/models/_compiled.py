"""Loops that Numba compiles once and keeps, and that a damaged file never harms.

Numba's own cache trusts its files: a damaged one ends every later run, some by a segmentation
fault, and two processes that compile different types at once may write to the same file. Here
each version of a loop has a file of its own that begins with a checksum; what is not whole, or
of another source, Numba or processor, is compiled again and replaced. Where nothing can be
written or read the loops are compiled by every process.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numba

from roughbench.models.compilation import tell_compiling
from roughbench.publish import publish

try:
    from numba.core.caching import FunctionCache
    from numba.core.serialize import dumps
except ImportError:  # of a Numba that is built otherwise: without a cache
    FunctionCache = object

_FORMAT = 2
_DIGEST = hashlib.sha256


def compiled(
    *, sources: Sequence[Path] = (), **options: Any
) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function on its first call, and keeps it.

    Parameters
    ----------
    sources : sequence of Path
        Modules, beside that of the function, whose constants and inlined functions are
        compiled into it: where one has changed, it is compiled again.
    **options
        Of :func:`numba.njit`, without ``cache``.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(**options)(function)
        with contextlib.suppress(Exception):  # no place for files, or another Numba
            dispatcher._cache = _CheckedCache(function, sources)  # noqa: SLF001  (as Numba)
        return dispatcher

    return decorate


class _CheckedCache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of one function, with files that are checked; trouble means: compile."""

    def __init__(self, function: Callable[..., Any], sources: Sequence[Path]) -> None:
        super().__init__(function)
        # Not their times and sizes, as Numba takes: two versions may agree in both.
        texts = [_DIGEST(path.read_bytes()).digest() for path in (_file_of(function), *sources)]
        self._cache_file = _CheckedFiles(
            Path(self.cache_path),
            self._impl.filename_base,
            (_FORMAT, numba.__version__, *texts),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        found = None
        with contextlib.suppress(Exception):
            found = super().load_overload(sig, target_context)
        if found is None:
            tell_compiling()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        with contextlib.suppress(Exception):
            super().save_overload(sig, data)


def _file_of(function: Callable[..., Any]) -> Path:
    return Path(function.__code__.co_filename)


class _CheckedFiles:
    """A file for each version of a function: checksum, then what it is of, then machine code.

    Parameters
    ----------
    folder : Path
    base : str
        Begin of the names.
    origin : tuple
        What a file has to be of: format, version of Numba, the sources' digests.
    """

    def __init__(self, folder: Path, base: str, origin: tuple[object, ...]) -> None:
        self._folder = folder
        self._base = base
        self._origin = repr(origin)

    def load(self, key: object) -> Any:
        """Return what was kept under a key: types, processor, bytecode; None for nothing."""
        content = self._path(key).read_bytes()
        size = _DIGEST().digest_size
        if _DIGEST(content[size:]).digest() != content[:size]:
            return None
        origin, of, data = pickle.loads(content[size:])  # noqa: S301  (as Numba does)
        return data if (origin, of) == (self._origin, repr(key)) else None

    def save(self, key: object, data: object) -> None:
        """Keep something under a key, in one step."""
        content = dumps((self._origin, repr(key), data))
        path = self._path(key)
        publish(lambda file: file.write(_DIGEST(content).digest() + content), path)

    def flush(self) -> None:
        """Remove everything."""
        for path in self._folder.glob(f"{self._base}.*.loop"):
            path.unlink(missing_ok=True)

    def _path(self, key: object) -> Path:
        name = hashlib.sha256(repr(key).encode()).hexdigest()[:16]
        return self._folder / f"{self._base}.{name}.loop"
