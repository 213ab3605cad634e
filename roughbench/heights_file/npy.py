"""Arrays in ``.npy`` files."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError

if TYPE_CHECKING:
    pass
from roughbench.heights_file.checks import check_layout, check_memory, check_there


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
