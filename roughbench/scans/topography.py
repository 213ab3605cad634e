"""A topography as it was measured: heights with size and unit, some of them missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Scan:
    """Heights as a file holds them, in SI units.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        In m; nan where a point is missing.
    size : (float, float)
        Of the scan along rows and columns (y, x), in m: points times their spacing.
    source : str
        The path as it was given.
    channel : str
        Name of the channel of the file; "" where it has only one.
    notes : tuple of str
        What was assumed in reading it.

    Examples
    --------
    >>> scan = Scan(np.array([[0.0, np.nan], [1e-9, 0.0]]), size=(2e-6, 2e-6))
    >>> scan.shape, scan.missing, scan.spacing
    ((2, 2), 0.25, (1e-06, 1e-06))
    """

    heights: FloatArray
    size: tuple[float, float]
    source: str = ""
    channel: str = ""
    notes: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.heights.shape
        return rows, columns

    @property
    def missing(self) -> float:
        """Share of the points that are missing."""
        return float(np.count_nonzero(np.isnan(self.heights)) / self.heights.size)

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance between neighbouring points along (y, x), in m."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]
