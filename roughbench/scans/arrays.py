"""Heights from files of NumPy: ``.npy`` and ``.npz``, which know neither size nor unit."""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.heights_file import check_layout, check_memory, check_there, read_npy
from roughbench.scans.image import Channel, Image, choose, held
from roughbench.text import on_one_line

_MOST_ARRAYS = 256


def read_npy_image(path: Path, name: str, channel: str | None) -> Image:
    """Return the array of a ``.npy`` file.

    Raises
    ------
    SurfaceError
        If it is no array of real numbers in two dimensions, or a channel is asked for.
    """
    if channel is not None:
        raise SurfaceError(
            f"{name}: a .npy file has no channels, channel: {on_one_line(channel)} must go"
        )
    return Image(as_values(read_npy(path, name), name))


def read_npz(path: Path, name: str, channel: str | None) -> Image:
    """Return the named array of a ``.npz`` file, or its only one of two dimensions.

    Raises
    ------
    SurfaceError
        If the file is damaged, or it is not clear which array is meant.
    """
    check_there(path, name)
    try:
        with zipfile.ZipFile(path) as archive:
            members = _members(archive, name)
            if channel is None and len(members) != 1:
                what = "more than one array of two dimensions" if members else "no array"
                raise SurfaceError(
                    f"{name}: {what} that may be the heights; {held([*members])}"
                    + ("; name one with channel:" if members else "")
                )
            chosen = [*members][choose([*members], channel, name)]
            with archive.open(members[chosen]) as file:
                shape, dtype = _npy_header(file)
                check_layout(shape, dtype, name)
                check_memory(shape, dtype, name)
                if math.prod(shape) * dtype.itemsize > members[chosen].file_size:
                    raise ValueError(f"{chosen.name} is cut short")
            with archive.open(members[chosen]) as file:
                array = np.lib.format.read_array(file, allow_pickle=False)
    except (
        *(zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError),
        *(ValueError, OSError, EOFError, MemoryError),
    ) as error:
        raise SurfaceError(
            f"{name}: not a readable .npz file ({on_one_line(str(error))}); write it with "
            "numpy.savez(path, heights=heights)"
        ) from error
    return Image(as_values(array, name), channel=chosen.name)


def as_values(array: NDArray[Any], name: str) -> NDArray[np.float64]:
    """Return an array of two dimensions as float64 of its own.

    Raises
    ------
    SurfaceError
        If it has one dimension.
    """
    if array.ndim != 2:
        raise SurfaceError(f"{name}: a scan has rows and columns, got the shape {array.shape}")
    with np.errstate(over="ignore"):  # of wider floats; infinity is taken as missing
        return np.ascontiguousarray(array, np.float64)


def _members(archive: zipfile.ZipFile, name: str) -> dict[Channel, zipfile.ZipInfo]:
    """Return the arrays of real numbers in two dimensions."""
    found: dict[Channel, zipfile.ZipInfo] = {}
    entries = archive.infolist()
    if len(entries) > _MOST_ARRAYS:
        raise SurfaceError(f"{name}: {len(entries)} arrays; a scan has {_MOST_ARRAYS} at most")
    for info in entries:
        if not info.filename.endswith(".npy"):
            continue
        with archive.open(info) as file:
            shape, dtype = _npy_header(file)
        if len(shape) == 2 and dtype.kind in "fiu" and not dtype.hasobject:
            found[Channel(info.filename.removesuffix(".npy"))] = info
    return found


def _npy_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = np.lib.format.read_magic(file)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    else:
        shape, _, dtype = np.lib.format.read_array_header_2_0(file)
    return shape, dtype
