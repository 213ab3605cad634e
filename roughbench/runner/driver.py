"""``run``: a spec in, results out; with an output, durable and resumable on the way."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from roughbench.engines.cluster import Cluster
from roughbench.engines.dask_cluster import compute_on_cluster
from roughbench.engines.local import (
    compute_here,
    compute_in_workers,
    refuse_in_a_new_worker,
)
from roughbench.errors import StoreError
from roughbench.outputs import Kind, check_output
from roughbench.planning.cells import Cell
from roughbench.planning.plan import check, plan, warnings
from roughbench.planning.resources import ResourceLimits, check_memory, resource_limits
from roughbench.planning.tasks import Task
from roughbench.publish import make_folder, put, refusals_named
from roughbench.results import MadeWhenAsked, ModelResult, Results
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import LOG, log, logged_to
from roughbench.runner.assemble import assemble
from roughbench.runner.bar import reported
from roughbench.runner.monitor import RunMonitor, monitored
from roughbench.runner.overview import PlanRow, overview
from roughbench.runner.progress import ProgressListener
from roughbench.runner.provenance import inputs_of, provenance, spent
from roughbench.runner.recording import records
from roughbench.runner.scan import CellState, scan
from roughbench.runner.selection import select
from roughbench.runner.speed import Speeds
from roughbench.seal import sha256_of
from roughbench.spec import MeasuredSurface, Source, Spec, load_spec
from roughbench.store import RESULTS, RESULTS_OR_STUMP, load, whose, written_results


def run(
    spec: Source,
    *,
    output: str | os.PathLike[str] | None = None,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    progress: ProgressListener | bool | None = None,
    force: bool = False,
    keep_going: bool = False,
    only: Sequence[str] = (),
    max_memory: int | str | None = None,
    log_file: str | os.PathLike[str] | None = None,
    cluster: Cluster | None = None,
    command: str = "",
) -> Results:
    """Compute everything that a spec asks for, and is not there already.

    Parameters
    ----------
    spec : path, str, mapping or Spec
        What to compute; see :func:`roughbench.spec.load_spec`.
    output : path, optional
        Results file to write; a results file that is there is replaced in one step at the
        end, and no other file ever is. Finished tasks are kept in its run directory,
        ``OUTPUT.rbrun``, from which a later run with the same output resumes. The folder is
        made if missing.
    jobs : int, optional
        Tasks at once; more than 1 starts as many processes. None: as many as cores and
        memory allow.
    threads : int, optional
        Threads of each task; default: cores / jobs. At equal ``threads`` the results
        are the same to the bit for every ``jobs``.
    overrides : sequence of str
        ``key=value`` each, as ``--set`` on the command line.
    progress : callable or bool, optional
        Called with a :class:`~roughbench.runner.Progress` whenever something is done; True: a
        line of text on standard error, in a notebook as well.
    force : bool
        Compute everything again, and replace the results of another spec.
    keep_going : bool
        After a task that fails, finish all others first.
    only : sequence of str
        Compute only these, as ``main/bem`` or ``main/bem:4`` (the fourth realization).
    max_memory : int or str, optional
        Bytes that all tasks together may take by estimate, or as ``12G``; default: 80 % of
        what is available.
    log_file : path, optional
        A second log, beside the one in the run directory.
    cluster : Cluster, optional
        Compute there; then ``jobs`` and ``max_memory`` mean nothing, and ``threads`` is 1 by
        default.
    command : str
        How to repeat this run, for messages.

    Returns
    -------
    Results
        What :func:`roughbench.load` returns for the results file.

    Raises
    ------
    SpecError
        With all faults of the spec.
    SurfaceError
        If a model cannot use the surface.
    SolverError
        If a model refuses its input; the results file stays as it was.
    IncompleteError
        If the disk refuses a finished task or the results file, or ``only`` leaves something
        out.
    LockedError
        If another run works for the same output.
    StoreError
        If the output is a file that roughbench did not write or that the run reads, or the
        results of another spec (without ``force``); or the run directory cannot be made.

    Examples
    --------
    >>> results = run({
    ...     "surface": {"H": 0.7, "q0": 1.0, "q1": 128.0, "slope": 0.1},
    ...     "pressures": [1e-3, 1e-2],
    ...     "models": [{"kind": "persson"}],
    ... })
    >>> [round(a, 5) for a in results["main"]["persson"]["area_mean"].tolist()]
    [0.01596, 0.15852]
    """
    return _run(
        spec,
        output=output,
        jobs=jobs,
        threads=threads,
        overrides=overrides,
        progress=progress,
        force=force,
        keep_going=keep_going,
        only=only,
        max_memory=max_memory,
        log_file=log_file,
        cluster=cluster,
        command=command,
    )


def run_to_file(spec: Source, output: str | os.PathLike[str], **options: Any) -> Path:
    """Compute what a spec asks for and leave it in the results file, as :func:`run`.

    Needs the memory of one model's results at a time; :func:`run` returns all of them.

    Parameters
    ----------
    spec, output
        As for :func:`run`.
    **options
        Its other arguments.

    Returns
    -------
    Path
        ``output``.

    Raises
    ------
    RoughbenchError
        As :func:`run`.
    """
    _run(spec, output=output, returned=False, **options)
    return Path(output)


def _run(
    spec: Source,
    *,
    output: str | os.PathLike[str] | None,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    progress: ProgressListener | bool | None = None,
    force: bool = False,
    keep_going: bool = False,
    only: Sequence[str] = (),
    max_memory: int | str | None = None,
    log_file: str | os.PathLike[str] | None = None,
    cluster: Cluster | None = None,
    command: str = "",
    returned: bool = True,
) -> Results:
    """Run; unless the results are ``returned``, no more of them than they have in common."""
    refuse_in_a_new_worker()
    resolved = load_spec(spec, overrides)
    limits = _limits(jobs, threads, max_memory, cluster)
    cells = plan(resolved)
    _check_files(cells, output, log_file)
    check(cells)
    folder = RunFolder(output) if output is not None else None
    logs = [Path(log_file)] if log_file is not None else []
    if folder is not None:
        changed = _check_former(folder, resolved, force=force)
        make_folder(folder.path.parent)
    with folder.locked(command or "a Python script") if folder else contextlib.nullcontext():
        if folder is not None:
            logs.append(folder.log)
        with (
            logged_to(logs),
            monitored(folder, command) as monitor,
            reported(progress) as report,
        ):
            if folder is not None and changed:
                log.warning("%s", changed)
            for text in warnings(cells):
                log.warning("%s", text)
            cell_states = _scan(cells, limits, folder, force=force)
            if folder is not None:
                folder.write_request(_request(resolved, cell_states, command))
            tasks = select(cell_states, only, parts=limits.parts)
            monitor.open(cell_states, tasks, report, keep_going=keep_going)
            _compute(tasks, limits, cluster, monitor, folder)
            monitor.finish()
            if folder is not None:
                _publish(folder, resolved, cell_states, command)
                if not returned:
                    return Results({}, resolved.text, resolved.sha256, resolved.name)
                return load(folder.results)  # before another run may replace it
            return _results(resolved, cell_states)


def preview(
    spec: Source,
    *,
    output: str | os.PathLike[str] | None = None,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    force: bool = False,
    only: Sequence[str] = (),
    max_memory: int | str | None = None,
    cluster: Cluster | None = None,
    measuring: Callable[[str], None] | None = None,
) -> list[PlanRow]:
    """Return what :func:`run` would compute, and why, without computing or writing any of it.

    Parameters
    ----------
    spec, output, jobs, threads, overrides, force, only, max_memory, cluster
        As for :func:`run`.
    measuring : callable, optional
        Measure how fast this machine is for models that were never measured, in some
        seconds, and keep it in the cache folder; message so. Default: by a formula.

    Raises
    ------
    SpecError, SurfaceError, RoughbenchError
        As :func:`run`.
    """
    limits = _limits(jobs, threads, max_memory, cluster)
    resolved = load_spec(spec, overrides)
    cells = plan(resolved)
    _check_files(cells, output, None)
    check(cells)
    folder = RunFolder(output) if output is not None else None
    if folder is not None:
        _check_former(folder, resolved, force=force)
    cell_states = scan(cells, limits, folder, force=force)
    tasks = select(cell_states, only, parts=limits.parts)
    if cluster is None:
        check_memory(tasks, limits)
    speeds = Speeds()
    if measuring is not None:
        speeds.measure([task.cell.model for task in tasks], measuring)
    return overview(cell_states, tasks, folder, speeds)


def _limits(
    jobs: int | None, threads: int | None, max_memory: int | str | None, cluster: Cluster | None
) -> ResourceLimits:
    if cluster is not None:  # the cores of this machine mean nothing there
        return resource_limits(None, threads or 1, max_memory)
    return resource_limits(jobs, threads, max_memory)


def _check_files(
    cells: Sequence[Cell],
    output: str | os.PathLike[str] | None,
    log_file: str | os.PathLike[str] | None,
) -> None:
    """Refuse outputs that would replace what they must not, or cannot be written."""
    heights = {c.surface.file for c in cells if isinstance(c.surface, MeasuredSurface)}
    if output is not None:
        check_output(output, _kind(RunFolder(output)), heights)
    if log_file is not None:
        check_output(log_file, LOG, heights if output is None else {*heights, output})


def _kind(folder: RunFolder) -> Kind:
    """Results that were written here are known by less, should they be damaged."""
    return RESULTS_OR_STUMP if folder.provenance() else RESULTS


def _check_former(folder: RunFolder, spec: Spec, *, force: bool) -> str:
    """Refuse to replace the results of another spec, or return what is to be said of it.

    Results of the same name are those of the same spec before it was changed; there it is
    enough to say so.
    """
    found = whose(folder.results)
    if found is None or found[1] == spec.sha256 or force:
        return ""
    name = found[0]
    if name == spec.name:
        return (
            f"{folder.results} has the results of {name} before its spec was changed; they "
            "are replaced when all is computed (-o with another name keeps them)"
        )
    raise StoreError(
        f"{folder.results} has the results of another spec, {name}; choose another file with "
        "-o, move it away, or replace it with --force"
    )


def _scan(
    cells: Sequence[Cell], limits: ResourceLimits, folder: RunFolder | None, *, force: bool
) -> list[CellState]:
    cell_states = scan(cells, limits, folder, force=force)
    if folder is not None:
        for cell_state in cell_states:
            for error in cell_state.damaged:
                log.warning("%s; set aside, to be computed again", error)
                folder.set_aside(error.path)
            if force:
                folder.forget(cell_state.key)
            folder.drop_checkpoints(cell_state.key, cell_state.shards)
    return cell_states


def _compute(
    tasks: Sequence[Task],
    limits: ResourceLimits,
    cluster: Cluster | None,
    monitor: RunMonitor,
    folder: RunFolder | None,
) -> None:
    if cluster is not None:
        log.info("%d tasks to compute, on a %s cluster", len(tasks), cluster.kind)
        compute_on_cluster(
            tasks,
            cluster,
            checkpoint_of=monitor.checkpoint,
            listener=monitor,
            folder=folder.path if folder is not None else Path.cwd(),
        )
        return
    check_memory(tasks, limits)
    processes = limits.processes(tasks)
    log.info("%d tasks to compute, in %d processes", len(tasks), processes)
    if processes == 1:
        compute_here(tasks, checkpoint_of=monitor.checkpoint, listener=monitor)
        return
    compute_in_workers(
        tasks,
        processes=processes,
        limits=limits,
        checkpoint_of=monitor.checkpoint,
        listener=monitor,
    )


def _results(spec: Spec, cell_states: Sequence[CellState], *, kept: bool = True) -> Results:
    """Return the results; those of each model are made when asked for, unless ``kept``."""
    experiments: dict[str, dict[str, Callable[[], ModelResult]]] = {}
    for cell_state in cell_states:
        models = experiments.setdefault(cell_state.cell.experiment, {})
        models[cell_state.cell.model.name] = functools.partial(_result, cell_state)
    made = {name: MadeWhenAsked(models) for name, models in experiments.items()}
    return Results(
        {name: dict(models) for name, models in made.items()} if kept else made,
        spec.text,
        spec.sha256,
        spec.name,
        records([cell_state.cell for cell_state in cell_states]),
    )


def _result(cell_state: CellState) -> ModelResult:
    result = assemble(cell_state.cell, cell_state.collect())
    cell_state.blocks.clear()  # they are in the result now
    total = spent(cell_state.usages)
    log.debug(
        "%s: %d tasks, %.1f s, peak memory %.2f GB, %d of %d states not converged",
        cell_state.cell,
        total["tasks"],
        total["seconds"],
        total["peak_memory"] / 1e9,
        cell_state.n_unconverged,
        cell_state.cell.n_states,
    )
    return result


def _publish(
    folder: RunFolder, spec: Spec, cell_states: Sequence[CellState], command: str
) -> None:
    """Write the results file, unless it is what these shards have made before."""
    inputs = inputs_of(spec, cell_states)
    if folder.provenance().get("inputs_sha256") == inputs and folder.has_its_results():
        log.info("%s is up to date", folder.results)
        return
    results = _results(spec, cell_states, kept=False)
    target = check_output(folder.results, _kind(folder))
    with refusals_named(folder.results), written_results(results, target) as temporary:
        sha256 = sha256_of(temporary)
        same = target.is_file() and sha256_of(target) == sha256
        folder.write_provenance(provenance(sha256, inputs, spec, cell_states, command))
        if not same:
            check_output(target, _kind(folder))  # again: it took a while
            put(temporary, target)
    log.info("%s is up to date" if same else "wrote %s", folder.results)


def _request(spec: Spec, cell_states: Sequence[CellState], command: str) -> dict[str, object]:
    return {
        "spec": spec.text,
        "name": spec.name,
        "folder": str(spec.folder.absolute()),
        "spec_sha256": spec.sha256,
        "command": command,
        "threads": {str(cell_state.cell): cell_state.threads for cell_state in cell_states},
        "keys": sorted({cell_state.key for cell_state in cell_states}),
    }
