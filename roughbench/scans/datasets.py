"""Heights from datasets of HDF5 and netCDF-4 files, with the size and unit that they note."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.heights_file import fill_values, find_dataset, open_hdf5, read_dataset
from roughbench.scans.arrays import as_values
from roughbench.scans.image import Channel, Image, choose, held
from roughbench.scans.lengths import in_metres
from roughbench.text import on_one_line

if TYPE_CHECKING:
    import h5py

_UNIT = ("units", "unit")
_WHOLE = ("physical_sizes", "physical_size", "size")
_PER_POINT = ("spacing", "pixel_size")
_UNEVEN = 1e-3
"""Largest departure of coordinates from equal steps, in steps."""
_MOST_COORDINATES = 1 << 20


def read_hdf5(path: Path, dataset: str | None, name: str, channel: str | None = None) -> Image:
    """Return a dataset as an image; nan, fill values and masked points are missing.

    The unit of the heights is the attribute ``units`` (or ``unit``) of the dataset,
    ``scale_factor`` and ``add_offset`` are applied. The size comes from coordinates on its
    dimensions (netCDF, xarray), or from an attribute ``size``, ``physical_size``,
    ``spacing`` or ``pixel_size`` with a ``…_unit``, if it is the same along both axes.

    Parameters
    ----------
    path : Path
    dataset : str or None
        Path in the file; None for the one of this ``channel``, or the only one there is.
    name : str
        Of the file, for messages.
    channel : str, optional

    Raises
    ------
    SurfaceError
        Whatever is wrong with it; if it is not clear which dataset is meant.
    """
    with open_hdf5(path, name) as file:
        if dataset is None:
            dataset = _only_dataset(file, name, channel)
        found = find_dataset(file, dataset, name)
        raw = read_dataset(found, name)
        values = as_values(raw, name)
        missing = np.zeros(raw.shape, bool)
        for fill in fill_values(found).values():
            missing |= np.isin(raw, fill)
        del raw
        unit = _unit(found, name)
        factor, offset = _number(found, "scale_factor", 1.0), _number(found, "add_offset", 0.0)
        if (factor, offset) != (1.0, 0.0):
            values *= factor
            values += offset
        values[missing] = np.nan
        try:
            steps, names = _steps(found)
            noted = _noted_size(found)
        except (OSError, RuntimeError, TypeError, ValueError, KeyError):  # damaged attributes
            steps, names, noted = (None, None), ("", ""), None
    notes = []
    if names == ("x", "y"):
        values, steps = np.ascontiguousarray(values.T), (steps[1], steps[0])
        notes.append("the dataset is ordered (x, y): rows and columns were exchanged")
    size = None
    if steps[0] is not None and steps[1] is not None:
        size = (steps[0] * values.shape[0], steps[1] * values.shape[1])
    elif noted is not None:
        whole, length = noted
        size = (
            (length, length) if whole else (length * values.shape[0], length * values.shape[1])
        )
    return Image(values, unit, size, dataset.strip("/"), tuple(notes))


def _only_dataset(file: h5py.File, name: str, channel: str | None) -> str:
    channels: list[Channel] = []

    def look(path: str, item: Any) -> None:
        shape, dtype = getattr(item, "shape", None), getattr(item, "dtype", None)
        if shape is not None and dtype is not None and len(shape) == 2 and dtype.kind in "fiu":
            unit = _text(item, _UNIT)
            is_height = unit in ("", "1") or in_metres(unit) is not None
            channels.append(Channel(path, unit, is_height))

    try:
        file.visititems(look)
    except (OSError, RuntimeError, KeyError) as error:
        raise SurfaceError(
            f"{name}: the file is damaged ({on_one_line(str(error))})"
        ) from error
    if channel is None and sum(entry.is_height for entry in channels) > 1:
        raise SurfaceError(
            f"{name}: more than one dataset that may be the heights; {held(channels)}; name "
            f"one, as in {name}:/{on_one_line(channels[0].name)}, or with channel:"
        )
    return "/" + channels[choose(channels, channel and channel.strip("/"), name)].name


def _unit(found: h5py.Dataset, name: str) -> float | None:
    """Return metres per unit of the heights, None where nothing is noted."""
    text = _text(found, _UNIT)
    if text in ("", "1"):
        return None
    unit = in_metres(text)
    if unit is None:
        raise SurfaceError(
            f"{name}: the dataset holds values in {on_one_line(text)!r}, which is no length: "
            "no heights; choose another, or correct its attribute units"
        )
    return unit


def _steps(found: h5py.Dataset) -> tuple[tuple[float | None, float | None], tuple[str, str]]:
    """Return the spacing along both axes, in m, and their names, from their coordinates."""
    steps: list[float | None] = []
    names = []
    for axis in (0, 1):
        dimension = found.dims[axis]
        scale = dimension[0] if len(dimension) else None
        label = dimension.label or (scale.name if scale is not None else "")
        names.append(str(label).rpartition("/")[2].lower())
        steps.append(None if scale is None else _step(scale, found.shape[axis]))
    return (steps[0], steps[1]), (names[0], names[1])


def _step(scale: h5py.Dataset, n_points: int) -> float | None:
    """Return the distance of neighbouring coordinates, in m, if they are even."""
    unit = in_metres(_text(scale, _UNIT))
    if unit is None or scale.shape != (n_points,) or n_points > _MOST_COORDINATES:
        return None
    if scale.is_virtual or scale.external or scale.dtype.kind not in "fiu" or n_points < 2:
        return None
    x: NDArray[np.float64] = scale[()].astype(np.float64)
    step = float(x[-1] - x[0]) / (n_points - 1)
    even = x[0] + step * np.arange(n_points)
    if not np.isfinite(x).all() or step == 0.0 or np.abs(x - even).max() > _UNEVEN * abs(step):
        return None
    return abs(step) * unit


def _noted_size(found: h5py.Dataset) -> tuple[bool, float] | None:
    """Return whether it is the whole image's or a point's, and a length in m."""
    for names, whole in ((_WHOLE, True), (_PER_POINT, False)):
        for key in names:
            value = np.ravel(found.attrs.get(key, ()))
            unit = in_metres(_text(found, (f"{key}_unit", f"{key}_units")))
            if unit is None or value.dtype.kind not in "fiu" or value.size not in (1, 2):
                continue
            if value[0] == value[-1] and value[0] > 0:
                return whole, float(value[0]) * unit
    return None


def _text(item: Any, keys: tuple[str, ...]) -> str:
    """Return the first of these attributes that is a text, "" for none."""
    for key in keys:
        try:
            value = item.attrs.get(key, "")
        except (OSError, RuntimeError, TypeError, ValueError):
            continue
        if isinstance(value, np.ndarray) and value.size == 1:
            value = value.ravel()[0]
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        if isinstance(value, str) and value.strip():
            return value.strip()
    return ""


def _number(found: h5py.Dataset, key: str, otherwise: float) -> float:
    try:
        value = np.ravel(found.attrs.get(key, otherwise))
    except (OSError, RuntimeError, TypeError, ValueError):
        return otherwise
    if value.size != 1 or value.dtype.kind not in "fiu" or not np.isfinite(value[0]):
        return otherwise
    return float(value[0])
