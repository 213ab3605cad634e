r"""Persson's contact mechanics: area, separation and stiffness from the spectrum alone.

With the slope :math:`\xi(q) = \sqrt{M_2(q)}` of the roughness up to q, and
:math:`w = \sqrt2/\xi`, :math:`x = w p/E^*`, :math:`P = \mathrm{erf}\,x`,

.. math::
    \frac{A}{A_0} &= P(q_1), \\
    \frac{U}{A_0 E^*} &= \frac\pi2\int q^2 C\, P\,[\gamma + (1-\gamma)P^2]\,dq, \\
    \bar u &= \sqrt\pi\int q^2 C\, w\,\Phi(x)\,dq, \qquad
    \Phi(x) = \int_x^\infty g(t)\frac{dt}{t}, \\
    K &= -\frac{dp}{d\bar u} = p\Big/\sqrt\pi\int q^2 C\, w\, g(x)\,dq, \qquad
    g(x) = [\gamma + 3(1-\gamma)\,\mathrm{erf}^2 x]\,e^{-x^2}.

The energy obeys :math:`-dU/d\bar u = pA_0`. The factor :math:`\gamma = 1` gives Persson
(2007), and :math:`\gamma\approx 0.45` Yang and Persson (2008).

**How it is computed.** Written with :math:`\sqrt\pi q^2Cw\,dq = dB`, i.e.
:math:`dB = \sqrt{2/\pi}\,d\xi/q`, all three are integrals of smooth functions of
:math:`\ln\xi`. Since :math:`d\Phi = g\,d\ln\xi` at a given pressure, the separation is by
parts

.. math:: \bar u = \int_0^{\xi(q_1)} [B(q_1) - B(q)]\, g(x)\, d\ln\xi ,

so that :math:`\Phi`, with its logarithm, is never needed and every term is positive.
Panels of eight Gauss-Legendre points are halved until on each the wavevector and the
slope change by less than a given factor, finer where :math:`e^{-x^2}` lives at high
pressure. They count :math:`\ln(q - q_0)` on the first segment, where the
slope starts as :math:`\sqrt{q - q_0}`, and :math:`\ln q` after it; moments come from
:func:`~roughbench.spectrum.power_integral`, so nothing cancels near q0.

**The self-consistent area.** The variance of the pressure in the contact grows with q by
less than at full contact, :math:`dV_{fc} = \tfrac14E^{*2}d\xi^2`, where little touches,

.. math:: dV = [\gamma + (1-\gamma)(A/A_0)^2]\,dV_{fc}, \qquad
          \frac{A}{A_0} = \mathrm{erf}\frac{p}{\sqrt{2V}}.

In :math:`x = p/\sqrt{2V}` the variables separate, so that the area is a function of
:math:`p/(E^*\xi)` alone whatever the spectrum (:func:`self_consistent_area`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from roughbench.errors import SolverError, SurfaceError
from roughbench.inputs import real_number
from roughbench.models._checks import checked_length, checked_positive, checked_pressures
from roughbench.models._persson_quadrature import Quadrature, make_quadrature
from roughbench.models.base import CompleteCurve, FloatArray, Model, Needs, Sample, Status
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum

FiniteSize = Literal["none", "max", "blend"]

_J0 = 0.4071249346343892
"""∫_0^∞ erf² t e^{-t²} dt/t = (2/π)∫_0^1 ln(2 + s²)/(1 + s²) ds."""
_STEPS = 100
_BLOCK = 1 << 17
"""Points times pressures evaluated at once, so that they stay in the cache."""


def persson_curve(
    spectrum: Spectrum, pressures: ArrayLike, gamma: float = 0.45
) -> CompleteCurve:
    r"""Return Persson's area, separation, stiffness and energy; bulk, no finite size.

    The equations stand at the top of this module.

    Parameters
    ----------
    spectrum : Spectrum
        Any chain of power laws: self-affine, or measured with hundreds of segments.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    gamma : float
        γ, 0 < γ ≤ 1: how much less elastic energy a partial contact stores than
        full contact would on the same area.

    Returns
    -------
    CompleteCurve
        With E* = 1. At pressures so high that the separation is zero in double
        precision (p/E* > 19 ξ) the stiffness is inf.

    Raises
    ------
    SolverError
        If γ or a pressure is out of range.
    SurfaceError
        If the spectrum has no power.

    Notes
    -----
    With all panels halved once more, ū, K and U change by less than 1e-11, relative, up to
    the pressure where they vanish or overflow.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=8192, rms_slope=0.1)
    >>> curve = persson_curve(spectrum, [1e-4, 1e-2])
    >>> for area, u in zip(curve.area, curve.separation / spectrum.rms_height, strict=True):
    ...     print(f"{area:.5e} {u:.5e}")
    1.59577e-03 2.41327e+00
    1.58519e-01 1.17933e-01
    """
    p = checked_pressures(pressures)
    _check_gamma(gamma)
    return _evaluate(make_quadrature(spectrum, p.min(initial=math.inf)), p, gamma)


def _evaluate(rule: Quadrature, p: FloatArray, gamma: float) -> CompleteCurve:
    from scipy.special import erf

    w = math.sqrt(2.0) / rule.slope
    compliance, separation, energy = (np.empty(p.size) for _ in range(3))
    block = max(1, _BLOCK // w.size)
    with np.errstate(under="ignore"):
        for start in range(0, p.size, block):
            part = slice(start, start + block)
            x = p[part, None] * w
            contact = erf(x)
            squared = contact * contact
            g = (gamma + 3.0 * (1.0 - gamma) * squared) * np.exp(-x * x)
            compliance[part] = g @ rule.stiffness
            separation[part] = g @ rule.separation
            energy[part] = (contact * (gamma + (1.0 - gamma) * squared)) @ rule.energy
    with np.errstate(divide="ignore", over="ignore"):
        stiffness = p / compliance
    return CompleteCurve(
        pressure=p,
        area=np.asarray(erf(math.sqrt(2.0) / rule.slope_end * p)),
        separation=separation,
        stiffness=stiffness,
        energy=energy,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
    )


def _check_gamma(gamma: float) -> None:
    if not 0.0 < real_number(gamma, "gamma") <= 1.0:
        raise SolverError(f"gamma must satisfy 0 < gamma <= 1, got {gamma}")


def self_consistent_area(pressure_over_slope: ArrayLike, gamma: float) -> FloatArray:
    r"""Return A/A0 = erf x, with the growth of the pressures' variance damped by γ.

    Separated and integrated, the equation at the top of this module is

    .. math:: x = \frac{\sqrt2\,p}{E^*\xi}\sqrt{H(x)}, \qquad
              H(x) = 1 + 2x^2\int_x^\infty
              \Bigl[\frac1{\gamma + (1-\gamma)\,\mathrm{erf}^2y} - 1\Bigr]
              \frac{dy}{y^3},

    where H falls from 1/γ at x = 0 to 1. So A/A0 begins as
    :math:`\sqrt{8/(\pi\gamma)}\,p/(E^*\xi)`, and γ = 1 gives the error function.

    Parameters
    ----------
    pressure_over_slope : array_like of float64, shape (P,)
        p/(E*ξ) > 0.
    gamma : float
        γ, 0 < γ ≤ 1.

    Returns
    -------
    ndarray of float64, shape (P,)

    Raises
    ------
    SolverError
        If γ or a pressure is out of range.

    Examples
    --------
    >>> self_consistent_area([0.01, 0.1, 1.0], gamma=0.5).round(4).tolist()
    [0.0225, 0.2092, 0.9557]
    """
    from scipy.special import erf

    _check_gamma(gamma)
    x_fc = math.sqrt(2.0) * checked_pressures(pressure_over_slope)
    # The logarithm of x/√H rises with a slope of at most one: Newton from its left end,
    # x_fc ≤ x ≤ x_fc/√γ, in the variable where it is nearly a straight line.
    x = x_fc
    for _ in range(_STEPS):
        h = _damping(x, gamma)
        contact = erf(x)
        # d ln(x/√H)/d ln x = 1/(H [γ + (1-γ) erf²])
        gain = h * (gamma + (1.0 - gamma) * contact * contact)
        change = gain * np.log(x_fc * np.sqrt(h) / x)
        x = np.clip(x * np.exp(change), x_fc, x_fc / math.sqrt(gamma))
        if (np.abs(change) < 1e-14).all():
            break
    return np.asarray(erf(x))


def _damping(x: FloatArray, gamma: float) -> FloatArray:
    """H(x) of :func:`self_consistent_area`; with y = x e^s, 1 + 2∫e^{-2s}[…]ds."""
    from scipy.special import erf

    points, weights = np.polynomial.legendre.leggauss(16)
    edges = np.linspace(0.0, 20.0, 41)  # e^-40 is nothing
    half = np.diff(edges)[:, None] / 2.0
    s = (edges[:-1, None] + half + half * points).ravel()
    weight = (2.0 * half * weights).ravel() * np.exp(-2.0 * s)
    with np.errstate(over="ignore"):
        contact = erf(x[:, None] * np.exp(s))
    squared = contact * contact
    missing = (1.0 - gamma) * (1.0 - squared) / (gamma + (1.0 - gamma) * squared)
    return np.asarray(1.0 + missing @ weight)


@dataclass(frozen=True, slots=True)
class Asymptotes:
    r"""The laws of low pressure: separation, eq. (2), area, eq. (3), stiffness, eq. (9).

    .. math:: \bar u = \alpha h \ln\frac{\beta E^*}{p}, \qquad
              K = \frac{p}{\alpha h}, \qquad
              \frac{A}{A_0} = \kappa\frac{p}{E^*\xi}.

    Attributes
    ----------
    alpha : float
        α = u0/h, with h = ``rms_height``.
    beta : float
        β = p0/E*.
    kappa : float
        κ = √(8/π) in Persson's theory.
    rms_height : float
        h of the continuum, √M_0, length.
    rms_slope : float
        ξ of the continuum, √M_2.
    """

    alpha: float
    beta: float
    kappa: float
    rms_height: float
    rms_slope: float

    def separation(self, pressures: ArrayLike) -> FloatArray:
        """Return ū by eq. (2), length, at the pressures p/E*."""
        p = np.asarray(pressures, float)
        return self.alpha * self.rms_height * np.log(self.beta / p)

    def stiffness(self, pressures: ArrayLike) -> FloatArray:
        """Return K by eq. (9), E*/length, at the pressures p/E*."""
        return np.asarray(pressures, float) / (self.alpha * self.rms_height)

    def area(self, pressures: ArrayLike) -> FloatArray:
        """Return A/A0 by eq. (3) at the pressures p/E*."""
        return self.kappa * np.asarray(pressures, float) / self.rms_slope


def persson_asymptotes(spectrum: Spectrum, gamma: float = 0.45) -> Asymptotes:
    r"""Return the constants α, β and κ of a spectrum.

    .. math:: u_0 = \gamma\sqrt\pi\int q^2Cw\,dq, \quad
              u_0\ln\frac{p_0}{E^*} = \sqrt\pi\int q^2 C w
              \{\gamma[-\ln w - \gamma_E/2] + 3(1-\gamma)J(0)\}\,dq

    with Euler's :math:`\gamma_E` and :math:`J(0) = \int_0^\infty \mathrm{erf}^2t\,
    e^{-t^2}dt/t = 0.4071249346`.

    Parameters
    ----------
    spectrum : Spectrum
    gamma : float
        γ, 0 < γ ≤ 1.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=8192, rms_slope=0.1)
    >>> constants = persson_asymptotes(spectrum)
    >>> f"{constants.alpha:.6f} {constants.beta:.5e} {constants.kappa:.4f}"
    '0.499074 6.97737e-03 1.5958'
    """
    _check_gamma(gamma)
    rule = make_quadrature(spectrum)
    log_w = math.log(2.0) / 2.0 - np.log(rule.slope)
    mean_log_w = float(rule.stiffness @ log_w) / rule.total
    constant = 3.0 * (1.0 - gamma) / gamma * _J0
    return Asymptotes(
        alpha=gamma * rule.total / spectrum.rms_height,
        beta=math.exp(constant - mean_log_w - np.euler_gamma / 2.0),
        kappa=math.sqrt(8.0 / math.pi),
        rms_height=spectrum.rms_height,
        rms_slope=spectrum.rms_slope,
    )


def finite_size_stiffness(
    spectrum: Spectrum, pressures: ArrayLike, length: float, theta: float = 1.0
) -> FloatArray:
    r"""Return the stiffness of the few contacts of a finite cell, the paper's eq. (10).

    .. math:: \frac{K h}{E^*} = \theta\left(\frac{h}{L^2 q_r}\right)^{H/(1+H)}
              \left(\frac{p}{E^*}\right)^{1/(1+H)}

    with the *continuum* rms height :math:`h = \sqrt{M_0}`. The paper prints it with
    "≈" and without θ. Exact calculations follow it with θ ≈ 2 to 2.6 when h is that of
    the realized heights, and about 1.95 with the continuum's where q_r = q0 = 2π/L.

    Parameters
    ----------
    spectrum : Spectrum
        Self-affine: with ``hurst`` and ``q_rolloff``.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0.
    length : float
        Side L of the cell, length.
    theta : float
        Prefactor θ > 0.

    Returns
    -------
    ndarray of float64, shape (P,)
        K/E*, 1/length.

    Raises
    ------
    SurfaceError
        If the spectrum has no Hurst exponent or roll-off, as a measured one.
    SolverError
        If θ, the length or a pressure is not positive.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.5, q_min=1, q_rolloff=1, q_max=64, rms_height=0.25)
    >>> finite_size_stiffness(spectrum, [1e-3], length=0.5).round(12).tolist()
    [0.04]
    """
    p = checked_pressures(pressures)
    side = checked_length(length)
    theta = checked_positive(theta, "theta")
    hurst, q_rolloff = spectrum.hurst, spectrum.q_rolloff
    if hurst is None or q_rolloff is None:
        raise SurfaceError(
            "the finite-size stiffness needs a Hurst exponent and a roll-off, which a "
            "measured spectrum has not; use finite_size: none"
        )
    h = spectrum.rms_height
    size = (h / (side * side * q_rolloff)) ** (hurst / (1.0 + hurst))
    return np.asarray(theta / h * size * p ** (1.0 / (1.0 + hurst)))


def _combine(
    bulk: FloatArray, finite: FloatArray, how: Literal["max", "blend"], m: float
) -> FloatArray:
    """Join the bulk and the finite-size stiffness: the larger, or (a^m + b^m)^(1/m)."""
    larger = np.maximum(bulk, finite)
    if how == "max":
        return larger
    with np.errstate(under="ignore"):
        ratio = np.minimum(bulk, finite) / larger
        return np.asarray(larger * (1.0 + ratio**m) ** (1.0 / m))


class Persson(Model):
    """Persson's theory, from the spectrum alone."""

    needs: ClassVar[Needs] = "spectrum"
    title: ClassVar[str] = "Persson"
    style: ClassVar[Style] = Style("#D55E00", ((3, 3), (1.5, 1.5), (6, 3)))
    page: ClassVar[str] = "docs/models/persson.md"
    iterative: ClassVar[bool] = False

    kind: Literal["persson"] = "persson"
    gamma: float = Field(
        default=0.45,
        gt=0.0,
        le=1.0,
        description="γ of Yang and Persson (2008): 1 is the theory of 2007, 0.45 the usual "
        "value, and 0.33 to 0.45 fit exact stiffnesses.",
    )
    finite_size: FiniteSize = Field(
        default="none",
        description="How the finite-size stiffness K_fs of the paper's eq. (10) enters K: "
        "none; max takes the larger of K_fs and the bulk K_P, as the "
        "stiffness of the paper's Fig. 4; "
        "blend takes (K_fs^m + K_P^m)^(1/m). Area, separation and energy stay those of the "
        "bulk, so that K is -dp/dū of them with none only.",
    )
    theta: float = Field(
        default=1.0,
        gt=0.0,
        allow_inf_nan=False,
        description="Prefactor θ of eq. (10), 1 as printed; exact calculations give 2 to 2.6.",
    )
    m: float = Field(
        default=2.0,
        ge=1.0,
        le=100.0,
        description="Exponent of finite_size: blend; large ones tend to max. The best one "
        "depends on the spectrum.",
    )

    area_gamma: float | None = Field(
        default=None,
        gt=0.0,
        le=1.0,
        description="γ of a self-consistent area: less than 1 damps the spread of the "
        "pressures where little touches, and 0.5 agrees with exact areas to some percent; "
        "default: the error function of Persson's theory, as 1.",
    )

    def unused_options(self) -> Mapping[str, str]:
        """θ and m, where the finite-size stiffness does not use them."""
        needs = {"theta": ("max", "blend"), "m": ("blend",)}
        return {
            option: f"has no effect with finite_size: {self.finite_size}; remove it, or "
            f"choose {' or '.join(choices)}"
            for option, choices in needs.items()
            if self.finite_size not in choices
        }

    def refused_with_given_heights(self) -> Mapping[str, str]:
        """Refuse the finite-size stiffness, which is that of a self-affine spectrum."""
        if self.finite_size == "none":
            return {}
        message = "needs H and qr, which heights from a file do not have; choose none"
        return {"finite_size": message}

    @classmethod
    def legend(cls, attributes: Mapping[str, Any], quantity: str) -> Sequence[str]:
        """Return the γ that a quantity depends on, and whether K is that of a finite size."""
        if quantity == "area" and "area_gamma" in attributes:
            return [rf"$\gamma_A = {attributes['area_gamma']:g}$"]
        shown = [rf"$\gamma = {attributes['gamma']:g}$"] if "gamma" in attributes else []
        if quantity == "stiffness" and attributes.get("finite_size", "none") != "none":
            shown.append("finite size")
        return shown

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the curve of the sample's spectrum; heights are not looked at."""
        if sample.spectrum is None:
            raise SurfaceError(
                "Persson's theory needs a spectrum; measured_spectrum gives that of heights"
            )
        curve = persson_curve(sample.spectrum, pressures, self.gamma)
        if self.area_gamma is not None:
            scaled = curve.pressure / sample.spectrum.rms_slope
            curve = replace(curve, area=self_consistent_area(scaled, self.area_gamma))
        if self.finite_size == "none":
            return curve
        finite = finite_size_stiffness(
            sample.spectrum, curve.pressure, sample.length, self.theta
        )
        return replace(
            curve, stiffness=_combine(curve.stiffness, finite, self.finite_size, self.m)
        )
