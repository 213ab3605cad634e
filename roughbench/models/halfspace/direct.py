r"""G applied point by point, for the few points that carry pressure at low loads.

A pair of transforms costs the same whether 10 points or all are under pressure. The sum
:math:`u_i = \sum_j G(x_i - x_j)\, p_j` over the loaded points alone, with the Green's
function of the periodic grid from a table, is exact as well, and needs no field: at
p = 10⁻⁶ E* on 4096² points it is a hundred times cheaper.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.loops import TILE
from roughbench.models.halfspace.loops import direct as loops
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.working_set import WorkingSet, tile_height


def cost_of_transforms(shape: tuple[int, int]) -> float:
    """Products of a direct sum that take as long as a transform pair.

    From a count of operations; at 4096² points, float32, it takes as long as 4e8 products.
    """
    n, m = shape
    return n * m * math.log2(n * m)


class DirectOperator:
    """G between working sets of few tiles.

    Parameters
    ----------
    operator : HalfSpaceOperator
        Its field serves to make the table and is overwritten.
    """

    def __init__(self, operator: HalfSpaceOperator) -> None:
        operator.unit_response()
        response = operator.field
        self.shape = response.shape
        self.team = operator.team
        self.lowest = float(response.min())
        """Smallest value of G: no point lies lower than Σp times this."""
        n, m = self.shape
        # Column c is the offset c − shift. The table is cut into strips of 16 columns, each
        # starting 8 after the last: the rows that one tile needs of another lie side by
        # side in memory.
        self._shift = TILE * (m // (2 * TILE)) + TILE - 1
        n_strips = -(-m // TILE)
        columns = (TILE * np.arange(n_strips)[:, None] + np.arange(2 * TILE) - self._shift) % m
        # Whole tiles are read: their last row may lie beyond half of the grid.
        rows = np.arange(n // 2 + tile_height(self.shape)) % n
        rows = np.minimum(rows, n - rows)
        double = np.empty((n_strips, rows.size, 2 * TILE))
        for strip, wanted in zip(double, columns, strict=True):
            strip[: n // 2 + 1] = response[: n // 2 + 1, wanted]
            strip[n // 2 + 1 :] = response[rows[n // 2 + 1 :, None], wanted]
        self._tables = {np.dtype(np.float64): double}

    def cost(self, n_sources: int, n_tiles: int) -> float:
        """Products of which the sum is made."""
        return n_sources * n_tiles * tile_height(self.shape) * TILE

    def is_cheaper(self, n_sources: int, n_tiles: int) -> bool:
        """Whether this sum is cheaper than a transform pair."""
        return self.cost(n_sources, n_tiles) < cost_of_transforms(self.shape)

    def apply(
        self, sources: WorkingSet, x: NDArray[Any], targets: WorkingSet, u: NDArray[Any]
    ) -> None:
        """u = G x on the targets, for x on the sources; in the precision of x."""
        table = self._tables.get(x.dtype)
        if table is None:
            table = self._tables[np.dtype(np.float64)].astype(x.dtype)
            self._tables[x.dtype] = table
        loaded = np.flatnonzero(x)
        tile, place = np.divmod(loaded, sources.tile_size)
        tops, lefts = sources.corners
        row, column = np.divmod(place, TILE)
        blocks = self.team.even(targets.tiles.size)
        self.team.run(
            loops.direct_sum,
            blocks,
            targets.corners,
            (tops[tile] + row, lefts[tile] + column, x[loaded]),
            (targets.height, *self.shape, self._shift),
            *(table, u),
        )
