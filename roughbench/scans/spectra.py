r"""Power spectra of measured heights: of the surface in rings, of its profiles along both axes.

The normalisation is that of :mod:`roughbench.spectrum`. A mode q of the heights, with
:math:`h_q = N^{-1}\sum h\,e^{-iq\cdot x}`, says :math:`C_{2D}(q) = |h_q|^2 L_xL_y/(2\pi)^2`,
so that :math:`\langle h^2\rangle = \int C_{2D}\,d^2q`. A profile measured along x says
:math:`C_x(q_x) = |h_{q_x}|^2 L_x/2\pi`, two-sided, averaged over the rows:

.. math:: C_x(q_x) = \int_{-\infty}^{\infty} C_{2D}(q_x, q_y)\,dq_y, \qquad
          \langle h^2\rangle = \int_{-\infty}^{\infty} C_x\,dq_x .

It has the slope of one direction only, and is **not** the spectrum :math:`\pi q C_{2D}` of
the line that Popov's mapping takes for the surface.

Heights that are not periodic are weighed by Hann's window :math:`w = \sin^2(\pi x/L)` along
each axis that is transformed, and the power multiplied so that the rms gradient by
differences stays that of all measured points; on average that is by
:math:`1/\langle w^2\rangle` (F. J. Harris, Proc. IEEE 66, 51 (1978); T. D. B. Jacobs,
T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017)). That is for spectra
only: in contact the window would be a different surface.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SurfaceError
from roughbench.inputs import check_heights, float_array
from roughbench.scans.measured_spectrum import HANN_WIDTH, MeasuredSpectrum

FloatArray = NDArray[np.float64]

_BLOCK = 1 << 18
"""Modes that are sorted into rings at once."""


def surface_spectrum(
    heights: ArrayLike,
    size: tuple[float, float],
    *,
    window: bool,
    measured: NDArray[np.bool_] | None = None,
) -> MeasuredSpectrum:
    r"""Return C2D averaged over rings of wavevectors, 2π over the longer side wide.

    Parameters
    ----------
    heights : array_like of float, shape (rows, columns)
        Length; without holes. Their mean is immaterial.
    size : (float, float)
        Along (y, x), length; pixels may be rectangular.
    window : bool
        Weigh with Hann's window: for heights that are not periodic.
    measured : ndarray of bool, shape (rows, columns), optional
        False where heights were filled: filled places are too smooth.

    Returns
    -------
    MeasuredSpectrum
        From 2π over the longer side to π over the larger spacing: the wavevectors that are
        seen in all directions.

    Raises
    ------
    SurfaceError
        If there are fewer than 4 × 4 heights, or some are missing or not finite.

    Examples
    --------
    >>> x = np.arange(64) / 64
    >>> wave = 0.1 * np.cos(2 * np.pi * 5 * x) * np.ones((64, 1))
    >>> found = surface_spectrum(wave, (1.0, 1.0), window=False)
    >>> round(found.moment(0), 12), round(float(found.q[found.power.argmax()] / np.pi))
    (0.005, 10)
    """
    h = _checked(heights)
    axes = (0, 1) if window else ()
    n, m = h.shape
    power = _transformed(h, axes)
    power *= _gain(h, size, axes, measured, (0, 1)) * size[0] * size[1] / (2.0 * math.pi) ** 2
    width = 2.0 * math.pi / max(size)
    end = math.pi / max(size[0] / n, size[1] / m) / width
    qy = 2.0 * math.pi / size[0] / width * np.fft.fftfreq(n, 1.0 / n)
    qx = 2.0 * math.pi / size[1] / width * np.arange(m // 2 + 1)
    once = np.ones(qx.size)
    once[0] = 0.5  # there ±q stand in the array both
    if m % 2 == 0:
        once[-1] = 0.5
    rings = int(end + 0.5) + 1
    count, total, squares, radius = (np.zeros(rings) for _ in range(4))
    rows = max(1, _BLOCK // qx.size)
    for start in range(0, n, rows):
        part = slice(start, start + rows)
        q2 = qy[part, None] ** 2 + qx**2
        ring = np.floor(np.sqrt(q2) + 0.5).astype(np.int64)
        inside = (q2 <= end**2 * (1.0 + 1e-12)) & (q2 > 0.0)
        ring, q2 = ring[inside], q2[inside]
        weight = np.broadcast_to(once, inside.shape)[inside]
        here = power[part][inside]
        for sums, values in (
            (count, weight),
            (total, weight * here),
            (squares, weight * here**2),
            (radius, weight * q2),
        ):
            sums += np.bincount(ring, values, minlength=rings)[:rings]
    held = count > 0.0
    count, total, squares, radius = (a[held] for a in (count, total, squares, radius))
    mean = total / count
    crowding = squares / count / np.where(mean > 0.0, mean, 1.0) ** 2
    return MeasuredSpectrum(
        kind="surface",
        q=width * np.sqrt(radius / count),
        power=mean,
        modes=count,
        independent=count / (HANN_WIDTH**2 if window else 1.0),
        crowding=crowding,
        size=(float(size[0]), float(size[1])),
        spacing=(size[0] / h.shape[0], size[1] / h.shape[1]),
        windowed=window,
    )


def profile_spectrum(
    heights: ArrayLike,
    size: tuple[float, float],
    axis: int,
    *,
    window: bool,
    measured: NDArray[np.bool_] | None = None,
) -> MeasuredSpectrum:
    r"""Return the spectrum of the profiles along one axis, averaged over all of them.

    Parameters
    ----------
    heights : array_like of float, shape (rows, columns)
        Length; without holes.
    size : (float, float)
        Along (y, x), length.
    axis : int
        0 for profiles along y (columns of the array), 1 for profiles along x.
    window : bool
        Weigh each profile with Hann's window.
    measured : ndarray of bool, shape (rows, columns), optional
        False where heights were filled.

    Returns
    -------
    MeasuredSpectrum
        Two-sided: the mean square height is twice the sum over its wavevectors, times 2π/L.
        ``independent`` counts by how many modes across the profiles the power is carried,
        since neighbouring profiles are nearly the same.
    """
    h = _checked(heights)
    power = _transformed(h if axis == 1 else h.T, (1,) if window else ())
    length = size[axis]
    power = power[:, 1:]  # without the mean
    points = h.shape[axis]
    total = power.sum(axis=0)
    squares = np.einsum("ij,ij->j", power, power)
    safe = np.where(total > 0.0, total, 1.0)
    # Of exponential powers ⟨P²⟩ is twice ⟨P⟩².
    independent = np.clip(2.0 * safe**2 / np.where(total > 0.0, squares, 1.0), 1.0, len(power))
    crowding = len(power) * squares / safe**2
    total *= _gain(h, size, (axis,) if window else (), measured, (axis,))
    total *= length / (2.0 * math.pi)
    modes = np.ones_like(total)
    if points % 2 == 0:
        modes[-1] = 0.5  # the one at the end of the band is its own mirror image
    return MeasuredSpectrum(
        kind="along x" if axis == 1 else "along y",
        q=2.0 * math.pi / length * np.arange(1, total.size + 1),
        power=total,
        modes=modes,
        independent=independent,
        crowding=crowding,
        size=(float(size[0]), float(size[1])),
        spacing=(size[0] / h.shape[0], size[1] / h.shape[1]),
        windowed=window,
    )


def _checked(heights: ArrayLike) -> FloatArray:
    h = float_array(heights, "heights", SurfaceError)
    if h.ndim != 2 or min(h.shape) < 4:
        raise SurfaceError(
            f"a spectrum needs at least 4 × 4 heights, got an array of shape {h.shape}"
        )
    fault = "a spectrum needs all heights; fill or crop the missing ones"
    check_heights(h, fault, SurfaceError, per_point=40)
    return h


def _transformed(h: FloatArray, windowed: tuple[int, ...]) -> FloatArray:
    """Return |h_q|² of the half plane, of heights weighed by a window along some axes."""
    from scipy import fft

    along_y, along_x = (_window(h.shape, axis, windowed) for axis in (0, 1))
    mean = (along_y @ h @ along_x) / (along_y.sum() * along_x.sum())
    weighed = h - mean  # so that the weighed heights have no mean
    weighed *= along_y[:, None]
    weighed *= along_x
    modes = fft.rfft2(weighed, norm="forward", overwrite_x=True, workers=2)
    del weighed
    power: FloatArray = np.square(modes.real)
    power += np.square(modes.imag)
    return power


def _window(shape: tuple[int, ...], axis: int, windowed: tuple[int, ...]) -> FloatArray:
    """Return Hann's window along an axis, or ones."""
    points = shape[axis]
    if axis not in windowed:
        return np.ones(points)
    return np.asarray(np.sin(np.pi * (np.arange(points) + 0.5) / points) ** 2)


