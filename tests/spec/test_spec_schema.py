"""The JSON schema: the names of the YAML, a description of each, the same limits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from roughbench.models import MODELS
from roughbench.spec import json_schema


def properties(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for part in (schema, *schema["$defs"].values()):
        yield from part.get("properties", {}).items()


def test_it_is_json_of_draft_2020_12() -> None:
    schema = json_schema()
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert json.loads(json.dumps(schema)) == schema


def test_every_key_has_a_description() -> None:
    for name, field in properties(json_schema()):
        assert field.get("description"), name


def test_the_keys_are_those_of_the_yaml() -> None:
    schema = json_schema()
    assert list(schema["properties"]) == [
        "name",
        "surface",
        "pressures",
        "modulus",
        "realizations",
        "seed",
        "models",
        "sweep",
        "observables",
        "save_fields",
        "twins",
    ]
    assert schema["required"] == ["surface", "pressures", "models"]
    surface = schema["$defs"]["SelfAffineSurface"]
    assert {"H", "q0", "qr", "q1", "slope", "rms_height", "below_qr"} <= {
        *surface["properties"]
    }
    assert surface["required"] == ["H"]
    assert surface["allOf"] == [
        {"anyOf": [{"required": ["q0"]}, {"required": ["longest"]}]},
        {"anyOf": [{"required": ["q1"]}, {"required": ["shortest"]}]},
    ]
    number, text = surface["properties"]["q0"]["anyOf"]
    assert number == {"exclusiveMinimum": 0.0, "type": "number"}
    assert text == {"type": "string", "examples": ["0.1 / um"]}
    assert surface["properties"]["H"]["exclusiveMaximum"] == 1.0
    assert schema["$defs"]["PressureRange"]["required"] == ["min", "max", "points"]


def test_unknown_keys_are_refused_everywhere() -> None:
    schema = json_schema()
    for part in (schema, *schema["$defs"].values()):
        assert part["additionalProperties"] is False


def test_every_model_is_chosen_by_its_kind() -> None:
    schema = json_schema()
    choices = schema["properties"]["models"]["items"]["oneOf"]
    *named, in_a_file = choices
    assert named == [{"$ref": f"#/$defs/{model.__name__}"} for model in MODELS.values()]
    assert in_a_file["properties"]["kind"]["pattern"] == r"\.py:[A-Za-z_]\w*$"
    for kind, model in MODELS.items():
        definition = schema["$defs"][model.__name__]
        assert definition["properties"]["kind"]["const"] == kind
        assert "kind" in definition["required"]
