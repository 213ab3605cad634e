"""An HDF5 file into results; each variable is read when it is asked for."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import h5py

from roughbench.errors import StoreError, explained
from roughbench.results import MODULUS, Array, ModelResult, Results
from roughbench.store.checks import (
    ReadingBudget,
    check_name,
    check_sealed,
    damage_named,
    members,
    read_attribute,
    rerun_hint,
)
from roughbench.store.format import FORMAT, FORMAT_VERSION, MADE_WITH, check_shapes
from roughbench.surface_record import DESCRIBED, PREFIX, SurfaceRecord
from roughbench.text import on_one_line, printable
from roughbench.variables import STORABLE, is_known

_REQUIRED = ("pressure", "status")
_LEAST_CHUNK = 1 << 16


def load(path: str | os.PathLike[str]) -> Results:
    """Read a results file.

    Returns
    -------
    Results
        Equal to what was written.

    Raises
    ------
    StoreError
        If there is no such file, it is no roughbench results file or one of a newer
        format, it is damaged, refers to other files, has names that roughbench gives to
        nothing, or claims more than it holds. Texts are escaped where they do not print.
    """
    with opened(path) as results:
        return Results(
            {
                experiment: {label: _whole(models[label]) for label in models}
                for experiment, models in results.items()
            },
            results.spec_text,
            results.spec_sha256,
            results.name,
            results.surfaces,
            results.made_with,
        )


@contextlib.contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[Results]:
    """Give the content of a results file, of which each variable is read when asked for.

    Yields
    ------
    Results
        As :func:`load` returns them; of no use afterwards.

    Raises
    ------
    StoreError
        As :func:`load`.
    """
    source = Path(path)
    try:
        if source.is_dir():
            raise StoreError(f"{source}: is a folder; give the results file in it")
        if source.exists() and not source.is_file():  # to open a pipe is to wait
            raise StoreError(f"{source}: is no regular file; give a results file")
        with source.open("rb"):
            pass
    except FileNotFoundError:
        raise StoreError(f"{source}: no such file; {rerun_hint()} or check the name") from None
    except OSError as error:
        raise StoreError(f"{source}: cannot be read: {explained(error)}") from error
    with contextlib.ExitStack() as stack:
        with damage_named(source):
            check_sealed(source)
            file = stack.enter_context(h5py.File(source, "r"))
            results = _read_root(file, source)
        yield results


class _Stored(Mapping[str, Array]):
    """Variables in a file."""

    def __init__(self, data: Mapping[str, h5py.Dataset], source: Path) -> None:
        self._data, self._source = data, source

    def __getitem__(self, name: str) -> Array:
        data = self._data[name]
        with damage_named(self._source):
            values: Array = data[()]
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)


def _whole(result: ModelResult) -> ModelResult:
    return dataclasses.replace(result, variables=dict(result.variables))


def whose(path: str | os.PathLike[str]) -> tuple[str, str] | None:
    """Return the name and the hash of the spec that a results file is of.

    None if there is no sound results file, so that there are no results to lose.
    """
    source = Path(path)
    try:
        if not source.is_file():
            return None
        check_sealed(source)
        with h5py.File(source, "r") as file:
            budget = ReadingBudget(source)
            name, sha256 = (
                read_attribute(file, key, budget) for key in ("name", "spec_sha256")
            )
            return on_one_line(str(name)), str(sha256)
    except (StoreError, OSError, KeyError, RuntimeError, ValueError, TypeError):
        return None


def _read_root(file: h5py.File, source: Path) -> Results:
    budget = ReadingBudget(source)
    if "format" not in file.attrs or read_attribute(file, "format", budget) != FORMAT:
        raise StoreError(
            f"{source}: an HDF5 file, but not written by roughbench; "
            "give a results file of 'roughbench run'"
        )
    version = int(read_attribute(file, "format_version", budget))
    if version > FORMAT_VERSION:
        raise StoreError(
            f"{source}: has format version {version}, newer than {FORMAT_VERSION}; "
            "upgrade roughbench to read it"
        )
    experiments: dict[str, dict[str, ModelResult]] = {}
    surfaces: dict[str, SurfaceRecord] = {}
    for experiment, models in members(file, h5py.Group, budget):
        experiments[experiment] = {}
        for label, group in members(models, h5py.Group, budget):
            found, record = _read_model(group, label, budget)
            experiments[experiment][label] = found
            if record is not None:
                surfaces[experiment] = record
    text, sha256, name = (
        str(read_attribute(file, key, budget)) for key in ("spec", "spec_sha256", "name")
    )
    said = read_attribute(file, MADE_WITH, budget) if MADE_WITH in file.attrs else "{}"
    return Results(
        experiments,
        printable(text),
        on_one_line(sha256),
        on_one_line(name),
        surfaces,
        _making(said),
    )


def _making(said: str | int | float) -> dict[str, str | int]:
    """Return what the file, or a group, says of its making."""
    found = json.loads(str(said))
    if not isinstance(found, dict):
        raise ValueError(f"{MADE_WITH} is no mapping")
    return {
        on_one_line(name): value if isinstance(value, int) else on_one_line(str(value))
        for name, value in found.items()
    }


def _read_model(
    group: h5py.Group, label: str, budget: ReadingBudget
) -> tuple[ModelResult, SurfaceRecord | None]:
    attributes = {}
    for name in group.attrs:
        check_name(name)
        value = read_attribute(group, name, budget)
        attributes[name] = on_one_line(value) if isinstance(value, str) else value
    kind, title = str(attributes.pop("kind")), str(attributes.pop("title"))
    making = attributes.pop(MADE_WITH, "{}")
    modulus = attributes.get(MODULUS, 1.0)
    if not isinstance(modulus, float) or not 0.0 < modulus < math.inf:
        raise ValueError(f"{group.name} has the {MODULUS} {modulus!r}")
    variables: dict[str, h5py.Dataset] = {}
    described: dict[str, tuple[str, str]] = {}
    for name, data in members(group, h5py.Dataset, budget):
        if data.external or data.is_virtual:
            raise StoreError(
                f"{budget.source}: {data.name} keeps its values in another file, which no "
                f"roughbench file does; {rerun_hint()}"
            )
        if data.dtype not in STORABLE:
            raise ValueError(f"{data.name} is of {data.dtype}")
        budget.take(data.nbytes, data.name)
        # A chunk is read whole, and may be larger than the array.
        if math.prod(data.chunks or ()) * data.dtype.itemsize > max(data.nbytes, _LEAST_CHUNK):
            raise ValueError(f"{data.name} has chunks of {data.chunks} for {data.shape}")
        if not (is_known(name) or name in DESCRIBED) and {"units", "long_name"} <= set(
            data.attrs
        ):
            unit, words = (read_attribute(data, key, budget) for key in ("units", "long_name"))
            described[name] = on_one_line(str(unit)), on_one_line(str(words))
        variables[name] = data
    missing = [name for name in _REQUIRED if name not in variables]
    if missing:
        raise ValueError(f"{group.name} lacks {', '.join(missing)}")
    recorded = {name: variables.pop(name) for name in DESCRIBED if name in variables}
    said = {name: attributes.pop(name) for name in [*attributes] if name.startswith(PREFIX)}
    check_shapes(variables, group.name)
    for index in ("realization", "field"):
        variables.pop(index, None)
    result = ModelResult(
        label,
        kind,
        title,
        attributes,
        _Stored(variables, budget.source),
        described,
        _making(making),
    )
    if not recorded:
        return result, None
    arrays = {name: data[()] for name, data in recorded.items()}
    return result, SurfaceRecord.of(arrays, said)
