r"""The Hurst exponent once more, from profiles along one axis.

A profile of a surface with the law :math:`C_{2D}` has
:math:`C_x(q_x) = 2\int_0^\infty C_{2D}(\sqrt{q_x^2 + q_y^2})\,dq_y`, about
:math:`q_x^{-1-2H}` far from the ends of the law. Level and H are fitted to that, with the ends
that the surface's spectrum has shown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.law import Law
from roughbench.scans.measured_spectrum import HANN_WIDTH, MeasuredSpectrum
from roughbench.scans.self_affine_fit import SelfAffineFit

FloatArray = NDArray[np.float64]

_PANELS = 48
_STEPS = 40
_FEWEST = 6


@dataclass(frozen=True, slots=True)
class ProfileFit:
    """What profiles along one axis say.

    Attributes
    ----------
    hurst, hurst_error : float
        H and its standard deviation.
    level : float
        Power over that of the law of the surface, both fitted; 1 for an isotropic surface.
    """

    hurst: float
    hurst_error: float
    level: float


def fit_profiles(spectrum: MeasuredSpectrum, fit: SelfAffineFit) -> ProfileFit | None:
    """Fit level and H to the spectrum of profiles; None where too little is left of it.

    Parameters
    ----------
    spectrum : MeasuredSpectrum
        Of profiles.
    fit : SelfAffineFit
        Of the surface.
    """
    first = max(fit.q_min, 2.0 * float(spectrum.q[0]) if spectrum.windowed else 0.0)
    inside = (spectrum.q >= first) & (spectrum.q <= 0.7 * fit.q_max)
    q, power = spectrum.q[inside], spectrum.power[inside]
    if q.size < _FEWEST:
        return None
    weights = spectrum.independent[inside] / (HANN_WIDTH if spectrum.windowed else 1.0)
    # The scatter of the surface's spectrum about the law, shared by a bin's wavevectors.
    bins = np.floor(np.log10(q / q[0]) * 12.0 + 1e-9).astype(np.int64)
    weights = weights / (1.0 + fit.scatter**2 * np.bincount(bins, weights)[bins])
    pivot = float(np.exp(np.mean(np.log(q))))
    expected = _profile(q, fit, fit.hurst, pivot)
    level, hurst = math.log(float(np.mean(power / expected))), fit.hurst
    information = np.eye(2)
    for _ in range(_STEPS):
        model = _profile(q, fit, hurst, pivot)
        by_hurst = (np.log(_profile(q, fit, hurst + 1e-4, pivot)) - np.log(model)) / 1e-4
        g = np.stack([np.ones_like(q), by_hurst])
        ratio = power / (model * math.exp(level))
        information = (weights * g) @ g.T
        step = np.linalg.solve(information, (weights * g) @ (ratio - 1.0))
        step *= min(1.0, 0.5 / float(np.abs(step).max()))
        level, hurst = level + float(step[0]), hurst + float(step[1])
        if float(np.abs(step).max()) < 1e-7:
            break
    covariance = np.linalg.inv(information)
    # With the surface's own law, how much power is there?
    ratio = power / _profile(
        q, fit, fit.hurst, pivot, fit.spectrum().psd_2d(np.array([pivot]))[0]
    )
    return ProfileFit(
        hurst=hurst,
        hurst_error=math.sqrt(covariance[1, 1]),
        level=float(np.sum(weights * ratio) / weights.sum()),
    )


def _profile(
    q: FloatArray, fit: SelfAffineFit, hurst: float, pivot: float, power: float = 1.0
) -> FloatArray:
    """∫C2D dq_y of a law between q0 and q1, with C2D(pivot) = power."""
    law = Law(0.0, hurst, fit.q_rolloff, pivot)
    nodes, weights = np.polynomial.legendre.leggauss(_PANELS)
    # q_y = q_x sinh t, so that |q| = q_x cosh t.
    end = np.arccosh(np.maximum(fit.q_max / q, 1.0))
    begin = np.arccosh(np.maximum(fit.q_min / q, 1.0))
    half = (end - begin)[:, None] / 2.0
    t = begin[:, None] + half * (1.0 + nodes)
    size = q[:, None] * np.cosh(t)
    level = float(law.log_power(np.array([pivot]))[0])
    values = np.exp(law.log_power(size.ravel()).reshape(size.shape) - level) * size
    result: FloatArray = 2.0 * power * np.sum(values * weights * half, axis=1)
    return result
