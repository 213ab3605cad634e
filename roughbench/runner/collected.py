"""The states of a cell as they come in, and those that are still missing."""

from __future__ import annotations

from collections.abc import Collection
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from roughbench.models.base import FloatArray
from roughbench.results import Array
from roughbench.runner.compute import Block
from roughbench.runner.plan import Cell
from roughbench.variables import FIELD_VARIABLES, dimensions


class Collected:
    """All states of a cell: each is missing until a block brings it, with its field if asked.

    Parameters
    ----------
    cell : Cell

    Attributes
    ----------
    known : ndarray of bool, shape (realizations, pressures)
        Which states there are.
    """

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        shape = (cell.n_realizations, len(cell.pressures))
        self.known: NDArray[np.bool_] = np.zeros(shape, np.bool_)
        self._columns = {p: column for column, p in enumerate(cell.pressures)}
        self._values: Block = {}
        self._kept = set(cell.asked.kept)
        self._fields: dict[tuple[int, float], tuple[Array, Array]] = {}

    def add(self, first: int, pressures: FloatArray, block: Block) -> int:
        """Take over what the cell needs of a block; states that are known stay as they are.

        Parameters
        ----------
        first : int
            Realization of the block's first row.
        pressures : ndarray of float64, shape (pressures,)
            p/E* of the block's columns.
        block : dict of str to ndarray

        Returns
        -------
        int
            Number of states that it brought.

        Raises
        ------
        ValueError
            If the block has other variables than those before.
        """
        n_rows = min(len(block["status"]), self.cell.n_realizations - first)
        pairs = [
            (column, self._columns[p])
            for column, p in enumerate(pressures.tolist())
            if p in self._columns
        ]
        if n_rows <= 0 or not pairs:
            return 0
        given = {name: v for name, v in block.items() if name not in FIELD_VARIABLES}
        if self._values and self._values.keys() != given.keys():
            raise ValueError(f"has the variables {sorted(given)}, not {sorted(self._values)}")
        theirs, ours = (np.array(side) for side in zip(*pairs, strict=True))
        rows = np.arange(first, first + n_rows)
        square = np.ix_(rows, ours)
        fresh = ~self.known[square]
        fields = _fields_of(block)
        for realization, pressure in self._kept - fields.keys():
            if realization in rows:
                fresh[realization - first, ours == self._columns[pressure]] = False
        new_rows = fresh.any(axis=1)
        if not new_rows.any():
            return 0
        for name, values in given.items():
            axes = dimensions(name)
            target = self._target(name, values)
            if axes == ("realization",):
                target[rows[new_rows]] = values[:n_rows][new_rows]
            elif axes[0] == "realization":
                chosen = fresh.reshape(*fresh.shape, *(1,) * (values.ndim - 2))
                target[square] = np.where(chosen, values[:n_rows][:, theirs], target[square])
            elif not np.array_equal(values, target):
                raise ValueError(f"has another {name} than the states before")
        for place in self._kept & fields.keys():
            self._fields.setdefault(place, fields[place])
        self.known[square] |= fresh
        return int(np.count_nonzero(fresh))

    def _target(self, name: str, values: Array) -> Array:
        if name not in self._values:
            axes = dimensions(name)
            if axes[0] != "realization":
                self._values[name] = values
            else:
                shape = self.known.shape[: len(axes)] + values.shape[2:]
                self._values[name] = np.zeros(shape, values.dtype)
        return self._values[name]

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

    @property
    def n_unconverged(self) -> int:
        """Number of known states that did not converge."""
        status = self._values.get("status")
        return 0 if status is None else int(np.count_nonzero(status[self.known]))

    def block(self) -> Block:
        """Return all states as one block; every one of them must be known."""
        if not self.complete:
            raise ValueError(f"{self.cell} lacks {np.count_nonzero(~self.known)} states")
        return self._values | self._field_block()

    def _field_block(self) -> Block:
        """Return the fields that are kept, in the order of realizations and pressures."""
        places = sorted(self._kept)
        if not places:
            return {}
        states = [(r, self._columns[p]) for r, p in places]
        columns = {
            "field_realization": np.array([r for r, _ in places], dtype=np.int64),
            "field_nominal_pressure": np.array([p for _, p in places]),
            "field_status": np.array([self._values["status"][state] for state in states]),
            "field_pressure": np.stack([self._fields[place][0] for place in places]),
            "field_gap": np.stack([self._fields[place][1] for place in places]),
        }
        return {name: columns[name] for name in FIELD_VARIABLES}


def _fields_of(block: Block) -> dict[tuple[int, float], tuple[Array, Array]]:
    """Return pressure and gap of the fields in a block, by realization and pressure."""
    if "field_realization" not in block:
        return {}
    return {
        (int(r), float(p)): (pressure, gap)
        for r, p, pressure, gap in zip(
            *(block[name] for name in ("field_realization", "field_nominal_pressure")),
            *(block[name] for name in ("field_pressure", "field_gap")),
            strict=True,
        )
    }
