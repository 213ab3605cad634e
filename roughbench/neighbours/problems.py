"""The same problem as other codes put it: their objects made of heights."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import RoughbenchError, SolverError
from roughbench.inputs import float_array, positive_number

FloatArray = NDArray[np.float64]
Length = float | tuple[float, ...]


def topography(heights: ArrayLike, length: Length, unit: str | None = None) -> Any:
    """Return heights as a periodic topography of SurfaceTopography.

    Parameters
    ----------
    heights : array_like, shape (rows, columns) or (n,)
        Along y and x; there x is the first axis.
    length : float or (float, float)
        Sides (y, x), or of square points that along y.
    unit : str, optional
        Of heights and sides, as "nm".

    Returns
    -------
    SurfaceTopography.Topography, or UniformLineScan of a line

    Raises
    ------
    RoughbenchError
        Without SurfaceTopography.
    """
    h, size = _checked(heights, length)
    package = _package("SurfaceTopography")
    if h.ndim == 1:
        return package.UniformLineScan(h, size[0], periodic=True, unit=unit)
    turned = np.ascontiguousarray(h.T)
    return package.Topography(turned, size[::-1], periodic=True, unit=unit)


def contactmechanics_system(heights: ArrayLike, length: Length, modulus: float = 1.0) -> Any:
    """Return a hard-wall system of ContactMechanics on a periodic half-space.

    ``system.minimize_proxy(external_force=pressure * area, pentol=…)`` solves it.

    Raises
    ------
    RoughbenchError
        Without ContactMechanics.
    """
    h, size = _checked(heights, length)
    package = _package("ContactMechanics")
    systems = _package("ContactMechanics.Systems")
    substrate = package.PeriodicFFTElasticHalfSpace(
        h.shape[::-1], positive_number(modulus, "modulus"), size[::-1]
    )
    return systems.NonSmoothContactSystem(substrate=substrate, surface=topography(h, length))


def tamaas_model(
    heights: ArrayLike, length: Length, modulus: float = 1.0
) -> tuple[Any, FloatArray]:
    """Return a model of Tamaas on a periodic half-space, and the surface for its solver.

    ``tamaas.PolonskyKeerRey(model, surface, tolerance).solve(pressure)`` solves it. E is E*
    and ν zero; the axes stay as they are.

    Raises
    ------
    RoughbenchError
        Without Tamaas.
    """
    h, size = _checked(heights, length)
    package = _package("tamaas")
    kinds = package.model_type
    kind = kinds.basic_1d if h.ndim == 1 else kinds.basic_2d
    model = package.ModelFactory.createModel(kind, list(size), list(h.shape))
    model.E, model.nu = positive_number(modulus, "modulus"), 0.0
    return model, np.ascontiguousarray(h)


def aspher_arguments(
    heights: ArrayLike, length: Length, pressure: float, modulus: float = 1.0
) -> dict[str, Any]:
    """Return the arguments of ``aspher.solve_nested`` for a periodic half-space.

    ASPHER takes the initial gap, −h, on a square grid; no package is needed for that.

    Raises
    ------
    SolverError
        If the heights are no square.
    """
    h, size = _checked(heights, length)
    if h.ndim != 2 or h.shape[0] != h.shape[1] or size[0] != size[1]:
        raise SolverError(f"ASPHER solves squares, got {h.shape} points and sides {size}")
    n = h.shape[0]
    coarsest = n
    while coarsest % 2 == 0 and coarsest > 64:
        coarsest //= 2
    return {
        "grid_size": n,
        "gap": -h.ravel(),
        "p_nominal": positive_number(pressure, "pressure"),
        "domain_size": size[0],
        "E_star": positive_number(modulus, "modulus"),
        "coarsest": coarsest,
        "backend": "periodic",
    }


def _checked(heights: ArrayLike, length: Length) -> tuple[FloatArray, tuple[float, ...]]:
    """Return heights, and all sides of their cell."""
    h = float_array(heights, "heights")
    if h.ndim not in (1, 2):
        raise SolverError(f"heights must be a line or a surface, got shape {h.shape}")
    if np.ndim(length):
        sides = tuple(positive_number(side, "length") for side in np.asarray(length).tolist())
    else:
        side = positive_number(length, "length")
        sides = tuple(side * n / h.shape[0] for n in h.shape)
    if len(sides) != h.ndim:
        raise SolverError(f"length must have {h.ndim} sides, got {length!r}")
    return h, sides


def _package(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise RoughbenchError(
            f"{package} is not installed: pip install {package}; it is imported only for "
            "objects of its own"
        ) from error
