"""Heights from topographies of SurfaceTopography and systems of ContactMechanics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PeriodicSurface:
    """Heights as :func:`roughbench.solve_contact` takes them.

    Attributes
    ----------
    heights : ndarray of float64, shape (rows, columns) or (n,)
        Along y and x, upwards into contact, in ``unit``.
    size : tuple of float
        (y, x) or (x,), in ``unit``: ``length`` of :func:`roughbench.solve_contact`.
    unit : str
        Of heights and sides; empty where it is not said.
    """

    heights: FloatArray
    size: tuple[float, ...]
    unit: str = ""


def surface_of(source: Any) -> PeriodicSurface:
    """Return the heights of a topography, or of a system of ContactMechanics.

    SurfaceTopography counts x along the first axis, roughbench along the last: heights and
    sides are turned.

    Parameters
    ----------
    source : object
        With ``heights()`` and ``physical_sizes``, or with such an object as ``surface``.

    Raises
    ------
    SurfaceError
        If it is neither; is not periodic (say what becomes of the edges:
        :func:`roughbench.characterize`), not on a regular grid, or lacks points.
    """
    topography = getattr(source, "surface", source)
    if not (callable(getattr(topography, "heights", None)) and _has_sides(topography)):
        raise SurfaceError(
            f"a {type(source).__name__} has no heights() and physical_sizes, as topographies "
            "of SurfaceTopography have; arrays need no door: give them to solve_contact with "
            "the length of their cell"
        )
    found = topography.heights()
    if np.ma.is_masked(found):
        missing = int(np.ma.getmaskarray(found).sum())
        raise SurfaceError(
            f"{missing} of {found.size} heights are missing; fill them first, as with "
            "topography.interpolate_undefined_data()"
        )
    heights = np.ma.getdata(found)
    sides = tuple(float(side) for side in topography.physical_sizes)
    if not getattr(topography, "is_uniform", True) or heights.ndim != len(sides):
        raise SurfaceError("the heights stand on no regular grid; interpolate them first")
    if topography is source and not getattr(topography, "is_periodic", False):
        raise SurfaceError(
            "the topography is not periodic, and its borders would press where they do not "
            "meet: mirror or taper it first, as a spec with edges: does, or say "
            "is_periodic=True in making it"
        )
    unit = getattr(topography, "unit", None)
    return PeriodicSurface(
        np.ascontiguousarray(heights.T, np.float64), sides[::-1], str(unit or "")
    )


def _has_sides(source: Any) -> bool:
    try:
        return len(source.physical_sizes) in (1, 2)
    except (AttributeError, TypeError):
        return False
