"""Measured surfaces of a spec: heights from a file, taken as they are or prepared."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, Field, PrivateAttr, field_validator

from roughbench.errors import UnitError
from roughbench.models.dimensional import LengthOption
from roughbench.scans import CHECKS
from roughbench.spec.strict import STRICT
from roughbench.system import split_dataset
from roughbench.units import to_si

if TYPE_CHECKING:
    from roughbench.scans.preparation import Preparation

_HDF5_ENDS = (".h5", ".hdf5")


def _of_heights(value: object) -> object:
    try:
        if not isinstance(value, str):
            raise UnitError("no text")
        return to_si(f"1 {value}", "length")
    except UnitError:
        raise ValueError(f"must be a unit of length, such as nm, got {value!r}") from None


HeightUnit = Annotated[float, BeforeValidator(_of_heights, json_schema_input_type=str)]
"""A unit of length, which becomes a number of meters."""


class MeasuredSurface(BaseModel):
    """Heights from a file: what all kinds of them share."""

    model_config = STRICT

    kind: str
    path: str

    accept: tuple[str, ...] | None = Field(
        default=None,
        min_length=1,
        description=f"Checks whose finding is known and accepted, of {', '.join(CHECKS)}.",
    )

    _folder: Path = PrivateAttr(default=Path())
    _twins: bool = PrivateAttr(default=False)

    def model_post_init(self, context: Any) -> None:
        """Remember the folder that relative paths start from."""
        if isinstance(context, dict):
            self._folder = Path(context.get("folder", ""))

    @field_validator("accept")
    @classmethod
    def _known_checks(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for name in value or ():
            if name not in CHECKS:
                raise ValueError(f"must be some of {', '.join(CHECKS)}, got {name!r}")
        return value

    @property
    def folder(self) -> Path:
        """Where a relative path starts."""
        return self._folder

    @property
    def file(self) -> Path:
        """The file that holds the heights."""
        return self._folder / split_dataset(self.path)[0]

    @property
    def is_twins(self) -> bool:
        """Whether it stands for surfaces with its spectrum and random phases."""
        return self._twins

    def twins(self) -> Self:
        """Return the ensemble of surfaces with this one's spectrum and random phases."""
        return self._copy(twins=True)

    def original(self) -> Self:
        """Return the surface itself, of which this one may be the twins."""
        return self._copy(twins=False) if self._twins else self

    def _copy(self, *, twins: bool) -> Self:
        copy = self.model_copy()
        copy._twins = twins  # noqa: SLF001  (of its own class)
        return copy


class FileSurface(MeasuredSurface):
    """One periodic cell of heights from a ``.npy`` file or from a dataset of an HDF5 file."""

    kind: Literal["file"] = Field(description="Which surface.")
    path: str = Field(
        min_length=1,
        description="heights.npy, or heights.h5:/dataset; relative to the folder of the spec.",
    )
    length: LengthOption = Field(description="Side of the periodic cell, the heights' unit.")
    unit: HeightUnit | None = Field(
        default=None, description="Unit of the heights, such as nm, in a spec with units."
    )

    @field_validator("path")
    @classmethod
    def _known_format(cls, value: str) -> str:
        if value.endswith(_HDF5_ENDS):
            raise ValueError(f"must name the dataset too, as in {value}:/heights")
        if not value.endswith(".npy") and not all(split_dataset(value)):
            raise ValueError(f"must name heights.npy or heights.h5:/dataset, got {value!r}")
        return value


Length = Annotated[str, Field(description="A length with its unit, as in 10 um.")]


class ScanSurface(MeasuredSurface):
    """A measured topography, and how it becomes a periodic cell."""

    kind: Literal["scan"] = Field(description="Which surface.")
    path: str = Field(
        min_length=1,
        description=(
            "File of the scan, relative to the folder of the spec: .npy, .npz, "
            "file.h5:/dataset, text, .csv, .xyz, or an instrument's format."
        ),
    )
    channel: str | None = Field(
        default=None, description="Channel or array of the file; default: the first heights."
    )
    size: tuple[Length, Length] | None = Field(
        default=None,
        description="Sides along x (columns) and y (rows), where the file does not say them.",
    )
    unit: HeightUnit | None = Field(
        default=None, description="Unit of the heights, where the file does not say it."
    )
    detrend: Literal["none", "mean", "plane", "quadratic"] | None = Field(
        default=None, description="What is subtracted; default: the mean."
    )
    fill: str | float | None = Field(
        default=None,
        description="Largest share of missing points that is filled, as in 5 %; default: 0.",
    )
    edges: Literal["periodic", "mirror", "taper", "crop"] | None = Field(
        default=None, description="What makes the cell periodic; default: it is."
    )
    outliers: float | None = Field(
        default=None,
        gt=0.0,
        description=(
            "Points further from the median of their neighbours than so many robust "
            "deviations are taken as missing; default: none."
        ),
    )
    resample: int | None = Field(
        default=None, ge=8, description="Points along the longer side; default: as they are."
    )

    @field_validator("size", mode="before")
    @classmethod
    def _two_sides(cls, value: object) -> object:
        if not isinstance(value, tuple) or len(value) != 2:
            shown = " ".join(map(str, value)) if isinstance(value, tuple) else value
            raise ValueError(
                f"must be two lengths, along x and y, as in [10 um, 7.5 um], got {shown!r}"
            )
        return value

    @field_validator("size")
    @classmethod
    def _lengths(cls, value: tuple[str, str] | None) -> tuple[str, str] | None:
        for side in value or ():
            _positive_length(side)
        return value

    @field_validator("fill")
    @classmethod
    def _share(cls, value: str | float | None) -> str | float | None:
        if value is not None and not 0.0 <= share_of(value) < 1.0:
            raise ValueError(f"must be a share from 0 to below 100 %, got {value}")
        return value

    @property
    def size_si(self) -> tuple[float, float] | None:
        """Sides along y and x, m."""
        if self.size is None:
            return None
        x, y = (_positive_length(side) for side in self.size)
        return y, x

    def preparation(self) -> Preparation:
        """Return what is done to the heights before anything presses on them."""
        from roughbench.scans.preparation import Preparation  # SciPy is slow to import

        return Preparation(
            detrend=self.detrend,
            fill=0.0 if self.fill is None else share_of(self.fill),
            edges=self.edges,
            outliers=self.outliers,
            resample=self.resample,
        )


def share_of(value: str | float) -> float:
    """Return a share: of ``5 %`` or ``0.05``.

    Raises
    ------
    ValueError
        If it is neither.

    Examples
    --------
    >>> share_of("5 %"), share_of(0.05), share_of("0.05")
    (0.05, 0.05, 0.05)
    """
    if not isinstance(value, str):
        return float(value)
    number = re.fullmatch(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(%?)\s*", value)
    try:
        if number is None:
            raise ValueError
        share = float(number[1])
    except ValueError:
        raise ValueError(f"must be a share such as 5 % or 0.05, got {value!r}") from None
    return share / 100.0 if number[2] else share


def _positive_length(text: str) -> float:
    try:
        length = to_si(text, "length")
    except UnitError as error:
        raise ValueError(error.reason) from None
    if not length > 0.0:
        raise ValueError(f"must be a positive length, got {text!r}")
    return length
