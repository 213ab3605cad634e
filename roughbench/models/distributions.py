r"""How pressures and gaps are distributed where no field says it: in theory, and of springs.

**Persson's gaps.** Where the surface looks as if it touched when only waves up to q are seen,
the share of the area is :math:`A(q) = \mathrm{erf}(\sqrt2p/E^*\xi(q))`, and the mean gap
:math:`\bar u(q)` there is that of the shorter waves, of a spectrum that begins at q, at the
pressure :math:`p/A(q)`. What comes apart when the next waves are seen is at the distance

.. math:: u_1 = \frac{d(\bar uA)}{dA} = \bar u + \frac{d\bar u}{d\ln A},

and the shorter waves, of the variance :math:`h_1^2 = M_0 - M_0(q)`, spread it:

.. math:: P(u) = \int_{A(q_1)}^1 \frac{dA}{\sqrt{2\pi}h_1}
          \bigl[e^{-(u-u_1)^2/2h_1^2} + e^{-(u+u_1)^2/2h_1^2}\bigr] .

Its integral is :math:`1 - A/A_0`. The mean of :math:`u_1` is :math:`\bar u`; that of P is
larger, since what the spread would take below zero is folded back. At wavevectors where
:math:`\bar u(q)` falls already and A is still 1, :math:`u_1` is far above all heights, for a
share of the area that vanishes: some 1e-4 of the points have gaps beyond 10 h.

Source: A. Almqvist, C. Campañá, N. Prodanov and B. N. J. Persson, J. Mech. Phys. Solids **59**,
2355 (2011). :math:`u_1` follows from the volume of the gap, :math:`\bar uA_0`, as parts come
apart; that the shorter waves spread it as if nothing held them is an assumption.

**Springs** under normally distributed heights (:mod:`.winkler`), with the plane at d and
h = :math:`h_{rms}`: a point is at the height z with the density :math:`\varphi(z/h)/h`, its
pressure is :math:`k_w(z - d)` and its gap :math:`d - z`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughbench.models._checks import checked_positive
from roughbench.models.base import FloatArray, Sample
from roughbench.models.persson import persson_curve
from roughbench.models.winkler import gaussian_winkler_curve, matched_modulus
from roughbench.spectrum import Spectrum

_WHOLE = 0.4
"""ξ(q) E*/p up to which the surface is one contact: 1 - A is 6e-7 there."""
_NEARLY_ALL, _ALL = 0.3, 1e-8
"""Shares of ξ² that are still missing between which the last waves are taken."""
_NODES = 64
"""With three times as many the densities in the bins of gap_pdf change by 0.3 % in the median,
and by up to 4 % in the tail of large gaps (q_r = 8, q1 = 128, p/E* = 1e-3 and 0.01)."""


@dataclass(frozen=True, slots=True)
class Separations:
    """At what distances the surface comes apart, in Persson's theory.

    Attributes
    ----------
    distance : ndarray of float64, shape (K,)
        u₁, length.
    spread : ndarray of float64, shape (K,)
        h₁, length.
    share : ndarray of float64, shape (K,)
        ΔA/A0; their sum is 1 - A/A0.
    """

    distance: FloatArray
    spread: FloatArray
    share: FloatArray


def shares_of(
    kind: str,
    attributes: Mapping[str, Any],
    spectrum: Spectrum,
    edges: FloatArray,
    nominal: float,
    *,
    of_gaps: bool,
) -> FloatArray | None:
    """Return the share of all points between two edges that a model has without a field.

    Parameters
    ----------
    kind : str
        Of the model.
    attributes : mapping
        Of its results, without units.
    spectrum : Spectrum
        Of its surfaces.
    edges : ndarray of float64, shape (K + 1,)
        Pressures σ/E*, or gaps, length.
    nominal : float
        p/E* > 0.
    of_gaps : bool
        Whether edges are gaps.

    Returns
    -------
    ndarray of float64, shape (K,), or None
        None for models without a distribution of their own. Of Persson's theory the pressures
        do not depend on its γ.
    """
    if kind == "persson":
        if of_gaps:
            return persson_gap_shares(edges, spectrum, nominal, float(attributes["gamma"]))
        return _persson_pressure_shares(edges, nominal, spectrum.rms_slope)
    if kind == "winkler" and attributes.get("heights") == "gaussian":
        own = attributes.get("modulus")
        modulus = matched_modulus(Sample(None, float(attributes["length"]), spectrum))
        modulus = modulus if own is None else float(own)
        return spring_shares(edges, nominal, spectrum.rms_height, modulus, of_gaps=of_gaps)
    return None


def _persson_pressure_shares(edges: FloatArray, nominal: float, slope: float) -> FloatArray:
    """Return those of [e^{-(σ-p)²/2V} - e^{-(σ+p)²/2V}]/√(2πV), V = ξ²/4."""
    from scipy.special import ndtr

    width = slope / 2.0
    above = ndtr((nominal - edges) / width) - ndtr((-nominal - edges) / width)
    return np.asarray(-np.diff(above))


def persson_separations(
    spectrum: Spectrum, nominal: float, gamma: float = 0.45, nodes: int = _NODES
) -> Separations:
    """Return at what distances the surface comes apart, as the waves are seen.

    Parameters
    ----------
    spectrum : Spectrum
    nominal : float
        p/E* > 0.
    gamma : float
        γ of the mean gap, 0 < γ ≤ 1.
    nodes : int
        Wavevectors at which A and ū are taken, evenly in ln ξ(q), and half as many evenly in
        the logarithm of what ξ² still lacks: small gaps are those of the last waves.

    Raises
    ------
    SolverError
        If the pressure or γ is out of its range.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=128, rms_slope=0.1)
    >>> found, curve = persson_separations(spectrum, 0.01), persson_curve(spectrum, [0.01])
    >>> f"{found.share.sum():.6f} {1.0 - curve.area[0]:.6f}"
    '0.841481 0.841481'
    """
    p = checked_positive(nominal, "the pressure")
    slope = spectrum.rms_slope
    first = min(_WHOLE * p, 0.5 * slope)
    rest_of_slope = np.geomspace(_NEARLY_ALL, _ALL, nodes // 2)
    slopes = np.append(
        np.geomspace(first, slope * math.sqrt(1.0 - _NEARLY_ALL), nodes, endpoint=False),
        slope * np.sqrt(1.0 - rest_of_slope),
    )
    q = _wavevectors(spectrum, np.append(slopes, slope))
    # The first node is the whole surface, the last the contact itself.
    area = np.array([1.0, *(math.erf(math.sqrt(2.0) * p / _slope(spectrum, k)) for k in q)])
    gap = np.zeros(area.shape)
    gap[0] = persson_curve(spectrum, [p], gamma).separation[0]
    for k in range(1, area.size - 1):
        rest = _from(spectrum, float(q[k - 1]))
        gap[k] = persson_curve(rest, [p / area[k]], gamma).separation[0]
    missing = spectrum.moment(0) - np.array([0.0, *(spectrum.moment(0, k) for k in q)])
    share = -np.diff(area)
    held = share > 0.0
    distance = -np.diff(gap * area)[held] / share[held]
    spread = np.sqrt(np.maximum(0.5 * (missing[1:] + missing[:-1]), 0.0))[held]
    return Separations(distance, spread, share[held])


def persson_gap_shares(
    edges: ArrayLike, spectrum: Spectrum, nominal: float, gamma: float = 0.45
) -> FloatArray:
    """Return the share of all points with a gap between two edges, in Persson's theory.

    Parameters
    ----------
    edges : array_like of float64, shape (K + 1,)
        Gaps, length, ascending from 0 or above.
    spectrum : Spectrum
    nominal, gamma : float
        As for :func:`persson_separations`.

    Returns
    -------
    ndarray of float64, shape (K,)
    """
    from scipy.special import erf

    found = persson_separations(spectrum, nominal, gamma)
    u = np.asarray(edges, float)[:, None]
    wide = math.sqrt(2.0) * found.spread
    below = (erf((u - found.distance) / wide) + erf((u + found.distance) / wide)) / 2.0
    return np.diff(below @ found.share)


def spring_shares(
    edges: ArrayLike, nominal: float, rms_height: float, modulus: float, *, of_gaps: bool
) -> FloatArray:
    """Return the share of all points between two edges, of springs under normal heights.

    Parameters
    ----------
    edges : array_like of float64, shape (K + 1,)
        Pressures σ/E*, or gaps, length; ascending from 0 or above.
    nominal : float
        p/E* > 0.
    rms_height : float
        Of the heights, length.
    modulus : float
        k_w/E*, 1/length.
    of_gaps : bool
        Whether edges are gaps.

    Returns
    -------
    ndarray of float64, shape (K,)

    Examples
    --------
    With the plane at the mean height half of the points carry pressure, half have a gap:

    >>> p = 1.0 / math.sqrt(2.0 * math.pi)
    >>> both = [spring_shares([0.0, 9.0], p, 1.0, 1.0, of_gaps=gaps) for gaps in (False, True)]
    >>> [float(share.round(12)[0]) for share in both]
    [0.5, 0.5]
    """
    from scipy.special import ndtr

    curve = gaussian_winkler_curve(rms_height, [nominal], modulus)
    plane = float(curve.separation[0]) - nominal / modulus
    x = np.asarray(edges, float)
    height = plane - x if of_gaps else plane + x / modulus
    # The share above: that of high points, which are few, is exact.
    return np.asarray(np.abs(np.diff(ndtr(-height / rms_height))))


def _slope(spectrum: Spectrum, q: float) -> float:
    return math.sqrt(spectrum.moment(2, q))


def _wavevectors(spectrum: Spectrum, slopes: FloatArray) -> FloatArray:
    """Return the wavevectors up to which a spectrum has these slopes, the last its end."""
    from scipy.optimize import brentq

    low, high = spectrum.q_min, spectrum.q_max
    found = [
        brentq(lambda q, s=slope: spectrum.moment(2, q) - s * s, low, high, rtol=1e-13)
        for slope in slopes[:-1]
    ]
    return np.array([*found, high])


def _from(spectrum: Spectrum, q: float) -> Spectrum:
    """Return the part of a spectrum above a wavevector."""
    kept = [k for k, upper in enumerate(spectrum.edges[1:]) if upper > q]
    return Spectrum(
        (q, *(spectrum.edges[k + 1] for k in kept)),
        tuple(spectrum.prefactors[k] for k in kept),
        tuple(spectrum.exponents[k] for k in kept),
    )
