"""Heights of a line or a surface from a ``.npy`` or HDF5 file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.inputs import check_heights

if TYPE_CHECKING:
    pass
from roughbench.heights_file.hdf5 import load_hdf5
from roughbench.heights_file.npy import read_npy
from roughbench.system import split_dataset

FloatArray = NDArray[np.float64]


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
    file_name, dataset = split_dataset(name)
    if dataset:
        heights = load_hdf5(Path(folder) / file_name, dataset, name)
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
