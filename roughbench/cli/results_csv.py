"""Results as CSV, for spreadsheets."""

from __future__ import annotations

import csv
import io
import re

import numpy as np

from roughbench.observables import OBSERVABLES
from roughbench.observables.described import described
from roughbench.outputs import Kind
from roughbench.results import Array, ModelResult
from roughbench.variables import STATES, dimensions

TABLE = Kind("table", lambda head, _: re.match(rb"(\w+ \[[^]\n]*\],?)+\n", head) is not None)
"""CSV: recognized by its first line, which has nothing but names with units."""


def summary_csv(result: ModelResult) -> str:
    """Return the averaged curves of one model as CSV, one row a pressure.

    The header names each variable with its unit in brackets: "1" is none, "length" the
    spec's length unit. Of a spec with units it is that of SI, without prefix.
    """
    names = [name for name in result if dimensions(name, result[name].ndim) == ("pressure",)]
    return _csv(result, {name: result[name] for name in names})


def states_csv(result: ModelResult) -> str:
    """Return every state of one model as CSV, one row a realization and pressure."""
    n_realizations, n_pressures = result["status"].shape
    columns = {
        "realization": np.repeat(np.arange(n_realizations), n_pressures),
        "pressure": np.tile(result["pressure"], n_realizations),
    }
    of_states = [name for name in result if dimensions(name, result[name].ndim) == STATES]
    columns |= {name: result[name].ravel() for name in of_states}
    return _csv(result, columns)


def observables_csv(result: ModelResult) -> dict[str, str]:
    """Return the averages of each observable of one model as CSV, by its variable.

    One row a pressure and bin: the place of the value, its mean, standard error, and
    Persson's theory where it says something.
    """
    texts = {}
    known = [one.variable for one in OBSERVABLES.values()]
    own = [one.variable for one in described(result.attributes)]
    for name in dict.fromkeys([*known, *own]):
        if name in result:
            places = result[f"{name}_bin"]
            columns = {
                "pressure": np.repeat(result["pressure"], places.size),
                f"{name}_bin": np.tile(places, result["pressure"].size),
            }
            for kind in ("mean", "sem", "persson"):
                if f"{name}_{kind}" in result:
                    columns[f"{name}_{kind}"] = result[f"{name}_{kind}"].ravel()
            texts[name] = _csv(result, columns)
    return texts


def _csv(result: ModelResult, columns: dict[str, Array]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(f"{name} [{result.units(name)}]" for name in columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return text.getvalue()
