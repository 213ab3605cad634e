"""Arrays in zip archives, as :func:`numpy.load` reads them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray


def write_arrays(file: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays to a file, in order, to the byte as :func:`numpy.savez` does.

    That of NumPy 1.26 leaves the archive open where the disk is full, and Python then prints,
    when it finds it, an error that nobody handles.

    Parameters
    ----------
    file : binary file
        Open for writing; arrays go straight to it, for they may be large.
    arrays : mapping of str to ndarray
        None of dtype object.

    Raises
    ------
    OSError
        If the system refuses; nothing is left open.
    """
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)
