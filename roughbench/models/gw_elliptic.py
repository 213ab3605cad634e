r"""The simplified elliptic model: every summit with its own height and curvatures.

Nayak's summits have two principal curvatures :math:`\kappa_1, \kappa_2` each. The
mildly elliptic Hertz contact of such a summit is replaced by the round one with
:math:`g = \sqrt{\kappa_1\kappa_2}` in place of the curvature (Greenwood 2006), so that
only the joint density of the height z, of
:math:`\kappa_m = \tfrac12(\kappa_1+\kappa_2) \ge g`, and of g is needed:

.. math::
    D(z, \kappa_m, g) = \frac{1}{2\pi m_2}\,\frac{3g^3}{m_4}\,
        e^{-3(\kappa_m^2-g^2)/(2m_4)}\; N_2(z, \kappa_m),

where :math:`N_2` is the normal density with the variances :math:`m_0` and
:math:`\tfrac23m_4` and the covariance :math:`m_2`; moments as in :mod:`.gw`. Then

.. math::
    \frac{A}{A_0} = \int\frac{\pi(z-d)}{g}D, \qquad
    p = \int\tfrac43E^*(z-d)^{3/2}g^{-1/2}D, \qquad \bar u = d .

**How it is computed.** In units of the standard deviations, k for
:math:`\kappa_m` and s for z, with the correlation
:math:`\rho = \sqrt{3/(2\alpha)}`, the integral over g is a confluent hypergeometric
function,

.. math:: W_a(k) = \int_0^k \gamma^a e^{\gamma^2-k^2}d\gamma
                 = \frac{k^{a+1}}{a+1}\,{}_1F_1(1; \tfrac{a+3}{2}; -k^2),

with a = 2 for the area and 5/2 for the load, that over k at given s a Gauss-Legendre
sum, and that over s the one of :mod:`._gaussian_excess`.

With *counted* summits of actual heights, each has its own z and g.

Source: J. A. Greenwood (2006); P. R. Nayak (1971) for the statistics.
"""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from roughbench.models._asperities import Distribution, counted_curve, integrated_curve
from roughbench.models._checks import checked_length, checked_pressures
from roughbench.models._gaussian_excess import Weight
from roughbench.models._summits import find_summits
from roughbench.models.base import CompleteCurve, FloatArray
from roughbench.models.gw import AsperityModel
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum

_POINTS = 64
_REACH = 9.0
"""Standard deviations of the curvature at a given height that are integrated over."""


def elliptic_curve(spectrum: Spectrum, pressures: ArrayLike) -> CompleteCurve:
    r"""Return the curve of the simplified elliptic model of a spectrum.

    The equations stand at the top of this module.

    Parameters
    ----------
    spectrum : Spectrum
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.

    Returns
    -------
    CompleteCurve
        With E* = 1. At high pressure the model leaves its ground: ū falls below zero, and
        A/A0 rises above one.

    Raises
    ------
    SolverError
        If a pressure is not positive.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=8192, rms_slope=0.1)
    >>> curve = elliptic_curve(spectrum, [1e-6, 1e-4, 1e-3, 1e-2])
    >>> (curve.area * 0.1 / curve.pressure).round(2).tolist()
    [0.38, 0.35, 0.33, 0.31]
    """
    p = checked_pressures(pressures)
    m2, m4 = spectrum.moment(2) / 2.0, 3.0 * spectrum.moment(4) / 8.0
    unit = math.sqrt(2.0 * m4 / 3.0)  # of the curvatures
    # (1/2πm2)(3/m4) g³ dg in this unit, times N_2 dz dκ_m = φ(s) ds N(k; ρs, 1-ρ²) dk.
    per_area = 2.0 * m4 / (3.0 * math.pi * m2)
    correlation = math.sqrt(1.5 / spectrum.nayak)
    summits = Distribution(
        mean=0.0,
        deviation=math.sqrt(spectrum.moment(0)),
        load=per_area / math.sqrt(unit),
        area=math.pi * per_area / unit,
        load_weight=make_weight(2.5, correlation),
        area_weight=make_weight(2.0, correlation),
    )
    return integrated_curve(summits, p)


def make_weight(order: float, correlation: float) -> Weight:
    r"""Return V(s) = ∫_0^∞ N(k; ρs, 1 − ρ²) W_a(k) dk, the mean of γ^(a−3) at the height s.

    Parameters
    ----------
    order : float
        a: 3 gives the density of summits, 2 their area, 5/2 their load.
    correlation : float
        ρ between height and mean curvature, 0 < ρ ≤ 1.

    Returns
    -------
    callable
        Takes and returns ndarray of float64, of one shape.
    """
    from scipy.special import hyp1f1

    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    spread = math.sqrt(max(1.0 - correlation**2, 1e-12))

    def weight(s: FloatArray) -> FloatArray:
        centre = correlation * s[..., None]
        low = np.maximum(centre - _REACH * spread, 0.0)
        high = np.maximum(centre, 0.0) + _REACH * spread
        k = low + (high - low) / 2.0 * (1.0 + points)
        with np.errstate(under="ignore"):
            inner = k ** (order + 1.0) / (order + 1.0)
            inner *= hyp1f1(1.0, (order + 3.0) / 2.0, -k * k)
            inner *= np.exp(-(((k - centre) / spread) ** 2) / 2.0)
            sums = (inner * weights).sum(axis=-1) * (high - low)[..., 0] / 2.0
        return np.asarray(sums / (spread * math.sqrt(2.0 * math.pi)))

    return weight


def counted_elliptic_curve(
    heights: ArrayLike, pressures: ArrayLike, length: float
) -> CompleteCurve:
    """Return the curve of the summits of given heights, each with its own curvatures.

    Parameters
    ----------
    heights : array_like of float64, shape (n, m)
        Periodic heights on square pixels, length.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    length : float
        Period along the first axis, length.

    Returns
    -------
    CompleteCurve
        With E* = 1; ``diagnostics`` has the ``summits_in_contact``.

    Raises
    ------
    SolverError
        If the heights have no summit, or a pressure is not positive.
    """
    p = checked_pressures(pressures)
    summits = find_summits(heights, checked_length(length))
    return counted_curve(summits.height, summits.effective_curvature, summits.nominal_area, p)


class Elliptic(AsperityModel):
    """Independent summits with their own heights and curvatures."""

    style: ClassVar[Style] = Style("#56B4E9", ((5, 1.5, 1, 1.5, 1, 1.5),))
    page: ClassVar[str] = "docs/models/gw_elliptic.md"

    kind: Literal["gw_elliptic"] = "gw_elliptic"

    @property
    def title(self) -> str:
        """Name in legends and tables."""
        return "Elliptic asperities" + (", counted" if self.uses_heights else "")

    def _of_spectrum(self, spectrum: Spectrum, pressures: FloatArray) -> CompleteCurve:
        return elliptic_curve(spectrum, pressures)

    def _of_heights(
        self, heights: FloatArray, pressures: FloatArray, length: float
    ) -> CompleteCurve:
        return counted_elliptic_curve(heights, pressures, length)
