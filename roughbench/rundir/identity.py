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
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import roughbench.observables
from roughbench.models.base import Model
from roughbench.observables import OBSERVABLES, Observable
from roughbench.planning.cells import Cell
from roughbench.planning.samples import draws_lines
from roughbench.public import LAZY
from roughbench.quantities import QUANTITIES
from roughbench.rundir import source
from roughbench.source_files import installed_files, origin_of
from roughbench.spec import MeasuredSurface, SelfAffineSurface
from roughbench.transform import fft_backend

Identity = Mapping[str, str | int | float]
"""Flat: key path in a spec, ``fft``, ``threads`` or ``code`` → value."""

_PACKAGE = Path(roughbench.observables.__file__).parents[1]
_numerics = re.compile(
    r"roughbench\.(models\.\w+|surface|spectrum|transform|heights_file)\b", re.ASCII
).match
_public = {f"roughbench.{name}": module for name, module in LAZY.items()}
_SAMPLES_FILES = {"roughbench/planning/samples.py", "roughbench/planning/measured.py"}
_SAMPLES = ("surface", "spectrum", "heights_file", "planning.samples", "planning.measured")
_ROWS = ("engines.compute", "engines.blocks")
"""What makes rows of results of curves and states."""


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
        Heights from a file count by their content. ``fft`` is the library of the Fourier
        transforms, for models that use those of :mod:`roughbench.transform`. ``code`` is a
        digest of what the source files compute that make the numbers, the model's own and
        those of the surfaces and of the rows that are kept: after a change of one of them
        nothing computed before is taken for its result. Observables count where they are asked
        for, with their own code; fields that are kept do not: a state without the field that
        it should have counts as missing.
    """
    model, surface = cell.model, cell.surface
    options = model.model_dump(
        by_alias=True, exclude={"label", "realizations", *model.sampling[:1]}
    )
    values = {f"model.{name}": value for name, value in options.items() if value is not None}
    values["model.kind"] = model.kind  # where its file lies does not matter
    given = surface.model_dump(by_alias=True, exclude_none=True, exclude={"path", "accept"})
    if cell.heights is not None and isinstance(surface, MeasuredSurface):
        # Of what was prepared it does not matter how.
        given = {"kind": surface.kind, "length": cell.heights.length}
        given["heights"] = cell.heights.digest
        if cell.is_random:
            given["drawn"] = "twins" if model.dimension == 2 else "lines"
            values["seed"] = cell.seed
        if draws_lines(model, cell.heights):
            values["model.grid"] = cell.n_points
    elif model.dimension and isinstance(surface, SelfAffineSurface):
        values["model.grid"] = model.grid_points(surface.spectrum(), surface.length)
        values["seed"] = cell.seed
    else:
        given.pop("amplitude", None)
    values |= {f"surface.{name}": value for name, value in given.items()}
    if transforms(type(model)):
        values["fft"] = fft_backend()
    if model.iterative:
        values["threads"] = threads
    else:
        values["pressures"] = _in_words(cell)
    if asked := cell.asked.observables:
        names = ", ".join(observable.name for observable in asked)
        values["observables"] = f"{names} ({observing_digest(asked)})"
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


def code_digest(model: type[Model]) -> str:
    """Return a digest of what the source files compute that make a model's numbers.

    12 digits; blind to docstrings, comments and layout, see :mod:`roughbench.rundir.source`.
    Of a model from outside its own files count, and those that it imports beside them (of a
    package: within it), and what it takes from roughbench.
    """
    return _together(_code_of(model).values())[:12]


def transforms(model: type[Model]) -> bool:
    """Whether a model's numbers come by way of :mod:`roughbench.transform`."""
    return any(path.startswith("roughbench/transform") for path in _code_of(model))


@functools.cache
def _code_of(model: type[Model]) -> dict[str, str]:
    """Return the digests of what makes a model's numbers, by path."""
    return _digests([_own_files(model), *(_unit(name) for name in (*_SAMPLES, *_ROWS))])


def _digests(waiting: list[dict[str, str]]) -> dict[str, str]:
    """Return the digests of texts, and of what they import of roughbench's numerics, by path.

    Parameters
    ----------
    waiting : list of dict of str to str
        Path → text.
    """
    digests: dict[str, str] = {}
    while waiting:
        for path, text in waiting.pop().items():
            if path in digests:
                continue
            digests[path] = source.digest(text)
            if path in _SAMPLES_FILES:  # imports what describes models
                continue
            names = {_public.get(name, name) for name in source.imported(text)}
            found = {match[1] for name in names if (match := _numerics(name))}
            waiting += [_unit(name) for name in sorted(found)]
    return {path: digests[path] for path in sorted(digests)}


@functools.cache
def observing_digest(observables: Sequence[Observable] = ()) -> str:
    """Return a digest of what the source files compute that make observables, 8 digits.

    Parameters
    ----------
    observables : tuple of Observable
        Those of other packages count with the files that they come from; those of files with
        these, what they import beside them, and what they take from roughbench.
    """
    paths = sorted(Path(roughbench.observables.__file__).parent.glob("*.py"))
    paths.append(_PACKAGE / "engines" / "observing.py")
    loaded: list[str] = []
    for observable in observables:
        if origin := origin_of(type(observable)):
            loaded += _digests([dict(origin.files.texts)]).values()
        else:
            paths += [path for path in _files_of(observable) if path not in paths]
    texts = [path.read_text(encoding="utf-8") for path in paths]
    return _together([*map(source.digest, texts), *loaded])[:8]


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
    names += ["runner.assemble", "rundir.collected", "planning.samples", "planning.measured"]
    texts = [text for name in names for text in _unit(name).values()]
    described = [repr(quantity) for quantity in QUANTITIES.values()]  # of other packages too
    return _together(
        [*map(source.digest, texts), *described, observing_digest((*OBSERVABLES.values(),))]
    )


def _together(digests: Iterable[str]) -> str:
    return hashlib.sha256("".join(digests).encode()).hexdigest()


def _own_files(model: type[Model]) -> dict[str, str]:
    """Return the texts of a model's own files, by path."""
    if origin := origin_of(model):
        return dict(origin.files.texts)
    if model.__module__.startswith("roughbench."):
        return _unit(model.__module__.removeprefix("roughbench."))
    return installed_files(model)


def _unit(name: str) -> dict[str, str]:
    """Return the texts of a module of roughbench, or of the whole package it stands in.

    Of a package with all that is below it: the loops of the exact solver stand in a folder of
    their own.
    """
    parts = name.split(".")
    folder = _PACKAGE.joinpath(*parts[:2])
    paths = sorted(folder.rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    return {path.relative_to(_PACKAGE.parent).as_posix(): text for path, text in texts.items()}
