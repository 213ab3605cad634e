"""The models of a spec: each entry of the list → the contender that its kind names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from roughbench.errors import ModelError
from roughbench.models.base import Model
from roughbench.models.registry import Catalog, kind_of, kinds
from roughbench.source_files import names_file
from roughbench.spec.tree import did_you_mean, show

_FROM_OUTSIDE = (
    "a theory of your own is known once its package is installed, or by its file, as in "
    "'mytheory.py:Erf09'"
)


def catalog_of(context: Any) -> Catalog:
    """Return where the models are found of a spec that is validated in a context."""
    found = context.get("catalog") if isinstance(context, Mapping) else None
    return found if isinstance(found, Catalog) else Catalog()


def _validated(value: object, info: ValidationInfo) -> Model:
    if isinstance(value, Model):
        return value
    if not isinstance(value, Mapping):
        raise PydanticCustomError("model_type", "must be a mapping")
    kind = value.get("kind")
    if "kind" not in value:
        raise _fault("missing_child", f"is missing; known here: {', '.join(kinds())}")
    if not isinstance(kind, str):
        raise _fault("child", f"must be one of {', '.join(kinds())}, got {show(kind)}")
    catalog = catalog_of(info.context)
    try:
        model = catalog.find(kind)
    except KeyError:
        hint = did_you_mean(kind, kinds())
        if not hint.startswith(" ("):  # no misspelled kind: perhaps one from outside
            hint += f"; {_FROM_OUTSIDE}"
        raise _fault("child", f"unknown kind {show(kind)}{hint}") from None
    except ModelError as error:
        raise _fault("child", str(error)) from None
    if not names_file(kind):
        return model.model_validate(value, context=info.context)
    own = catalog.own_kind(kind)
    made = model.model_validate({**value, "kind": own}, context=info.context)
    return made.referred_to(kind)


def _fault(code: str, message: str) -> PydanticCustomError:
    return PydanticCustomError(code, "{text}", {"part": "kind", "text": message})


class _ByKind:
    """Tells pydantic to look the class up, rather than to try all that there are."""

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        del source, handler
        return core_schema.with_info_plain_validator_function(_validated)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        del schema, handler
        return {"type": "object"}  # json_schema knows more


if TYPE_CHECKING:
    AnyModel = Model
else:
    AnyModel = Annotated[Model, _ByKind()]
    """One of the contenders that there are, chosen by its kind."""

__all__ = ["AnyModel", "catalog_of", "kind_of"]
