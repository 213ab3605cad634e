"""Convolution without a period: padded with zeros, of which only some are stored."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.transform import FEWEST_POINTS, slices
from roughbench.transform.plans import empty, make_plan, planning

WORK = 1 << 18
"""Bytes of columns that are transformed at a time: they stay in the second cache."""

Multiply = Callable[[NDArray[Any], int], None]
"""Multiplies columns of the spectrum, the first of which has this number, in place."""


class PaddedConvolution:
    """One field, convolved in place with a kernel on a grid of twice its size.

    The field has n rows; the n rows of zeros below it are never stored. Its rows are
    transformed first, padded with zeros to twice their length. Of the columns a few at a
    time are then padded, transformed, multiplied and transformed back, and the half that
    is wanted is kept.

    Parameters
    ----------
    shape : (int, int)
        Shape (n, m) of the field.
    period : (int, int)
        Even numbers of at least 2n − 1 and 2m − 1: what is padded to.
    dtype : dtype
        float32 or float64.
    threads : int
        Threads of one convolution.

    Attributes
    ----------
    real : ndarray of ``dtype``, shape (n, m)
        The field; a view into rows of twice the length.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        period: tuple[int, int],
        dtype: DTypeLike,
        threads: int = 1,
    ) -> None:
        n, m = shape
        self.period = period
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        spectral_dtype = np.result_type(self.dtype, np.complex64)
        n_columns = period[1] // 2 + 1
        self._spectral: NDArray[Any] = empty((n, n_columns), spectral_dtype)
        self._padded: NDArray[Any] = self._spectral.view(self.dtype)[:, : period[1]]
        self.real: NDArray[Any] = self._padded[:, :m]
        threads = threads if n * m >= FEWEST_POINTS else 1
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None
        self._rows = slices(n, threads, 1)
        at_once = min(max(WORK // (period[0] * spectral_dtype.itemsize) // 8 * 8, 8), 64)
        self._columns = slices(n_columns, threads, at_once)
        self._work = [empty((period[0], at_once), spectral_dtype) for _ in self._columns]
        with planning(shape, (*shape, *period, self.dtype.char, threads)):
            padded, spectral = self._padded, self._spectral
            self._forth = [make_plan(padded[b], spectral[b], 1) for b in self._rows]
            self._back = [make_plan(spectral[b], padded[b], 1, back=True) for b in self._rows]
            self._down = [make_plan(work, work, 0) for work in self._work]
            self._up = [make_plan(work, work, 0, back=True) for work in self._work]
        for work in self._work:
            work[...] = 0.0
        self._spectral[...] = 0.0

    def apply(self, multiply: Multiply) -> None:
        """Replace the field by its convolution, times the number of points of the period.

        Parameters
        ----------
        multiply : callable
            Multiplies columns of the spectrum (period[0] rows) by the kernel's, in place.
        """
        self._each(self._transform_rows)
        self._each(lambda k: self._convolve_columns(k, multiply))
        self._each(lambda k: self._back[k].execute())

    def _transform_rows(self, k: int) -> None:
        self._padded[self._rows[k], self.real.shape[1] :] = 0.0
        self._forth[k].execute()

    def _convolve_columns(self, k: int, multiply: Multiply) -> None:
        work, columns = self._work[k], self._columns[k]
        n = self.real.shape[0]
        for first in range(columns.start, columns.stop, work.shape[1]):
            here = self._spectral[:, first : min(first + work.shape[1], columns.stop)]
            width = here.shape[1]
            work[:n, :width] = here
            work[n:] = 0.0
            self._down[k].execute()
            multiply(work[:, :width], first)
            self._up[k].execute()
            here[...] = work[:n, :width]

    def _each(self, step: Callable[[int], object]) -> None:
        """Do one step for the blocks of all threads, the last in this one."""
        last = len(self._rows) - 1
        if self._pool is None:
            step(last)
            return
        others = [self._pool.submit(step, k) for k in range(last)]
        step(last)
        for other in others:
            other.result()
