"""Memory that the exact solver needs, added up before it starts."""

from __future__ import annotations

import math
from pathlib import Path

from roughbench.errors import SolverError

# Bytes per grid point at full occupancy: the exact field (8), and at the working
# precision a field, the scratch with its halo and seven vectors (p, r, d, s, y, the
# tangent's x, the pressure that a new working set is filled from): not all at once.
_MIXED = 8 + 9 * 4
_DOUBLE = 9 * 8

_MEMINFO = Path("/proc/meminfo")


def needed(n_points: int, *, double: bool) -> int:
    """Bytes that the solver takes for a grid of ``n_points``, beyond the heights.

    An upper bound, reached near full contact; at low loads the vectors are short.
    Measured at A/A0 = 0.96 in mixed precision: 41 bytes a point, for the 44 counted.
    """
    return n_points * (_DOUBLE if double else _MIXED)


def available() -> int | None:
    """Bytes that can be had without swapping, or None where the system does not say."""
    try:
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None


def check(shape: tuple[int, ...], *, double: bool) -> None:
    """Refuse a grid that does not fit into memory.

    Raises
    ------
    SolverError
        With what is needed, what there is, and what would fit.
    """
    n_points = math.prod(shape)
    room = available()
    wanted = needed(n_points, double=double)
    if room is None or wanted <= room:
        return
    if len(shape) == 2:
        side = math.isqrt(room // needed(1, double=double))
        fits = f"a grid of {side} × {side} points would fit"
    else:
        fits = f"{room // needed(1, double=double)} points would fit"
    hint = ", and so may precision: mixed" if double else ""
    raise SolverError(
        f"the exact solver needs up to {wanted / 1e9:.1f} GB for {n_points} points, and "
        f"{room / 1e9:.1f} GB are available; {fits}{hint}"
    )
