"""What is there of a run that is not finished, as results."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import RoughbenchError
from roughbench.planning.cells import NOTHING
from roughbench.results import ModelResult, Results
from roughbench.rundir.collected import Collected
from roughbench.runner.assemble import assemble
from roughbench.runner.inspection import find, requested
from roughbench.runner.recording import records
from roughbench.runner.scan import CellState


def partial_results(path: str | os.PathLike[str]) -> Results:
    """Return what a run has finished so far; it may be running.

    Of each model those realizations that are there at all pressures, without their fields.
    :attr:`~roughbench.results.Results.partial` says how many there are of how many.

    Parameters
    ----------
    path : path
        As for :func:`roughbench.runner.status`.

    Raises
    ------
    RoughbenchError
        If there is no run there, or nothing is finished.
    """
    folder = find(path)
    spec, _, cell_states = requested(folder, folder.request())
    experiments: dict[str, dict[str, ModelResult]] = {}
    partial: dict[str, tuple[int, int]] = {}
    for cell_state in cell_states:
        cell = cell_state.cell
        rows = np.flatnonzero(cell_state.coverage.known.all(axis=1))
        if rows.size < cell.n_realizations:
            partial[str(cell)] = int(rows.size), cell.n_realizations
        if rows.size:
            models = experiments.setdefault(cell.experiment, {})
            models[cell.model.name] = _of_rows(cell_state, rows)
    if not experiments:
        raise RoughbenchError(
            f"{folder.path}: no realization of any model is finished yet; wait for the first"
        )
    measured = records([state.cell for state in cell_states])
    return Results(
        experiments,
        spec.text,
        spec.sha256,
        spec.name,
        {name: one for name, one in measured.items() if name in experiments},
        partial=partial,
    )


def _of_rows(cell_state: CellState, rows: NDArray[np.intp]) -> ModelResult:
    """Return the results of some realizations of a cell."""
    cell = cell_state.cell
    collected = Collected(cell)
    for shard in sorted(cell_state.shards, key=lambda shard: shard.path.name):
        with shard.opened() as variables:
            collected.add(shard.realizations, shard.pressures, variables, shard.kept)
    asked = replace(NOTHING, observables=cell.asked.observables)
    fewer = replace(cell, n_realizations=int(rows.size), asked=asked)
    return assemble(fewer, collected.rows(rows))
