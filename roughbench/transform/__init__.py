"""Real Fourier transforms in place: the only place that plans FFTs.

Plans are measured once per machine, shape, precision and thread count, and kept as
FFTW wisdom in the user's cache folder (``ROUGHBENCH_CACHE``, or
``$XDG_CACHE_HOME/roughbench``, or ``~/.cache/roughbench``): two measurements may choose
plans that differ in the last bit of their results, a kept one cannot. What takes long, to
measure or to wait for another process that measures, is said once in the log of the run.
"""

from __future__ import annotations

import base64
import contextlib
import itertools
import json
import logging
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.locks import open_lock, show_life, wait_for_lock
from roughbench.publish import publish


def cache_folder() -> Path:
    """Folder for what is measured once per machine."""
    own = os.environ.get("ROUGHBENCH_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "roughbench"


_log = logging.getLogger("roughbench.run.plans")
_planned: set[tuple[tuple[int, ...], str, int, Path]] = set()
_said: set[str] = set()
"""What this process has said already, or given up: once is enough."""

SILENCE = 3.0
"""Seconds that nothing is said; most plans take less than one, one for a line minutes."""
PATIENCE = 30.0
"""Seconds to wait for a process that keeps the plans locked and does not measure any."""

FEWEST_POINTS = 1 << 17
"""From here on threads gain more than their hand-over costs."""
_CACHE_LINE = 64


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

    Notes
    -----
    Each thread transforms a block of rows, then one of columns. FFTW has threads of its
    own, but leaves them idle for half of the time where the grid is large: a pair at 16384²
    takes 1.75 s with them and 1.37 s this way, and its plan 37 s instead of 14. Up to 8192²
    both take the same.
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike, threads: int = 1) -> None:
        import pyfftw

        n, m = shape
        self.shape = shape
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        spectral_dtype = np.result_type(self.dtype, np.complex64)
        self.spectral: NDArray[Any] = pyfftw.empty_aligned((n, m // 2 + 1), spectral_dtype)
        self.real: NDArray[Any] = self.spectral.view(self.dtype)[:, :m]
        # A line is a transform over its one long axis; more threads only cost there.
        threads = threads if n > 1 and n * m >= FEWEST_POINTS else 1
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        rows = _blocks(n, threads, 1)
        columns = _blocks(m // 2 + 1, threads, _CACHE_LINE // spectral_dtype.itemsize)
        real, spectral = self.real, self.spectral
        key = (shape, self.dtype.char, threads, cache_folder())
        # FFTW remembers the plans of this process by itself.
        with contextlib.nullcontext() if key in _planned else _kept_wisdom(pyfftw, shape):
            self._steps = {
                "rows": [_plan(real[b], spectral[b], 1) for b in rows],
                "rows back": [_plan(spectral[b], real[b], 1, back=True) for b in rows],
            }
            if n > 1:
                blocks = [spectral[:, b] for b in columns]
                self._steps["columns"] = [_plan(b, b, 0) for b in blocks]
                self._steps["columns back"] = [_plan(b, b, 0, back=True) for b in blocks]
        _planned.add(key)
        self.spectral[...] = 0.0

    def forward(self) -> None:
        """Replace the real field by its half spectrum, Σ f e^{-iqx}."""
        self._execute("rows")
        self._execute("columns")

    def backward(self) -> None:
        """Replace the half spectrum by the real field, not divided by n·m."""
        self._execute("columns back")
        self._execute("rows back")

    def _execute(self, step: str) -> None:
        """Transform all blocks of one step, one in this thread, the others beside it."""
        plans = self._steps.get(step)
        if plans is None:
            return
        if self._pool is None:
            plans[0].execute()
            return
        others = [self._pool.submit(plan.execute) for plan in plans[1:]]
        plans[0].execute()
        for other in others:
            other.result()


def _plan(source: NDArray[Any], target: NDArray[Any], axis: int, *, back: bool = False) -> Any:
    import pyfftw

    return pyfftw.FFTW(
        source,
        target,
        axes=(axis,),
        direction="FFTW_BACKWARD" if back else "FFTW_FORWARD",
        flags=("FFTW_MEASURE",),
        threads=1,
    )


def _blocks(count: int, threads: int, unit: int) -> list[slice]:
    """Cut a range into one slice for each thread, at multiples of a unit."""
    ends = [count * k // threads // unit * unit for k in range(1, threads)]
    return [slice(a, b) for a, b in itertools.pairwise([0, *ends, count])]


@contextlib.contextmanager
def _kept_wisdom(fftw: ModuleType, shape: tuple[int, int]) -> Iterator[None]:
    """Plan with the wisdom of earlier plans, and add what this one learns to it.

    A lock makes processes that start together measure one after the other, so that all of
    them use the first one's plans. Where the file system knows no locks they may measure
    at once, and one's plans are kept. Without a writable cache folder, and where another
    process keeps the lock for too long, the plans are measured all the same, only not kept.
    """
    folder = cache_folder()
    path = folder / "fftw-wisdom.json"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = open_lock(folder / "fftw-wisdom.lock")
    except OSError:
        with _planning(shape, None):
            yield
        return
    try:
        mine = _wait_for(lock, folder) is not False
        kept = _read_wisdom(path)
        if kept is not None:
            fftw.import_wisdom(kept)
        with _planning(shape, lock if mine else None):
            yield
        learned = fftw.export_wisdom()
        if mine and learned != kept:
            text = json.dumps([base64.b64encode(part).decode("ascii") for part in learned])
            with contextlib.suppress(OSError):  # a full disk: they hold for this process
                publish(lambda file: file.write(text.encode()), path)
    finally:
        os.close(lock)  # and with it the lock


def _wait_for(lock: int, folder: Path) -> bool | None:
    """Wait for the lock on the kept plans; only once for one that nobody lets go of."""
    place = str(folder)
    held = wait_for_lock(
        lock,
        0.0 if f"gave up {place}" in _said else PATIENCE,
        SILENCE,
        lambda: _say(
            f"waiting {place}",
            f"waiting for another process that measures FFTW's plans ({folder}); if it does "
            f"not go on, for {PATIENCE:.0f} s",
        ),
    )
    if held is False:
        _say(
            f"gave up {place}",
            f"another process keeps {folder / 'fftw-wisdom.lock'} locked; going on with plans "
            "of this one's own, which are not kept and may change the last digits of results",
        )
    return held


@contextlib.contextmanager
def _planning(shape: tuple[int, int], lock: int | None) -> Iterator[None]:
    """Plan; meanwhile say that it takes long, and show those who wait that it goes on."""
    planned = threading.Event()
    size = " × ".join(str(n) for n in shape if n > 1)

    def watch() -> None:
        while not planned.wait(SILENCE):
            if lock is not None:
                show_life(lock)
            _say(
                "measuring",
                f"measuring FFTW's plans for {size} points, once on this machine; that can "
                "take minutes for long lines",
            )

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        planned.set()
        thread.join()


def _say(what: str, text: str) -> None:
    if what not in _said:
        _said.add(what)
        _log.warning(text)


def _read_wisdom(path: Path) -> tuple[bytes, ...] | None:
    """Kept wisdom, or None where there is none that can be read."""
    try:
        double, single, extended = (
            base64.b64decode(part) for part in json.loads(path.read_text())
        )
    except (OSError, ValueError, TypeError):
        return None
    return double, single, extended
