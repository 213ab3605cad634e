"""A topography as it was measured: heights with size and unit, some of them missing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.heights_file import check_there
from roughbench.scans import arrays, datasets, instruments, tables
from roughbench.scans.image import Image
from roughbench.scans.scale import settled_size, settled_unit
from roughbench.system import split_dataset
from roughbench.text import on_one_line

FloatArray = NDArray[np.float64]
_FEWEST = 4
"""Points per side: fewer carry no wave but the one that alternates from point to point."""
_HDF5 = frozenset({".h5", ".hdf5", ".hdf", ".he5", ".nc", ".nc4"})


@dataclass(frozen=True, slots=True)
class Scan:
    """Heights as a file holds them, in SI units.

    Rows run along y and columns along x, as the image shows it: the first row is its top
    one, the first column its left one. In lists of points the first row has the smallest y.

    Parameters
    ----------
    heights : ndarray of float64, shape (rows, columns)
        In m; nan where a point is missing.
    size : (float, float)
        Of the scan along rows and columns (y, x), in m: points times their spacing.
    source : str
        The path as it was given.
    channel : str
        Name of the channel of the file; "" where it has only one.
    notes : tuple of str
        What was assumed in reading it.

    Examples
    --------
    >>> scan = Scan(np.array([[0.0, np.nan], [1e-9, 0.0]]), size=(2e-6, 2e-6))
    >>> scan.shape, scan.missing, scan.spacing
    ((2, 2), 0.25, (1e-06, 1e-06))
    """

    heights: FloatArray
    size: tuple[float, float]
    source: str = ""
    channel: str = ""
    notes: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.heights.shape
        return rows, columns

    @property
    def missing(self) -> float:
        """Share of the points that are missing."""
        return float(np.count_nonzero(np.isnan(self.heights)) / self.heights.size)

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance between neighbouring points along (y, x), in m."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]


def read_scan(
    path: str | Path,
    folder: str | Path = ".",
    *,
    channel: str | None = None,
    size: tuple[float, float] | None = None,
    unit: float | None = None,
) -> Scan:
    """Read a topography of any kind of file, in SI units.

    Built in are ``.npy``, ``.npz``, HDF5 (``file.h5`` or ``file.h5:/dataset``), matrices
    and lists of points as text (``.txt``, ``.csv``, ``.xyz`` …). The formats of instruments
    are read by SurfaceTopography.

    Parameters
    ----------
    path : str or Path
    folder : str or Path
        Where a relative path starts from.
    channel : str, optional
        Which image of the file; otherwise the first that holds heights.
    size : (float, float), optional
        Of the image along (y, x), in m: where the file does not say it.
    unit : float, optional
        Metres per unit of the heights: where the file does not say it.

    Returns
    -------
    Scan
        With nan for points that are missing or not finite.

    Raises
    ------
    SurfaceError
        In one line, with the name of the file, whatever is wrong with it: not there, not
        readable, damaged, too large for the memory; without size or unit, where none is
        given; with another size or unit than given.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> heights = np.arange(20.0).reshape(4, 5)
    >>> np.save(f"{folder}/scan.npy", heights)
    >>> scan = read_scan("scan.npy", folder, size=(0.5, 1.25), unit=1e-9)
    >>> scan.spacing, round(float(scan.heights[3, 4]), 12)
    ((0.125, 0.25), 1.9e-08)
    >>> read_scan("scan.npy", folder)
    Traceback (most recent call last):
        ...
    roughbench.errors.SurfaceError: scan.npy: the file does not say the size of the image and
    the unit of the heights; give them: size: [10 um, 10 um] (x, y) and unit: nm
    """
    name = on_one_line(str(path))
    image = _read(str(path), Path(folder), name, channel)
    image_size = settled_size(image, size, unit, name)
    factor = settled_unit(image, unit, name)
    values, notes = image.values, list(image.notes)
    if min(values.shape) < _FEWEST:
        raise SurfaceError(
            f"{name}: a surface needs at least {_FEWEST} points per side, got "
            f"{values.shape[0]} rows and {values.shape[1]} columns"
        )
    heights = values if values.flags.writeable else values.copy()
    with np.errstate(over="ignore"):
        heights *= factor
    infinite = np.isinf(heights)
    n_infinite = int(np.count_nonzero(infinite))
    if n_infinite:
        heights[infinite] = np.nan
        notes.append(f"{n_infinite} infinite heights were taken as missing")
    if np.isnan(heights).all():
        raise SurfaceError(f"{name}: all {heights.size} points are missing; nothing to read")
    return Scan(heights, image_size, str(path), image.channel, tuple(notes))


def _read(path: str, folder: Path, name: str, channel: str | None) -> Image:
    """Hand the file to the reader of its kind."""
    file_name, dataset = split_dataset(path)
    if dataset:
        if channel is not None:
            raise SurfaceError(
                f"{name}: the dataset is named twice, by :{on_one_line(dataset)} and by "
                f"channel: {on_one_line(channel)}; leave one of them out"
            )
        return datasets.read_hdf5(folder / file_name, dataset, name)
    place = folder / path
    check_there(place, name)
    suffix = place.suffix.lower()
    head = _head(place, name)
    if suffix == ".npy":
        return arrays.read_npy_image(place, name, channel)
    if suffix == ".npz":
        return arrays.read_npz(place, name, channel)
    if suffix in _HDF5 and not (suffix.startswith(".nc") and head.startswith(b"CDF")):
        return datasets.read_hdf5(place, None, name, channel)
    if tables.is_table(suffix, head):
        return tables.read_table(place, name, channel)
    return instruments.read_instrument(place, name, channel)


def _head(path: Path, name: str) -> bytes:
    try:
        with path.open("rb") as file:
            head = file.read(tables.HEAD)
    except OSError as error:
        raise SurfaceError(f"{name}: cannot be read: {error.strerror or error}") from error
    if not head:
        raise SurfaceError(f"{name}: the file is empty")
    return head
