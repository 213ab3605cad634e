"""The surface of a spec: a self-affine spectrum, or heights from a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    ValidationInfo,
    field_validator,
)
from pydantic_core import PydanticCustomError

from roughbench.errors import UnitError
from roughbench.models.dimensional import (
    LengthOption,
    WavevectorOption,
    says,
)
from roughbench.spectrum import BelowRolloff, Spectrum, self_affine
from roughbench.surface import Amplitude
from roughbench.units import to_si

STRICT = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)

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


def _of_heights(value: object) -> object:
    try:
        if not isinstance(value, str):
            raise UnitError("no text")
        return to_si(f"1 {value}", "length")
    except UnitError:
        raise ValueError(f"must be a unit of length, such as nm, got {value!r}") from None


HeightUnit = Annotated[float, BeforeValidator(_of_heights, json_schema_input_type=str)]
"""A unit of length, which becomes a number of meters."""


class FileSurface(BaseModel):
    """Heights from a ``.npy`` file or from a dataset of an HDF5 file."""

    model_config = STRICT

    kind: Literal["file"] = Field(description="Which surface.")
    path: str = Field(
        min_length=1,
        description="heights.npy, or heights.h5:/dataset; relative to the folder of the spec.",
    )
    length: LengthOption = Field(description="Side of the periodic cell, the heights' unit.")
    unit: HeightUnit | None = Field(
        default=None, description="Unit of the heights, such as nm, in a spec with units."
    )

    _folder: Path = PrivateAttr(default=Path())

    def model_post_init(self, context: Any) -> None:
        """Remember the folder that relative paths start from."""
        if isinstance(context, dict):
            self._folder = Path(context.get("folder", ""))

    @field_validator("path")
    @classmethod
    def _known_format(cls, value: str) -> str:
        if value.endswith((".h5", ".hdf5")):
            raise ValueError(f"must name the dataset too, as in {value}:/heights")
        if not value.endswith(".npy") and not value.rpartition(":/")[0]:
            raise ValueError(f"must name heights.npy or heights.h5:/dataset, got {value!r}")
        return value

    @property
    def folder(self) -> Path:
        """Where a relative path starts."""
        return self._folder

    @property
    def file(self) -> Path:
        """The file that holds the heights."""
        name, colon, _ = self.path.rpartition(":/")
        return self._folder / (name if colon else self.path)


def _surface_kind(value: object) -> str | None:
    if isinstance(value, (SelfAffineSurface, FileSurface)):
        return value.kind
    if not isinstance(value, dict):
        return None
    kind = value.get("kind", "self-affine")
    return kind if isinstance(kind, str) else repr(kind)


Surface = Annotated[
    Annotated[SelfAffineSurface, Tag("self-affine")] | Annotated[FileSurface, Tag("file")],
    Discriminator(_surface_kind),
]
"""Either surface; a spec that names no kind means the self-affine one."""
