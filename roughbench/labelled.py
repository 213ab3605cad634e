"""Arrays with named dimensions, as xarray and pandas have them: the only user of both.

Neither is needed by anything else; ``pip install 'roughbench[xarray]'`` adds both.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import RoughbenchError

if TYPE_CHECKING:
    from pandas import DataFrame as DataFrame
    from xarray import Dataset as Dataset
    from xarray import DataTree as DataTree

COMMAND = "pip install 'roughbench[xarray]'"
"""What adds xarray and pandas."""


class NamedArray(NamedTuple):
    """An array with what its file says of it.

    Attributes
    ----------
    dimensions : tuple of str
        A name for every axis.
    values : ndarray
    units, long_name : str
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str


def dataset(arrays: Mapping[str, NamedArray], attributes: Mapping[str, Any]) -> Dataset:
    """Return arrays as a dataset; one over the dimension of its own name is a coordinate.

    Raises
    ------
    RoughbenchError
        Without xarray.
    """
    xarray = _package("xarray")
    variables = {
        name: (one.dimensions, one.values, {"units": one.units, "long_name": one.long_name})
        for name, one in arrays.items()
    }
    made: Dataset = xarray.Dataset(variables, attrs=dict(attributes))
    return made


def together(
    parts: Iterable[Dataset], names: Iterable[str], swept: Mapping[str, list[Any]]
) -> Dataset:
    """Return datasets as one, along the dimensions that they were computed for.

    Where all combinations of the swept values are there, each swept key is a dimension;
    otherwise ``experiment`` is one, and they are coordinates along it. Pressures,
    realizations and fields that only some parts have are nan in the others. Other
    coordinates that differ, as the bins of an observable do, become variables
    ``<name>_value``, since their number is what they have in common.

    Parameters
    ----------
    parts : iterable of Dataset
    names : iterable of str
        Of the experiments.
    swept : mapping of str to list
        Key → its value in each part.

    Raises
    ------
    RoughbenchError
        Without xarray; or if a coordinate differs in its number of values.
    """
    xarray, pandas = _package("xarray"), _package("pandas")
    parts, names = list(parts), list(names)
    parts = _alike(parts)
    whole = xarray.concat(
        parts,
        _index(names, name="experiment"),
        data_vars="all",
        coords="different",
        compat="equals",
        join="outer",
        combine_attrs="drop_conflicts",
    )
    choices = list(zip(*swept.values(), strict=True))
    counts = [len(dict.fromkeys(values)) for values in swept.values()]
    if not swept:
        return whole
    if len(choices) != int(np.prod(counts)) or len(set(choices)) != len(choices):
        return whole.assign_coords(
            {key: ("experiment", values) for key, values in swept.items()}
        )
    levels = [_index(list(dict.fromkeys(values))) for values in swept.values()]
    order = pandas.MultiIndex.from_product(levels, names=list(swept))
    place = {choice: k for k, choice in enumerate(choices)}
    whole = whole.isel(experiment=[place[choice] for choice in order])
    index = xarray.Coordinates.from_pandas_multiindex(order, "experiment")
    made: Dataset = whole.drop_vars("experiment").assign_coords(index).unstack("experiment")
    return made.transpose(*swept, ...)


def _index(values: list[Any], name: str | None = None) -> Any:
    """Return an index, text as objects: NumPy 1 knows no strings like those of pandas 3."""
    text = any(isinstance(value, str) for value in values)
    return _package("pandas").Index(values, dtype=object if text else None, name=name)


def tree(datasets: Mapping[str, Dataset], attributes: Mapping[str, Any]) -> DataTree:
    """Return datasets as a tree of one level.

    Raises
    ------
    RoughbenchError
        Without xarray, or with one that has no trees.
    """
    xarray = _package("xarray")
    if not hasattr(xarray, "DataTree"):
        raise RoughbenchError(
            f"xarray {xarray.__version__} has no DataTree: {COMMAND} --upgrade, or name a "
            "model: to_xarray('bem')"
        )
    made: DataTree = xarray.DataTree.from_dict(
        {"/": xarray.Dataset(attrs=dict(attributes)), **datasets}
    )
    return made


def frame(rows: Iterable[Mapping[str, Any]], units: Mapping[str, str]) -> DataFrame:
    """Return tables below each other as one; ``frame.attrs["units"]`` has the units.

    Parameters
    ----------
    rows : iterable of mapping
        At least one table: its columns, arrays of one length or single values. Columns that
        a table lacks are nan there.
    units : mapping of str to str
        By column.

    Raises
    ------
    RoughbenchError
        Without pandas.
    """
    pandas = _package("pandas")
    tables = [pandas.DataFrame(columns) for columns in rows]
    made: DataFrame = pandas.concat(tables, ignore_index=True)
    made.attrs["units"] = {name: units[name] for name in made.columns if name in units}
    return made


def _package(name: str) -> Any:
    """Import a package that is not always there.

    Raises
    ------
    RoughbenchError
        With the command that adds it.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise RoughbenchError(
            f"this needs {name}, which is not installed: {COMMAND}"
        ) from error


_JOINED = ("pressure", "realization", "field")
"""Dimensions whose coordinates may differ between experiments."""


def _alike(parts: list[Dataset]) -> list[Dataset]:
    for name in dict.fromkeys(name for part in parts for name in part.indexes):
        if name in _JOINED:
            continue
        own = [part[name].to_numpy() for part in parts if name in part.indexes]
        if all(np.array_equal(own[0], other) for other in own[1:]):
            continue
        sizes = sorted({one.size for one in own})
        if len(sizes) > 1:
            raise RoughbenchError(
                f"{name} has {sizes[0]} values in one experiment and {sizes[-1]} in another, "
                "which no common array holds; take results[experiment][label].to_xarray()"
            )
        parts = [
            part.assign(
                {f"{name}_value": (name, part[name].to_numpy(), part[name].attrs)}
            ).drop_vars(name)
            if name in part.indexes
            else part
            for part in parts
        ]
    return parts
