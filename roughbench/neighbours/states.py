"""Pressure and gap from solved problems of other codes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.inputs import positive_number, real_array
from roughbench.neighbours.surfaces import surface_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PressedFields:
    """Pressure and gap of a state, whoever solved it.

    Attributes
    ----------
    pressure : ndarray of float64, shape (rows, columns) or (n,)
        Force over area, positive in compression, in the unit of the modulus. It serves as
        ``start`` of :func:`roughbench.solve_contact`.
    gap : ndarray of float64, of the same shape
        Local separation, zero in contact up to the other code's tolerance, length.
    size : tuple of float
        Sides (y, x) or (x,), length.
    modulus : float
        E*.
    """

    pressure: FloatArray
    gap: FloatArray
    size: tuple[float, ...]
    modulus: float

    @property
    def nominal_pressure(self) -> float:
        """⟨p⟩, in the unit of the modulus."""
        return float(self.pressure.mean())

    @property
    def mean_separation(self) -> float:
        """ū, the mean of the gap, length."""
        return float(self.gap.mean())

    @property
    def area_fraction_raw(self) -> float:
        """Points with a positive pressure / all points."""
        return float(np.count_nonzero(self.pressure > 0.0) / self.pressure.size)


def fields_of(
    solved: Any,
    *,
    length: float | tuple[float, ...] | None = None,
    modulus: float | None = None,
) -> PressedFields:
    """Return pressure and gap of a solved problem.

    Parameters
    ----------
    solved : object
        A state of :func:`roughbench.solve_contact`; a ``System`` of ContactMechanics after
        ``minimize_proxy``; a ``Model`` of Tamaas after a solver that leaves its field ``gap``
        (``PolonskyKeerRey``); or the result of ``aspher.solve_nested``.
    length : float or tuple of float, optional
        Of the cell, where the object does not know it: ASPHER's.
    modulus : float, optional
        E*, likewise.

    Raises
    ------
    SolverError
        If it is none of them, is not solved yet, or has fields of other shapes.
    """
    if _has(solved, "substrate", "surface", "offset"):
        return _of_system(solved)
    if _has(solved, "traction", "displacement", "system_size"):
        return _of_tamaas(solved)
    if not _has(solved, "pressure", "gap"):
        raise SolverError(
            f"a {type(solved).__name__} is no state of roughbench, system of ContactMechanics, "
            "model of Tamaas or result of ASPHER that holds pressure and gap"
        )
    sides = getattr(solved, "size", length)
    if sides is None:
        raise SolverError("the result does not know its cell: give length")
    shape = np.shape(solved.pressure)
    size = tuple(np.broadcast_to(np.asarray(sides, float), len(shape)).tolist())
    known = getattr(solved, "modulus", modulus)
    return _checked(solved.pressure, solved.gap, size, 1.0 if known is None else known)


def _of_system(system: Any) -> PressedFields:
    """Return those of a system: forces on points, turned and without the padding."""
    surface = surface_of(system)
    force, displacement = system.force, system.disp
    if force is None or displacement is None:
        raise SolverError("the system is not solved: call its minimize_proxy first")
    shape = surface.heights.shape
    part = tuple(slice(n) for n in shape[::-1])  # a free half-space is padded
    force, displacement = (np.ma.getdata(one)[part].T for one in (force, displacement))
    area = float(np.prod(surface.size)) / surface.heights.size
    gap = displacement - surface.heights - float(system.offset)
    body = system.substrate
    modulus = getattr(body, "contact_modulus", body.young)
    return _checked(force / area, gap, surface.size, float(modulus))


def _of_tamaas(model: Any) -> PressedFields:
    """Return those of a model: its axes are taken as they are."""
    if "gap" not in list(model):
        raise SolverError(
            "the model has no field gap: solve it with PolonskyKeerRey, which leaves one"
        )
    size = tuple(float(side) for side in model.system_size)
    traction = np.array(model.traction, np.float64)
    if traction.ndim != len(size):
        raise SolverError(
            f"the tractions have the shape {traction.shape}: only models of normal contact, "
            "basic_1d and basic_2d, have one pressure at each point"
        )
    return _checked(traction, np.array(model["gap"], np.float64), size, float(model.E_star))


def _checked(pressure: Any, gap: Any, size: tuple[float, ...], modulus: Any) -> PressedFields:
    p = np.ascontiguousarray(real_array(pressure, "pressures"), np.float64)
    g = np.ascontiguousarray(real_array(gap, "gaps"), np.float64)
    if p.shape != g.shape or p.ndim != len(size):
        raise SolverError(
            f"pressure and gap must be of one shape, got {p.shape} and {g.shape} in a cell of "
            f"{len(size)} sides"
        )
    sides = tuple(positive_number(side, "length") for side in size)
    return PressedFields(p, g, sides, positive_number(modulus, "modulus"))


def _has(source: Any, *names: str) -> bool:
    return all(hasattr(source, name) for name in names)
