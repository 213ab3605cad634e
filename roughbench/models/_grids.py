"""The grid that models choose when the spec leaves it to them."""

from __future__ import annotations

from roughbench.spectrum import Spectrum
from roughbench.surface import check_grid, highest_mode


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
