"""Pressure and gap of independent springs, from a curve that is computed already."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import ArrayLike

from roughbench.inputs import float_array
from roughbench.models.base import Curve, Fields, Solved


def spring_fields(
    heights: ArrayLike, pressure: float, separation: float, modulus: float
) -> Fields:
    """Return pressure and gap of every spring in a state that is solved already.

    Parameters
    ----------
    heights : array_like of float64, any shape
        Length.
    pressure : float
        Nominal pressure p/E*.
    separation : float
        ū at this pressure, length; the plane is at d = ū + ⟨h⟩ − p/k_w.
    modulus : float
        k_w/E*, 1/length.

    Returns
    -------
    Fields

    Examples
    --------
    >>> fields = spring_fields([3.0, 2.0, 0.0, 0.0], 0.5, 0.75, modulus=1.0)
    >>> fields.pressure.tolist(), fields.gap.tolist()
    ([1.5, 0.5, 0.0, 0.0], [0.0, 0.0, 1.5, 1.5])
    """
    h = float_array(heights, "heights", kinds="buif")
    overlap = h - (separation + h.mean() - pressure / modulus)
    return Fields(modulus * np.maximum(overlap, 0.0), np.maximum(-overlap, 0.0), modulus)


def hand_out_fields(
    heights: ArrayLike, curve: Curve, modulus: float, solved: Solved | None
) -> None:
    """Call ``solved`` for every state of a curve of independent springs, with its fields."""
    if solved is None:
        return
    for k in np.argsort(curve.pressure, kind="stable"):
        pressure, separation = float(curve.pressure[k]), float(curve.separation[k])
        solved(None, functools.partial(spring_fields, heights, pressure, separation, modulus))
