r"""Functions of the wavevector: modes gathered in rings, ten per decade.

For a function f on the grid, :math:`C_f(q) = (L/2\pi)^2\langle|f_q|^2\rangle` over the
modes of a ring of wavevectors, in the convention of :mod:`roughbench.spectrum`: its
integral :math:`2\pi\int qC_f\,dq` is the variance of f. (On a line
:math:`(L/2\pi)\langle|f_q|^2\rangle`, two-sided.)

On a self-affine surface at small loads the exponents are

=========================================  ============
stress and contact, elastically coupled    −(1 + H)
contact of independent springs (overlap)   −(2 + H)
stress of independent springs              −(2 + 2H)
=========================================  ============
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.observables.base import Observable, Origin
from roughbench.observables.fields import Field, FloatArray, Profile
from roughbench.quantities import Variable
from roughbench.spectrum import Spectrum, wavenumbers

RINGS_PER_DECADE = 10
WAVEVECTOR = Variable("wavevector q", length=-1)


@dataclass(frozen=True, slots=True)
class Modes:
    """The modes of a function on the grid but the uniform one, and their rings.

    Attributes
    ----------
    power : ndarray of float64, shape (n,)
        |f_q|².
    weight : ndarray of float64, shape (n,)
        How many modes each stands for.
    q : ndarray of float64, shape (n,)
        |q|, 1/length.
    ring : ndarray of int64, shape (n,)
    edges : ndarray of float64, shape (rings + 1,)
        Ends of the rings, 1/length.
    """

    power: FloatArray
    weight: FloatArray
    q: FloatArray
    ring: NDArray[np.int64]
    edges: FloatArray

    def total(self, values: FloatArray) -> FloatArray:
        """Return the sum over the modes of each ring."""
        return np.bincount(self.ring, self.weight * values, self.edges.size - 1).astype(
            np.float64
        )

    def mean(self, values: FloatArray, scale: float = 1.0) -> FloatArray:
        """Return the mean over the modes of each ring, times a scale; nan for none."""
        number = self.total(np.ones(self.q.shape))
        mean = np.full(number.shape, math.nan)
        np.divide(self.total(values) * scale, number, out=mean, where=number > 0.0)
        return mean

    @property
    def places(self) -> FloatArray:
        """The geometric mean of the wavevectors of each ring, nan for none."""
        return np.exp(self.mean(np.log(self.q)))


def modes_of(values: FloatArray, field: Field) -> Modes:
    """Return the modes of a function on the grid of a field."""
    transform = np.fft.rfftn(values, norm="forward")
    power = (np.abs(transform) ** 2).ravel()[1:]
    weight = np.full(transform.shape, 2.0)
    weight[..., 0] = 1.0
    if values.shape[-1] % 2 == 0:
        weight[..., -1] = 1.0
    q = wavenumbers(values.shape, field.length).ravel()[1:]
    lowest = 2.0 * math.pi / (field.spacing * max(values.shape))
    # The first edge is below the longest wave by half a ring.
    steps = RINGS_PER_DECADE * np.log10(q / lowest) + 0.5
    ring = np.floor(steps + 1e-9).astype(np.int64)
    edges = lowest * 10.0 ** ((np.arange(ring.max() + 2) - 0.5) / RINGS_PER_DECADE)
    return Modes(power, weight.ravel()[1:], q, ring, edges)


class SpectralDensity(Observable):
    """The power spectrum of a function of the fields.

    Subclasses say of which, and fill :attr:`scalars` with :meth:`described`. ``variance`` is
    the integral; ``exponent``, where the spectrum of the surface is known, the slope of
    ln C over ln q between the wavevectors of :func:`exponent_range`.
    """

    x = "wavevector $q$"
    places = WAVEVECTOR
    attributes: ClassVar[tuple[str, ...]] = ("exponent_from", "exponent_to")

    @abstractmethod
    def function(self, field: Field) -> FloatArray:
        """Return the function whose spectrum it is."""

    @staticmethod
    def described(variance: str, exponent: str, modulus: int = 0) -> dict[str, Variable]:
        """Return what the single numbers mean; ``modulus``: power of E* in the variance."""
        return {
            "variance": Variable(f"variance of {variance}", modulus=modulus),
            "exponent": Variable(f"exponent of the power spectrum of {exponent}"),
        }

    def compute(self, field: Field) -> Profile:
        """Return it for one state: length², of a line length."""
        values = self.function(field)
        modes = modes_of(values, field)
        volume = field.spacing**values.ndim * values.size / (2.0 * math.pi) ** values.ndim
        density = modes.mean(modes.power, volume)
        variance = float(modes.total(modes.power).sum())
        found = Profile(self.name, modes.edges, modes.places, density, {"variance": variance})
        if field.spectrum is None:
            return found
        try:
            slope = exponent([found], *exponent_range(field.spectrum))[0]
        except SolverError:  # too few rings, or none with power: there is no exponent
            slope = math.nan
        return replace(found, scalars={"variance": variance, "exponent": slope})

    def parameters(self, origin: Origin) -> Mapping[str, float]:
        """Return the wavevectors between which the exponent is fitted."""
        if origin.spectrum is None:
            return {}
        low, high = exponent_range(origin.spectrum)
        return {"exponent_from": low, "exponent_to": high}

    def drawn_unit(self, places: FloatArray, dimension: int) -> FloatArray:
        """Return πq for a line, whose spectrum stands for the surface's mapped to it."""
        return math.pi * places if dimension == 1 else np.ones(places.shape)


def exponent_range(spectrum: Spectrum) -> tuple[float, float]:
    """Return the wavevectors between which spectra of the fields are fitted.

    The larger of twice the roll-off and an eighth of the cut-off, and half the cut-off.
    """
    rolloff = spectrum.q_rolloff or spectrum.q_min
    return max(2.0 * rolloff, spectrum.q_max / 8.0), spectrum.q_max / 2.0


def exponent(profiles: Sequence[Profile], q_low: float, q_high: float) -> tuple[float, float]:
    """Return the exponent of a spectrum between two wavevectors, and its standard error.

    Parameters
    ----------
    profiles : sequence of Profile
        One a realization.
    q_low, q_high : float
        1/length; at least three rings between them.

    Returns
    -------
    (float, float)
        Mean over the realizations of the least-squares slopes of ln C over ln q, and its
        standard error (nan for one realization).

    Raises
    ------
    SolverError
        If there are fewer than three rings, or one of them holds no power.
    """
    slopes = []
    for profile in profiles:
        inside = (profile.places >= q_low) & (profile.places <= q_high)
        values = profile.values[inside]
        if values.size < 3 or not (values > 0.0).all():
            raise SolverError(
                f"{profile.name} has {values.size} rings between q = {q_low:g} and "
                f"{q_high:g}; a slope needs three with power"
            )
        slopes.append(float(np.polyfit(np.log(profile.places[inside]), np.log(values), 1)[0]))
    if not slopes:
        raise SolverError("an exponent needs at least one realization")
    error = (
        float(np.std(slopes, ddof=1)) / math.sqrt(len(slopes)) if len(slopes) > 1 else math.nan
    )
    return float(np.mean(slopes)), error
