"""A doubt about given heights, and what a check knows of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.preparation import Preparation
from roughbench.scans.rms import rms_height_and_gradient
from roughbench.scans.topography import Scan
from roughbench.units import in_words

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Doubt:
    """One reason to mistrust the answer.

    Attributes
    ----------
    check : str
        tilt, jump, step, slope, unit, quantization, resolution or bumps.
    text : str
        One line: what is found, with a number, and the remedy.
    is_wrong : bool
        Whether the answer is wrong; else it is doubtful.
    """

    check: str
    text: str
    is_wrong: bool


@dataclass(frozen=True, slots=True)
class Case:
    """The heights of a check, and what is known of them.

    Attributes
    ----------
    part : ndarray
        The heights without their reflections.
    spacing : float
    as_read : ndarray
        Those of the raw scan.
    read_spacing : (float, float)
    unit : str
        "m", or "1" where there is none.
    """

    part: FloatArray
    spacing: float
    as_read: FloatArray
    read_spacing: tuple[float, float]
    unit: str
    preparation: Preparation
    gap: float | None

    @classmethod
    def of(
        cls,
        heights: FloatArray,
        length: float,
        raw: Scan | None,
        preparation: Preparation,
        gap: float | None,
        *,
        reflected: bool | None = None,
    ) -> Case:
        """Put together what the checks look at; the arguments are those of doubts_of."""
        spacing = length / heights.shape[0]
        if raw is None:
            return cls(heights, spacing, heights, (spacing,) * 2, "1", preparation, gap)
        part = heights
        if preparation.edges == "mirror" if reflected is None else reflected:
            part = heights[: heights.shape[0] // 2, : heights.shape[1] // 2]
        return cls(part, spacing, raw.heights, raw.spacing, "m", preparation, gap)

    def words(self, value: float) -> str:
        """Return a length with its unit, if it has one."""
        return in_words(value, self.unit)

    def remedy(self, key: str, check: str) -> str:
        """Return how to settle a check: by a key of a scan, or by accepting it."""
        scan = "" if self.unit == "m" else "take the file as kind: scan with "
        return f"{scan}{key}, or accept: [{check}]"

    def slope(self) -> float:
        """Rms slope within, without the border."""
        if self.part.ndim == 1:
            return math.sqrt(float(np.mean(np.diff(self.part) ** 2))) / self.spacing
        return rms_height_and_gradient(self.part, (self.spacing,) * 2, periodic=False)[1]
