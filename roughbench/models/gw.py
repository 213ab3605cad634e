r"""Greenwood and Williamson's asperities: spheres of one radius, independent of each other.

The summits of an isotropic Gaussian surface have, by Nayak's random-process theory with
McCool's constants, from the profile moments :math:`m_0 = M_0`, :math:`m_2 = M_2/2`,
:math:`m_4 = 3M_4/8` and :math:`\alpha = m_0m_4/m_2^2`,

.. math::
    \eta = \frac{m_4}{6\pi\sqrt3\,m_2}, \quad R = \frac{3\sqrt\pi}{8\sqrt{m_4}}, \quad
    \sigma_s^2 = \Bigl(1 - \frac{0.8968}{\alpha}\Bigr)m_0, \quad
    \bar z = 4\sqrt{\frac{m_0}{\pi\alpha}} ,

a density, one radius for all, and normally distributed heights. With
:math:`t = (d-\bar z)/\sigma_s` and :math:`F_n = \int_t^\infty (s-t)^n\varphi\,ds`,

.. math::
    p = \tfrac43E^*\eta R^{1/2}\sigma_s^{3/2}F_{3/2}, \quad
    \frac{A}{A_0} = \pi\eta R\sigma_s F_1, \quad
    K = 2E^*\eta(R\sigma_s)^{1/2}F_{1/2}, \quad \bar u = d .

The same with the *counted* summits of actual heights: each at its own height, with the
radius :math:`R = 1/\langle\kappa_m\rangle` of their mean curvature.

Source: J. A. Greenwood and J. B. P. Williamson (1966); P. R. Nayak (1971); J. I. McCool
(1987).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from roughbench.errors import SolverError, SurfaceError
from roughbench.models._asperities import Distribution, counted_curve, integrated_curve
from roughbench.models._checks import checked_length, checked_pressures
from roughbench.models._grids import GridOption, HeightsOrSpectrum
from roughbench.models._summits import find_summits
from roughbench.models.base import CompleteCurve, FloatArray, Sample
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum

SummitSource = Literal["nayak", "counted"]


@dataclass(frozen=True, slots=True)
class SummitStatistics:
    """What Greenwood and Williamson's model knows of the summits.

    Attributes
    ----------
    density : float
        η, summits per area, 1/length².
    radius : float
        R, length.
    deviation : float
        σ_s, standard deviation of the summits' heights, length.
    mean : float
        z̄, mean height of the summits above the mean plane, length.
    """

    density: float
    radius: float
    deviation: float
    mean: float


def summit_statistics(spectrum: Spectrum) -> SummitStatistics:
    """Return density, radius and heights of the summits, by Nayak and McCool.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=8192, rms_slope=0.1)
    >>> found = summit_statistics(spectrum)
    >>> f"{found.density:.4g} {found.radius:.4g}"
    '3.574e+05 0.002752'
    """
    m0, m2, m4 = (
        spectrum.moment(0),
        spectrum.moment(2) / 2.0,
        3.0 * spectrum.moment(4) / 8.0,
    )
    alpha = spectrum.nayak
    return SummitStatistics(
        density=m4 / (6.0 * math.pi * math.sqrt(3.0) * m2),
        radius=3.0 * math.sqrt(math.pi / m4) / 8.0,
        deviation=math.sqrt((1.0 - 0.8968 / alpha) * m0),
        mean=4.0 * math.sqrt(m0 / (math.pi * alpha)),
    )


def gw_curve(spectrum: Spectrum, pressures: ArrayLike) -> CompleteCurve:
    r"""Return Greenwood and Williamson's curve of a spectrum.

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
    >>> curve = gw_curve(spectrum, [1e-6, 1e-2])
    >>> (curve.area * 0.1 / curve.pressure).round(2).tolist()  # κ, far below √(2π)
    [0.32, 0.25]
    """
    p = checked_pressures(pressures)
    found = summit_statistics(spectrum)
    summits = Distribution(
        mean=found.mean,
        deviation=found.deviation,
        load=found.density * math.sqrt(found.radius),
        area=math.pi * found.density * found.radius,
    )
    return integrated_curve(summits, p)


def counted_gw_curve(heights: ArrayLike, pressures: ArrayLike, length: float) -> CompleteCurve:
    """Return the curve of spheres of one radius at the summits of given heights.

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
    curvature = np.full(summits.height.shape, float(summits.mean_curvature.mean()))
    return counted_curve(summits.height, curvature, summits.nominal_area, p)


class AsperityModel(HeightsOrSpectrum):
    """What the models of independent summits share: where they take the summits from."""

    iterative: ClassVar[bool] = False
    idle_grid: ClassVar[str] = "has no effect with summits: nayak; remove it, or choose counted"

    summits: SummitSource = Field(
        default="nayak",
        description="nayak: distribution of the summits of a Gaussian surface with this "
        "spectrum; counted: the maxima of the surfaces that bem is given.",
    )
    grid: GridOption = Field(
        default=None,
        description="Points per side of the surfaces whose summits are counted; default: "
        "as bem, 4 on the shortest wavelength.",
    )

    @property
    def uses_heights(self) -> bool:
        """Whether it works on the heights of surfaces."""
        return self.summits == "counted"

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the curve of the spectrum, or of the summits of one surface."""
        if not self.uses_heights:
            if sample.spectrum is None:
                raise SurfaceError(f"{self.kind} with summits: nayak needs a spectrum")
            return self._of_spectrum(sample.spectrum, pressures)
        if sample.heights is None:
            raise SolverError(f"{self.kind} with summits: counted needs heights")
        return self._of_heights(sample.heights, pressures, sample.length)

    @abstractmethod
    def _of_spectrum(self, spectrum: Spectrum, pressures: FloatArray) -> CompleteCurve: ...

    @abstractmethod
    def _of_heights(
        self, heights: FloatArray, pressures: FloatArray, length: float
    ) -> CompleteCurve: ...


class GreenwoodWilliamson(AsperityModel):
    """Independent spheres of one radius at the summits."""

    style: ClassVar[Style] = Style("#E69F00", ((1.2, 1.2),))
    page: ClassVar[str] = "docs/models/gw.md"

    kind: Literal["gw"] = "gw"

    @property
    def title(self) -> str:
        """Name in legends and tables."""
        return "Greenwood–Williamson" + (", counted summits" if self.uses_heights else "")

    def _of_spectrum(self, spectrum: Spectrum, pressures: FloatArray) -> CompleteCurve:
        return gw_curve(spectrum, pressures)

    def _of_heights(
        self, heights: FloatArray, pressures: FloatArray, length: float
    ) -> CompleteCurve:
        return counted_gw_curve(heights, pressures, length)
