"""What the numbers of a cell depend on, and the key that stands for it.

Two cells with the same identity have the same numbers, to the bit. How many jobs, which
engine and which machine compute them is no part of it; nor is the number of realizations,
which may grow. The pressures are for models whose states are cheap. The states of an
iterative model are kept when pressures are added: those start from other neighbours than
in one go, and agree within the tolerance.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import roughbench.models
import roughbench.observables
from roughbench.models.base import Model
from roughbench.observables import OBSERVABLES, Observable
from roughbench.planning.plan import Cell
from roughbench.quantities import QUANTITIES
from roughbench.rundir import source
from roughbench.spec import SelfAffineSurface

Identity = Mapping[str, str | int | float]
"""Flat: key path in a spec, ``threads`` or ``code`` → value."""

_PACKAGE = Path(roughbench.models.__file__).parents[1]
_numerics = re.compile(
    r"roughbench\.(models\.\w+|surface|spectrum|transform|heights_file)\b", re.ASCII
).match
_SAMPLES = ("surface", "spectrum", "heights_file", "planning.samples")


def identity(cell: Cell, threads: int) -> Identity:
    """Return what the numbers of a cell depend on.

    Parameters
    ----------
    cell : Cell
    threads : int
        Of each task; left out for models that do not iterate.

    Returns
    -------
    mapping of str to str, int or float
        Heights from a file count by their content. ``code`` is a digest of what the source
        files compute that make the numbers, the model's own and those of the surfaces: after
        a change of one of them nothing computed before is taken for its result. Observables
        count where they are asked for, with their own code; fields that are kept do not:
        a state without the field that it should have counts as missing.
    """
    model, surface = cell.model, cell.surface
    options = model.model_dump(by_alias=True, exclude={"label", "realizations", "grid"})
    values = {f"model.{name}": value for name, value in options.items() if value is not None}
    given = surface.model_dump(by_alias=True, exclude_none=True, exclude={"path"})
    if cell.heights is not None:
        given["heights"] = cell.heights.digest
    elif model.dimension and isinstance(surface, SelfAffineSurface):
        values["model.grid"] = model.grid_points(surface.spectrum(), surface.length)
        values["seed"] = cell.seed
    else:
        given.pop("amplitude", None)
    values |= {f"surface.{name}": value for name, value in given.items()}
    if model.iterative:
        values["threads"] = threads
    else:
        values["pressures"] = _in_words(cell)
    if asked := cell.asked.observables:
        values["observables"] = f"{', '.join(asked)} ({observing_digest(asked)})"
    values["code"] = code_digest(type(model))
    return values


def _in_words(cell: Cell) -> str:
    p = cell.pressures
    digest = hashlib.sha256(cell.pressure_array().tobytes()).hexdigest()[:8]
    return f"{len(p)} from {p[0]:g} to {p[-1]:g} ({digest})"


def key_of(identity: Identity) -> str:
    """Return the key of an identity: 20 hexadecimal digits of a SHA-256.

    Examples
    --------
    >>> key_of({"seed": 1, "surface.H": 0.7})
    '9c9d45b6edf3cbd5bd84'
    """
    canonical = json.dumps(identity, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()[:20]


def changes(before: Identity, after: Identity) -> list[str]:
    """Return what differs between two identities, each with both values.

    Examples
    --------
    >>> changes({"surface.H": 0.7, "seed": 1}, {"surface.H": 0.8, "seed": 1})
    ['surface.H: 0.7 → 0.8']
    """
    names = [name for name in {**before, **after} if before.get(name) != after.get(name)]
    return [
        f"{name}: {before.get(name, 'unset')} → {after.get(name, 'unset')}" for name in names
    ]


@functools.cache
def code_digest(model: type[Model]) -> str:
    """Return a digest of what the source files compute that make a model's numbers.

    12 digits; blind to docstrings, comments and layout, see :mod:`roughbench.rundir.source`.
    """
    waiting = [_unit(model.__module__.removeprefix("roughbench."), model)]
    waiting += [_unit(name, model) for name in _SAMPLES]
    digests: dict[Path, str] = {}
    while waiting:
        for path in waiting.pop():
            if path in digests:
                continue
            text = path.read_text(encoding="utf-8")
            digests[path] = source.digest(text)
            if path.name == "samples.py":  # imports every model
                continue
            found = {match[1] for name in source.imported(text) if (match := _numerics(name))}
            waiting += [_unit(name, model) for name in sorted(found)]
    return _together([digests[path] for path in sorted(digests)])[:12]


@functools.cache
def observing_digest(names: Sequence[str] = ()) -> str:
    """Return a digest of what the source files compute that make observables, 8 digits.

    Parameters
    ----------
    names : tuple of str
        Observables; those of other packages count with the files that they come from.
    """
    paths = sorted(Path(roughbench.observables.__file__).parent.glob("*.py"))
    paths.append(_PACKAGE / "engines" / "observing.py")
    for name in names:
        paths += [path for path in _files_of(OBSERVABLES[name]) if path not in paths]
    return _together([source.digest(path.read_text(encoding="utf-8")) for path in paths])[:8]


def _files_of(observable: Observable) -> list[Path]:
    """Return the file of an observable, or those of the package that it stands in."""
    classes = [one for one in type(observable).__mro__ if one.__module__ != "builtins"]
    files: list[Path] = []
    for one in classes:
        path = Path(inspect.getfile(one))
        if not path.is_relative_to(_PACKAGE) and one.__module__ not in sys.stdlib_module_names:
            inside = "." in one.__module__ or path.name == "__init__.py"
            files += sorted(path.parent.glob("*.py")) if inside else [path]
    return files


@functools.cache
def assembly_digest() -> str:
    """Return a digest of what the source files compute that make a results file of shards."""
    names = ["ensemble", "quantities", "results", "store", "variables", "spectrum"]
    names += ["runner/assemble", "rundir/collected", "planning/samples"]
    paths = [_PACKAGE / f"{name}.py" for name in names]
    texts = [path.read_text(encoding="utf-8") for path in paths]
    described = [repr(quantity) for quantity in QUANTITIES.values()]  # of other packages too
    return _together(
        [*map(source.digest, texts), *described, observing_digest((*OBSERVABLES,))]
    )


def _together(digests: Sequence[str]) -> str:
    return hashlib.sha256("".join(digests).encode()).hexdigest()


def _unit(name: str, model: type[Model]) -> list[Path]:
    """Return the files of a module, or of the whole package that it stands in."""
    parts = name.split(".")
    if parts[0] not in {
        "models",
        "planning",
        "surface",
        "spectrum",
        "transform",
        "heights_file",
    }:
        return [Path(inspect.getfile(model))]  # a model from elsewhere
    folder = _PACKAGE.joinpath(*parts[:2])
    if folder.is_dir():
        return sorted(folder.glob("*.py"))
    return [folder.with_suffix(".py")]
