r"""The spectrum of the contact pressure, and Persson's.

.. math:: C_\sigma(q) = \tfrac14 E^{*2}q^2C(q)\,P\,[\gamma + (1-\gamma)P^2], \qquad
          P = \mathrm{erf}\frac{\sqrt2\,p}{E^*\xi(q)} .
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError
from roughbench.observables.base import Origin
from roughbench.observables.fields import Field, FloatArray
from roughbench.observables.rings import SpectralDensity
from roughbench.quantities import Variable
from roughbench.spectrum import Spectrum

GAMMA = 0.45
"""Of Persson's spectrum beside the models'."""


class StressSpectrum(SpectralDensity):
    """C_σ(q) of the contact pressure in units of E*.

    ``variance`` is that of σ/E*.
    """

    name = "stress_spectrum"
    title = "Spectrum of the contact pressure"
    y = "$C_σ(q)/E*²$; of lines $C_σ/πq$"
    values = Variable(
        "power spectrum C(q) of the contact pressure / E*", per_dimension=1, modulus=2
    )
    scalars = SpectralDensity.described("the contact pressure / E*", "the pressure", modulus=2)
    attributes: ClassVar[tuple[str, ...]] = (*SpectralDensity.attributes, "persson_gamma")

    def function(self, field: Field) -> FloatArray:
        """Return σ/E*."""
        return field.pressure

    def theory(self, origin: Origin, places: FloatArray) -> FloatArray | None:
        """Return Persson's spectrum, of surfaces."""
        spectrum = origin.spectrum
        if spectrum is None or origin.dimension != 2:
            return None
        held = places > spectrum.q_min  # ξ(q) > 0
        values = np.full((len(origin.pressures), places.size), math.nan)
        for k, p in enumerate(origin.pressures):
            values[k, held] = persson_stress_spectrum(spectrum, places[held], p, GAMMA)
        return values

    def theory_title(self, attributes: Mapping[str, object]) -> str:
        """Return the legend's text, with γ."""
        return rf"Persson, $\gamma = {attributes['persson_gamma']:g}$"

    def parameters(self, origin: Origin) -> Mapping[str, float]:
        """Return the range of the exponent, and γ of the theory."""
        found = super().parameters(origin)
        if origin.spectrum is None or origin.dimension != 2:
            return found
        return {**found, "persson_gamma": GAMMA}


stress_spectrum = StressSpectrum()


def persson_stress_spectrum(
    spectrum: Spectrum, q: ArrayLike, nominal: float, gamma: float = 0.45
) -> FloatArray:
    """Return Persson's C_σ(q) of a surface in units of E*; the equation stands above.

    Parameters
    ----------
    spectrum : Spectrum
    q : array_like of float64
        1/length.
    nominal : float
        p/E* > 0.
    gamma : float
        0 < γ ≤ 1.

    Returns
    -------
    ndarray of float64
        length².

    Raises
    ------
    SolverError
        If the pressure or γ is out of its range.
    """
    if not nominal > 0.0 or not 0.0 < gamma <= 1.0:
        raise SolverError("Persson's stress spectrum needs p > 0 and 0 < γ ≤ 1")
    wave = np.asarray(q, float)
    slope = np.array([math.sqrt(spectrum.moment(2, k)) for k in wave.ravel()])
    with np.errstate(divide="ignore"):
        argument = math.sqrt(2.0) * nominal / slope
    contact = np.array([math.erf(x) for x in argument]).reshape(wave.shape)
    damped = contact * (gamma + (1.0 - gamma) * contact**2)
    return np.asarray(0.25 * wave**2 * spectrum.psd_2d(wave) * damped)
