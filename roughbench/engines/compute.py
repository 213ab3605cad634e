"""The work of one task: samples, curves, and their rows of the results."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from roughbench.engines.observing import Observer
from roughbench.errors import RoughbenchError, SolverError
from roughbench.models.base import Curve, Sample, Snapshot, Status, TakeFields
from roughbench.planning.plan import Block, Task
from roughbench.planning.samples import make_sample, rms_of
from roughbench.results import Array
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.variables import AVERAGED, FIELD_VARIABLES, dimensions


def compute(
    task: Task,
    solved: Callable[[int], None] | None = None,
    checkpoint: Checkpoint | None = None,
) -> Block:
    """Return the curves of a task's realizations, one row each.

    Parameters
    ----------
    task : Task
    solved : callable, optional
        Called with the number of states that are done, of the whole task, whenever there
        are more: after each pressure of the exact solver, or where fields are observed,
        else after each realization.
    checkpoint : Checkpoint, optional
        Keeps the finished states of a long curve, and continues from those it has; for
        tasks of one realization.

    Returns
    -------
    dict of str to ndarray
        ``area`` and so on have shape (realizations, pressures), ``rms_height`` and
        ``rms_slope`` (realizations,); see :func:`roughbench.results.dimensions`.

    Raises
    ------
    SolverError
        If the model refuses; names the realization.
    """
    cell = task.cell
    rows: list[Block] = []
    observers: list[Observer] = []
    pressures = task.pressure_array()
    digest = cell.heights.digest if cell.heights is not None else ""
    done = 0

    def one_more(snapshot: Snapshot | None = None, fields: TakeFields | None = None, /) -> None:
        nonlocal done
        observer = observers[-1]
        if fields is not None:
            observer.note(done % pressures.size, fields)
        done += 1
        if checkpoint is not None and snapshot is not None and done < task.n_states:
            checkpoint.offer(done, lambda: {**snapshot(), **observer.snapshot()})
        if solved is not None:
            solved(done)

    def resumed(sample: Sample) -> Curve | None:
        """Go on from the checkpoint; None if there is none, or it is none for this model."""
        nonlocal done
        finished = checkpoint.load() if checkpoint is not None else None
        if finished is None:
            return None
        try:
            done, arrays = finished
            if not 0 < done < task.n_states:
                raise ValueError(f"{done} states of {task.n_states}")
            arrays = observers[-1].restore(arrays)
            return cell.model.resume(
                sample, pressures, arrays, threads=task.threads, solved=one_more
            )
        except RoughbenchError:
            raise
        except Exception:  # (whatever arrays of another kind lead to)
            if done > finished[0]:  # they have led to a state
                raise
            done = 0
            observers[-1] = Observer(task, task.realizations[0], sample)
            if solved is not None:
                solved(0)
            return None

    if checkpoint is not None and len(task.realizations) > 1:
        raise ValueError("a checkpoint belongs to one realization")
    # More threads of BLAS would change the last bits with the number of cores.
    with threadpool_limits(1, "blas"):
        for realization in task.realizations:
            try:
                sample = make_sample(cell.surface, cell.model, cell.seed, realization, digest)
                observers.append(Observer(task, realization, sample))
                curve = resumed(sample)
                if curve is None:
                    # Cheap states are worth no word each, unless someone looks at them.
                    watch = cell.model.iterative or not observers[-1].is_idle
                    curve = cell.model.curve(
                        sample,
                        pressures,
                        threads=task.threads,
                        solved=one_more if watch else None,
                    )
                row = _row(curve, pressures.shape)
                row |= observers[-1].finish(row["status"])
            except RoughbenchError as error:
                raise SolverError(f"{task.only(realization)}: {error}") from error
            height, slope = rms_of(sample)
            row["rms_height"], row["rms_slope"] = np.array(height), np.array(slope)
            rows.append(row)
            if done < len(rows) * pressures.size:
                done = len(rows) * pressures.size
                if solved is not None:
                    solved(done)
    return _stacked(rows) | _fields(task, observers)


def _stacked(rows: list[Block]) -> Block:
    """Return the rows of all realizations in one; the bins are the same for all."""
    block = {}
    for name, values in rows[0].items():
        if dimensions(name)[0] == name:
            block[name] = values
        else:
            block[name] = np.stack([row[name] for row in rows])
    return block


def _fields(task: Task, observers: list[Observer]) -> Block:
    """Return the fields that are kept, in the order of realizations and pressures."""
    found = [
        (realization, task.pressures[k], fields)
        for realization, observer in zip(task.realizations, observers, strict=True)
        for k, fields in sorted(observer.fields.items())
    ]
    if not found:
        return {}
    columns = {
        "field_realization": np.array([r for r, _, _ in found], dtype=np.int64),
        "field_nominal_pressure": np.array([p for _, p, _ in found]),
        "field_pressure": np.stack([fields.pressure for _, _, fields in found]),
        "field_gap": np.stack([fields.gap for _, _, fields in found]),
    }
    return {name: columns[name] for name in FIELD_VARIABLES if name in columns}


def _row(curve: Curve, shape: tuple[int, ...]) -> Block:
    """Return the variables of one curve; what is not finite never passes as converged."""
    row: dict[str, Array] = {
        name: np.asarray(value, dtype=np.float64)
        for name in AVERAGED
        if (value := getattr(curve, name)) is not None
    }
    lost = ~np.isfinite(row["area"]) | ~np.isfinite(row["separation"])
    lost |= np.isnan(row["stiffness"])  # inf is full contact
    converged = curve.status == Status.CONVERGED
    row["status"] = np.where(lost & converged, Status.NOT_FINITE, curve.status).astype(np.int32)
    row |= {name: _storable(values) for name, values in curve.diagnostics.items()}
    for name, values in row.items():
        if values.shape != shape:
            raise ValueError(f"{name} has shape {values.shape}, the pressures {shape}")
    return row


def _storable(values: Array) -> Array:
    """Return a diagnostic in one of the types that the results file knows."""
    values = np.asarray(values)
    if values.dtype.kind == "f":
        return values.astype(np.float64, copy=False)
    return values.astype(np.int64, copy=False)
