"""The work of one task: samples, curves, and their rows of the results."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np
from threadpoolctl import threadpool_limits

from roughbench.engines.blocks import row_of, stacked, stacked_fields
from roughbench.engines.observing import Observer
from roughbench.errors import RoughbenchError, SolverError
from roughbench.models.base import QUANTITIES, Curve, Fields, Sample, State
from roughbench.planning.samples import make_sample, rms_of
from roughbench.planning.tasks import Block, Task
from roughbench.results import Array
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.collected import of_other_variables
from roughbench.signals import signals_held_back
from roughbench.variables import bins_of

_FINISHED, _DIAGNOSTICS = "finished.", "diagnostics."
_OBSERVED, _MODEL = "observed.", "model."
"""Parts of a checkpoint: the finished states, what was observed of them, the snapshot."""


def compute(
    task: Task,
    advanced: Callable[[int], None] | None = None,
    checkpoint: Checkpoint | None = None,
) -> Block:
    """Return the curves of a task's realizations, one row each.

    Parameters
    ----------
    task : Task
    advanced : callable, optional
        Called with the number of states that are done, of the whole task, whenever there
        are more: after each realization, and after each state of a model that yields them
        one by one, or where fields are observed.
    checkpoint : Checkpoint, optional
        Keeps the finished states of a long curve, and continues from those it has; for
        tasks of one realization.

    Returns
    -------
    dict of str to ndarray
        ``area`` and so on have shape (realizations, pressures), ``rms_height`` and
        ``rms_slope`` (realizations,); see :func:`roughbench.variables.dimensions`.

    Raises
    ------
    SolverError
        If the model refuses, or gives other quantities of one realization than of another;
        names the realization.
    """
    if checkpoint is not None and len(task.realizations) > 1:
        raise ValueError("a checkpoint belongs to one realization")
    rows: list[Block] = []
    kept: list[tuple[int, float, Fields]] = []
    with _one_blas_thread():
        for realization in task.realizations:
            before = len(rows) * len(task.pressures)

            def tell(done: int, before: int = before) -> None:
                if advanced is not None:
                    advanced(before + done)

            try:
                row, fields = _compute_row(task, realization, checkpoint, tell)
                if rows and row.keys() != rows[0].keys():
                    raise SolverError(of_other_variables(row, rows[0]))
            except RoughbenchError as error:
                raise SolverError(f"{task.only(realization)}: {error}") from error
            rows.append(row)
            kept += [(realization, task.pressures[k], fields[k]) for k in sorted(fields)]
    return stacked(rows, bins_of(task.cell.asked.observables)) | stacked_fields(kept)


@contextlib.contextmanager
def _one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread: more would change the last bits with the number of cores.

    The libraries are looked for in a callback from C, in which the exception of a signal's
    handler would be lost, and Ctrl-C with it.
    """
    with signals_held_back():
        limits = threadpool_limits(1, "blas")
    try:
        yield
    finally:
        limits.restore_original_limits()


def _compute_row(
    task: Task,
    realization: int,
    checkpoint: Checkpoint | None,
    tell: Callable[[int], None],
) -> tuple[Block, dict[int, Fields]]:
    """Return the variables of one realization, and the fields that are kept of it."""
    cell, pressures = task.cell, task.pressure_array()
    sample = make_sample(cell.surface, cell.model, cell.seed, realization, cell.heights)
    observer = Observer(task, realization, sample)
    if cell.model.is_vectorized and observer.is_idle:
        # Cheap states are worth no word each, unless someone looks at them.
        curve = cell.model.curve(sample, pressures)
        tell(pressures.size)
    else:
        curve, observer = _follow(task, sample, observer, checkpoint, tell)
    row = row_of(curve, pressures)
    row |= observer.finish(row["status"])
    height, slope = rms_of(sample)
    row["rms_height"], row["rms_slope"] = np.array(height), np.array(slope)
    return row, observer.fields


def _follow(
    task: Task,
    sample: Sample,
    observer: Observer,
    checkpoint: Checkpoint | None,
    tell: Callable[[int], None],
) -> tuple[Curve, Observer]:
    """Return the curve of a model that yields its states, and what was observed of them."""
    pressures, finished = task.pressure_array(), list[State]()
    resumed = _resumed(task, sample, checkpoint) if checkpoint is not None else None
    if resumed is not None:
        finished, observer, states = resumed
    else:
        states = task.cell.model.states(sample, pressures, threads=task.threads)
    for state in states:
        if state.fields is not None:
            observer.note(len(finished), state.fields)
        finished.append(replace(state, fields=None, snapshot=None))
        if checkpoint is not None and state.snapshot and len(finished) < pressures.size:
            checkpoint.offer(len(finished), partial(_to_keep, finished, observer, state))
        tell(len(finished))
    return Curve.from_states(finished, pressures), observer


def _resumed(
    task: Task, sample: Sample, checkpoint: Checkpoint
) -> tuple[list[State], Observer, Iterator[State]] | None:
    """Return the states of a checkpoint, what was observed of them, and the states to come.

    None if there is no checkpoint, or it is none of this curve.
    """
    loaded = checkpoint.load()
    if loaded is None:
        return None
    done, arrays = loaded
    try:
        finished = _finished_states(arrays)
        observer = Observer(task, task.realizations[0], sample)
        observer.restore(_part(arrays, _OBSERVED))
        states = task.cell.model.states(
            sample,
            task.pressure_array(),
            threads=task.threads,
            finished=_part(arrays, _MODEL),
        )
        first = next(states)
        pressures = [state.pressure for state in [*finished, first]]
        if len(finished) != done or pressures != list(task.pressures[: done + 1]):
            raise ValueError(f"{done} states of others")
    except RoughbenchError:
        raise
    except Exception:  # noqa: BLE001, RUF100  (whatever arrays of another kind lead to)
        return None
    return finished, observer, chain([first], states)


def _to_keep(finished: list[State], observer: Observer, state: State) -> dict[str, Array]:
    """Return the arrays of a checkpoint after ``state``."""
    curve = Curve.from_states(finished, np.array([state.pressure for state in finished]))
    given = {name: getattr(curve, name) for name in ("pressure", "status", *QUANTITIES)}
    parts = {
        _FINISHED: {name: values for name, values in given.items() if values is not None},
        _DIAGNOSTICS: curve.diagnostics,
        _OBSERVED: observer.snapshot(),
        _MODEL: state.snapshot() if state.snapshot is not None else {},
    }
    return {
        f"{part}{name}": values for part, own in parts.items() for name, values in own.items()
    }


def _finished_states(arrays: Mapping[str, Array]) -> list[State]:
    given = _part(arrays, _FINISHED)
    return list(Curve(**given, diagnostics=_part(arrays, _DIAGNOSTICS)).states())


def _part(arrays: Mapping[str, Array], part: str) -> dict[str, Array]:
    """Return the arrays of a part of a checkpoint."""
    return {name.removeprefix(part): arrays[name] for name in arrays if name.startswith(part)}
