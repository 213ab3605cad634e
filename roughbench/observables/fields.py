"""What the observables look at: pressure and gap of one contact, and what they return."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roughbench.ensemble import mean_and_error
from roughbench.errors import SolverError
from roughbench.inputs import real_array
from roughbench.spectrum import Spectrum

FloatArray = NDArray[np.float64]


class Units(Protocol):
    """The units of pressures and gaps, as a spectrum has them."""

    @property
    def rms_slope(self) -> float:
        """ξ: pressures are in units of E*ξ."""

    @property
    def rms_height(self) -> float:
        """h_rms, length: gaps are in units of it."""


@dataclass(frozen=True, slots=True)
class Scales:
    """Units for heights without a spectrum.

    Attributes
    ----------
    rms_slope : float
    rms_height : float
        Length.
    """

    rms_slope: float
    rms_height: float


@dataclass(frozen=True, slots=True)
class Field:
    """Pressure and gap of one state on a periodic grid of square pixels.

    Attributes
    ----------
    pressure : ndarray of float64, shape (n, m) or (n,)
        Contact pressure σ/E*, zero out of contact.
    gap : ndarray of float64, of the same shape
        Local separation, length; of no account where the pressure is positive.
    length : float
        Period along the first axis, length.
    rms_slope, rms_height : float
        ξ and h_rms (length) of the spectrum or of the heights: the units of pressures
        and gaps, so that surfaces can be averaged bin by bin.
    modulus : float or None
        k_w/E* of independent springs, 1/length; None for a half-space.
    screening : float
        q_c of a half-space, 1/length; 0 for none.
    spectrum : Spectrum or None
        Of the surface, where it is known.
    """

    pressure: FloatArray
    gap: FloatArray
    length: float
    rms_slope: float
    rms_height: float
    modulus: float | None = None
    spectrum: Spectrum | None = None
    screening: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no state.

        Raises
        ------
        SolverError
            If shapes differ, or values are not finite or out of their range.
        """
        for name in ("pressure", "gap"):
            real_array(getattr(self, name), f"values of {name}")
        if self.pressure.shape != self.gap.shape or self.pressure.ndim not in (1, 2):
            raise SolverError(
                "pressure and gap must be of one shape, (n,) or (n, m), got "
                f"{self.pressure.shape} and {self.gap.shape}"
            )
        if not (np.isfinite(self.pressure).all() and np.isfinite(self.gap).all()):
            raise SolverError("pressure and gap must be finite")
        if (self.pressure < 0.0).any():
            raise SolverError("a contact without adhesion has no negative pressure")
        if not 0.0 <= self.screening < math.inf:
            raise SolverError(f"screening must be at least 0, got {self.screening}")
        for name in ("length", "rms_slope", "rms_height"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise SolverError(f"{name} must be positive and finite")

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Where the pressure is positive."""
        return self.pressure > 0.0

    @property
    def nominal(self) -> float:
        """Nominal pressure p/E*."""
        return float(self.pressure.mean())

    @property
    def spacing(self) -> float:
        """Side of a pixel, length."""
        return self.length / self.pressure.shape[0]


@dataclass(frozen=True, slots=True)
class Profile:
    """An observable of one state.

    Attributes
    ----------
    name : str
    edges : ndarray of float64, shape (K + 1,)
        Ends of the bins, the same for all realizations of an ensemble.
    places : ndarray of float64, shape (K,)
        Where in its bin a value stands; nan for an empty ring of wavevectors.
    values : ndarray of float64, shape (K,)
    scalars : mapping of str to float
        Single numbers that belong to it.
    """

    name: str
    edges: FloatArray
    places: FloatArray
    values: FloatArray
    scalars: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Average:
    """An observable averaged over an ensemble.

    Attributes
    ----------
    name, edges, places
        As of its profiles.
    mean, sem : ndarray of float64, shape (K,)
        Mean and its standard error (nan for a single realization).
    scalars : mapping of str to (float, float)
        Mean and standard error of each single number.
    count : int
        Number of realizations.
    """

    name: str
    edges: FloatArray
    places: FloatArray
    mean: FloatArray
    sem: FloatArray
    scalars: Mapping[str, tuple[float, float]]
    count: int


def average(profiles: Sequence[Profile]) -> Average:
    """Average one observable over the realizations of an ensemble.

    Parameters
    ----------
    profiles : sequence of Profile
        Of states with the same grid, units and nominal pressure.

    Raises
    ------
    SolverError
        If there is none, or they have other bins.
    """
    if not profiles:
        raise SolverError("an average needs at least one realization")
    first = profiles[0]
    for other in profiles[1:]:
        if other.name != first.name or not np.array_equal(other.edges, first.edges):
            raise SolverError(f"the realizations of {first.name} have different bins")
    mean, sem = mean_and_error(np.stack([profile.values for profile in profiles]))
    scalars = {}
    for name in first.scalars:
        a, b = mean_and_error([[profile.scalars[name]] for profile in profiles])
        scalars[name] = (float(a[0]), float(b[0]))
    return Average(first.name, first.edges, first.places, mean, sem, scalars, len(profiles))
