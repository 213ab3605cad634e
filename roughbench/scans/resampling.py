"""Scans on another grid: square pixels, or as many points as wanted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

FloatArray = NDArray[np.float64]


def square_grid(
    shape: tuple[int, int], size: tuple[float, float], points: int | None = None
) -> tuple[int, int]:
    """Return the grid of square pixels for a scan.

    Without a wish it has the smaller spacing of the two directions, so that no wave is lost.
    Both sides are whole numbers of pixels only by chance: the second one is rounded.

    Parameters
    ----------
    shape : (int, int)
        Points along (y, x).
    size : (float, float)
        Along (y, x).
    points : int, optional
        Points along the longer side.

    Examples
    --------
    >>> square_grid((100, 200), (1.0, 1.0)), square_grid((100, 100), (1.0, 2.0), 50)
    ((200, 200), (25, 50))
    """
    if points is not None:
        spacing = max(size) / points
    else:
        spacing = min(length / n for length, n in zip(size, shape, strict=True))
    rows, columns = (max(1, math.floor(length / spacing + 0.5)) for length in size)
    return rows, columns


def resample(heights: FloatArray, shape: tuple[int, int], *, periodic: bool) -> FloatArray:
    """Return the heights on another grid of the same cell, by way of their waves.

    Fewer points: the waves that they cannot carry are left out (an ideal low-pass filter at the
    new Nyquist wavevector of each direction), so that none appears as another. More points: the
    waves between the points are none. Of a cell that is not periodic the waves are cosines
    (DCT-II), those of the scan and its mirror images, which have no jump at the border; the
    pixels of both grids divide the same area.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        Without missing points.
    shape : (int, int)
        Wanted points along (y, x).
    periodic : bool

    Examples
    --------
    >>> x = (np.arange(12) + 0.5) / 12
    >>> wave = np.cos(2 * np.pi * x) + 0.0 * x[:, None]
    >>> coarse = resample(wave, (4, 4), periodic=False)
    >>> coarse[0].round(6).tolist()
    [0.707107, -0.707107, -0.707107, 0.707107]
    """
    for axis, points in enumerate(shape):
        if points != heights.shape[axis]:
            change = _change_periodic if periodic else _change_mirrored
            heights = change(heights, points, axis)
    return heights


def _change_mirrored(heights: FloatArray, points: int, axis: int) -> FloatArray:
    before = heights.shape[axis]
    waves = fft.dct(heights, type=2, axis=axis, norm="forward")
    waves = _cut_or_extend(waves, points, axis, min(before, points))
    changed: FloatArray = fft.idct(waves, type=2, axis=axis, norm="forward", overwrite_x=True)
    return changed


def _change_periodic(heights: FloatArray, points: int, axis: int) -> FloatArray:
    before = heights.shape[axis]
    waves = fft.rfft(heights, axis=axis, norm="forward")
    # The wave at the Nyquist wavevector of the smaller grid has no phase there: left out.
    kept = (min(before, points) + 1) // 2
    waves = _cut_or_extend(waves, points // 2 + 1, axis, kept)
    changed: FloatArray = fft.irfft(waves, points, axis=axis, norm="forward", overwrite_x=True)
    return changed


def _cut_or_extend(waves: NDArray[Any], points: int, axis: int, kept: int) -> NDArray[Any]:
    shape = list(waves.shape)
    shape[axis] = points
    changed: NDArray[Any] = np.zeros(shape, waves.dtype)
    part = tuple(slice(kept) if k == axis else slice(None) for k in range(2))
    changed[part] = waves[part]
    return changed
