"""What a task has computed as a block of arrays, a row for each realization."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from roughbench.errors import SolverError
from roughbench.models.base import QUANTITIES, Curve, Fields, FloatArray, Status
from roughbench.planning.tasks import Block
from roughbench.results import Array
from roughbench.variables import FIELD_VARIABLES


def stacked(rows: list[Block], bins: Collection[str]) -> Block:
    """Return the rows of all realizations in one; the bins are the same for all."""
    block = {}
    for name, values in rows[0].items():
        if name in bins:
            block[name] = values
        else:
            block[name] = np.stack([row[name] for row in rows])
    return block


def stacked_fields(kept: list[tuple[int, float, Fields]]) -> Block:
    """Return the fields that are kept, in the order of realizations and pressures."""
    if not kept:
        return {}
    columns = {
        "field_realization": np.array([r for r, _, _ in kept], dtype=np.int64),
        "field_nominal_pressure": np.array([p for _, p, _ in kept]),
        "field_pressure": np.stack([fields.pressure for _, _, fields in kept]),
        "field_gap": np.stack([fields.gap for _, _, fields in kept]),
    }
    return {name: columns[name] for name in FIELD_VARIABLES if name in columns}


def row_of(curve: Curve, pressures: FloatArray) -> Block:
    """Return the variables of one curve; what is not finite never passes as converged."""
    row: dict[str, Array] = {
        name: np.asarray(value, dtype=np.float64)
        for name in QUANTITIES
        if (value := getattr(curve, name)) is not None
    }
    diagnostics = {name: storable(values) for name, values in curve.diagnostics.items()}
    for name, values in (row | {"status": curve.status} | diagnostics).items():
        if values.shape != pressures.shape:
            raise SolverError(
                f"{name} has shape {values.shape}, the pressures {pressures.shape}"
            )
    if not np.array_equal(curve.pressure, pressures):
        raise SolverError("the curve is not of the pressures that were asked for")
    lost = ~np.isfinite(row["area"])
    if "separation" in row:
        lost = lost | ~np.isfinite(row["separation"])
    if "stiffness" in row:
        lost = lost | np.isnan(row["stiffness"])  # inf is full contact
    converged = curve.status == Status.CONVERGED
    row["status"] = np.where(lost & converged, Status.NOT_FINITE, curve.status).astype(np.int32)
    return row | diagnostics


def storable(values: Array) -> Array:
    """Return a diagnostic in one of the types that the results file knows."""
    values = np.asarray(values)
    if values.dtype.kind == "f":
        return values.astype(np.float64, copy=False)
    return values.astype(np.int64, copy=False)
