"""A theory of your own beside the exact solution: see mytheory.yaml."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from scipy.special import erf

import roughbench as rb


class Erf09(rb.Model):
    """A/A0 = erf(f √2 p/(E* ξ)): Persson's area with a factor f."""

    title: ClassVar[str] = "Erf 0.9"
    needs: ClassVar[Literal["spectrum"]] = "spectrum"
    iterative: ClassVar[bool] = False
    kind: Literal["erf09"] = "erf09"
    factor: float = 0.9

    def curve(self, sample: rb.Sample, pressures: np.ndarray) -> rb.Curve:
        """Return the area; separation and stiffness are not given."""
        area = erf(self.factor * np.sqrt(2.0) * pressures / sample.spectrum.rms_slope)
        return rb.Curve(pressure=pressures, area=area)
