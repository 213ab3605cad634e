"""What a spec asks of the fields of a contact: observables, and states to keep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    Field,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
)
from pydantic_core import PydanticCustomError

from roughbench.errors import ModelError
from roughbench.models.registry import Catalog
from roughbench.observables import OBSERVABLES, Observable
from roughbench.observables.files import load_observable
from roughbench.source_files import names_file
from roughbench.spec.models import catalog_of
from roughbench.spec.pressures import PressureList
from roughbench.spec.strict import STRICT


def _once(values: tuple[str | int, ...]) -> tuple[str | int, ...]:
    for number, value in enumerate(values):
        if value in values[:number]:
            raise PydanticCustomError(
                "child",
                "{value} stands there already; remove it",
                {"value": value, "part": number},
            )
    return values


def _of_a_file(
    value: object, by_name: Callable[[object], object], info: ValidationInfo
) -> object:
    if not isinstance(value, str) or not names_file(value):
        return by_name(value)
    catalog = catalog_of(info.context)
    if catalog.outside is None:
        try:
            load_observable(value, catalog.folder, OBSERVABLES)
        except ModelError as error:
            raise ValueError(str(error)) from None
    return value


def _named_once(names: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    known: dict[str, str] = {}
    for number, observable in enumerate(observables_of(names, catalog_of(info.context))):
        if observable.name in known:
            raise PydanticCustomError(
                "child",
                "has the name {name} as {other}; choose another",
                {"name": observable.name, "other": known[observable.name], "part": number},
            )
        known[observable.name] = names[number]
    return names


def observables_of(names: Sequence[str], catalog: Catalog) -> list[Observable]:
    """Return the observables that a spec names.

    Where it is read only for what it says, as that of results, those of files are left out.
    """
    found = []
    for name in names:
        if not names_file(name):
            found.append(OBSERVABLES[name])
        elif catalog.outside is None:
            found.append(load_observable(name, catalog.folder))
    return found


if TYPE_CHECKING:
    ObservableName = str
else:
    ObservableName = Annotated[
        Literal[tuple(OBSERVABLES)],
        WrapValidator(_of_a_file),
        WithJsonSchema(
            {
                "anyOf": [
                    {"enum": [*OBSERVABLES], "type": "string"},
                    {
                        "type": "string",
                        "pattern": r"\.py:[A-Za-z_]\w*$",
                        "description": "File, relative to the folder of the spec, and class.",
                    },
                ]
            }
        ),
    ]

Observables = Annotated[
    tuple[ObservableName, ...],
    Field(min_length=1),
    AfterValidator(_once),
    AfterValidator(_named_once),
]


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
