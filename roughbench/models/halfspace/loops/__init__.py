"""Fused loops of the exact solver: one pass over memory each, sums in float64.

A *working set* is a list of tiles of the grid, 8 × 8 points (a line: 1 × 8), tile row
by tile row: those of tile row I are ``tiles[rows[I]:rows[I + 1]]``, increasing tile
columns. Vectors on it are flat, tile after tile, each row by row, so that the innermost
loops run over 8 adjacent numbers and need no index. Where the grid ends inside a tile,
the points beyond it have p = 0 and r = ``NEVER_FREE``.

A point is *free* if p > 0 or ρ = r − α < 0. ``field`` is a dense (n, m) array;
``scratch`` is one with a halo of one point, zero off the free points. Sums over a tile are
taken in the working precision, sums over tiles in float64. Values are computed for every
point and then selected, which compiles to vector instructions where a branch would not.

Every loop works on tile rows, or tiles, or grid rows ``a`` to ``b``, releases the
interpreter lock and returns its sums, so that :class:`.threads.ThreadTeam` can run several
blocks at once and add the sums in block order. Arguments that belong together are tuples:

- ``tiling``: height of a tile in grid rows, ``rows``, ``tiles``;
- ``vectors``: p, r, d, s, y of a working set;
- ``surface``: heights, scale and datum; h = scale·(heights − datum) is dimensionless.
- ``one``: 1 in the working precision, where LLVM sums in another order if it is a constant.

They are plain tuples, not named ones: for these Numba looks up the type in Python on every
call. A call then takes 5.7 instead of 1.5 µs, and a curve of 16 loads on 64² points makes
2,000 of them in 130 ms.
"""

from __future__ import annotations

from pathlib import Path

import numba
import numpy as np

from roughbench.models._compiled import compiled

TILE = 8
"""Points per tile and direction."""

NEVER_FREE = 1e30
"""Residual of points that can never be free."""

# Sums may be reordered, and minima taken, by vector instructions. Infinities keep their
# meaning; a NaN still reaches the sums that the solver checks.
_FLAGS = {"reassoc", "contract", "arcp", "nsz", "nnan"}
loop = compiled(sources=[Path(__file__)], nogil=True, error_model="numpy", fastmath=_FLAGS)
inlined = numba.njit(inline="always", error_model="numpy", fastmath=_FLAGS)

# Loops over whole tiles go through views, and rows of eight through unsigned indices: of an
# index that cannot be negative the compiler makes vector instructions.
UNSIGNED_TILE = np.uint64(TILE)


@inlined
def copy_row(source, i, target, j, width):
    """target[j : j + width] = source[i : i + width], for at most eight values."""
    k, c = np.uint64(i), np.uint64(j)
    if width == TILE:
        for e in range(UNSIGNED_TILE):
            target[c + e] = source[k + e]
    else:
        for e in range(np.uint64(width)):
            target[c + e] = source[k + e]
