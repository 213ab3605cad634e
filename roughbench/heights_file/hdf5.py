"""Datasets of HDF5 files; nothing is read that lies outside the file."""

from __future__ import annotations

import math
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.text import on_one_line

if TYPE_CHECKING:
    import h5py
from roughbench.heights_file.checks import check_layout, check_memory, check_there

_MOST_SOFT_LINKS = 16
_MOST_FILLS = 16
_MOST_COMPRESSED = 1100
"""Bytes that a byte of a file can stand for: deflate reaches 1032."""
_MOST_NAMES = 8


def load_hdf5(path: Path, dataset: str, name: str) -> NDArray[Any]:
    """Return the array of a dataset, in which no point is missing, in the type it has."""
    with open_hdf5(path, name) as file:
        found = find_dataset(file, dataset, name)
        heights = read_dataset(found, name)
        _refuse_fill_values(heights, found, name)
        return heights


def open_hdf5(path: Path, name: str) -> h5py.File:
    """Open an HDF5 file for reading; a context manager.

    Raises
    ------
    SurfaceError
        If there is no such file, or it is no HDF5 file.
    """
    import h5py

    check_there(path, name)
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise SurfaceError(f"{name}: {path.name} is not a readable HDF5 file") from error


def read_dataset(found: h5py.Dataset, name: str) -> NDArray[Any]:
    """Return the array of a dataset, of one or two dimensions, in the type it has.

    Raises
    ------
    SurfaceError
        If its data are in other files, were never written in part, cannot be held in
        memory or read, or are no array of real numbers of a good shape.
    """
    if found.is_virtual or found.external:
        raise SurfaceError(
            f"{name}: the dataset keeps its data in other files, which is refused; "
            "copy them into one dataset"
        )
    check_layout(found.shape, found.dtype, name)
    _check_stored(found, name)
    check_memory(found.shape, found.dtype, name)
    try:
        values: NDArray[Any] = found[()]
    except (OSError, MemoryError) as error:
        raise SurfaceError(f"{name}: the dataset cannot be read ({error})") from error
    return values


def fill_values(found: h5py.Dataset) -> dict[str, NDArray[Any]]:
    """Return the numbers that a dataset says stand for missing points, by attribute."""
    fills = {}
    for attribute in ("_FillValue", "missing_value"):
        try:
            fill = np.ravel(found.attrs.get(attribute, ()))
        except (OSError, TypeError, ValueError):  # of a type that numbers do not have
            continue
        if fill.dtype.kind in "fiu" and fill.size:
            fills[attribute] = fill[:_MOST_FILLS]
    return fills


def _refuse_fill_values(heights: NDArray[Any], found: h5py.Dataset, name: str) -> None:
    """Refuse points that the dataset says are missing, as netCDF writes masked arrays."""
    for attribute, fill in fill_values(found).items():
        missing = sum(int(np.count_nonzero(heights == value)) for value in fill)
        if missing:
            raise SurfaceError(
                f"{name}: {missing} of {heights.size} heights are marked as missing "
                f"({attribute} = {fill[0]:g}); fill or cut the missing points before"
            )


def _check_stored(found: h5py.Dataset, name: str) -> None:
    """Refuse what was never written, which reads as zeros, or cannot be in so few bytes."""
    stored = found.id.get_storage_size()
    if found.chunks is None:
        missing = stored < found.nbytes
        largest = found.nbytes
    else:
        pairs = zip(found.shape, found.chunks, strict=True)
        missing = found.id.get_num_chunks() < math.prod(-(-n // chunk) for n, chunk in pairs)
        largest = max(found.nbytes, math.prod(found.chunks) * found.dtype.itemsize)
    if missing:
        raise SurfaceError(
            f"{name}: parts of the dataset were never written ({found.nbytes} bytes are "
            f"declared, {stored} stored); write all of the heights"
        )
    if largest > _MOST_COMPRESSED * stored:
        raise SurfaceError(
            f"{name}: {stored} bytes of the file claim to be {largest} bytes of heights; save "
            "them again, with chunks no larger than the dataset"
        )


def find_dataset(file: h5py.File, dataset: str, name: str) -> h5py.Dataset:
    """Follow the path link by link, so that no link leads out of the file.

    Raises
    ------
    SurfaceError
        If there is no such dataset, or a link to another file on the way.
    """
    import h5py

    here: h5py.Group = file
    parts = deque(part for part in dataset.split("/") if part)
    followed = 0
    while parts:
        part = parts.popleft()
        link = here.get(part, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise SurfaceError(
                f"{name}: {part} is a link to another file, which is refused; "
                f"name that file itself ({on_one_line(f'{link.filename}:{link.path}')})"
            )
        if isinstance(link, h5py.SoftLink):
            followed += 1
            if followed > _MOST_SOFT_LINKS:
                raise SurfaceError(f"{name}: the links of {dataset} go in circles")
            if link.path.startswith("/"):
                here = file
            parts.extendleft(reversed([part for part in link.path.split("/") if part]))
            continue
        item = here[part] if link is not None else None
        if isinstance(item, h5py.Dataset) and not parts:
            return item
        if not isinstance(item, h5py.Group):
            raise SurfaceError(f"{name}: no dataset {part} in {here.name}; {_held(here)}")
        here = item
    raise SurfaceError(f"{name}: {here.name} is a group, not a dataset; {_held(here)}")


def _held(group: h5py.Group) -> str:
    """Say what a group holds, or the beginning of it."""
    names = sorted(group)
    shown = [on_one_line(name) for name in names[:_MOST_NAMES]]
    if len(names) > _MOST_NAMES:
        shown.append(f"and {len(names) - _MOST_NAMES} more")
    return f"it holds {', '.join(shown) or 'nothing'}"
