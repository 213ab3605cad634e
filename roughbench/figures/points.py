"""Points over the curves: an experiment's, or another code's, from a CSV file.

The first line names the columns: ``pressure`` and at least one quantity, ``area``,
``separation`` or ``stiffness``, each with its unit in brackets behind it if it has one, and
``area_error`` and so on; ``label`` names the points in the legend, ``experiment`` the
experiment that they belong to where the results have several. Lines that begin with # are
remarks.

    pressure (MPa),area (%),area_error (%)
    0.1,1.2,0.2
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from roughbench.errors import StoreError, UnitError, explained
from roughbench.models.style import Style
from roughbench.quantities import PRESSURE, Quantity, compared
from roughbench.results import MODULUS, ModelResult, Results
from roughbench.text import on_one_line, suggestion
from roughbench.units import factor_to_si

POINTS = "points"
"""Kind of what is drawn like a model and is none."""
MARKERS = "oD^v<>p*h"
_LARGEST = 1 << 24
_TAKEN_OVER = ("rms_height", "rms_slope", "length", "surface", "hurst", "q_min", MODULUS)
"""Attributes of the experiment that figures ask every model for."""
_HEADING = re.compile(r"\s*([^()\[\]]+?)\s*(?:[(\[]\s*([^()\[\]]*?)\s*[)\]])?\s*")


@dataclass(frozen=True, slots=True)
class _Column:
    """A column of numbers."""

    name: str
    unit: str
    place: int
    quantity: Quantity


def overlaid(results: Results, path: str | Path) -> Results:
    """Return results with the points of a CSV file beside the models.

    Parameters
    ----------
    results : Results
    path : str or path

    Raises
    ------
    StoreError
        With line, column and remedy: if the file cannot be read, a column or an experiment is
        unknown, a unit does not suit, a number is none, or is negative.
    """
    name = on_one_line(str(path))
    rows = _rows(Path(path), name)
    line, headings = next(rows, (0, []))
    columns, words = _columns(headings, results, f"{name}:{line}")
    groups: dict[tuple[str, str], list[dict[str, float]]] = {}
    for number, cells in rows:
        where = f"{name}:{number}"
        if len(cells) != len(headings):
            raise StoreError(
                f"{where}: {len(cells)} cells under {len(headings)} names; leave a cell empty "
                "where there is no value"
            )
        experiment = _experiment(results, words, cells, where)
        label = cells[words["label"]] if "label" in words else ""
        reference = next(iter(results.experiments[experiment].values()))
        row = _row(columns, cells, reference, where)
        groups.setdefault((experiment, label or Path(path).stem), []).append(row)
    if not groups:
        raise StoreError(f"{name}: no points; write a line of numbers under the names")
    experiments = {one: dict(models) for one, models in results.experiments.items()}
    for (experiment, label), found in groups.items():
        models = experiments[experiment]
        key = f"{POINTS}: {on_one_line(label)}"
        if key in models:
            raise StoreError(f"{name}: points called {label!r} are drawn already; rename one")
        models[key] = _points(found, key, label, next(iter(models.values())))
    return replace(results, experiments=experiments)


def quantities_of(results: Results) -> set[str]:
    """Return the quantities that the points in results have values of."""
    return {
        name
        for _, result in results.models()
        if result.kind == POINTS
        for name in compared()
        if name in result
    }


def _rows(path: Path, name: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells of the lines that are no remarks."""
    try:
        if not path.is_file():
            raise StoreError(f"{name}: no such file; give a CSV file of points")
        if path.stat().st_size > _LARGEST:
            raise StoreError(f"{name}: is larger than 16 MB, which are no points for a figure")
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise StoreError(f"{name}: no text in UTF-8; save the table as CSV") from error
    except OSError as error:
        raise StoreError(f"{name}: cannot be read: {explained(error)}") from error
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip() and not line.lstrip().startswith("#"):
            try:
                yield number, [cell.strip() for cell in next(csv.reader([line], strict=True))]
            except csv.Error as error:
                raise StoreError(f"{name}:{number}: no line of a CSV file: {error}") from error


def _columns(
    headings: Sequence[str], results: Results, where: str
) -> tuple[list[_Column], dict[str, int]]:
    """Return the columns of numbers, and the places of those of words."""
    known = compared()
    named: dict[str, Quantity] = {"pressure": PRESSURE, **known}
    named |= {f"{name}_error": quantity for name, quantity in known.items()}
    columns: list[_Column] = []
    words: dict[str, int] = {}
    for place, heading in enumerate(headings):
        found = _HEADING.fullmatch(heading)
        name, unit = (found[1], found[2] or "") if found else (heading, "")
        if name in words or any(name == column.name for column in columns):
            raise StoreError(f"{where}: two columns are named {name!r}; remove one")
        if name in ("label", "experiment") and not unit:
            words[name] = place
        elif name in named:
            columns.append(_Column(name, unit, place, named[name]))
        else:
            near = suggestion(name, [*named, "label", "experiment"])
            hint = f" (did you mean {near!r}?)" if near else ""
            raise StoreError(
                f"{where}: unknown column {on_one_line(name)!r}{hint}; columns are "
                f"{', '.join([*named, 'label', 'experiment'])}, each with its unit in brackets"
            )
    there = {column.name for column in columns}
    if "pressure" not in there or not there & set(known):
        raise StoreError(
            f"{where}: the first line must name the columns, pressure and one of "
            f"{', '.join(known)}, divided by commas"
        )
    for name in known:
        if f"{name}_error" in there and name not in there:
            raise StoreError(f"{where}: {name}_error is the error of no column {name}")
    if len(results) > 1 and "experiment" not in words:
        raise StoreError(
            f"{where}: the results have several experiments; add a column experiment that "
            f"names one of them in each line: {', '.join(results)}"
        )
    for column in columns:  # before any number is read
        for models in results.experiments.values():
            _factor(column, next(iter(models.values())), where)
    return columns, words


