"""The JSON schema of a spec, for editors that complete and check YAML."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import models_json_schema

from roughbench.models.base import Model
from roughbench.models.registry import declared, kind_of, kinds
from roughbench.spec.model import Spec
from roughbench.spec.wavelengths import OF_WAVES, WAVELENGTHS
from roughbench.units import EXAMPLES

_SCALAR = {"type": ["number", "string", "boolean", "null"]}
_OF_ALL = Model.model_json_schema()["properties"]
_IN_A_FILE = {
    "title": "Model in a file",
    "description": "A model in a Python file, with the options that its class has.",
    "type": "object",
    "required": ["kind"],
    "properties": {
        "kind": {
            "type": "string",
            "pattern": r"\.py:[A-Za-z_]\w*$",
            "description": "File, relative to the folder of the spec, and class.",
        },
        **{name: _OF_ALL[name] for name in ("label", "realizations")},
    },
}


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a spec, under the names used in YAML.

    Rules that tie several keys together (q0 <= qr < q1, exactly one of slope and
    rms_height) are checked by :func:`roughbench.spec.load_spec` only.

    Examples
    --------
    >>> schema = json_schema()
    >>> schema["$defs"]["SelfAffineSurface"]["properties"]["H"]["description"]
    'Hurst exponent, 0 < H < 1.'
    """
    schema = Spec.model_json_schema(by_alias=True)
    definitions = schema["$defs"]
    models = [model for kind in kinds() if (model := declared(kind)) is not None]
    references, found = models_json_schema(
        [(model, "validation") for model in models], by_alias=True
    )
    definitions |= found["$defs"]
    named = [references[model, "validation"] for model in models]
    schema["properties"]["models"]["items"] = {"oneOf": [*named, _IN_A_FILE]}
    for part in (schema, *definitions.values()):
        for field in part.get("properties", {}).values():
            field.pop("title", None)
    for model, name in zip(models, named, strict=True):
        definition = definitions[name["$ref"].rpartition("/")[2]]
        kind = kind_of(model)
        if model.page:
            definition["description"] += f"\n\nSee {model.page}."
        choice = {"const": kind, "type": "string", "description": "Which contender."}
        definition["properties"]["kind"] = choice
        # In a list of models the kind chooses, so that the class's default is none here.
        definition["required"] = ["kind", *{*definition.get("required", ())} - {"kind"}]
    _add_wavelengths(definitions["SelfAffineSurface"])
    schema["$defs"] = dict(sorted(definitions.items()))
    schema["properties"]["sweep"]["additionalProperties"] = {
        "type": "array",
        "minItems": 1,
        "uniqueItems": True,
        "items": _SCALAR,
    }
    schema["required"] = [key for key in schema["required"] if key != "name"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _add_wavelengths(surface: dict[str, Any]) -> None:
    """Allow wavelengths in place of wavevectors, which they become before validation."""
    for key, words in OF_WAVES.items():
        example = {"type": "string", "examples": [EXAMPLES["length"]]}
        surface["properties"][key] = {**example, "description": words}
    needed = {WAVELENGTHS[key]: key for key in ("longest", "shortest")}
    surface["required"] = [key for key in surface["required"] if key not in needed]
    surface["allOf"] = [
        {"anyOf": [{"required": [vector]}, {"required": [length]}]}
        for vector, length in needed.items()
    ]
