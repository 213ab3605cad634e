r"""How the contact pressure is distributed over the surface.

Persson's distribution of the pressure, beside that of a state, is

.. math:: P(\sigma) = \frac{1}{\sqrt{2\pi V}}
          \bigl[e^{-(\sigma-p)^2/2V} - e^{-(\sigma+p)^2/2V}\bigr],
          \qquad V = \tfrac14 E^{*2}\xi^2 ,

with :math:`\int_{0+}^\infty P\,d\sigma = A/A_0` and :math:`\int\sigma P\,d\sigma = p`. It
vanishes at :math:`\sigma = 0`; on a grid the pressure of the exact solution does not.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError
from roughbench.observables.base import IN_CONTACT, Observable, Origin
from roughbench.observables.fields import Field, FloatArray, Profile
from roughbench.quantities import Variable

PRESSURE_EDGES = np.linspace(0.0, 3.0, 121)
"""σ/(E*ξ). Persson's distribution has the width ½ in this unit."""


class PressureDensity(Observable):
    """The distribution of the contact pressure over *all* points of the surface.

    Over σ/(E*ξ), the density in this unit: its integral, with the share ``above`` the
    last bin, is the contact area in points, ``contact``. ``nominal`` is p/(E*ξ).
    """

    name = "pressure_pdf"
    title = "Distribution of the contact pressure"
    x, y = "pressure $σ/(E*ξ)$", "density"
    x_is_log = False
    values = Variable("density of the contact pressure over all points, per E* ξ")
    places = Variable("contact pressure / (E* ξ)")
    scalars: ClassVar = {
        "contact": IN_CONTACT,
        "nominal": Variable("nominal pressure p/(E* ξ)"),
        "above": Variable("share of points with a pressure above the bins"),
    }

    def compute(self, field: Field) -> Profile:
        """Return it for one state."""
        sigma = field.pressure[field.contact] / field.rms_slope
        counts, _ = np.histogram(sigma, PRESSURE_EDGES)
        points = field.pressure.size
        return Profile(
            self.name,
            edges=PRESSURE_EDGES,
            places=(PRESSURE_EDGES[1:] + PRESSURE_EDGES[:-1]) / 2.0,
            values=counts / points / np.diff(PRESSURE_EDGES),
            scalars={
                "contact": sigma.size / points,
                "nominal": float(sigma.sum()) / points,
                "above": float((sigma > PRESSURE_EDGES[-1]).sum()) / points,
            },
        )

    def theory(self, origin: Origin, places: FloatArray) -> FloatArray | None:  # noqa: ARG002
        """Return Persson's distribution in the bins, of lines too."""
        if origin.spectrum is None:
            return None
        slope = origin.spectrum.rms_slope
        return np.stack([persson_pressure_shares(p, slope) for p in origin.pressures])


pressure_pdf = PressureDensity()


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
