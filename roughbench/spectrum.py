r"""Isotropic power spectra of rough surfaces and of the lines mapped from them.

**The normalisation, written once, cited elsewhere.** With Persson's convention

.. math:: C_{2D}(q) = (2\pi)^{-2} \int d^2x\, \langle h(x) h(0)\rangle e^{-iq\cdot x},

the mean squared height is

.. math:: \langle h^2\rangle = 2\pi\int_0^\infty q\, C_{2D}\, dq
                             = \int_{-\infty}^{\infty} C_{1D}\, dq,
          \qquad C_{1D}(q) = \pi |q|\, C_{2D}(|q|).

The one-dimensional spectrum is *two-sided*. The mapping (Popov's) preserves every
moment :math:`M_k = 2\pi\int q^{1+k} C_{2D}\,dq`: the rms height
:math:`\sqrt{M_0}`, the full rms slope :math:`\xi = \sqrt{M_2}`, and
:math:`\int |q| C_{1D} dq = M_1`. Wavevectors are angular, :math:`q = 2\pi/\lambda`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SurfaceError
from roughbench.inputs import check_heights, float_array, real_array, real_number

FloatArray = NDArray[np.float64]
BelowRolloff = Literal["rolloff", "cutoff"]


def power_integral(lower: ArrayLike, stretch: ArrayLike, exponent: ArrayLike) -> FloatArray:
    r"""Return :math:`\int_a^{a(1+x)} q^{n-1} dq`, without cancellation for small x.

    Parameters
    ----------
    lower : array_like
        Lower limit a > 0.
    stretch : array_like
        Relative width x ≥ 0 of the interval.
    exponent : array_like
        n; zero gives the logarithm.

    Returns
    -------
    ndarray of float64
        The integral, broadcast over the arguments.

    Examples
    --------
    >>> float(power_integral(1.0, 1.0, 2.0))
    1.5
    """
    a, x, n = np.broadcast_arrays(
        np.asarray(lower, float), np.asarray(stretch, float), np.asarray(exponent, float)
    )
    growth = np.log1p(x)
    safe = np.where(n == 0.0, 1.0, n)
    return np.where(n == 0.0, growth, a**n * np.expm1(safe * growth) / safe)


@dataclass(frozen=True, slots=True)
class Spectrum:
    """An isotropic power spectrum C2D(q) as a chain of power laws.

    Between ``edges[i]`` and ``edges[i + 1]`` it is ``prefactors[i] * q**-exponents[i]``,
    and zero outside the edges. All moments are closed forms.

    Parameters
    ----------
    edges : tuple of float, length n + 1
        Increasing wavevectors, 1/length.
    prefactors, exponents : tuple of float, length n
        The power law of each segment; C2D is a length to the fourth power.
    hurst, q_rolloff : float, optional
        Known for self-affine spectra (:func:`self_affine`), None for measured ones.
    """

    edges: tuple[float, ...]
    prefactors: tuple[float, ...]
    exponents: tuple[float, ...]
    hurst: float | None = None
    q_rolloff: float | None = None

    def __post_init__(self) -> None:
        """Refuse a chain that is none.

        Raises
        ------
        SurfaceError
            If the lengths do not fit, the edges do not increase from a positive one, or
            a prefactor is negative.
        """
        n = len(self.prefactors)
        if n == 0 or len(self.exponents) != n or len(self.edges) != n + 1:
            raise SurfaceError(
                "a spectrum of n segments has n + 1 edges, n prefactors and n exponents, "
                f"got {len(self.edges)}, {n} and {len(self.exponents)}"
            )
        values = np.asarray([*self.edges, *self.prefactors, *self.exponents], float)
        edges = values[: n + 1]
        if not np.isfinite(values).all() or edges[0] <= 0.0 or (np.diff(edges) <= 0.0).any():
            raise SurfaceError("the edges of a spectrum must be finite, positive and increase")
        if min(self.prefactors) < 0.0:
            raise SurfaceError("the power of a spectrum must not be negative")

    @property
    def q_min(self) -> float:
        """Smallest wavevector with power, 1/length."""
        return self.edges[0]

    @property
    def q_max(self) -> float:
        """Largest wavevector with power, 1/length."""
        return self.edges[-1]

    def psd_2d(self, q: ArrayLike) -> FloatArray:
        """C2D(q) of the surface, length⁴; zero outside ``q_min`` … ``q_max``."""
        q = np.asarray(q, float)
        edges = np.asarray(self.edges)
        # A wavevector on the lattice, n·2π/L, may miss an edge by rounding.
        slack = 1e-12
        inside = (q >= edges[0] * (1 - slack)) & (q <= edges[-1] * (1 + slack))
        clipped = np.clip(q, edges[0], edges[-1])
        segment = np.clip(
            np.searchsorted(edges, clipped * (1 + slack), side="right") - 1,
            0,
            len(self.prefactors) - 1,
        )
        c = np.asarray(self.prefactors)[segment]
        s = np.asarray(self.exponents)[segment]
        return np.where(inside, c * clipped**-s, 0.0)

    def psd_1d(self, q: ArrayLike) -> FloatArray:
        """C1D(q) = π |q| C2D(|q|) of the mapped line, two-sided, length³."""
        size = np.abs(np.asarray(q, float))
        return np.pi * size * self.psd_2d(size)

    def moment(self, order: float, q_max: float | None = None) -> float:
        r"""M_k = 2π∫q^{1+k} C2D dq up to ``q_max`` (default: all of it).

        Parameters
        ----------
        order : float
            k: 0 for the squared rms height, 2 for the squared rms slope.
        q_max : float, optional
            Upper limit of the integral, 1/length.

        Returns
        -------
        float
            length^(2 - k).

        Examples
        --------
        >>> spectrum = self_affine(hurst=0.7, q_min=1.0, q_rolloff=8.0, q_max=8192.0,
        ...                        rms_slope=0.1)
        >>> f"{spectrum.moment(0) ** 0.5:.6e}"
        '1.338290e-03'
        """
        limit = self.q_max if q_max is None else q_max
        lower = np.asarray(self.edges[:-1])
        upper = np.clip(self.edges[1:], None, limit)
        stretch = np.clip(upper / lower - 1.0, 0.0, None)
        parts = power_integral(lower, stretch, order + 2.0 - np.asarray(self.exponents))
        return float(2.0 * np.pi * np.sum(np.asarray(self.prefactors) * parts))

    @property
    def rms_height(self) -> float:
        """h_rms of the continuum, √M_0, length."""
        return math.sqrt(self.moment(0))

    @property
    def rms_slope(self) -> float:
        """ξ = √⟨|∇h|²⟩ = √M_2 of the continuum."""
        return math.sqrt(self.moment(2))

    @property
    def nayak(self) -> float:
        """Nayak's bandwidth parameter m0 m4 / m2², with m2 = M_2/2 and m4 = 3M_4/8."""
        m0, m2, m4 = self.moment(0), self.moment(2) / 2.0, 3.0 * self.moment(4) / 8.0
        return m0 * m4 / m2**2


