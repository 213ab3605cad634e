"""The JSON schema of a spec, for editors that complete and check YAML."""

from __future__ import annotations

from typing import Any

from roughbench.models import MODELS
from roughbench.spec.model import Spec

_SCALAR = {"type": ["number", "string", "boolean", "null"]}


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
    for part in (schema, *definitions.values()):
        for field in part.get("properties", {}).values():
            field.pop("title", None)
    for kind, model in MODELS.items():
        definition = definitions[model.__name__]
        choice = {"const": kind, "type": "string", "description": "Which contender."}
        definition["properties"]["kind"] = choice
        # In a list of models the kind chooses, so that the class's default is none here.
        definition["required"] = ["kind", *{*definition.get("required", ())} - {"kind"}]
    schema["properties"]["sweep"]["additionalProperties"] = {
        "type": "array",
        "minItems": 1,
        "uniqueItems": True,
        "items": _SCALAR,
    }
    schema["required"] = [key for key in schema["required"] if key != "name"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
