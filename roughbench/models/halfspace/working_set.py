"""The tiles of the grid that may carry pressure, and the vectors on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.loops import TILE


def tile_height(shape: tuple[int, int]) -> int:
    """Grid rows per tile: 8, or 1 for a line."""
    return 1 if shape[0] == 1 else TILE


def tile_grid(shape: tuple[int, int]) -> tuple[int, int]:
    """Tiles along each axis; the last ones may reach beyond the grid."""
    return -(-shape[0] // tile_height(shape)), -(-shape[1] // TILE)


def _vector(n: int, dtype: DTypeLike) -> NDArray[Any]:
    """Room for n numbers, apart from other vectors in memory.

    Where two short vectors lie side by side, compiled loops cannot rule out that they
    overlap and add up in another order: the last bit would depend on the allocator.
    """
    return np.empty(max(n, 256), dtype)[:n]


@dataclass(slots=True)
class WorkingSet:
    """Tiles, and vectors on their points (layout: :mod:`.loops`).

    Attributes
    ----------
    height : int
        Grid rows per tile.
    rows : ndarray of int64, shape (tile rows + 1,)
        Tiles of tile row I are the entries rows[I] … rows[I + 1].
    tiles : ndarray of int32, shape (t,)
        Tile column of each tile, increasing within a tile row.
    p, r : ndarray, shape (t · points per tile,)
        Pressure; gap above the plane of the last outer iteration.
    d, s, y : ndarray, same shape
        Workspace of the relaxation: direction, step, image of the step. Empty between
        relaxations: at paper scale each vector is up to a gigabyte.
    """

    height: int
    rows: NDArray[np.int64]
    tiles: NDArray[np.int32]
    p: NDArray[Any]
    r: NDArray[Any]
    d: NDArray[Any]
    s: NDArray[Any]
    y: NDArray[Any]

    @classmethod
    def on(
        cls, shape: tuple[int, int], marked: NDArray[np.uint8], dtype: DTypeLike
    ) -> WorkingSet:
        """Tiles where ``marked`` (shape of the tiles) is set; p and r unset, no workspace."""
        rows = np.zeros(marked.shape[0] + 1, np.int64)
        np.cumsum(np.count_nonzero(marked, axis=1), out=rows[1:])
        tiles = np.nonzero(marked)[1].astype(np.int32)
        n = tiles.size * tile_height(shape) * TILE
        p, r = _vector(n, dtype), _vector(n, dtype)
        none = np.empty(0, dtype)
        return cls(tile_height(shape), rows, tiles, p, r, none, none, none)

    def open_vectors(self) -> None:
        """Set d, s and y to zero, and make room for them and r where there is none."""
        if self.r.size != self.p.size:
            self.r = _vector(self.p.size, self.p.dtype)
        self.d, self.s, self.y = (
            _vector(self.p.size, self.p.dtype) if v.size != self.p.size else v
            for v in (self.d, self.s, self.y)
        )
        for v in (self.d, self.s, self.y):
            v.fill(0)

    def in_contact(self) -> WorkingSet:
        """Only the tiles with a point under pressure, and p on them."""
        p = self.p.reshape(-1, self.tile_size)
        loaded = p.max(axis=1, initial=0) > 0
        rows = np.concatenate(([0], np.cumsum(loaded)))[self.rows]
        kept = _vector(int(rows[-1]) * self.tile_size, self.p.dtype)
        # Any mode but clip has a second array of this size.
        np.take(
            p, np.flatnonzero(loaded), axis=0, out=kept.reshape(-1, self.tile_size), mode="clip"
        )
        return self.under_pressure(self.height, rows, self.tiles[loaded], kept)

    @classmethod
    def under_pressure(
        cls, height: int, rows: NDArray[np.int64], tiles: NDArray[np.int32], p: NDArray[Any]
    ) -> WorkingSet:
        """Tiles that carry p, without room for more."""
        none = np.empty(0, p.dtype)
        return cls(height, rows, tiles, p, none, none, none, none)

    def keep_pressure(self) -> None:
        """Free all vectors but p."""
        self.r = self.d = self.s = self.y = np.empty(0, self.p.dtype)

    @property
    def tiling(self) -> tuple[int, NDArray[np.int64], NDArray[np.int32]]:
        """Height, rows and tiles, for the loops."""
        return self.height, self.rows, self.tiles

    @property
    def vectors(self) -> tuple[NDArray[Any], ...]:
        """p, r, d, s and y, for the loops."""
        return self.p, self.r, self.d, self.s, self.y

    @property
    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """Tile row and tile column of each tile."""
        return np.repeat(np.arange(self.rows.size - 1), np.diff(self.rows)), self.tiles

    @property
    def corners(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Grid row and column of the first point of each tile."""
        rows, columns = self.places
        return rows * self.height, columns.astype(np.int64) * TILE

    @property
    def tile_size(self) -> int:
        """Points per tile."""
        return self.height * TILE

    @property
    def n_contact(self) -> int:
        """Number of points under pressure."""
        return int(np.count_nonzero(self.p))

    @property
    def sum_p(self) -> float:
        """Σp."""
        return float(self.p.sum(dtype=np.float64))