def self_affine(
    *,
    hurst: float,
    q_min: float,
    q_rolloff: float,
    q_max: float,
    rms_slope: float | None = None,
    rms_height: float | None = None,
    below_rolloff: BelowRolloff = "rolloff",
) -> Spectrum:
    r"""Return the self-affine spectrum C2D ∝ q^{-2-2H} of the given slope or height.

    Parameters
    ----------
    hurst : float
        Hurst exponent H, 0 < H < 1.
    q_min, q_rolloff, q_max : float
        q0 ≤ qr < q1, 1/length.
    rms_slope, rms_height : float
        Exactly one of them; it fixes the prefactor through M_2 or M_0 (continuum).
    below_rolloff : {"rolloff", "cutoff"}
        Below ``q_rolloff`` the spectrum is flat, or zero.

    Raises
    ------
    SurfaceError
        If a parameter is out of its range, or not exactly one scale is given.

    Examples
    --------
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=8192, rms_slope=0.1)
    >>> f"{spectrum.rms_height:.6e}"
    '4.395117e-03'
    """
    if not 0.0 < hurst < 1.0:
        raise SurfaceError(f"the Hurst exponent must lie between 0 and 1, got {hurst}")
    if not 0.0 < q_min <= q_rolloff < q_max < math.inf:
        raise SurfaceError(
            "wavevectors must satisfy 0 < q0 <= qr < q1, "
            f"got q0 = {q_min}, qr = {q_rolloff}, q1 = {q_max}"
        )
    if (rms_slope is None) == (rms_height is None):
        raise SurfaceError("give exactly one of rms_slope and rms_height")
    fall = 2.0 + 2.0 * hurst
    if q_rolloff > q_min and below_rolloff == "rolloff":
        edges: tuple[float, ...] = (q_min, q_rolloff, q_max)
        prefactors: tuple[float, ...] = (q_rolloff**-fall, 1.0)
        exponents: tuple[float, ...] = (0.0, fall)
    else:
        edges, prefactors, exponents = (q_rolloff, q_max), (1.0,), (fall,)
    unit = Spectrum(edges, prefactors, exponents)
    order, target = (2, rms_slope) if rms_slope is not None else (0, rms_height)
    if target is None or not 0.0 < target < math.inf:
        raise SurfaceError(f"the rms slope or rms height must be positive, got {target}")
    scale = target**2 / unit.moment(order)
    return Spectrum(
        edges,
        tuple(scale * prefactor for prefactor in prefactors),
        exponents,
        hurst=hurst,
        q_rolloff=q_rolloff,
    )


