"""The exact contender: a periodic elastic half-space pressed against a hard rough wall."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from roughbench.models.base import Curve, FloatArray, Model, Sample
from roughbench.spectrum import Spectrum


class HalfSpace(Model):
    """Exact boundary-element solution on a periodic grid."""

    dimension: ClassVar[int] = 2
    title: ClassVar[str] = "Exact (BEM)"

    kind: Literal["bem"] = "bem"
    grid: int | None = Field(
        default=None,
        ge=2,
        description="Points per side; default 4 q1 length / 2π, at least 2 q1 length / 2π.",
    )
    tolerance: float = Field(
        default=1e-6, gt=0.0, lt=1e-2, description="Relative complementarity Σ|p g| / (Σp h_rms)."
    )

    def grid_points(self, spectrum: Spectrum, length: float) -> int:
        raise NotImplementedError

    def curve(self, sample: Sample, pressures: FloatArray, *, threads: int = 1) -> Curve:
        raise NotImplementedError
