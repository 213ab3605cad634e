"""Memory that the exact solver needs, added up before it starts."""

from __future__ import annotations

import math

from roughbench import memory

# Bytes per grid point at full occupancy: the exact field (8), and at the working
# precision a field, the scratch with its halo and seven vectors (p, r, d, s, y, the
# tangent's x, the pressure that a new working set is filled from): not all at once.
_MIXED = 8 + 9 * 4
_DOUBLE = 9 * 8
# On a free half-space the fields have rows of twice their length, and there is the transform
# of G besides, both with a tenth more points, at most, than the grid.
_FREE_MIXED = 24 * 1.1 + 12 * 1.1 + 8 * 4
_FREE_DOUBLE = 24 * 1.1 + 8 * 8

_BOUNDED = 6
"""With a hardness: which points are free, and what is elastic among them."""


def needed(n_points: int, *, double: bool, free: bool = False, bounded: bool = False) -> int:
    """Bytes that the solver takes for a grid of ``n_points``, beyond the heights.

    An upper bound, reached near full contact; at low loads the vectors are short.
    Measured at A/A0 = 0.96 in mixed precision: 41 bytes a point, for the 44 counted.
    """
    if free:
        return math.ceil(n_points * (_FREE_DOUBLE if double else _FREE_MIXED))
    return n_points * ((_DOUBLE if double else _MIXED) + bounded * _BOUNDED)


def check(
    shape: tuple[int, ...],
    *,
    double: bool,
    instead: str = "precision: mixed",
    converted: bool = False,
    free: bool = False,
    bounded: bool = False,
) -> None:
    """Refuse a grid that does not fit into memory.

    Parameters
    ----------
    shape : tuple of int
    double : bool
        Whether it iterates in float64.
    instead : str
        What makes it iterate in float32.
    converted : bool
        Whether the heights have to be copied as well.
    free : bool
        Whether the half-space is not periodic.
    bounded : bool
        Whether there is a hardness.

    Raises
    ------
    SolverError
        With what is needed, what there is, and what would fit.
    """
    n_points = math.prod(shape)
    copy = 8 if converted else 0
    per_point = needed(1, double=double, free=free, bounded=bounded) + copy

    def remedy(room: int) -> str:
        side = math.isqrt(room // per_point)
        fits = (
            f"a grid of {side} × {side} points would fit"
            if len(shape) == 2
            else f"{room // per_point} points would fit"
        )
        light = needed(1, double=False, free=free, bounded=bounded)
        lighter = n_points * (light + copy) <= room
        return fits + (f", and so may {instead}" if double and lighter else "")

    wanted = n_points * per_point
    what = f"the exact solver needs up to {memory.gigabytes(wanted)} for {n_points} points"
    memory.check(wanted, what, remedy)
