"""The options that the exact solver has on a surface and on a line."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from roughbench.models.dimensional import PressureOption, WithUnit

Precision = Literal["mixed", "double"]
Correction = Literal["none", "perimeter"]
Boundary = Literal["periodic", "free"]

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
ScreeningOption = Annotated[
    float,
    Field(
        ge=0.0,
        allow_inf_nan=False,
        description="q_c, 1/length, in G = 2/(E*√(q² + q_c²)): waves longer than 2π/q_c do not "
        "couple; 0 is the half-space, and far above the largest wavevector of the grid every "
        "point is a spring of its own, of k_w = E* q_c/2 (winkler).",
    ),
    WithUnit("wavevector"),
]
BoundaryOption = Annotated[
    Boundary,
    Field(
        description="periodic, or free: the given heights alone on a half-space without end. "
        "Then the pressure is the force over their nominal area, and the separation is minus "
        "the approach, counted from the first contact.",
    ),
]
