"""What a spec asks of the fields of a contact: observables, and states to keep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, BaseModel, Field
from pydantic_core import PydanticCustomError

from roughbench.observables import OBSERVABLES
from roughbench.spec.pressures import PressureList
from roughbench.spec.surfaces import STRICT


def _once(values: tuple[str | int, ...]) -> tuple[str | int, ...]:
    for number, value in enumerate(values):
        if value in values[:number]:
            raise PydanticCustomError(
                "child",
                "{value} stands there already; remove it",
                {"value": value, "part": number},
            )
    return values


if TYPE_CHECKING:
    ObservableName = str
else:
    ObservableName = Literal[tuple(OBSERVABLES)]

Observables = Annotated[tuple[ObservableName, ...], Field(min_length=1), AfterValidator(_once)]


class SavedFields(BaseModel):
    """States whose pressure and gap the results file keeps."""

    model_config = STRICT

    pressures: PressureList = Field(
        description="Those of the spec's pressures p/E*, with six digits."
    )
    realizations: Annotated[
        tuple[Annotated[int, Field(ge=0, description="A realization, from 0.")], ...],
        Field(min_length=1),
        AfterValidator(_once),
    ] = Field(default=(0,), description="Realizations, from 0; default: the first.")
