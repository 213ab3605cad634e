"""Results on disk: the only module that knows the layout of the HDF5 file.

A file is written beside its place, group by group, and published in one step, so that a
reader finds either the old file or the whole new one, whatever happens in between. The bytes
depend on the results alone: no times, no names of machines.

``/<experiment>/<label>`` holds one model's arrays with dimension scales ``realization``
and ``pressure``, and those of observables and fields (:mod:`roughbench.variables`); the root
holds ``format``, ``format_version``, ``name``, ``spec`` and ``spec_sha256``. Behind the HDF5
file stands the checksum of its bytes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import itertools
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

import h5py
import numpy as np

from roughbench.errors import StoreError, explained
from roughbench.models.base import Status
from roughbench.outputs import ENDS, Kind, check_output
from roughbench.program import command, program
from roughbench.publish import put, refusals_named, written
from roughbench.results import MODULUS, Array, Attribute, ModelResult, Results
from roughbench.seal import check_seal, has_mark, seal_file
from roughbench.signals import signals_held_back
from roughbench.sink import Sink
from roughbench.surface_record import DESCRIBED, PREFIX, SurfaceRecord
from roughbench.text import on_one_line, printable, unsafe_character
from roughbench.variables import STORABLE, compare_shape, dimensions, is_known

__all__ = ["FORMAT_VERSION", "RESULTS", "ModelResult", "Results", "load", "write_results"]

FORMAT = "roughbench"
FORMAT_VERSION = 2
"""2: with dimensions beside realization and pressure. Files without any are written as 1,
which older versions read."""

_HDF5 = b"\x89HDF\r\n\x1a\n"
_ATTRIBUTES = (b"format_version", b"spec_sha256")
_END_ADDRESS = slice(28, 36)
"""Where an HDF5 file says how long it is."""
_BEFORE_ATTRIBUTES = 512
"""Bytes at the beginning that hold nothing of anybody."""
_REQUIRED = ("pressure", "status")
_LONGEST_NAME = 1000
"""Characters; a sweep of many keys has long names."""
_LEAST_CHUNK = 1 << 16
_counter = itertools.count()


def write_results(results: Results, path: str | os.PathLike[str]) -> Path:
    """Write the results file; one that is there is replaced in one step, or left as it is.

    Parameters
    ----------
    results : Results
    path : str or path
        The folder must exist.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    StoreError
        If the file cannot be written, or stands where another file is.
    """
    target = check_output(path, RESULTS)
    with refusals_named(target), written_results(results, target) as temporary:
        put(temporary, target)
    return Path(path)


@contextlib.contextmanager
def written_results(results: Results, path: Path) -> Iterator[Path]:
    """Write a results file beside its place, for :func:`roughbench.publish.put`.

    Needs the memory of one model's results at a time, where ``results`` makes them one at a
    time.

    Raises
    ------
    OSError
        If the system refuses.
    """
    with written(lambda file: _write(results, file), path) as temporary:
        yield temporary


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
        raise StoreError(f"{source}: no such file; {_rerun()} or check the name") from None
    except OSError as error:
        raise StoreError(f"{source}: cannot be read: {explained(error)}") from error
    with contextlib.ExitStack() as stack:
        with _damage_named(source):
            _check_seal(source)
            file = stack.enter_context(h5py.File(source, "r"))
            results = _read_root(file, source)
        yield results


class _Stored(Mapping[str, Array]):
    """Variables in a file."""

    def __init__(self, data: Mapping[str, h5py.Dataset], source: Path) -> None:
        self._data, self._source = data, source

    def __getitem__(self, name: str) -> Array:
        data = self._data[name]
        with _damage_named(self._source):
            values: Array = data[()]
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)


def _whole(result: ModelResult) -> ModelResult:
    return dataclasses.replace(result, variables=dict(result.variables))


@contextlib.contextmanager
def _damage_named(source: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise StoreError(f"{source}: damaged ({error}); {_rerun()}") from error


def whose(path: str | os.PathLike[str]) -> tuple[str, str] | None:
    """Return the name and the hash of the spec that a results file is of.

    None if there is no sound results file, so that there are no results to lose.
    """
    source = Path(path)
    try:
        if not source.is_file():
            return None
        _check_seal(source)
        with h5py.File(source, "r") as file:
            budget = _Budget(source)
            name, sha256 = (_attribute(file, key, budget) for key in ("name", "spec_sha256"))
            return on_one_line(str(name)), str(sha256)
    except (StoreError, OSError, KeyError, RuntimeError, ValueError, TypeError):
        return None


# -- writing -----------------------------------------------------------------------------


def _is_results(head: bytes, tail: bytes) -> bool:
    """Whether a file is one of ours, perhaps damaged at one end."""
    if has_mark(io.BytesIO(tail)):
        return True
    return head.startswith(_HDF5) and all(word in head for word in _ATTRIBUTES)


def _is_stump(head: bytes) -> bool:
    """Whether a file is the first bytes of an HDF5 file, too few to tell whose."""
    if not head.startswith(_HDF5) or len(head) == ENDS:
        return False
    claimed = int.from_bytes(head[_END_ADDRESS], "little")
    return len(head) < _BEFORE_ATTRIBUTES or len(head) < claimed


RESULTS = Kind("results file", _is_results)
RESULTS_OR_STUMP = Kind("results file", lambda h, t: _is_results(h, t) or _is_stump(h))
"""What a run directory lets be replaced that knows of results: also their first bytes."""


def image(results: Results) -> bytes:
    """Return the bytes of the results file."""
    file = io.BytesIO()
    _write(results, file)
    return file.getvalue()


def _write(results: Results, target: IO[bytes]) -> None:
    """Write all of a results file.

    Raises
    ------
    OSError
        If the system refuses.
    """
    sink = Sink(target)
    try:
        with _fresh_file(sink) as file:
            with signals_held_back():
                file.attrs["format"] = FORMAT
                file.attrs["format_version"] = 1
                file.attrs["name"] = results.name
                file.attrs["spec"] = results.spec_text
                file.attrs["spec_sha256"] = results.spec_sha256
            for experiment, models in results.experiments.items():
                with signals_held_back():
                    parent = _create_group(file, experiment)
                for label in models:  # one at a time: not .items(), which holds the last
                    result = models[label]
                    with signals_held_back():
                        version = _write_model(_create_group(parent, label), result, sink)
                        if version > file.attrs["format_version"]:
                            file.attrs.modify("format_version", version)
                    del result
                if experiment in results.surfaces:
                    with signals_held_back():
                        first = parent[next(iter(models))]
                        _write_surface(first, results.surfaces[experiment], sink)
                        file.attrs.modify("format_version", FORMAT_VERSION)
    finally:
        sink.check()  # rather than what HDF5 makes of it
    seal_file(target)


def _axes(result: ModelResult, name: str) -> tuple[str, ...]:
    return dimensions(name, result[name].ndim)


def _version(result: ModelResult) -> int:
    axes = {axis for name in result for axis in _axes(result, name)}
    return 1 if axes <= {"realization", "pressure"} else FORMAT_VERSION


def _check_seal(source: Path) -> None:
    """Refuse a file whose bytes are not those that were written.

    HDF5 checks the arrays on its own, but a damage elsewhere may be read without notice, or
    make it loop for ever.
    """
    with source.open("rb") as file:
        try:
            check_seal(file)
        except ValueError:
            if has_mark(file):
                raise
            file.seek(0)
            begins = file.read(len(_HDF5))
        else:
            return
    if begins == _HDF5:
        raise StoreError(
            f"{source}: an HDF5 file, but not written by roughbench, or cut short; give a "
            f"results file of 'roughbench run', or {_rerun()}"
        )
    if source.suffix in {".yaml", ".yml"}:
        hint = f"if it is a spec, compute it with: {command('run', source)}"
    else:
        hint = "give a roughbench results file"
    raise StoreError(f"{source}: not an HDF5 file; {hint}")


def _rerun() -> str:
    return f"run its spec again ({program()} run SPEC.yaml)"


@contextlib.contextmanager
def _fresh_file(sink: Sink) -> Iterator[h5py.File]:
    """Open a fresh HDF5 file, which keeps the order of its groups, not times."""
    created = h5py.h5p.create(h5py.h5p.FILE_CREATE)
    _keep_order_not_times(created)
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_fileobj_driver(h5py.h5fd.fileobj_driver, sink)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
    # HDF5 wants a name that no other open file of the process has.
    name = f"roughbench-{os.getpid()}-{next(_counter)}"
    file = None
    try:
        with signals_held_back():  # one in a callback of HDF5 would leave the file open
            handle = h5py.h5f.create(
                name.encode(), h5py.h5f.ACC_TRUNC, fcpl=created, fapl=access
            )
            file = h5py.File(handle)
        yield file
    finally:
        if file is not None:
            with signals_held_back():
                file.close()


def _create_group(parent: h5py.Group, name: str) -> h5py.Group:
    created = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    _keep_order_not_times(created)
    return h5py.Group(h5py.h5g.create(parent.id, name.encode(), gcpl=created))


def _keep_order_not_times(properties: h5py.h5p.PropOCID) -> None:
    properties.set_link_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
    properties.set_obj_track_times(False)


def _write_model(group: h5py.Group, result: ModelResult, sink: Sink) -> int:
    """Write the results of one model; returns the least version of the format that knows it.

    Raises
    ------
    OSError
        If the system has refused something.
    """
    group.attrs["kind"] = result.kind
    group.attrs["title"] = result.title
    for name, value in result.attributes.items():
        group.attrs[name] = value
    for name, values in _with_scales(result).items():
        axes = dimensions(name, values.ndim)
        # The checksum needs a chunked layout: one chunk holds it all, or one field.
        chunks = (1, *values.shape[1:]) if axes[0] == "field" else values.shape
        data = group.create_dataset(name, data=values, chunks=chunks, fletcher32=True)
        sink.check()
        data.attrs["units"] = result.units(name)
        data.attrs["long_name"] = result.long_name(name)
        if axes == (name,):
            data.make_scale(name)
            continue
        for axis, scale in zip(data.dims, axes, strict=True):
            axis.attach_scale(group[scale])
    group["status"].attrs["flag_values"] = np.array([int(s) for s in Status], np.int32)
    group["status"].attrs["flag_meanings"] = " ".join(s.name.lower() for s in Status)
    return _version(result)


def _write_surface(group: h5py.Group, record: SurfaceRecord, sink: Sink) -> None:
    """Write the record of the measured surface of an experiment beside its first model."""
    for name, value in record.attributes().items():
        group.attrs[name] = value
    for name, values in record.arrays().items():
        axes, units, words = DESCRIBED[name]
        data = group.create_dataset(name, data=values, chunks=values.shape, fletcher32=True)
        sink.check()
        data.attrs["units"], data.attrs["long_name"] = units, words
        if axes == (name,):
            data.make_scale(name)
            continue
        for axis, scale in zip(data.dims, axes, strict=True):
            axis.attach_scale(group[scale])


def _with_scales(result: ModelResult) -> dict[str, Array]:
    """Return the variables of a model, its dimension scales first."""
    scales = {
        "pressure": result["pressure"],
        "realization": np.arange(result.n_realizations, dtype=np.int64),
    }
    if "field_status" in result:
        scales["field"] = np.arange(len(result["field_status"]), dtype=np.int64)
    scales |= {name: result[name] for name in result if _axes(result, name) == (name,)}
    variables = scales | dict(result.variables)
    for name, values in variables.items():
        if values.dtype not in STORABLE:
            raise StoreError(
                f"{result.label}: {name} has type {values.dtype}; "
                "store it as float64, float32, int64 or int32"
            )
    _check_shapes(variables, result.label)
    return variables


# -- reading -----------------------------------------------------------------------------


def _read_root(file: h5py.File, source: Path) -> Results:
    budget = _Budget(source)
    if "format" not in file.attrs or _attribute(file, "format", budget) != FORMAT:
        raise StoreError(
            f"{source}: an HDF5 file, but not written by roughbench; "
            "give a results file of 'roughbench run'"
        )
    version = int(_attribute(file, "format_version", budget))
    if version > FORMAT_VERSION:
        raise StoreError(
            f"{source}: has format version {version}, newer than {FORMAT_VERSION}; "
            "upgrade roughbench to read it"
        )
    experiments: dict[str, dict[str, ModelResult]] = {}
    surfaces: dict[str, SurfaceRecord] = {}
    for experiment, models in _members(file, h5py.Group, budget):
        experiments[experiment] = {}
        for label, group in _members(models, h5py.Group, budget):
            found, record = _read_model(group, label, budget)
            experiments[experiment][label] = found
            if record is not None:
                surfaces[experiment] = record
    text, sha256, name = (
        str(_attribute(file, key, budget)) for key in ("spec", "spec_sha256", "name")
    )
    return Results(
        experiments, printable(text), on_one_line(sha256), on_one_line(name), surfaces
    )


class _Budget:
    """What a file of ours can hold: each object once, and no more bytes than it has.

    A crafted one links the same object a million times, or declares arrays that nobody wrote.
    """

    def __init__(self, source: Path) -> None:
        self.source = source
        self._left = self._size = source.stat().st_size
        self._seen: set[tuple[int, int]] = set()

    def meet(self, item: h5py.Group | h5py.Dataset) -> None:
        """Refuse an object that was met before."""
        info = h5py.h5o.get_info(item.id)
        place = (info.fileno, info.addr)
        if place in self._seen:
            raise ValueError(f"{on_one_line(item.name)} stands in it under two names")
        self._seen.add(place)

    def take(self, n_bytes: int, what: str) -> None:
        """Refuse more bytes in all than the file has."""
        self._left -= n_bytes
        if self._left < 0:
            raise ValueError(f"{what} claims {n_bytes} bytes, the file has {self._size} in all")


def _members(
    group: h5py.Group, wanted: type[h5py.Group | h5py.Dataset], budget: _Budget
) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    """Yield the members of a group; only plain links to the wanted type are followed."""
    for name in group:
        _check_name(name)
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise StoreError(
                f"{budget.source}: {group.name}/{name} is a link to another place, which no "
                f"roughbench file has; {_rerun()}"
            )
        member = group[name]
        if not isinstance(member, wanted):
            raise ValueError(f"{member.name} should be a {wanted.__name__.lower()}")
        budget.meet(member)
        yield name, member


def _check_name(name: str) -> None:
    """Refuse names that mean something to file systems, terminals or spreadsheets."""
    means_else = "/" in name or name[:1] in "=+-@" or name == "."
    if means_else or unsafe_character(name) or len(name) > _LONGEST_NAME:
        shown = on_one_line(name[:_LONGEST_NAME])
        raise ValueError(f"the name {shown!r} is none that roughbench gives")


def _read_model(
    group: h5py.Group, label: str, budget: _Budget
) -> tuple[ModelResult, SurfaceRecord | None]:
    attributes = {}
    for name in group.attrs:
        _check_name(name)
        value = _attribute(group, name, budget)
        attributes[name] = on_one_line(value) if isinstance(value, str) else value
    kind, title = str(attributes.pop("kind")), str(attributes.pop("title"))
    modulus = attributes.get(MODULUS, 1.0)
    if not isinstance(modulus, float) or not 0.0 < modulus < math.inf:
        raise ValueError(f"{group.name} has the {MODULUS} {modulus!r}")
    variables: dict[str, h5py.Dataset] = {}
    described: dict[str, tuple[str, str]] = {}
    for name, data in _members(group, h5py.Dataset, budget):
        if data.external or data.is_virtual:
            raise StoreError(
                f"{budget.source}: {data.name} keeps its values in another file, which no "
                f"roughbench file does; {_rerun()}"
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
            unit, words = (_attribute(data, key, budget) for key in ("units", "long_name"))
            described[name] = on_one_line(str(unit)), on_one_line(str(words))
        variables[name] = data
    missing = [name for name in _REQUIRED if name not in variables]
    if missing:
        raise ValueError(f"{group.name} lacks {', '.join(missing)}")
    recorded = {name: variables.pop(name) for name in DESCRIBED if name in variables}
    said = {name: attributes.pop(name) for name in [*attributes] if name.startswith(PREFIX)}
    _check_shapes(variables, group.name)
    for index in ("realization", "field"):
        variables.pop(index, None)
    result = ModelResult(
        label, kind, title, attributes, _Stored(variables, budget.source), described
    )
    if not recorded:
        return result, None
    arrays = {name: data[()] for name, data in recorded.items()}
    return result, SurfaceRecord.of(arrays, said)


def _attribute(owner: h5py.Group, name: str, budget: _Budget) -> Attribute:
    """Return an attribute as a plain Python string or number; look at its size first."""
    attribute = owner.attrs.get_id(name)
    if attribute.shape != ():
        raise ValueError(f"an attribute {on_one_line(name)} of shape {attribute.shape}")
    budget.take(attribute.dtype.itemsize, f"attribute {on_one_line(name)}")
    value = _plain(owner.attrs[name])
    if isinstance(value, str):
        budget.take(len(value), f"attribute {on_one_line(name)}")
    return value


def _check_shapes(variables: Mapping[str, Array | h5py.Dataset], where: str) -> None:
    shape = variables["status"].shape
    if len(shape) != 2:
        raise ValueError(f"{where}: status must have two dimensions, got {len(shape)}")
    lengths = dict(zip(("realization", "pressure"), shape, strict=True))
    for name, values in variables.items():
        suits, wanted = compare_shape(name, values.shape, lengths)
        if not suits:
            raise ValueError(
                f"{where}: {name} must have the shape {wanted}, got {values.shape}"
            )


def _plain(value: object) -> Attribute:
    """Return an attribute as a plain Python string or number."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, str | int | float):
        return value
    raise ValueError(f"an attribute of type {type(value).__name__}")
