"""What the fields of a contact say beyond their averages.

>>> import numpy as np
>>> import roughbench as rb
>>> from roughbench.observables import OBSERVABLES, average, of_state
>>> from roughbench.spectrum import self_affine
>>> from roughbench.surface import make_surface, realization_generator
>>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=4, q_max=16, rms_slope=0.1)
>>> states = []
>>> for realization in range(3):
...     generator = realization_generator(1, realization)
...     heights = make_surface(spectrum, 64, 2 * np.pi, generator)
...     solved = rb.solve_contact(heights, 0.01, length=2 * np.pi, threads=1)
...     states.append(of_state(solved, 2 * np.pi, spectrum))
>>> pressures = average([OBSERVABLES["pressure_pdf"](state) for state in states])
>>> pressures.count, round(pressures.scalars["nominal"][0], 6)  # p/(E* ξ)
(3, 0.1)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.inputs import float_array
from roughbench.models.base import Fields
from roughbench.observables.base import Observable, Origin
from roughbench.observables.contact import contact_spectrum
from roughbench.observables.energy import energy_spectrum
from roughbench.observables.fields import Average, Field, Profile, Scales, Units, average
from roughbench.observables.gaps import gap_pdf
from roughbench.observables.patches import Patches, clusters, find_patches
from roughbench.observables.pressures import (
    persson_pressure_pdf,
    persson_pressure_shares,
    pressure_pdf,
)
from roughbench.observables.rings import exponent
from roughbench.observables.stress import persson_stress_spectrum, stress_spectrum
from roughbench.registry import Registry
from roughbench.spectrum import Spectrum

__all__ = [
    "OBSERVABLES",
    "Average",
    "Field",
    "Observable",
    "Origin",
    "Patches",
    "Profile",
    "Scales",
    "Units",
    "average",
    "clusters",
    "contact_spectrum",
    "energy_spectrum",
    "exponent",
    "find_patches",
    "gap_pdf",
    "of_fields",
    "of_springs",
    "of_state",
    "persson_pressure_pdf",
    "persson_pressure_shares",
    "persson_stress_spectrum",
    "pressure_pdf",
    "stress_spectrum",
]

_OWN = (pressure_pdf, gap_pdf, stress_spectrum, contact_spectrum, clusters, energy_spectrum)

OBSERVABLES: Mapping[str, Observable] = Registry(
    "roughbench.observables", {observable.name: observable for observable in _OWN}
)
"""Name → observable, a function of a field; other packages declare theirs as entry points."""


class SolvedState(Protocol):
    """What a function of fields needs to know of a state."""

    @property
    def pressure(self) -> NDArray[np.float64]: ...
    @property
    def gap(self) -> NDArray[np.float64]: ...


def of_state(
    state: SolvedState,
    length: float,
    units: Units,
    modulus: float = 1.0,
    screening: float = 0.0,
) -> Field:
    """Return the field of a state that :func:`roughbench.solve_contact` found.

    Parameters
    ----------
    state : ContactState
        Its fields may be those of a line.
    length : float
        As it was given to the solver.
    units : Units
        ξ and h_rms: a spectrum, or :class:`Scales`.
    modulus : float
        E*, as it was given to the solver.
    screening : float
        q_c, as it was given to the solver.
    """
    return Field(
        pressure=float_array(state.pressure, "pressures") / modulus,
        gap=float_array(state.gap, "gaps"),
        length=length,
        rms_slope=units.rms_slope,
        rms_height=units.rms_height,
        spectrum=_spectrum(units),
        screening=screening,
    )


def of_springs(
    heights: ArrayLike, pressure: float, modulus: float, length: float, units: Units
) -> Field:
    """Return the field of independent springs under given heights.

    Parameters
    ----------
    heights : array_like of float64, shape (n, m) or (n,)
        Length; square pixels.
    pressure : float
        p/E* > 0.
    modulus : float
        k_w/E*, 1/length: of :mod:`roughbench.models.winkler`; 4/(πL) for the foundation.
    length : float
        Period along the first axis, length.
    units : Units
        ξ and h_rms: a spectrum, or :class:`Scales`.

    Returns
    -------
    Field
        Its mean pressure is ``pressure``.
    """
    from roughbench.models._springs import spring_fields
    from roughbench.models.winkler import winkler_curve

    separation = float(winkler_curve(heights, [pressure], modulus).separation[0])
    fields = spring_fields(heights, pressure, separation, modulus)
    return of_fields(fields, length, units)


def of_fields(fields: Fields, length: float, units: Units) -> Field:
    """Return the field of what a model hands out of a state, with E* = 1.

    Parameters
    ----------
    fields : Fields
    length : float
        Period along the first axis, length.
    units : Units
        ξ and h_rms: a spectrum, or :class:`Scales`.
    """
    return Field(
        pressure=fields.pressure,
        gap=fields.gap,
        length=length,
        rms_slope=units.rms_slope,
        rms_height=units.rms_height,
        modulus=fields.modulus,
        spectrum=_spectrum(units),
        screening=fields.screening,
    )


def _spectrum(units: Units) -> Spectrum | None:
    return units if isinstance(units, Spectrum) else None
