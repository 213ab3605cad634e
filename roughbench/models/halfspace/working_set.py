"""The grid points that may carry pressure, and the vectors on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


@dataclass(slots=True)
class WorkingSet:
    """Points row by row, with compressed vectors (layout: :mod:`.loops`).

    Attributes
    ----------
    rows : ndarray of int64, shape (n_rows + 1,)
        Points of row i are the entries rows[i] … rows[i + 1].
    columns : ndarray of int32, shape (n,)
        Column of each point, increasing within a row.
    p, r : ndarray, shape (n,)
        Pressure; gap above the plane of the last outer iteration.
    d, z, s, y : ndarray, shape (n,)
        Room for the relaxation: direction, preconditioned residual, step, its image.
    """

    rows: NDArray[np.int64]
    columns: NDArray[np.int32]
    p: NDArray[Any]
    r: NDArray[Any]
    d: NDArray[Any]
    z: NDArray[Any]
    s: NDArray[Any]
    y: NDArray[Any]

    @classmethod
    def empty(cls, counts: NDArray[np.int64], dtype: DTypeLike) -> WorkingSet:
        """Room for ``counts[i]`` points in row i; all entries unset."""
        rows = np.zeros(counts.size + 1, np.int64)
        np.cumsum(counts, out=rows[1:])
        n = int(rows[-1])
        vectors = (np.empty(n, dtype) for _ in range(6))
        return cls(rows, np.empty(n, np.int32), *vectors)

    @property
    def size(self) -> int:
        """Number of points."""
        return self.columns.size

    def in_contact(self) -> WorkingSet:
        """Return the points under pressure alone, with their ``p``."""
        mask = self.p > 0
        before = np.zeros(self.size + 1, np.int64)
        np.cumsum(mask, out=before[1:])
        points = WorkingSet.empty(np.diff(before[self.rows]), self.p.dtype)
        points.columns[:] = self.columns[mask]
        points.p[:] = self.p[mask]
        return points