def _gain(
    h: FloatArray,
    size: tuple[float, float],
    windowed: tuple[int, ...],
    measured: NDArray[np.bool_] | None,
    axes: tuple[int, ...],
) -> float:
    """Return by what the power must be multiplied to be that of all measured points.

    That is 1/⟨w²⟩ for roughness that is everywhere the same. A window shows the middle of
    the scan, where the roughness is another by chance, and filled places have less of it; so
    both are weighed by what is known everywhere: the mean square slope between neighbours.
    """
    if measured is not None and measured.all():
        measured = None
    if not windowed and measured is None:
        return 1.0
    weights = [_window(h.shape, axis, windowed) ** 2 for axis in (0, 1)]
    known = shown = 0.0
    for axis in axes:
        squares = np.diff(h, axis=axis)
        squares *= squares
        step = size[axis] / h.shape[axis]
        pairs: NDArray[np.bool_] | bool = True
        if measured is not None:
            pairs = (
                measured[1:] & measured[:-1]
                if axis == 0
                else measured[:, 1:] & measured[:, :-1]
            )
        count = squares.size if pairs is True else np.count_nonzero(pairs)
        known += float(np.sum(squares, where=pairs)) / max(count, 1) / step**2
        between = [(w[1:] + w[:-1]) / 2.0 if k == axis else w for k, w in enumerate(weights)]
        everything = between[0].sum() * between[1].sum()
        shown += float(between[0] @ squares @ between[1] / everything) / step**2
    kept = float(weights[0].mean() * weights[1].mean())
    return known / shown / kept if known > 0.0 and shown > 0.0 else 1.0 / kept
