"""The summits of given heights: where they are highest among their neighbours."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError
from roughbench.models._checks import checked_heights
from roughbench.models.base import FloatArray


@dataclass(frozen=True, slots=True)
class Summits:
    """Local maxima of a surface; arrays have shape (n,).

    Attributes
    ----------
    height : ndarray of float64
        Above the mean plane, length.
    mean_curvature : ndarray of float64
        κ_m = −∇²h/2 > 0, 1/length.
    effective_curvature : ndarray of float64
        g = √(κ1 κ2) > 0, 1/length.
    nominal_area : float
        Of the cell, length².
    """

    height: FloatArray
    mean_curvature: FloatArray
    effective_curvature: FloatArray
    nominal_area: float


def find_summits(heights: ArrayLike, length: float) -> Summits:
    """Return the summits of periodic heights, from Fourier derivatives.

    A point not lower than its eight neighbours is taken for a summit; one Newton step
    with gradient and curvatures of the trigonometric interpolation leads from the grid
    point to its top. Points that are no maxima of the interpolation, or whose top is
    more than one grid spacing away along an axis, are left out.

    Parameters
    ----------
    heights : ndarray of float64, shape (n, m)
        Length; square pixels.
    length : float
        Period along the first axis, length.

    Raises
    ------
    SolverError
        If the heights are no surface, not finite, or without a summit.
    """
    h = checked_heights(heights, "the heights of the surface must be finite")
    if h.ndim != 2 or min(h.shape) < 3:
        raise SolverError(f"summits need the heights of a surface, got shape {h.shape}")
    h = h - h.mean()
    place = np.flatnonzero(_highest_of_nine(h))
    spacing = length / h.shape[0]
    gx, gy, hxx, hyy, hxy = (field.ravel()[place] for field in _derivatives(h, spacing))
    determinant = hxx * hyy - hxy * hxy
    with np.errstate(divide="ignore", invalid="ignore"):
        dx = -(hyy * gx - hxy * gy) / determinant
        dy = -(hxx * gy - hxy * gx) / determinant
    is_top = (determinant > 0.0) & (hxx + hyy < 0.0)
    is_top[is_top] &= np.maximum(np.abs(dx[is_top]), np.abs(dy[is_top])) <= spacing
    if not is_top.any():
        raise SolverError("the heights have no summit: nothing to press")
    rise = (gx[is_top] * dx[is_top] + gy[is_top] * dy[is_top]) / 2.0
    return Summits(
        height=h.ravel()[place[is_top]] + rise,
        mean_curvature=-(hxx + hyy)[is_top] / 2.0,
        effective_curvature=np.sqrt(determinant[is_top]),
        nominal_area=length * spacing * h.shape[1],
    )


def _highest_of_nine(h: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Mark points above their neighbours; of equal ones the first counts."""
    marks = np.ones(h.shape, bool)
    for shift in ((0, 1), (1, -1), (1, 0), (1, 1)):
        marks &= h >= np.roll(h, (-shift[0], -shift[1]), (0, 1))
        marks &= h > np.roll(h, shift, (0, 1))
    return marks


def _derivatives(h: FloatArray, spacing: float) -> Iterator[FloatArray]:
    """Yield h_x, h_y, h_xx, h_yy, h_xy of the trigonometric interpolation, one at a time."""
    modes = np.fft.rfft2(h)
    qx = 2.0 * math.pi * np.fft.fftfreq(h.shape[0], spacing)[:, None]
    qy = 2.0 * math.pi * np.fft.rfftfreq(h.shape[1], spacing)[None, :]
    # At the Nyquist wavevector both signs fall together, and odd derivatives vanish.
    ox = np.where(np.isclose(np.abs(qx), math.pi / spacing), 0.0, qx)
    oy = np.where(np.isclose(qy, math.pi / spacing), 0.0, qy)
    factors = (1j * ox, 1j * oy, -qx * qx, -qy * qy, -ox * oy)
    for factor in factors:
        yield np.fft.irfft2(modes * factor, s=h.shape)
