"""Heights of a line or a surface from a ``.npy`` or HDF5 file."""

from __future__ import annotations

import math
import os
from collections import deque
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench import memory
from roughbench.errors import SurfaceError, explained
from roughbench.inputs import check_heights
from roughbench.text import on_one_line

if TYPE_CHECKING:
    import h5py

FloatArray = NDArray[np.float64]

_FEWEST = 4
"""Points per side: fewer carry no wave but the one that alternates from point to point."""
_MOST_SOFT_LINKS = 16
_MOST_FILLS = 16
_MOST_COMPRESSED = 1100
"""Bytes that a byte of a file can stand for: deflate reaches 1032."""
_MOST_NAMES = 8


def load_heights(path: str | Path, folder: str | Path = ".") -> FloatArray:
    """Return the heights that a file holds, as they stand in it (mean included).

    Parameters
    ----------
    path : str or Path
        ``heights.npy``, or ``file.h5:/dataset`` for a dataset of an HDF5 file.
    folder : str or Path
        Where a relative path starts from.

    Returns
    -------
    ndarray of float64, shape (n,) or (n, m)
        Heights in the file's unit; integers and other floats are converted.

    Raises
    ------
    SurfaceError
        If the file or dataset does not exist or cannot be read, or does not hold finite
        numbers in one or two dimensions with at least four points each. Data outside
        the HDF5 file (external links, external storage, virtual datasets) are refused.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> np.save(f"{folder}/line.npy", [0.0, 1.0, 0.0, -1.0])
    >>> load_heights("line.npy", folder).tolist()
    [0.0, 1.0, 0.0, -1.0]
    """
    name = str(path)
    file_name, colon, dataset = name.rpartition(":/")
    if colon:
        heights = _load_hdf5(Path(folder) / file_name, "/" + dataset, name)
    elif name.endswith(".npy"):
        heights = read_npy(Path(folder) / name, name)
    else:
        raise SurfaceError(
            f"{name}: heights come from a .npy file, or from an HDF5 file with the dataset "
            "named after it, as in file.h5:/heights"
        )
    if not np.isfinite(heights).all():
        bad = np.argwhere(~np.isfinite(heights))
        index = ", ".join(str(i) for i in bad[0])
        raise SurfaceError(
            f"{name}: {len(bad)} of {heights.size} heights are not finite, the first at index "
            f"[{index}]; fill or cut the missing points before"
        )
    try:
        check_heights(heights, error=SurfaceError)
    except SurfaceError as error:
        raise SurfaceError(f"{name}: {error}") from None
    return np.ascontiguousarray(heights, np.float64)


def check_layout(shape: tuple[int, ...] | None, dtype: np.dtype[Any], name: str) -> None:
    """Refuse what is no array of real numbers in one or two dimensions.

    Raises
    ------
    SurfaceError
        Naming the file, the type or shape, and the remedy.
    """
    if dtype.kind not in "fiu":
        raise SurfaceError(
            f"{name}: heights must be real numbers, got the type {dtype}; save them as float64"
        )
    if shape is None or len(shape) not in (1, 2):
        raise SurfaceError(
            f"{name}: heights must have one dimension (a line) or two (a surface), "
            f"got the shape {shape}"
        )
    if min(shape) < _FEWEST:
        raise SurfaceError(
            f"{name}: heights need at least {_FEWEST} points per side, got the shape {shape}"
        )


def check_memory(shape: tuple[int, ...], dtype: np.dtype[Any], name: str) -> None:
    """Refuse what would not fit into memory, as it is in the file and in float64.

    Raises
    ------
    SurfaceError
        Naming the file and what would fit.
    """
    n_points, per_point = math.prod(shape), dtype.itemsize + 8
    memory.check(
        per_point * n_points,
        f"{name}: to read {n_points} heights takes {memory.gigabytes(per_point * n_points)}",
        lambda room: f"{room // per_point} would fit: take a coarser or smaller part",
        SurfaceError,
    )


def check_there(path: Path, name: str) -> None:
    """Refuse what is no regular file that can be read.

    Raises
    ------
    SurfaceError
        Naming the file as ``name``, and the remedy.
    """
    try:
        there = path.is_file()
    except OSError as error:
        raise SurfaceError(f"{name}: cannot be read: {explained(error)}") from error
    if not there:
        raise SurfaceError(f"{name}: no such file; relative paths start from {path.parent}")
    if not os.access(path, os.R_OK):
        raise SurfaceError(f"{name}: no permission to read it; check the permissions")


def read_npy(path: Path, name: str) -> NDArray[Any]:
    """Return the array of a ``.npy`` file, of one or two dimensions, in the type it has.

    Raises
    ------
    SurfaceError
        If there is no such file, or no array of real numbers of a good shape in it.
    """
    check_there(path, name)
    try:
        with path.open("rb") as file:
            _check_npy(file, name)
            array = np.lib.format.read_array(file, allow_pickle=False)
    except (ValueError, OSError, EOFError, MemoryError) as error:
        raise SurfaceError(
            f"{name}: not a .npy file of numbers ({error}); write it with "
            "numpy.save(path, heights)"
        ) from error
    return array


def _check_npy(file: IO[bytes], name: str) -> None:
    """Look at the header before anything is allocated; leaves the file at its beginning."""
    version = np.lib.format.read_magic(file)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    else:
        shape, _, dtype = np.lib.format.read_array_header_2_0(file)
    if dtype.hasobject:
        raise ValueError("Object arrays cannot be loaded")
    check_layout(shape, dtype, name)
    start = file.tell()
    held = file.seek(0, os.SEEK_END) - start
    wanted = math.prod(shape) * dtype.itemsize
    if wanted > held:
        raise ValueError(f"cut short: {shape} numbers take {wanted} bytes, it has {held}")
    check_memory(shape, dtype, name)
    file.seek(0)


def _load_hdf5(path: Path, dataset: str, name: str) -> NDArray[Any]:
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
