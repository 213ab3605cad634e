"""The pressures of a spec: a range with a number of points, or a list."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from roughbench.models.dimensional import PressureOption, has_units, says
from roughbench.spec.strict import STRICT

MAX_POINTS = 10_000


class PressureRange(BaseModel):
    """Evenly spaced pressures from ``min`` to ``max``, both included."""

    model_config = STRICT

    min: PressureOption = Field(description="Smallest pressure p/E*.")
    max: PressureOption = Field(description="Largest pressure p/E*.")
    points: int = Field(ge=2, le=MAX_POINTS, description="Number of pressures.")
    spacing: Literal["log", "linear"] = Field(
        default="log", description="Even steps of log p, or of p."
    )

    @field_validator("max")
    @classmethod
    def _above_min(cls, value: float, info: ValidationInfo) -> float:
        lowest = info.data.get("min")
        if lowest is not None and value <= lowest:
            low, got = says(lowest, "pressure", info), says(value, "pressure", info)
            raise ValueError(f"must be greater than min = {low}, got {got}")
        return value

    @model_validator(mode="after")
    def _points_apart(self) -> Self:
        values = self.values()
        if not all(low < high < math.inf for low, high in pairwise(values)):
            raise ValueError(f"{self.points} points do not fit between min and max")
        return self

    def values(self) -> tuple[float, ...]:
        """Return the pressures, ascending."""
        with np.errstate(all="ignore"):
            if self.spacing == "log":
                points = np.geomspace(self.min, self.max, self.points)
            else:
                points = np.linspace(self.min, self.max, self.points)
        return tuple(points.tolist())


def _no_duplicates(values: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
    first: dict[float, int] = {}
    for number, value in enumerate(values):
        if value in first:
            raise PydanticCustomError(
                "child",  # the fault stands at this entry, not at the list
                "the pressure {value} stands at [{first}] already",
                {
                    "value": says(value, "pressure", info) if has_units(info) else value,
                    "first": first[value],
                    "part": number,
                },
            )
        first[value] = number
    return values


def _form(value: object) -> str | None:
    if isinstance(value, (dict, PressureRange)):
        return "range"
    return "list" if isinstance(value, tuple) else None


PressureList = Annotated[
    tuple[Annotated[PressureOption, Field(description="A pressure p/E*.")], ...],
    Field(min_length=1, max_length=MAX_POINTS, description="Pressures p/E* in any order."),
    AfterValidator(_no_duplicates),
]
Pressures = Annotated[
    Annotated[PressureRange, Tag("range")] | Annotated[PressureList, Tag("list")],
    Discriminator(_form),
]


def values_of(pressures: PressureRange | tuple[float, ...]) -> tuple[float, ...]:
    """Return the pressures of a range or a list, ascending: p/E*, or Pa as they are."""
    if isinstance(pressures, PressureRange):
        return pressures.values()
    return tuple(sorted(pressures))


def nearest(pressure: float, pressures: tuple[float, ...]) -> float:
    """Return the nearest of ``pressures``, by ratio.

    Examples
    --------
    >>> nearest(3e-3, (1e-3, 1e-2))
    0.001
    """
    return min(pressures, key=lambda other: abs(math.log(other / pressure)))


def is_among(pressure: float, pressures: tuple[float, ...]) -> bool:
    """Return whether one of ``pressures`` is meant, written with six digits or more.

    Examples
    --------
    >>> is_among(0.333333, (1 / 3,)), is_among(0.333, (1 / 3,))
    (True, False)
    """
    return math.isclose(pressure, nearest(pressure, pressures), rel_tol=2e-6)
