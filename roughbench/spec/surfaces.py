"""The surface of a spec: a self-affine spectrum, or measured heights."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import (
    BaseModel,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
)
from pydantic_core import PydanticCustomError

from roughbench.models.dimensional import LengthOption, WavevectorOption, says
from roughbench.spec.measured import FileSurface, MeasuredSurface, ScanSurface
from roughbench.spec.strict import STRICT
from roughbench.spectrum import BelowRolloff, Spectrum, self_affine
from roughbench.surface import Amplitude

# Wavevectors are user input: 2π/q0 may be off in its last digits and still mean 2π/q0.
_ROUNDING = 1e-9


class SelfAffineSurface(BaseModel):
    """A surface with C2D ∝ q^(-2-2H) between the roll-off and the cut-off."""

    model_config = STRICT

    kind: Literal["self-affine"] = Field(default="self-affine", description="Which surface.")
    hurst: float = Field(alias="H", gt=0.0, lt=1.0, description="Hurst exponent, 0 < H < 1.")
    q_min: WavevectorOption = Field(
        alias="q0", description="Smallest wavevector q0 of the roughness, 1/length."
    )
    q_rolloff: WavevectorOption = Field(
        alias="qr",
        default_factory=lambda data: data.get("q_min", 1.0),
        description="Roll-off wavevector, q0 <= qr < q1, 1/length; default q0.",
    )
    q_max: WavevectorOption = Field(
        alias="q1", description="Largest wavevector q1 of the roughness, 1/length."
    )
    rms_slope: float | None = Field(
        alias="slope",
        default=None,
        gt=0.0,
        description="Rms slope √⟨|∇h|²⟩; give exactly one of slope and rms_height.",
    )
    rms_height: LengthOption | None = Field(
        default=None,
        validate_default=True,
        description="Rms height, length; give exactly one of slope and rms_height.",
    )
    below_rolloff: BelowRolloff = Field(
        alias="below_qr",
        default="rolloff",
        description="Spectrum between q0 and qr: rolloff (flat) or cutoff (zero).",
    )
    amplitude: Amplitude = Field(
        default="fixed",
        description="Mode amplitudes: fixed (random phases) or gaussian (complex normal).",
    )
    length: LengthOption = Field(
        default_factory=lambda data: 2.0 * math.pi / data.get("q_min", 1.0),
        description="Side of the periodic cell, at least 2π/q0; default 2π/q0.",
    )

    @field_validator("q_rolloff")
    @classmethod
    def _above_q_min(cls, value: float, info: ValidationInfo) -> float:
        q_min = info.data.get("q_min")
        if q_min is not None and value < q_min:
            lowest, got = says(q_min, "wavevector", info), says(value, "wavevector", info)
            raise ValueError(f"must be at least q0 = {lowest}, got {got}")
        return value

    @field_validator("q_max")
    @classmethod
    def _above_rolloff(cls, value: float, info: ValidationInfo) -> float:
        for key, name in (("q_rolloff", "qr"), ("q_min", "q0")):
            if value <= info.data.get(key, 0.0):
                below, got = (says(q, "wavevector", info) for q in (info.data[key], value))
                raise ValueError(f"must be greater than {name} = {below}, got {got}")
        return value

    @field_validator("rms_height")
    @classmethod
    def _exactly_one_scale(cls, value: float | None, info: ValidationInfo) -> float | None:
        if "rms_slope" in info.data and (info.data["rms_slope"] is None) == (value is None):
            got = "none" if value is None else "both"
            raise PydanticCustomError(
                "parent",  # the fault stands at the surface, not at the missing key
                "give exactly one of slope and rms_height, got {got}",
                {"got": got, "keys": ("slope", "rms_height")},
            )
        return value

    @field_validator("length")
    @classmethod
    def _holds_longest_wave(cls, value: float, info: ValidationInfo) -> float:
        q_min = info.data.get("q_min")
        if q_min is not None and value < 2.0 * math.pi / q_min * (1.0 - _ROUNDING):
            longest = says(2.0 * math.pi / q_min, "length", info)
            raise ValueError(
                f"must be at least 2π/q0 = {longest}, the longest wave, "
                f"got {says(value, 'length', info)}"
            )
        return value

    def spectrum(self) -> Spectrum:
        """Return C2D(q) with its moments."""
        return self_affine(
            hurst=self.hurst,
            q_min=self.q_min,
            q_rolloff=self.q_rolloff,
            q_max=self.q_max,
            rms_slope=self.rms_slope,
            rms_height=self.rms_height,
            below_rolloff=self.below_rolloff,
        )


AnySurface = SelfAffineSurface | MeasuredSurface


def _surface_kind(value: object) -> str | None:
    if isinstance(value, (SelfAffineSurface, MeasuredSurface)):
        return value.kind
    if not isinstance(value, dict):
        return None
    kind = value.get("kind", "self-affine")
    return kind if isinstance(kind, str) else repr(kind)


Surface = Annotated[
    Annotated[SelfAffineSurface, Tag("self-affine")]
    | Annotated[FileSurface, Tag("file")]
    | Annotated[ScanSurface, Tag("scan")],
    Discriminator(_surface_kind),
]
"""Any surface; a spec that names no kind means the self-affine one."""
