"""A scan without trend and holes, on its own points: what its spectra are taken of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.detrending import fit_trend
from roughbench.scans.edges import Edges, border_jump, without_missing_border
from roughbench.scans.filling import fill_holes
from roughbench.scans.measured_spectrum import MeasuredSpectrum
from roughbench.scans.outliers import find_outliers
from roughbench.scans.preparation import Preparation
from roughbench.scans.spectra import profile_spectrum, surface_spectrum
from roughbench.scans.topography import Scan

FloatArray = NDArray[np.float64]

MEETING = 1.2
"""Rms step across the border over that between neighbours, up to which heights are taken for
periodic by their spectrum: the leakage of such a step is less than that of a window's loss."""


@dataclass(frozen=True, slots=True, eq=False)
class Levelled:
    """A scan after its trend was subtracted and its holes were filled, before anything else.

    Attributes
    ----------
    heights : ndarray of float64, shape (rows, columns)
        m; of the scan's points, without borders that were cropped because they are missing.
    size : (float, float)
        Along (y, x), m.
    measured : ndarray of bool, shape (rows, columns), or None
        Which of the points were; None for all.
    window : bool
        Whether the spectra need Hann's window, because the borders do not meet.
    """

    heights: FloatArray
    size: tuple[float, float]
    measured: NDArray[np.bool_] | None
    window: bool

    def surface_spectrum(self) -> MeasuredSpectrum:
        """Return C2D, m⁴."""
        return surface_spectrum(
            self.heights, self.size, window=self.window, measured=self.measured
        )

    def profile_spectrum(self, axis: int) -> MeasuredSpectrum:
        """Return the spectrum of profiles along y (0) or x (1), m³."""
        return profile_spectrum(
            self.heights, self.size, axis, window=self.window, measured=self.measured
        )

    def with_holes(self) -> FloatArray:
        """Return the heights, nan where they are missing."""
        if self.measured is None:
            return self.heights
        return np.where(self.measured, self.heights, np.nan)


def level(scan: Scan, preparation: Preparation) -> Levelled:
    """Take outliers, missing borders, the trend and holes out of a scan, as is asked."""
    heights, (dy, dx) = scan.heights.astype(np.float64), scan.spacing
    if preparation.outliers is not None:
        heights[find_outliers(heights, preparation.outliers)[0]] = np.nan
    if preparation.edges == "crop":
        heights = np.ascontiguousarray(heights[without_missing_border(heights)])
    trend = preparation.detrend or "mean"
    if trend != "none":
        fit_trend(heights, (dy, dx), trend).subtract_from(heights)
    measured = np.isfinite(heights)
    size = dy * heights.shape[0], dx * heights.shape[1]
    whole = bool(measured.all())
    if not whole:
        fill_holes(heights, (dy, dx), periodic=preparation.edges == "periodic")
    window = _needs_window(heights, preparation.edges)
    return Levelled(heights, size, None if whole else measured, window)


def _needs_window(heights: FloatArray, edges: Edges | None) -> bool:
    if edges is not None:
        return edges != "periodic"
    jumps = (border_jump(heights, axis) for axis in (0, 1))
    return any(across > MEETING * within for across, within in jumps)
