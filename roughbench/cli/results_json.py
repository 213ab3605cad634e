"""Results as JSON, for programs."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from roughbench.numbers import json_number
from roughbench.results import Array, ModelResult, Results


def to_json(results: Results) -> Iterator[str]:
    """Yield all that a results file holds as strict JSON, piece by piece.

    Infinities become the strings "inf" and "-inf", nan becomes null; all other numbers
    carry their full precision. No piece is longer than a row of an array.
    """
    head = {
        "name": results.name,
        "spec": results.spec_text,
        "spec_sha256": results.spec_sha256,
        "made_with": dict(results.made_with),
    }
    partial = {
        model: {"realizations": there, "planned": planned}
        for model, (there, planned) in results.partial.items()
    }
    yield "{\n"
    yield from (f" {_json(key)}: {_json(value)},\n" for key, value in head.items())
    if partial:
        yield f' "partial": {_json(partial)},\n'
    yield ' "experiments": {'
    for number, (experiment, models) in enumerate(results.items()):
        yield f"{',' * (number > 0)}\n  {_json(experiment)}: {{"
        for place, label in enumerate(models):
            yield f"{',' * (place > 0)}\n   {_json(label)}: "
            yield from _model_as_json(models[label])
        yield "\n  }"
    yield "\n }\n}"


def _model_as_json(result: ModelResult) -> Iterator[str]:
    head = {
        "kind": result.kind,
        "title": result.title,
        "n_realizations": result.n_realizations,
        "n_unconverged": result.n_unconverged,
        "attributes": {
            name: value if isinstance(value, str) else json_number(value)
            for name, value in result.attributes.items()
        },
        "units": {name: result.units(name) for name in result},
        "made_with": dict(result.made_with),
    }
    yield "{\n"
    yield from (f"    {_json(key)}: {_json(value)},\n" for key, value in head.items())
    yield '    "variables": {'
    for number, name in enumerate(result):
        yield f"{',' * (number > 0)}\n     {_json(name)}: "
        yield from _json_array(result[name])
    yield "\n    }\n   }"


def _json_array(values: Array) -> Iterator[str]:
    if values.ndim < 2:
        row = values.tolist()
        yield _json(row if np.isfinite(values).all() else [json_number(v) for v in row])
        return
    yield "["
    for number, row in enumerate(values):
        yield ",\n      " * (number > 0)
        yield from _json_array(row)
    yield "]"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
