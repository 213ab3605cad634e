"""Results as tables for people."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping

from roughbench.models.registry import has_option
from roughbench.notation import plain
from roughbench.observables import OBSERVABLES
from roughbench.observables.described import PREFIX, described
from roughbench.quantities import PRESSURE, Quantity, compared
from roughbench.results import MODULUS, Attribute, ModelResult, Results
from roughbench.units import in_words, prefix

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
    blocks += [
        f"PARTIAL, the run is not finished: {model} has {there} of {planned} realizations"
        for model, (there, planned) in results.partial.items()
    ]
    prefixes = prefixes_of(results)
    for experiment, models in results.items():
        # Of models with an option "heights" the file is not known.
        first = min(models.values(), key=lambda one: has_option(one.kind, "heights"))
        blocks.append("\n".join([f"== {experiment} ==", *_surface_lines(first)]))
        for result in models.values():
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
    if has_option(result.kind, "heights"):
        given.pop("heights", None)
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
