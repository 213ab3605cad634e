"""Real Fourier transforms in place: the only place that plans FFTs.

By FFTW, through pyFFTW, where that can be imported; by SciPy where it cannot, or where
``ROUGHBENCH_FFT`` says so (:mod:`roughbench.transform.backend`). FFTW's plans are measured once
per machine, shape, precision and thread count, and kept as its wisdom in the user's cache
folder (``ROUGHBENCH_CACHE``, or ``$XDG_CACHE_HOME/roughbench``, or ``~/.cache/roughbench``):
two measurements may choose plans that differ in the last bit of their results, a kept one
cannot. What takes long, to measure or to wait for another process that measures, is said once
in the log of the run. SciPy measures nothing.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.transform.backend import Backend, fft_backend
from roughbench.transform.plans import Plan, empty, make_plan, planning
from roughbench.transform.wisdom import cache_folder

__all__ = ["FEWEST_POINTS", "Backend", "RealTransform", "cache_folder", "fft_backend", "slices"]

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
        n, m = shape
        self.shape = shape
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        spectral_dtype = np.result_type(self.dtype, np.complex64)
        self.spectral: NDArray[Any] = empty((n, m // 2 + 1), spectral_dtype)
        self.real: NDArray[Any] = self.spectral.view(self.dtype)[:, :m]
        # A line is a transform over its one long axis; more threads only cost there.
        threads = threads if n > 1 and n * m >= FEWEST_POINTS else 1
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        rows = slices(n, threads, 1)
        columns = slices(m // 2 + 1, threads, _CACHE_LINE // spectral_dtype.itemsize)
        real, spectral = self.real, self.spectral
        with planning(shape, (*shape, self.dtype.char, threads)):
            self._steps: dict[str, list[Plan]] = {
                "rows": [make_plan(real[b], spectral[b], 1) for b in rows],
                "rows back": [make_plan(spectral[b], real[b], 1, back=True) for b in rows],
            }
            if n > 1:
                parts = [spectral[:, b] for b in columns]
                self._steps["columns"] = [make_plan(b, b, 0) for b in parts]
                self._steps["columns back"] = [make_plan(b, b, 0, back=True) for b in parts]
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
        """Transform all slices of one step, one in this thread, the others beside it."""
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


def slices(count: int, threads: int, unit: int) -> list[slice]:
    """Cut a range into one slice for each thread, at multiples of a unit."""
    ends = [count * k // threads // unit * unit for k in range(1, threads)]
    return [slice(a, b) for a, b in itertools.pairwise([0, *ends, count])]
