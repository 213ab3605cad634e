"""Positive options with a unit: a number, or a text such as ``10 um``, which becomes SI.

Bare numbers are in any unit of length and in E*; a spec decides whether it writes units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from roughbench.errors import UnitError
from roughbench.units import EXAMPLES, SI, Dimension, begins_with_number, in_words, to_si


def has_units(info: ValidationInfo) -> bool:
    """Return whether what is validated belongs to a spec with units."""
    return isinstance(info.context, dict) and bool(info.context.get("has_units"))


def says(value: float, dimension: Dimension, info: ValidationInfo) -> str:
    """Write a value for a message of a validator, with a unit where its spec has units."""
    return in_words(value, SI[dimension], 6) if has_units(info) else str(value)


@dataclass(frozen=True, slots=True)
class WithUnit:
    """Marks a number that may be written with a unit of this dimension."""

    dimension: Dimension

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Convert texts before the number is checked."""
        return core_schema.with_info_before_validator_function(self._in_si, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Allow texts beside the numbers."""
        text = {"type": "string", "examples": [EXAMPLES[self.dimension]]}
        return {"anyOf": [handler(schema), text]}

    def _in_si(self, value: object, info: ValidationInfo) -> object:
        if not isinstance(value, str):
            return value
        if not has_units(info) and not begins_with_number(value):
            return value  # no number at all
        try:
            return to_si(value, self.dimension)
        except UnitError as error:
            raise ValueError(error.reason) from None


# The mark comes last, so that it wraps the check of the number.
LengthOption = Annotated[float, Field(gt=0.0, allow_inf_nan=False), WithUnit("length")]
WavevectorOption = Annotated[float, Field(gt=0.0, allow_inf_nan=False), WithUnit("wavevector")]
PressureOption = Annotated[float, Field(gt=0.0, allow_inf_nan=False), WithUnit("pressure")]


def dimension_of(field: FieldInfo) -> Dimension | None:
    """Return the dimension of an option that may have a unit, None for all others.

    Examples
    --------
    >>> from pydantic import BaseModel
    >>> class Surface(BaseModel):
    ...     H: float
    ...     length: LengthOption | None = None
    >>> [dimension_of(field) for field in Surface.model_fields.values()]
    [None, 'length']
    """
    marks = [*field.metadata]
    waiting = [field.annotation]
    while waiting:
        annotation = waiting.pop()
        marks += getattr(annotation, "__metadata__", ())
        waiting += get_args(annotation)
    return next((mark.dimension for mark in marks if isinstance(mark, WithUnit)), None)
