r"""What a measured surface is like: heights, slopes and curvatures as numbers.

With :math:`z = h - \langle h\rangle`, averaged over the measured points,

.. math::
    S_a = \langle|z|\rangle, \quad S_q = \sqrt{\langle z^2\rangle}, \quad
    S_{sk} = \langle z^3\rangle/S_q^3, \quad S_{ku} = \langle z^4\rangle/S_q^4, \quad
    S_z = \max z - \min z, \\
    S_{dq} = \sqrt{\langle|\nabla h|^2\rangle}, \qquad
    S_{dr} = \langle\sqrt{1 + |\nabla h|^2} - 1\rangle .

Names and definitions are those of ISO 25178-2:2021, clause 4, for the heights as they are
given: form and filters are the caller's business. The moments of a profile,

.. math:: m_0 = \langle z^2\rangle, \quad m_2 = \langle h_{,x}^2\rangle, \quad
          m_4 = \langle h_{,xx}^2\rangle, \quad \alpha = m_0 m_4/m_2^2,

are those of P. R. Nayak, J. Lubr. Technol. 93, 398 (1971), averaged over both axes. In terms
of :mod:`roughbench.spectrum`, :math:`m_2 = M_2/2` and :math:`m_4 = 3M_4/8` where the surface
is isotropic. All derivatives are differences of neighbouring points; nothing is taken across
a border, or across a missing point.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SurfaceError
from roughbench.inputs import float_array, positive_number
from roughbench.scans.rms import NO_SLOPE, blocks, mean_square_slopes, spread

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Roughness:
    """Numbers of one surface; lengths in the unit of its heights and its size.

    Attributes
    ----------
    points : (int, int)
        Rows and columns.
    size : (float, float)
        (y, x), length.
    missing : float
        Share of the points that are missing.
    Sa, Sq, peak_to_valley : float
        Mean and root mean square distance from the mean height; highest less lowest height
        (Sz); length.
    Ssk, Sku : float
        Skewness, and kurtosis (3 for Gaussian heights).
    Sdq, Sdr : float
        Root mean square gradient; share by which the area exceeds its projection.
    m0, m2, m4 : float
        Moments of a profile by differences; length², 1, length^-2.
    nayak : float
        m0 m4/m2².
    band : (float, float)
        Wavevectors that the points can show, and that all of the above are taken over:
        from 2π over the longer side to π over the smaller spacing, 1/length. Differences
        of points show the gradient of a wave of wavevector q by a factor
        sin(qΔ/2)/(qΔ/2) too small, at the upper end of the band by 2/π.
    slopes : (float, float)
        Root mean square slope along (y, x); Sdq² is the sum of their squares.
    anisotropy : float
        Largest over smallest rms slope of all directions, at least 1; inf if there is a
        direction without any slope.
    direction : float
        Direction of the largest slope, in degrees from the x axis (columns) towards the y
        axis (rows), -90 < direction ≤ 90; of no meaning where the anisotropy is near 1.
    """

    points: tuple[int, int]
    size: tuple[float, float]
    missing: float
    Sa: float
    Sq: float
    Ssk: float
    Sku: float
    Sdq: float
    Sdr: float
    peak_to_valley: float
    m0: float
    m2: float
    m4: float
    nayak: float
    band: tuple[float, float]
    slopes: tuple[float, float]
    anisotropy: float
    direction: float


def roughness(heights: ArrayLike, size: tuple[float, float]) -> Roughness:
    r"""Return what a surface is like, in numbers.

    Parameters
    ----------
    heights : array_like of float, shape (rows, columns)
        Length; nan where a point is missing.
    size : (float, float)
        Of the scan along (y, x), in the same unit: points times their spacing.

    Returns
    -------
    Roughness

    Raises
    ------
    SurfaceError
        If fewer than 3 × 3 points are given, a height is infinite, all measured heights are
        equal, or nowhere enough neighbouring points are measured for a slope.

    Notes
    -----
    Sq and Sdq follow the rule of :mod:`roughbench.scans.rms`, of heights that are not periodic.
    Sdr is the area of the triangles between neighbouring points, two in each cell; of a wave
    that many points resolve it is Sdq²/2 for small slopes.

    Examples
    --------
    >>> x = np.arange(256) / 256
    >>> wave = 0.01 * np.cos(2 * np.pi * 4 * x) * np.ones((256, 1))
    >>> found = roughness(wave, (1.0, 1.0))
    >>> f"{found.Sq:.6f} {found.Sku:.3f} {found.Sdq:.4f}"
    '0.007071 1.500 0.1780'
    """
    h = float_array(heights, "heights", SurfaceError)
    if h.ndim != 2 or min(h.shape) < 3:
        raise SurfaceError(
            f"roughness needs at least 3 × 3 heights, got an array of shape {h.shape}"
        )
    if np.isinf(h).any():
        raise SurfaceError("heights must be finite, or nan where they are missing; got inf")
    sides = tuple(
        positive_number(side, f"size along {axis}", SurfaceError)
        for side, axis in zip(size, "yx", strict=True)
    )
    spacing = sides[0] / h.shape[0], sides[1] / h.shape[1]
    of_heights = _heights(h)
    square_y, square_x = mean_square_slopes(h, spacing, periodic=False)
    if math.isnan(square_y):
        raise SurfaceError(NO_SLOPE)
    mixed, developed = _crossings(h, spacing)
    m4 = _curvature(h, spacing)
    m2 = (square_y + square_x) / 2.0
    (across, along), directions = np.linalg.eigh([[square_y, mixed], [mixed, square_x]])
    steepest = directions[:, 1]
    angle = math.degrees(math.atan2(steepest[0], steepest[1]))
    return Roughness(
        points=(h.shape[0], h.shape[1]),
        size=(sides[0], sides[1]),
        Sdq=math.sqrt(2.0 * m2),
        Sdr=developed,
        m0=of_heights["Sq"] ** 2,
        m2=m2,
        m4=m4,
        nayak=of_heights["Sq"] ** 2 * m4 / m2**2 if m2 else math.inf,
        band=(2.0 * math.pi / max(sides), math.pi / min(spacing)),
        slopes=(math.sqrt(square_y), math.sqrt(square_x)),
        anisotropy=math.sqrt(along / across) if across > 1e-12 * along else math.inf,
        direction=angle - 180.0 if angle > 90.0 else angle + 180.0 if angle <= -90.0 else angle,
        **of_heights,
    )


def _heights(h: FloatArray) -> dict[str, float]:
    """Return what the heights say wherever they stand."""
    found = spread(h)
    if not found.count:
        raise SurfaceError("all points are missing: there is no surface to describe")
    width = found.highest - found.lowest
    if not width > 1e-14 * max(abs(found.highest), abs(found.lowest)):
        raise SurfaceError(
            f"all heights are the same, {found.highest:g}: there is no roughness"
        )
    absolute = third = fourth = 0.0
    for start, stop in blocks(*h.shape):
        z = h[start:stop]
        z = (z[np.isfinite(z)] - found.mean) / found.rms
        square = z * z
        absolute += float(np.abs(z).sum())
        third += float((square * z).sum())
        fourth += float((square * square).sum())
    return {
        "missing": 1.0 - found.count / h.size,
        "Sa": absolute / found.count * found.rms,
        "Sq": found.rms,
        "Ssk": third / found.count,
        "Sku": fourth / found.count,
        "peak_to_valley": width,
    }


def _crossings(h: FloatArray, spacing: tuple[float, float]) -> tuple[float, float]:
    """Return ⟨∂h/∂y ∂h/∂x⟩, and the share of area that is gained."""
    dy, dx = spacing
    rows, columns = h.shape
    crossings = triangles = 0
    mixed = gained = 0.0
    for start, stop in blocks(rows - 1, columns):
        part = h[start : stop + 1]
        along_y, along_x = np.diff(part, axis=0) / dy, np.diff(part, axis=1) / dx
        # The slopes of both sides of a cell, multiplied: noise has none of it.
        product = (along_y[:, :-1] + along_y[:, 1:]) * (along_x[:-1] + along_x[1:])
        product = product[np.isfinite(product)]
        crossings += product.size
        mixed += float(product.sum()) / 4.0
        for y, x in ((along_y[:, :-1], along_x[:-1]), (along_y[:, 1:], along_x[1:])):
            square = y * y + x * x
            square = square[np.isfinite(square)]
            # √(1 + s) − 1 without cancellation.
            gained += float(np.sum(square / (np.sqrt(1.0 + square) + 1.0)))
            triangles += square.size
    return mixed / max(crossings, 1), gained / triangles


def _curvature(h: FloatArray, spacing: tuple[float, float]) -> float:
    """Return the mean square second derivative of profiles along both axes."""
    total, count = [0.0, 0.0], [0, 0]
    for start, stop in blocks(*h.shape):
        for axis, part in enumerate((h[max(start - 2, 0) : stop], h[start:stop])):
            second = np.diff(part, n=2, axis=axis)
            second = second[np.isfinite(second)]
            total[axis] += float(np.sum(second * second)) / spacing[axis] ** 4
            count[axis] += second.size
    means = [one / n for one, n in zip(total, count, strict=True) if n]
    if not means:
        raise SurfaceError(
            "so many points are missing that nowhere three neighbours are left in a row"
        )
    return sum(means) / len(means)