def wavenumbers(shape: tuple[int, ...], length: float) -> FloatArray:
    """|q| of the entries of a real transform of ``shape``; square pixels, side ``length``.

    Returns
    -------
    ndarray of float64, shape (…, n // 2 + 1)
        Angular wavevectors, 1/length.
    """
    spacing = length / shape[0]
    axes = [2 * np.pi * np.fft.fftfreq(n, spacing) for n in shape[:-1]]
    axes.append(2 * np.pi * np.fft.rfftfreq(shape[-1], spacing))
    grids = np.meshgrid(*axes, indexing="ij", sparse=True)
    q: FloatArray = np.sqrt(sum(g * g for g in grids))
    return q


def mode_power(heights: FloatArray) -> FloatArray:
    """Return the share of each mode in ⟨(h − ⟨h⟩)²⟩, in the layout of a real transform.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        Length.

    Returns
    -------
    ndarray of float64, shape (n // 2 + 1,) or (n, m // 2 + 1)
        length²; a mode and its mirror image count together.
    """
    h = float_array(heights, "heights", SurfaceError, kinds="buif")
    power: FloatArray = np.abs(np.fft.rfftn(h, norm="forward")) ** 2
    power *= 2.0  # the other half plane
    power[..., 0] /= 2.0
    if h.shape[-1] % 2 == 0:
        power[..., -1] /= 2.0
    power.flat[0] = 0.0
    return power


def measured_spectrum(heights: FloatArray, length: float) -> Spectrum:
    r"""Return the radially averaged spectrum of given heights, as a chain of flat shells.

    The shells are 2π/L wide, centred on the multiples of 2π/L, where L is the longest
    side of the cell. C2D is constant on each, with all the power that the modes of the
    heights have in it, so that M_0 is their mean square exactly. M_2 is not: shell n
    carries its power at (n² + ¼)(2π/L)² on average, and the modes carry it a little
    beside that. Heights of a line are taken as one with C1D = πqC2D (Popov's mapping).

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        Periodic heights on square pixels, length; their mean is immaterial.
    length : float
        Period along the first axis, length.

    Returns
    -------
    Spectrum
        Without shells that hold nothing but rounding at either end (less than 1e-24 of
        the power); no Hurst exponent or roll-off.

    Raises
    ------
    SurfaceError
        If the heights have a wrong shape, are constant or not finite.

    Examples
    --------
    >>> x = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    >>> spectrum = measured_spectrum(0.1 * np.cos(3 * x), length=2 * np.pi)
    >>> spectrum.edges, round(spectrum.rms_height**2, 12)
    ((2.5, 3.5), 0.005)
    """
    h = real_array(heights, "heights", SurfaceError, kinds="buif")
    if h.ndim not in (1, 2) or min(h.shape) < 2:
        raise SurfaceError(
            f"a spectrum needs the heights of a line or a surface, got shape {h.shape}"
        )
    check_heights(h, "a spectrum needs finite heights", SurfaceError)
    h = h.astype(np.float64, copy=False)
    length = real_number(length, "length", SurfaceError)
    if not 0.0 < length < math.inf:
        raise SurfaceError(f"the length of the cell must be positive and finite, got {length}")
    width = 2.0 * math.pi / (length * max(h.shape) / h.shape[0])
    shell = np.floor(wavenumbers(h.shape, length) / width + 0.5).astype(np.int64)
    power = np.bincount(shell.ravel(), weights=mode_power(h - h.mean()).ravel())
    if not power.sum() > 1e-28 * np.mean(h * h):
        raise SurfaceError("the heights are constant: there is no roughness to measure")
    held = np.flatnonzero(power > 1e-24 * power.sum())
    first, last = int(held[0]), int(held[-1])
    edges = width * (np.arange(first, last + 2) - 0.5)
    # 2π∫q C dq over the shell is its power.
    density = power[first : last + 1] / (math.pi * np.diff(edges**2))
    return Spectrum(
        tuple(edges.tolist()), tuple(density.tolist()), (0.0,) * int(last - first + 1)
    )
