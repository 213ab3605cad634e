"""One transform along one axis, prepared once and executed often, by either library."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Hashable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from roughbench.transform.backend import fft_backend
from roughbench.transform.wisdom import cache_folder, kept_wisdom

SCIPY_WORK = 1 << 18
"""Bytes that SciPy transforms at a time: it makes an array of its own for them."""

_planned: set[tuple[Hashable, Path]] = set()


class Plan(Protocol):
    """What transforms one array into another, not divided by the number of points."""

    def execute(self) -> object:
        """Transform what is in the arrays now."""


def empty(shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an array as the library likes it, its values undefined."""
    if fft_backend() == "scipy":
        return np.empty(shape, dtype)
    import pyfftw

    return pyfftw.empty_aligned(shape, dtype)


def planning(shape: tuple[int, int], key: Hashable) -> AbstractContextManager[None]:
    """Return what plans are to be made within: FFTW measures those it does not know.

    Parameters
    ----------
    shape : (int, int)
        For words: how large it is.
    key : hashable
        What is planned; FFTW remembers the plans of this process by itself.
    """
    planned = key, cache_folder()
    if fft_backend() == "scipy" or planned in _planned:
        return contextlib.nullcontext()
    return _first_planning(shape, planned)


@contextlib.contextmanager
def _first_planning(shape: tuple[int, int], planned: tuple[Hashable, Path]) -> Iterator[None]:
    with kept_wisdom(shape):
        yield
    _planned.add(planned)


def make_plan(
    source: NDArray[Any], target: NDArray[Any], axis: int, *, back: bool = False
) -> Plan:
    """Prepare a transform along one axis of two dimensions; what is in the arrays is lost.

    Parameters
    ----------
    source, target : ndarray of float or complex
        They may share their memory. Real rows belong to half spectra.
    axis : {0, 1}
        0 for complex columns only.
    back : bool
        Inverse, with the sign + in the exponent.
    """
    if fft_backend() == "scipy":
        return _ScipyPlan(source, target, axis, back=back)
    import pyfftw

    plan: Plan = pyfftw.FFTW(
        source,
        target,
        axes=(axis,),
        direction="FFTW_BACKWARD" if back else "FFTW_FORWARD",
        flags=("FFTW_MEASURE",),
        threads=1,
    )
    return plan


class _ScipyPlan:
    """As :func:`make_plan`, some rows or columns at a time."""

    def __init__(
        self, source: NDArray[Any], target: NDArray[Any], axis: int, *, back: bool
    ) -> None:
        self._transform = _scipy_transform(source, target, axis, back=back)
        across = source.shape[1 - axis]
        bytes_of_one = max(1, source.nbytes // max(1, across))
        at_once = max(8, SCIPY_WORK // bytes_of_one)
        parts = [slice(first, first + at_once) for first in range(0, across, at_once)]
        self._pairs = [
            (source[part], target[part]) if axis == 1 else (source[:, part], target[:, part])
            for part in parts
        ]

    def execute(self) -> None:
        """Transform what is in the arrays now."""
        for source, target in self._pairs:
            target[...] = self._transform(source)


def _scipy_transform(
    source: NDArray[Any], target: NDArray[Any], axis: int, *, back: bool
) -> Callable[[NDArray[Any]], NDArray[Any]]:
    from scipy import fft

    if source.dtype.kind == "f":
        return lambda values: fft.rfft(values, axis=axis)
    if target.dtype.kind == "f":
        points = target.shape[axis]
        return lambda values: fft.irfft(values, points, axis=axis, norm="forward")
    if back:
        return lambda values: fft.ifft(values, axis=axis, norm="forward", overwrite_x=True)
    return lambda values: fft.fft(values, axis=axis, overwrite_x=True)
