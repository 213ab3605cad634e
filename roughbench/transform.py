"""Real Fourier transforms in place: the only place that plans FFTs.

Plans are measured once per machine, shape, precision and thread count, and kept as
FFTW wisdom in the user's cache folder (``ROUGHBENCH_CACHE``, or
``$XDG_CACHE_HOME/roughbench``, or ``~/.cache/roughbench``): two measurements may choose
plans that differ in the last bit of their results, a kept one cannot.
"""

from __future__ import annotations

import base64
import contextlib
import fcntl
import functools
import json
import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


@functools.cache
def _fftw() -> ModuleType:
    """Import pyFFTW with an OpenMP runtime whose idle threads sleep.

    Its default is to spin after each transform, on the cores that the loops between
    the transforms need: that costs up to a factor of four. The runtime reads the
    variable once, when it loads.
    """
    before = os.environ.get("OMP_WAIT_POLICY")
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    try:
        import pyfftw
    finally:
        if before is None:
            del os.environ["OMP_WAIT_POLICY"]
    return pyfftw


def cache_folder() -> Path:
    """Folder for what is measured once per machine."""
    own = os.environ.get("ROUGHBENCH_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "roughbench"


_planned: set[tuple[tuple[int, int], str, int, Path]] = set()


class RealTransform:
    """One buffer that holds a real field or, after :meth:`forward`, its transform.

    Parameters
    ----------
    shape : tuple of int
        Shape (n, m) of the real field; (1, m) for a line.
    dtype : dtype
        float32 or float64.
    threads : int
        Threads of one transform over a surface.

    Attributes
    ----------
    real : ndarray of ``dtype``, shape (n, m)
        The real field; a view into the buffer, with padded rows.
    spectral : ndarray of complex, shape (n, m // 2 + 1)
        The half spectrum; a view into the same memory.
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike, threads: int = 1) -> None:
        fftw = _fftw()
        n, m = shape
        self.shape = shape
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        spectral_dtype = np.result_type(self.dtype, np.complex64)
        self.spectral: NDArray[Any] = fftw.empty_aligned((n, m // 2 + 1), spectral_dtype)
        self.real: NDArray[Any] = self.spectral.view(self.dtype)[:, :m]
        # A line is a transform over its one long axis; more threads only cost there.
        axes = (1,) if n == 1 else (0, 1)
        threads = 1 if n == 1 else threads
        options = {"axes": axes, "flags": ("FFTW_MEASURE",), "threads": threads}
        key = (shape, self.dtype.char, threads, cache_folder())
        # FFTW remembers the plans of this process by itself.
        with contextlib.nullcontext() if key in _planned else _kept_wisdom(fftw):
            self._forward = fftw.FFTW(self.real, self.spectral, **options)
            self._backward = fftw.FFTW(
                self.spectral, self.real, direction="FFTW_BACKWARD", **options
            )
        _planned.add(key)
        self.spectral[...] = 0.0

    def forward(self) -> None:
        """Replace the real field by its half spectrum, Σ f e^{-iqx}."""
        self._forward.execute()

    def backward(self) -> None:
        """Replace the half spectrum by the real field, not divided by n·m."""
        self._backward.execute()


@contextlib.contextmanager
def _kept_wisdom(fftw: ModuleType) -> Iterator[None]:
    """Plan with the wisdom of earlier plans, and add what this one learns to it.

    The lock makes processes that start together measure one after the other, so that
    all of them use the first one's plans. Without a writable cache folder the plans
    are still measured, only not kept.
    """
    try:
        folder = cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / "fftw-wisdom.lock").open("w")
    except OSError:
        yield
        return
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        path = folder / "fftw-wisdom.json"
        kept = _read_wisdom(path)
        if kept is not None:
            fftw.import_wisdom(kept)
        yield
        learned = fftw.export_wisdom()
        if learned != kept:
            text = json.dumps([base64.b64encode(part).decode("ascii") for part in learned])
            partial = path.with_suffix(f".{os.getpid()}.tmp")
            try:
                partial.write_text(text)
                partial.replace(path)
            except OSError:  # a full disk: the plans hold for this process
                with contextlib.suppress(OSError):
                    partial.unlink()


def _read_wisdom(path: Path) -> tuple[bytes, ...] | None:
    """Kept wisdom, or None where there is none that can be read."""
    try:
        double, single, extended = (
            base64.b64decode(part) for part in json.loads(path.read_text())
        )
    except (OSError, ValueError, TypeError):
        return None
    return double, single, extended
