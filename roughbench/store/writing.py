"""Results into an HDF5 file, whose bytes depend on the results alone: no times, no machines.

A file is written beside its place, group by group, and published in one step, so that a
reader finds either the old file or the whole new one, whatever happens in between.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

import h5py
import numpy as np

from roughbench.errors import StoreError
from roughbench.models.base import Status
from roughbench.outputs import check_output
from roughbench.publish import put, refusals_named, written
from roughbench.results import Array, ModelResult, Results
from roughbench.seal import seal_file
from roughbench.signals import signals_held_back
from roughbench.sink import Sink
from roughbench.store.format import FORMAT, FORMAT_VERSION, MADE_WITH, RESULTS, check_shapes
from roughbench.surface_record import DESCRIBED, SurfaceRecord
from roughbench.variables import STORABLE, dimensions

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
    with written(lambda file: write_file(results, file), path) as temporary:
        yield temporary


def image(results: Results) -> bytes:
    """Return the bytes of the results file."""
    file = io.BytesIO()
    write_file(results, file)
    return file.getvalue()


def write_file(results: Results, target: IO[bytes]) -> None:
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
                _write_making(file, results.made_with)
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
    _write_making(group, result.made_with)
    # Each dataset stays open until the next is made: the layout of the file depends on that.
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


def _write_making(group: h5py.Group, made_with: Mapping[str, str | int]) -> None:
    if made_with:
        group.attrs[MADE_WITH] = json.dumps(dict(made_with))


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
    check_shapes(variables, result.label)
    return variables
