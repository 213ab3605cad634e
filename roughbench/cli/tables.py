"""Results as text: tables for people, JSON and CSV for programs."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import textwrap
from collections.abc import Iterator, Mapping

import numpy as np

from roughbench.notation import plain
from roughbench.observables import OBSERVABLES
from roughbench.observables.described import PREFIX, described
from roughbench.outputs import Kind
from roughbench.quantities import PRESSURE, Quantity, compared
from roughbench.results import MODULUS, Array, Attribute, ModelResult, Results
from roughbench.units import in_words, prefix
from roughbench.variables import STATES, dimensions

_OF_SURFACE = (
    "surface",
    "heights",
    "length",
    "hurst",
    "q_min",
    "q_rolloff",
    "q_max",
    "below_rolloff",
    "amplitude",
    "rms_slope",
    "seed",
)
_OF_FIELDS = {"dimension", *(name for one in OBSERVABLES.values() for name in one.attributes)}
TABLE = Kind("table", lambda head, _: re.match(rb"(\w+ \[[^]\n]*\],?)+\n", head) is not None)
"""CSV: recognized by its first line, which has nothing but names with units."""
_NOT_OPTIONS = {
    *(*_OF_SURFACE, *_OF_FIELDS),
    *("rms_height", "grid_points", "grid_columns", "warnings", MODULUS),
}
_HELD = "\xa0"
"""A space within a number and its unit, where no line breaks."""
_SI = {"length": "m", "q_min": "1/m", "q_rolloff": "1/m", "q_max": "1/m"}
"""Units of a surface's parameters in a spec with units."""


def as_text(results: Results, source: str) -> str:
    """Return a table of every curve.

    Parameters
    ----------
    results : Results
    source : str
        Name of the file, for the title.
    """
    blocks = [f"{source}: {results.name} (spec sha256 {results.spec_sha256[:12]})"]
    prefixes = prefixes_of(results)
    for experiment, models in results.items():
        for number, result in enumerate(models.values()):
            if number == 0:
                blocks.append("\n".join([f"== {experiment} ==", *_surface_lines(result)]))
            blocks.append("\n".join(_model_lines(result, prefixes)))
    return "\n\n".join(blocks)


def prefixes_of(results: Results) -> dict[str, tuple[float, str]]:
    """Return factor and prefixed unit of each column: the same in all tables of a file.

    Empty for results without units. Dimensionless columns have none.
    """
    columns: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    for _, result in results.models() if results.has_units else ():
        for name in ("pressure", *(f"{name}_mean" for name in compared())):
            if name in result and result.units(name) != "1":
                quantity = name.removesuffix("_mean")
                columns.setdefault(quantity, []).extend(result[name].tolist())
                units[quantity] = result.units(name)
    return {name: prefix(values, units[name]) for name, values in columns.items()}


def _surface_lines(result: ModelResult) -> Iterator[str]:
    given = dict(result.attributes)
    height = f"{given['rms_height']:.6g}"
    if result.has_units:
        height = in_words(float(given["rms_height"]), "m", 6)
        given |= {
            name: in_words(float(given[name]), unit, 6).replace(" ", _HELD)
            for name, unit in _SI.items()
            if name in given
        }
    yield from _listed({name: given[name] for name in _OF_SURFACE if name in given})
    origin = "of the heights" if result.is_measured else "of the spectrum, continuum"
    yield f"h_rms = {height} ({origin})"
    if result.modulus is not None:
        yield f"E* = {in_words(result.modulus, 'Pa', 6)}"
    yield from (f"warning: {text}" for text in result.warnings)


def _model_lines(
    result: ModelResult, prefixes: Mapping[str, tuple[float, str]]
) -> Iterator[str]:
    many = "s" * (result.n_realizations > 1)
    yield f"{result.label}: {result.title}, {result.n_realizations} realization{many}"
    own = described(result.attributes)
    left_out = {f"{PREFIX}{one.name}" for one in own}.union(*(one.attributes for one in own))
    left_out |= _NOT_OPTIONS
    yield from _listed({k: v for k, v in result.attributes.items() if k not in left_out})
    if own:
        names = ", ".join(f"{one.name} ({one.source})" for one in own)
        yield from textwrap.wrap(
            f"observables from outside: {names}",
            88,
            initial_indent="  ",
            subsequent_indent="  ",
        )
    shown = [
        one for one in compared().values() if one.is_expected or f"{one.name}_mean" in result
    ]
    headings = (f"  {_heading(result, quantity, prefixes):^20}" for quantity in shown)
    yield f"{_heading(result, PRESSURE, prefixes):>10}{''.join(headings)}    n"
    columns = [_column(result, quantity, prefixes) for quantity in shown]
    for i, pressure in enumerate(result["pressure"]):
        cells = "".join(f"  {column[i]:20}" for column in columns)
        first = f"{pressure:10.3e}"
        if result.has_units:
            first = f"{pressure * prefixes['pressure'][0]:10.6g}"
        yield f"{first}{cells}{result['n_converged'][i]:5d}"
    if result.n_unconverged:
        yield (
            f"{result.n_unconverged} of {result.n_states} states did not converge; "
            "they are left out of the averages"
        )


