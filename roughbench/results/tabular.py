"""Results as datasets of xarray and tables of pandas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from roughbench import labelled
from roughbench.labelled import NamedArray
from roughbench.results import display
from roughbench.variables import STATES, dimensions

if TYPE_CHECKING:
    from roughbench.labelled import DataFrame, Dataset, DataTree
    from roughbench.results.model_result import ModelResult
    from roughbench.results.results import Results


def model_dataset(result: ModelResult) -> Dataset:
    """Return the variables of a model as a dataset."""
    arrays = {name: _named(result, name, result[name]) for name in result}
    for index, of in (("realization", "status"), ("field", "field_status")):
        if of in result and index not in arrays:
            places = np.arange(len(result[of]), dtype=np.int64)
            arrays[index] = _named(result, index, places)
    said = {"label": result.label, "kind": result.kind, "title": result.title}
    return labelled.dataset(arrays, {**said, **result.attributes})


def swept(results: Results, label: str) -> Dataset:
    """Return a model in all experiments that have it as one dataset."""
    own = {
        name: models[label] for name, models in results.experiments.items() if label in models
    }
    if not own:
        known = dict.fromkeys(result.label for _, result in results.models())
        raise display.unknown_name("model", label, list(known))
    if len(results) == 1:
        return model_dataset(next(iter(own.values())))
    taken = {
        one
        for result in own.values()
        for name in result
        for one in (name, *_axes(result, name))
    }
    choices = sweep_of(list(own), taken)
    return labelled.together(map(model_dataset, own.values()), own, choices)


def results_tree(results: Results) -> DataTree:
    """Return all models as a tree of datasets, one each."""
    labels = dict.fromkeys(result.label for _, result in results.models())
    said = {"name": results.name, "spec": results.spec_text, "spec_sha256": results.spec_sha256}
    return labelled.tree({label: swept(results, label) for label in labels}, said)


def model_frame(result: ModelResult, *, averages: bool) -> DataFrame:
    """Return the curves of a model as a table."""
    return labelled.frame([_columns(result, averages=averages)], _units([result]))


def results_frame(results: Results, *, averages: bool) -> DataFrame:
    """Return the curves of all models below each other."""
    choices = sweep_of(list(results), {name for _, one in results.models() for name in one})
    places = {name: k for k, name in enumerate(results)}
    rows = [
        {
            "experiment": experiment,
            **{key: values[places[experiment]] for key, values in choices.items()},
            "model": result.label,
            **_columns(result, averages=averages),
        }
        for experiment, result in results.models()
    ]
    return labelled.frame(rows, _units([result for _, result in results.models()]))


def sweep_of(experiments: Sequence[str], taken: set[str]) -> dict[str, list[Any]]:
    """Return the swept keys and their value in each experiment, from its name.

    Parameters
    ----------
    experiments : sequence of str
    taken : set of str
        Names that no key may be shortened to.

    Returns
    -------
    dict of str to list
        Numbers where all of a key are numbers, else texts; empty without a sweep.

    Examples
    --------
    >>> sweep_of(["surface.qr=1.0,twins=8", "surface.qr=8.0,twins=8"], set())
    {'qr': [1.0, 8.0], 'twins': [8.0, 8.0]}
    >>> sweep_of(["scan", "twins"], set())
    {}
    """
    named = [
        dict(part.partition("=")[::2] for part in name.split(",") if "=" in part)
        for name in experiments
    ]
    keys = [*dict.fromkeys(key for one in named for key in one)]
    if any([*one] != keys for one in named):
        return {}
    short = [key.rpartition(".")[2] for key in keys]
    found: dict[str, list[Any]] = {}
    for key, word in zip(keys, short, strict=True):
        name = key if short.count(word) > 1 or word in taken or word == "model" else word
        values = [one[key] for one in named]
        found[name] = _numbers(values) or values
    return found


def _numbers(values: Sequence[str]) -> list[float]:
    """Return texts as numbers; none if one of them is no number."""
    try:
        return [float(value) for value in values]
    except ValueError:
        return []


def _axes(result: ModelResult, name: str) -> tuple[str, ...]:
    return dimensions(name, result[name].ndim)


def _named(result: ModelResult, name: str, values: Any) -> NamedArray:
    axes = dimensions(name, values.ndim)
    return NamedArray(axes, values, result.units(name), result.long_name(name))


def _columns(result: ModelResult, *, averages: bool) -> dict[str, Any]:
    """Return what has a value for each pressure, or for each realization and pressure."""
    if averages:
        return {name: result[name] for name in result if _axes(result, name) == ("pressure",)}
    shape = result["status"].shape
    realization, pressure = np.indices(shape)
    columns: dict[str, Any] = {
        "realization": realization.ravel(),
        "pressure": result["pressure"][pressure.ravel()],
    }
    for name in result:
        axes = _axes(result, name)
        if axes == STATES:
            columns[name] = result[name].ravel()
        elif axes == ("realization",):
            columns[name] = result[name][realization.ravel()]
    return columns


def _units(results: Sequence[ModelResult]) -> Mapping[str, str]:
    return {name: result.units(name) for result in results for name in result}
