"""The page of the results file, made from what describes its content in the code.

Variables are those that quantities, observables and fields declare. What only models know,
their diagnostics and attributes, is read from a results file computed here, of every model.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import h5py

import roughbench as rb
from roughbench.ensemble import STATISTICS
from roughbench.models import MODELS
from roughbench.observables import OBSERVABLES
from roughbench.quantities import QUANTITIES, Variable
from roughbench.spec import SelfAffineSurface
from roughbench.store.format import FORMAT_VERSION
from roughbench.store.writing import image
from roughbench.surface_record import DESCRIBED
from roughbench.variables import FIELD_VARIABLES, every_variable, is_known

OPTIONS: dict[str, dict[str, Any]] = {
    "foundation": {"springs": 64},
    "gw": {"summits": "counted"},
}

SPEC: dict[str, Any] = {
    "name": "example",
    "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 4.0, "slope": 0.1},
    "pressures": [0.001, 0.02],
    "seed": 1,
    "models": [{"kind": kind, "realizations": 1} | OPTIONS.get(kind, {}) for kind in MODELS],
    "observables": list(OBSERVABLES),
    "save_fields": {"pressures": [0.02]},
}

ATTRIBUTES = {
    "format": "by which a results file is known",
    "format_version": "1; 2 with dimensions beside realization and pressure",
    "name": "of the run",
    "spec": "the YAML text",
    "spec_sha256": "hash of what was to be computed",
    "kind": "of the model",
    "title": "of the model, in legends and tables",
    "seed": "of the random numbers",
    "surface": "kind of the surface",
    "rms_height": "of the spectrum (length)",
    "rms_slope": "of the spectrum",
    "grid_points": "points per side",
    "dimension": "of the heights: 2 for surfaces, 1 for lines",
    "exponent_from": "smallest wavevector of the exponents of spectra (1/length)",
    "exponent_to": "largest wavevector of the exponents of spectra (1/length)",
    "persson_gamma": "γ of the theory's curves of observables",
}
"""What is said of attributes that no option of a model or a surface describes."""


def results_file_page() -> str:
    """Return the page, in Markdown."""
    results = rb.run(SPEC)
    with h5py.File(io.BytesIO(image(results))) as file:
        root = dict(file.attrs)
        groups = {kind: dict(group.attrs) for kind, group in file["main"].items()}
    lines = [
        "# Results file, from the code",
        "",
        f"What is in a results file of roughbench {rb.__version__}, format {FORMAT_VERSION}:",
        "made from where the code declares it. How to read it, and what averages mean, says",
        "[Results](../docs/results.md).",
        "",
        "Dimensions are HDF5 dimension scales. Without units in the spec, pressures are",
        "divided by E\\*, and `length` is the length unit of the spec; with units all is SI.",
        "",
        "## Quantities",
        "",
        "A number for each state; their averages over the realizations have the dimension",
        "`pressure` and the endings " + _listed(f"_{name}" for name in STATISTICS) + ".",
        "",
        *_table(["pressure", *_quantities()]),
        "## Realizations and states",
        "",
        *_table(name for name in every_variable() if name in _rest()),
        "## Diagnostics of models",
        "",
        "Beside these, for each realization and pressure:",
        "",
        *_diagnostics(results["main"]),
        "## Observables",
        "",
        "Those that a spec asks for. Averages have the endings `_mean` and `_sem`.",
        "",
    ]
    for name, observable in OBSERVABLES.items():
        words = [one for one in every_variable() if _base(one, observable.variable)]
        lines += [f"### `{name}`", "", *_table(words)]
    lines += [
        "## Fields",
        "",
        "Of the states that `save_fields` names; of a line without the dimension y.",
        "",
        *_table([*FIELD_VARIABLES, "field", "x", "y"]),
        "## A measured surface",
        "",
        "Beside the first model of an experiment, always in SI:",
        "",
        "| variable | dimensions | unit | meaning |",
        "|---|---|---|---|",
        *(
            f"| `{name}` | {', '.join(axes)} | {unit} | {words} |"
            for name, (axes, unit, words) in DESCRIBED.items()
        ),
        "",
        "## Attributes of the file",
        "",
        *_attributes({"": root}),
        "## Attributes of a group",
        "",
        "One group for each model in each experiment. Options of a model and parameters of the",
        "surface stand there by their names; the examples are those of a small spec.",
        "",
        *_attributes(groups),
    ]
    return "\n".join(lines)


def _quantities() -> Iterator[str]:
    for name, quantity in QUANTITIES.items():
        yield name
        if quantity.has_harmonic_mean:
            yield f"{name}_harmonic"


def _rest() -> set[str]:
    """Return what belongs to no quantity, observable or field."""
    own = {*_quantities(), *FIELD_VARIABLES, "pressure", "field", "x", "y"}
    own |= {f"{name}_{end}" for name in QUANTITIES for end in STATISTICS}
    variables = [observable.variable for observable in OBSERVABLES.values()]
    seen = {one for one in every_variable() for name in variables if one.startswith(name)}
    return set(every_variable()) - own - seen


def _base(name: str, variable: str) -> bool:
    return name.startswith(variable) and not name.endswith(("_mean", "_sem"))


def _table(names: Iterable[str]) -> Iterator[str]:
    known = every_variable()
    yield "| variable | dimensions | unit | with units | meaning |"
    yield "|---|---|---|---|---|"
    for name in names:
        axes, variable = known[name]
        units = [_units(variable, si=False), _units(variable, si=True)]
        cells = [f"`{name}`", ", ".join(axes), *units, _escaped(variable.long_name)]
        yield f"| {' | '.join(cells)} |"
    yield ""


def _units(variable: Variable, *, si: bool) -> str:
    found = {
        dimension: (variable.si_units if si else variable.units)(dimension)
        for dimension in (2, 1)
    }
    if found[2] == found[1]:
        return _escaped(found[2])
    return f"{_escaped(found[2])}; of a line {_escaped(found[1])}"


def _diagnostics(models: Mapping[str, rb.ModelResult]) -> Iterator[str]:
    givers: dict[str, list[str]] = {}
    for kind, result in models.items():
        for name in result:
            if not is_known(name):
                givers.setdefault(name, []).append(kind)
    yield "| variable | of |"
    yield "|---|---|"
    yield from (f"| `{name}` | {_listed(kinds)} |" for name, kinds in givers.items())
    yield ""


def _attributes(groups: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """Yield a table: name, who has it, an example, what it means."""
    first: dict[str, Any] = {}
    givers: dict[str, list[str]] = {}
    for kind, attributes in groups.items():
        for name, value in attributes.items():
            first.setdefault(name, value)
            givers.setdefault(name, []).append(kind)
    yield "| attribute | type | example | of | meaning |"
    yield "|---|---|---|---|---|"
    for name, value in first.items():
        kinds = givers[name]
        of = "all" if len(kinds) == len(groups) else _listed(kinds)
        text = str(value).splitlines()[0]
        example = f"`{text[:24]}…`" if len(text) > 24 else f"`{text}`"
        words = _escaped(_meaning(name, kinds))
        yield f"| `{name}` | {_type(value)} | {example} | {of} | {words} |"
    yield ""


def _meaning(name: str, kinds: Iterable[str]) -> str:
    if name in ATTRIBUTES:
        return ATTRIBUTES[name]
    owners: list[Any] = [SelfAffineSurface, *(MODELS[kind] for kind in kinds if kind)]
    fields = [one.model_fields[name] for one in owners if name in one.model_fields]
    return str(fields[0].description or "") if fields else ""


def _type(value: object) -> str:
    return (
        "text" if isinstance(value, str) else str(getattr(value, "dtype", type(value).__name__))
    )


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _escaped(text: str) -> str:
    for mark in "\\*_|<":
        text = text.replace(mark, f"\\{mark}")
    return text
