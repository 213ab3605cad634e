"""The options that the exact solver has on a surface and on a line."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from roughbench.models.dimensional import PressureOption

Precision = Literal["mixed", "double"]
Correction = Literal["none", "perimeter"]

ToleranceOption = Annotated[
    float,
    Field(gt=0.0, le=1e-2, description="Largest Σ|p g| / (Σp h_rms) of a converged state."),
]
PrecisionOption = Annotated[
    Precision,
    Field(description="Iterate in float32 and certify in float64, or float64 throughout."),
]
CorrectionOption = Annotated[
    Correction,
    Field(
        description="Whether the area is corrected for the points that a grid counts too many "
        "along the free edges of the contact."
    ),
]
HardnessOption = Annotated[
    PressureOption | None,
    Field(
        description="Largest pressure that the material bears, p/E*: elastic and perfectly "
        "plastic; default: none."
    ),
]
