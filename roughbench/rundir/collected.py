"""Which states of a cell there are, and their values put together."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from roughbench.models.base import FloatArray, IntArray
from roughbench.planning.cells import Cell
from roughbench.planning.tasks import Block
from roughbench.results import Array
from roughbench.variables import FIELD_VARIABLES, dimensions

Place = tuple[int, float]
"""Realization and nominal pressure of a field."""


@dataclass(frozen=True, slots=True)
class Taken:
    """What a cell takes of a block.

    Attributes
    ----------
    rows : ndarray of int, shape (rows,)
        Realizations of the cell, those of the first rows of the block.
    theirs, ours : ndarray of int, shape (columns,)
        Columns of the block, and those of the cell that they belong to.
    fresh : ndarray of bool, shape (rows, columns)
        Which of these states the block brings.
    """

    rows: NDArray[np.intp]
    theirs: NDArray[np.intp]
    ours: NDArray[np.intp]
    fresh: NDArray[np.bool_]


class Coverage:
    """Which states of a cell there are: each is missing until a block brings it.

    A state whose field is asked for comes with its field, or not at all.

    Attributes
    ----------
    known : ndarray of bool, shape (realizations, pressures)
        Which states there are.
    """

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        shape = (cell.n_realizations, len(cell.pressures))
        self.known: NDArray[np.bool_] = np.zeros(shape, np.bool_)
        self._kept = set(cell.asked.realizations)
        self._columns = {p: column for column, p in enumerate(cell.pressures)}
        self._names: set[str] = set()

    def take(
        self,
        realizations: range,
        pressures: FloatArray,
        names: Iterable[str],
        fields: Collection[Place],
    ) -> Taken | None:
        """Take over what the cell needs of a block; None for nothing.

        Parameters
        ----------
        realizations : range
            Of the block's rows.
        pressures : ndarray of float64, shape (pressures,)
            p/E* of the block's columns.
        names : iterable of str
            Of the block's variables.
        fields : collection of Place
            Those that the block has.

        Raises
        ------
        ValueError
            If the block has other variables than those before.
        """
        rows = np.arange(realizations.start, min(realizations.stop, len(self.known)))
        pairs = [
            (column, self._columns[p])
            for column, p in enumerate(pressures.tolist())
            if p in self._columns
        ]
        if not rows.size or not pairs:
            return None
        given = {name for name in names if name not in FIELD_VARIABLES}
        if self._names and self._names != given:
            raise ValueError(of_other_variables(given, self._names))
        theirs, ours = (np.array(side) for side in zip(*pairs, strict=True))
        square = np.ix_(rows, ours)
        fresh = ~self.known[square]
        asked, there = self.cell.asked, set(fields)
        for row, realization in enumerate(rows.tolist()):
            if realization in self._kept:
                for pressure in asked.pressures:
                    if (realization, pressure) not in there:
                        fresh[row, ours == self._columns[pressure]] = False
        if not fresh.any():
            return None
        self._names = given
        self.known[square] |= fresh
        return Taken(rows, theirs, ours, fresh)

    @property
    def complete(self) -> bool:
        """Whether nothing is missing."""
        return bool(self.known.all())

    def missing(
        self, only: Collection[int] | None = None
    ) -> list[tuple[range, tuple[float, ...]]]:
        """Return runs of realizations that lack the same pressures, and these.

        Parameters
        ----------
        only : collection of int, optional
            Realizations to look at; default: all.
        """
        lacks = ~self.known
        if only is not None:
            lacks[[row for row in range(len(lacks)) if row not in only]] = False
        groups = []
        start = 0
        for _, run in groupby(lacks, key=lambda row: row.tobytes()):
            rows = list(run)
            if rows[0].any():
                columns = np.flatnonzero(rows[0])
                pressures = tuple(self.cell.pressures[column] for column in columns)
                groups.append((range(start, start + len(rows)), pressures))
            start += len(rows)
        return groups


class Collected:
    """The values of all states of a cell, block by block.

    Blocks that come in another order, or in other cuts, make the same values: of several
    that have a state the first counts, and they come in the order of the shards' names.
    """

    def __init__(self, cell: Cell) -> None:
        self._coverage = Coverage(cell)
        self._values: Block = {}
        self._fields: Block = {}
        self._places = {place: number for number, place in enumerate(sorted(cell.asked.kept))}
        self._entered: set[Place] = set()

    def add(
        self,
        realizations: range,
        pressures: FloatArray,
        variables: Mapping[str, Array],
        fields: Collection[Place],
    ) -> None:
        """Take over what the cell needs of a block; states that are known stay as they are.

        Parameters
        ----------
        realizations, pressures, fields
            As for :meth:`Coverage.take`; the fields in the order of the block.
        variables : mapping of str to ndarray
            Asked one by one, and each at most once.

        Raises
        ------
        ValueError
            If the block has other variables, or other bins, than those before.
        """
        taken = self._coverage.take(realizations, pressures, variables, fields)
        if taken is None:
            return
        for name in variables:
            if name not in FIELD_VARIABLES:
                self._enter(name, variables[name], taken)
        wanted = [
            (number, self._places[place])
            for number, place in enumerate(fields)
            if place in self._places and place not in self._entered
        ]
        if wanted:
            theirs, ours = (list(side) for side in zip(*wanted, strict=True))
            for name in ("field_pressure", "field_gap"):
                values = variables[name]
                shape = (len(self._places), *values.shape[1:])
                target = self._fields.setdefault(name, np.empty(shape, values.dtype))
                for here, there in zip(ours, theirs, strict=True):
                    target[here] = values[there]
            self._entered.update(place for place in fields if place in self._places)

    def _enter(self, name: str, values: Array, taken: Taken) -> None:
        axes = dimensions(name, values.ndim)
        if axes[0] != "realization":
            if not np.array_equal(values, self._values.setdefault(name, values)):
                raise ValueError(f"has another {name} than the states before")
            return
        rows = taken.rows
        if name not in self._values:
            shape = self._coverage.known.shape[: len(axes)] + values.shape[2:]
            self._values[name] = np.zeros(shape, values.dtype)
        target = self._values[name]
        if axes == ("realization",):
            new = taken.fresh.any(axis=1)
            target[rows[new]] = values[: rows.size][new]
            return
        square = np.ix_(rows, taken.ours)
        chosen = taken.fresh.reshape(*taken.fresh.shape, *(1,) * (values.ndim - 2))
        target[square] = np.where(chosen, values[: rows.size][:, taken.theirs], target[square])

    def block(self) -> Block:
        """Return all states as one block; every one of them must be known."""
        known = self._coverage.known
        if not known.all():
            cell = self._coverage.cell
            raise ValueError(f"{cell} lacks {np.count_nonzero(~known)} states")
        return self._values | self._field_block()

    def rows(self, rows: NDArray[np.intp]) -> Block:
        """Return some realizations, which must be known at all pressures, without fields."""
        if not self._coverage.known[rows].all():
            raise ValueError(f"{self._coverage.cell} lacks states of these realizations")
        return {
            name: values[rows] if dimensions(name, values.ndim)[0] == "realization" else values
            for name, values in self._values.items()
        }

    def _field_block(self) -> Block:
        """Return the fields that are kept, in the order of realizations and pressures."""
        if not self._places:
            return {}
        cell = self._coverage.cell
        status: IntArray = self._values["status"]
        columns = self._fields | {
            "field_realization": np.array([r for r, _ in self._places], dtype=np.int64),
            "field_nominal_pressure": np.array([p for _, p in self._places]),
            "field_status": np.array(
                [status[r, cell.pressures.index(p)] for r, p in self._places]
            ),
        }
        return {name: columns[name] for name in FIELD_VARIABLES}


def of_other_variables(given: Iterable[str], before: Iterable[str]) -> str:
    """Say that realizations differ in what there is of them."""
    more, less = sorted(set(given).difference(before)), sorted(set(before).difference(given))
    parts = [f"has no {', '.join(less)}"] * bool(less) + [f"has {', '.join(more)}"] * bool(more)
    return (
        f"{' and '.join(parts)}, unlike the realizations before; a model gives the same "
        "quantities of all of them, nan where one is unknown"
    )


def places_of(block: Mapping[str, Array]) -> tuple[Place, ...]:
    """Return realization and pressure of the fields in a block."""
    if "field_realization" not in block:
        return ()
    columns = block["field_realization"], block["field_nominal_pressure"]
    return tuple(zip(*(column.tolist() for column in columns), strict=True))
