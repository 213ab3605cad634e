"""One realization of the roughness, as a contender gets it."""

from __future__ import annotations

from dataclasses import dataclass

from roughbench.models.states import FloatArray
from roughbench.spectrum import Spectrum


@dataclass(frozen=True, slots=True)
class Sample:
    """One realization of the roughness, as a contender gets it.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m), or None
        Heights of a line or a surface with zero mean, length; None where the model
        works on the spectrum alone.
    length : float
        Side of the periodic cell, length: the period along the first axis. Pixels are
        square, so that that along the second is m/n times as long.
    spectrum : Spectrum or None
        The spectrum behind the heights; None for heights from a file.
    area : float or None
        A0 of a cell that is no square, where there are no heights to show it, length².
    """

    heights: FloatArray | None
    length: float
    spectrum: Spectrum | None = None
    area: float | None = None

    @property
    def nominal_area(self) -> float:
        """A0 of the cell of a surface, length²."""
        if self.area is not None:
            return self.area
        return cell_area(() if self.heights is None else self.heights.shape, self.length)


def cell_area(shape: tuple[int, ...], length: float) -> float:
    """Return the area of a cell of square pixels, length²; of a square one without a shape.

    Parameters
    ----------
    shape : tuple of int
        Of heights (n, m).
    length : float
        Period along the first axis, length.

    Examples
    --------
    >>> cell_area((4, 8), 2.0), cell_area((8, 4), 4.0), cell_area((), 3.0)
    (8.0, 8.0, 9.0)
    """
    square = length * length
    return square * shape[1] / shape[0] if len(shape) == 2 else square
