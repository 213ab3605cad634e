"""The contact modulus of a spec with units: of one body, of two, or given as E*."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Discriminator, Field, Tag

from roughbench.models.dimensional import PressureOption
from roughbench.spec.strict import STRICT


class Body(BaseModel):
    """An elastic body."""

    model_config = STRICT

    young: PressureOption = Field(alias="E", description="Young's modulus, such as 2.5 GPa.")
    poisson: float = Field(
        alias="nu", gt=-1.0, le=0.5, description="Poisson's ratio, 0.5 where incompressible."
    )


class ContactModulus(BaseModel):
    """The contact modulus itself."""

    model_config = STRICT

    value: PressureOption = Field(
        alias="E*", description="Contact modulus, 1/E* = Σ(1 − ν²)/E, such as 3.33 GPa."
    )


def _form(value: object) -> str | None:
    if isinstance(value, tuple):
        return "bodies"
    if isinstance(value, (Body, ContactModulus)):
        return "body" if isinstance(value, Body) else "contact"
    if not isinstance(value, dict):
        return None
    return "contact" if "E*" in value else "body"


Modulus = Annotated[
    Annotated[Body, Tag("body")]
    | Annotated[tuple[Body, Body], Tag("bodies")]
    | Annotated[ContactModulus, Tag("contact")],
    Discriminator(_form),
]


def contact_modulus(given: Body | tuple[Body, Body] | ContactModulus) -> float:
    """Return E*, Pa: 1/E* = Σ(1 − ν²)/E over the bodies; the other one of a single is rigid.

    Examples
    --------
    >>> contact_modulus(Body(E="3 GPa", nu=0.5)), contact_modulus(ContactModulus(**{"E*": 2.0}))
    (4000000000.0, 2.0)
    """
    if isinstance(given, ContactModulus):
        return given.value
    if isinstance(given, Body):
        return given.young / (1.0 - given.poisson**2)
    return 1.0 / sum((1.0 - body.poisson**2) / body.young for body in given)