def _listed(values: dict[str, Attribute]) -> list[str]:
    parts = (
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in values.items()
    )
    text = ", ".join(parts)
    lines = textwrap.wrap(text, 88, initial_indent="  ", subsequent_indent="  ")
    return [line.replace(_HELD, " ") for line in lines]


def _heading(
    result: ModelResult, quantity: Quantity, prefixes: Mapping[str, tuple[float, str]]
) -> str:
    """Return how a column is called: with its unit; without units, lengths are in h_rms."""
    if not result.has_units:
        return plain(quantity.scaled)
    symbol = plain(quantity.symbol)
    return f"{symbol} [{prefixes[quantity.name][1]}]" if quantity.name in prefixes else symbol


def _column(
    result: ModelResult, quantity: Quantity, prefixes: Mapping[str, tuple[float, str]]
) -> list[str]:
    """Return the means of a quantity with their errors, a text for each pressure."""
    name = quantity.name
    if f"{name}_mean" not in result:
        return ["not given"] * len(result["pressure"])
    mean, sem = result[f"{name}_mean"], result[f"{name}_sem"]
    if name in prefixes:
        factor = prefixes[name][0]
        return [_in_unit(m * factor, e * factor) for m, e in zip(mean, sem, strict=True)]
    unit = (
        quantity.unit(float(result.attributes["rms_height"])) if not result.has_units else 1.0
    )
    pairs = zip(mean / unit, sem / unit, strict=True)
    return [_with_error(*pair, quantity.digits) for pair in pairs]


def _with_error(mean: float, sem: float, digits: int) -> str:
    if math.isnan(mean):
        return f"{'-':>10}"
    if math.isinf(mean):
        return f"{'inf':>10}"
    value = f"{mean:10.{digits - 1}e}"
    return value if math.isnan(sem) else f"{value} ± {sem:.1e}"


def _in_unit(mean: float, sem: float) -> str:
    """Write a number whose unit has a fitting prefix."""
    if not math.isfinite(mean):
        return _with_error(mean, sem, 1)
    value = f"{mean:10.4g}"
    return value if math.isnan(sem) else f"{value} ± {sem:.2g}"


def to_json(results: Results) -> Iterator[str]:
    """Yield all that a results file holds as strict JSON, piece by piece.

    Infinities become the strings "inf" and "-inf", nan becomes null; all other numbers
    carry their full precision. No piece is longer than a row of an array.
    """
    head = {"name": results.name, "spec": results.spec_text, "spec_sha256": results.spec_sha256}
    yield "{\n"
    yield from (f" {_json(key)}: {_json(value)},\n" for key, value in head.items())
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
        "attributes": {name: _json_number(value) for name, value in result.attributes.items()},
        "units": {name: result.units(name) for name in result},
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
        yield _json(row if np.isfinite(values).all() else [_json_number(v) for v in row])
        return
    yield "["
    for number, row in enumerate(values):
        yield ",\n      " * (number > 0)
        yield from _json_array(row)
    yield "]"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _json_number(value: str | float) -> str | float | None:
    if isinstance(value, str) or math.isfinite(value):
        return value
    return None if math.isnan(value) else str(value)


def summary_csv(result: ModelResult) -> str:
    """Return the averaged curves of one model as CSV, one row a pressure.

    The header names each variable with its unit in brackets: "1" is none, "length" the
    spec's length unit. Of a spec with units it is that of SI, without prefix.
    """
    names = [name for name in result if dimensions(name, result[name].ndim) == ("pressure",)]
    return _csv(result, {name: result[name] for name in names})


def states_csv(result: ModelResult) -> str:
    """Return every state of one model as CSV, one row a realization and pressure."""
    n_realizations, n_pressures = result["status"].shape
    columns = {
        "realization": np.repeat(np.arange(n_realizations), n_pressures),
        "pressure": np.tile(result["pressure"], n_realizations),
    }
    of_states = [name for name in result if dimensions(name, result[name].ndim) == STATES]
    columns |= {name: result[name].ravel() for name in of_states}
    return _csv(result, columns)


def observables_csv(result: ModelResult) -> dict[str, str]:
    """Return the averages of each observable of one model as CSV, by its variable.

    One row a pressure and bin: the place of the value, its mean, standard error, and
    Persson's theory where it says something.
    """
    texts = {}
    known = [one.variable for one in OBSERVABLES.values()]
    own = [one.variable for one in described(result.attributes)]
    for name in dict.fromkeys([*known, *own]):
        if name in result:
            places = result[f"{name}_bin"]
            columns = {
                "pressure": np.repeat(result["pressure"], places.size),
                f"{name}_bin": np.tile(places, result["pressure"].size),
            }
            for kind in ("mean", "sem", "persson"):
                if f"{name}_{kind}" in result:
                    columns[f"{name}_{kind}"] = result[f"{name}_{kind}"].ravel()
            texts[name] = _csv(result, columns)
    return texts


def _csv(result: ModelResult, columns: dict[str, Array]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(f"{name} [{result.units(name)}]" for name in columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return text.getvalue()