def _experiment(
    results: Results, words: Mapping[str, int], cells: Sequence[str], where: str
) -> str:
    if "experiment" not in words:
        return next(iter(results))
    name = cells[words["experiment"]]
    if name not in results.experiments:
        raise StoreError(
            f"{where}: experiment: {on_one_line(name)!r} is none of the results: "
            f"{', '.join(results)}"
        )
    return name


def _row(
    columns: Sequence[_Column], cells: Sequence[str], reference: ModelResult, where: str
) -> dict[str, float]:
    row: dict[str, float] = {}
    for column in columns:
        text = cells[column.place]
        if not text and column.name != "pressure":
            row[column.name] = math.nan
            continue
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        is_error = column.name.endswith("_error")
        if not 0.0 < value < math.inf and not (is_error and value == 0.0):
            remedy = "" if is_error else ": the axes are logarithmic; leave the line out"
            raise StoreError(
                f"{where}: {column.name}: must be a positive number, got "
                f"{on_one_line(text)!r}{remedy}"
            )
        row[column.name] = value * _factor(column, reference, where)
    return row


def _factor(column: _Column, reference: ModelResult, where: str) -> float:
    """Return what makes numbers of a column those of the results.

    Raises
    ------
    StoreError
        If the unit does not suit, with those that do.
    """
    quantity, unit = column.quantity, column.unit.replace("·", " ").replace("E∗", "E*")
    own = "pressure" if quantity is PRESSURE else quantity.name
    si = quantity.si_units()
    scaled = _scaled_unit(quantity)
    if scaled != "1" and unit == scaled:
        height = float(reference.attributes["rms_height"])
        return quantity.unit(height) * (reference.modulus or 1.0) ** quantity.modulus
    if si == "1":
        if unit in ("", "1", "%"):
            return 0.01 if unit == "%" else 1.0
        raise StoreError(f"{where}: {column.name}: has no unit but %, got {unit!r}")
    if not reference.has_units:
        if unit in ("", "1" if own == "pressure" else reference.units(own)):
            return 1.0
        raise StoreError(
            f"{where}: {column.name}: the results have no units, so that the column must be in "
            f"{scaled}, or as the results file has it; got {unit!r}"
        )
    if not unit:
        raise StoreError(
            f"{where}: {column.name}: the results have units; write that of the column in "
            f"brackets, as in '{column.name} ({si})'"
        )
    try:
        return factor_to_si(unit, si)
    except UnitError as error:
        raise StoreError(
            f"{where}: {column.name}: {error.reason}; write one such as {si}, or {scaled}"
        ) from error


def _scaled_unit(quantity: Quantity) -> str:
    """Return the unit of a value without dimension: E*, h_rms, E*/h_rms.

    Examples
    --------
    >>> from roughbench.quantities import QUANTITIES
    >>> [_scaled_unit(QUANTITIES[name]) for name in ("area", "separation", "stiffness")]
    ['1', 'h_rms', 'E*/h_rms']
    """
    above = ["E*"] * quantity.modulus + ["h_rms"] * quantity.length
    below = "/h_rms" * -quantity.length
    return (" ".join(above) or "1") + below


def _points(
    rows: Sequence[Mapping[str, float]], key: str, label: str, reference: ModelResult
) -> ModelResult:
    """Return points as what figures draw: a model with one realization."""
    rows = sorted(rows, key=lambda row: row["pressure"])
    variables = {"pressure": np.array([row["pressure"] for row in rows])}
    variables["status"] = np.zeros((1, len(rows)), np.int32)
    for name in compared():
        if name not in rows[0]:
            continue
        values = np.array([row[name] for row in rows])
        errors = np.array([row.get(f"{name}_error", math.nan) for row in rows])
        variables[name] = values[None, :]
        statistics = {"mean": values, "sem": errors, "median": values}
        statistics |= {"q16": values, "q84": values}
        variables |= {f"{name}_{kind}": array for kind, array in statistics.items()}
    attributes = {
        name: reference.attributes[name] for name in _TAKEN_OVER if name in reference.attributes
    }
    attributes["style"] = Style(markers=MARKERS, order=6).as_text()
    title = on_one_line(label).replace("$", r"\$")
    return ModelResult(key, POINTS, title, attributes, variables)
