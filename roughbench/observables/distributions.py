r"""How pressures and gaps are distributed over the surface.

Persson's distribution of the pressure, beside that of a state, is

.. math:: P(\sigma) = \frac{1}{\sqrt{2\pi V}}
          \bigl[e^{-(\sigma-p)^2/2V} - e^{-(\sigma+p)^2/2V}\bigr],
          \qquad V = \tfrac14 E^{*2}\xi^2 ,

with :math:`\int_{0+}^\infty P\,d\sigma = A/A_0` and :math:`\int\sigma P\,d\sigma = p`. It
vanishes at :math:`\sigma = 0`; on a grid the pressure of the exact solution does not.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError
from roughbench.observables.fields import Field, FloatArray, Profile

PRESSURE_EDGES = np.linspace(0.0, 3.0, 121)
"""σ/(E*ξ). Persson's distribution has the width ½ in this unit."""
GAP_EDGES = np.geomspace(1e-4, 10.0, 101)
"""g/h_rms."""


def pressure_pdf(state: Field) -> Profile:
    """Return the distribution of the contact pressure over *all* points of the surface.

    Returns
    -------
    Profile
        Over σ/(E*ξ), the density in this unit: its integral, with the share ``above`` the
        last bin, is the contact area in points, ``contact``. ``nominal`` is p/(E*ξ).
    """
    sigma = state.pressure[state.contact] / state.rms_slope
    counts, _ = np.histogram(sigma, PRESSURE_EDGES)
    points = state.pressure.size
    return Profile(
        name="pressure_pdf",
        axis="contact pressure / (E* ξ)",
        edges=PRESSURE_EDGES,
        places=(PRESSURE_EDGES[1:] + PRESSURE_EDGES[:-1]) / 2.0,
        values=counts / points / np.diff(PRESSURE_EDGES),
        scalars={
            "contact": sigma.size / points,
            "nominal": float(sigma.sum()) / points,
            "above": float((sigma > PRESSURE_EDGES[-1]).sum()) / points,
        },
    )


def gap_pdf(state: Field) -> Profile:
    """Return the distribution of the gap over the points out of contact.

    Returns
    -------
    Profile
        Over g/h_rms, the density in this unit among *all* points: its integral, with the
        shares ``below`` and ``above`` the bins and in ``contact``, is one.
        ``separation`` is ū/h_rms.
    """
    gap = state.gap[~state.contact] / state.rms_height
    counts, _ = np.histogram(gap, GAP_EDGES)
    points = state.pressure.size
    return Profile(
        name="gap_pdf",
        axis="gap / h_rms",
        edges=GAP_EDGES,
        places=np.sqrt(GAP_EDGES[1:] * GAP_EDGES[:-1]),
        values=counts / points / np.diff(GAP_EDGES),
        scalars={
            "contact": 1.0 - gap.size / points,
            "separation": float(gap.sum()) / points,
            "below": float((gap < GAP_EDGES[0]).sum()) / points,
            "above": float((gap > GAP_EDGES[-1]).sum()) / points,
        },
    )


def persson_pressure_pdf(pressure: ArrayLike, nominal: float, rms_slope: float) -> FloatArray:
    """Return Persson's density P(σ) at contact pressures σ/E*; the equation stands above.

    Parameters
    ----------
    pressure : array_like of float64
        σ/E* ≥ 0.
    nominal : float
        p/E* > 0.
    rms_slope : float
        ξ > 0.

    Returns
    -------
    ndarray of float64
        Per unit of σ/E*; the share in contact is its integral.

    Raises
    ------
    SolverError
        If an argument is out of its range.

    Examples
    --------
    >>> sigma = np.linspace(0.0, 1.0, 100001)
    >>> density = persson_pressure_pdf(sigma, 0.01, 0.1)
    >>> f"{np.sum(density) * 1e-5:.6f} {np.sum(sigma * density) * 1e-5:.8f}"
    '0.158519 0.01000000'
    """
    sigma = np.asarray(pressure, float)
    if not (nominal > 0.0 and rms_slope > 0.0 and (sigma >= 0.0).all()):
        raise SolverError("Persson's distribution needs σ ≥ 0, p > 0 and ξ > 0")
    variance = rms_slope**2 / 4.0
    with np.errstate(under="ignore"):
        # The difference of both exponentials, without cancellation at small σ.
        peak = np.exp(-((sigma - nominal) ** 2) / (2.0 * variance))
        part = -np.expm1(-2.0 * sigma * nominal / variance)
    return np.asarray(peak * part / math.sqrt(2.0 * math.pi * variance))


def persson_pressure_shares(nominal: float, rms_slope: float) -> FloatArray:
    """Return Persson's distribution in the bins of :func:`pressure_pdf`, and in its unit.

    Parameters
    ----------
    nominal : float
        p/E* > 0.
    rms_slope : float
        ξ > 0.

    Returns
    -------
    ndarray of float64, shape (120,)
        Mean density over each bin.
    """
    points, weights = np.polynomial.legendre.leggauss(16)
    half = np.diff(PRESSURE_EDGES)[:, None] / 2.0
    sigma = PRESSURE_EDGES[:-1, None] + half * (1.0 + points)
    density = persson_pressure_pdf(sigma, nominal / rms_slope, 1.0)
    return np.asarray((density * weights).sum(axis=1) / 2.0)
