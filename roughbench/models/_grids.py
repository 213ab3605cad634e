"""What contenders on a grid of points share: the option, and the grid chosen without it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from roughbench.models.base import Model
from roughbench.spectrum import Spectrum
from roughbench.surface import check_grid, highest_mode

GridOption = Annotated[int | None, Field(ge=2)]
"""Points per side, at least two; None leaves them to the model."""


def chosen_grid(
    wanted: int | None, spectrum: Spectrum, length: float, per_wave: int = 4
) -> int:
    """Return the points per side: those asked for, or some on the shortest wavelength.

    Parameters
    ----------
    wanted : int or None
    spectrum : Spectrum
    length : float
        Side of the cell, length.
    per_wave : int
        Points on the shortest wavelength where none are asked for.

    Returns
    -------
    int

    Raises
    ------
    SurfaceError
        If those asked for are fewer than two on the shortest wavelength.
    """
    if wanted is None:
        return max(2, per_wave * highest_mode(spectrum, length))
    check_grid(wanted, spectrum, length)
    return wanted


class GridModel(Model):
    """A contender of surfaces that has the option ``grid``.

    Each declares it itself, in its place among its options and in its own words.
    """

    if TYPE_CHECKING:
        grid: GridOption

    def grid_points(self, spectrum: Spectrum, length: float) -> int:
        """Points per side: the option, or four per shortest wavelength."""
        return chosen_grid(self.grid, spectrum, length)


class HeightsOrSpectrum(GridModel):
    """A contender of surfaces, or of the spectrum alone, as one of its options says."""

    idle_grid: ClassVar[str]
    """What to do about ``grid`` where the spectrum alone counts."""

    @property
    @abstractmethod
    def uses_heights(self) -> bool:
        """Whether it works on the heights of surfaces."""

    @property
    def dimension(self) -> int:
        """Surfaces, or the spectrum alone."""
        return 2 if self.uses_heights else 0

    def unused_options(self) -> Mapping[str, str]:
        """Without heights, their grid."""
        return {} if self.uses_heights else {"grid": self.idle_grid}
