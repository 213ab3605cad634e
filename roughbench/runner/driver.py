"""``run``: a spec in, results out; with an output, durable and resumable on the way."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughbench.engines.cluster import Cluster
from roughbench.engines.worker_pool import refuse_in_a_new_worker
from roughbench.planning.cells import Cell
from roughbench.planning.plan import warnings
from roughbench.publish import make_folder
from roughbench.results import Results
from roughbench.rundir.journal import log, logged_to
from roughbench.runner.bar import reported
from roughbench.runner.computing import compute_tasks
from roughbench.runner.monitor import monitored
from roughbench.runner.preparation import prepare
from roughbench.runner.progress import ProgressListener
from roughbench.runner.provenance import request_of
from roughbench.runner.publication import publish, results_of
from roughbench.runner.scan import scan_cleared
from roughbench.runner.selection import select
from roughbench.spec import Source
from roughbench.store import load

Narrowing = Callable[[list[Cell]], list[Cell]]
"""From all that a spec asks for to what is computed and written of it."""


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
        output,
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
        Its other arguments; and ``narrowed``, a callable that returns those of the cells that
        are to be computed, for results with no more in them.

    Returns
    -------
    Path
        ``output``.

    Raises
    ------
    RoughbenchError
        As :func:`run`.
    """
    _run(spec, output, returned=False, **options)
    return Path(output)


def _run(
    spec: Source,
    output: str | os.PathLike[str] | None,
    *,
    progress: ProgressListener | bool | None = None,
    keep_going: bool = False,
    only: Sequence[str] = (),
    log_file: str | os.PathLike[str] | None = None,
    force: bool = False,
    cluster: Cluster | None = None,
    command: str = "",
    returned: bool = True,
    narrowed: Narrowing | None = None,
    **options: Any,
) -> Results:
    """Run; unless the results are ``returned``, no more of them than they have in common."""
    refuse_in_a_new_worker()
    run = prepare(spec, output, force=force, cluster=cluster, log_file=log_file, **options)
    if narrowed is not None:
        run = replace(run, cells=narrowed(run.cells))
    folder = run.folder
    logs = [Path(log_file)] if log_file is not None else []
    if folder is not None:
        make_folder(folder.path.parent)
    with folder.locked(command or "a Python script") if folder else contextlib.nullcontext():
        if folder is not None:
            logs.append(folder.log)
        with (
            logged_to(logs),
            monitored(folder, command) as monitor,
            reported(progress) as report,
        ):
            for text in filter(None, [run.notice, *warnings(run.cells)]):
                log.warning("%s", text)
            cell_states = scan_cleared(run.cells, run.limits, folder, force=force)
            if folder is not None:
                folder.write_request(request_of(run.spec, cell_states, command))
            tasks = select(cell_states, only, parts=run.limits.parts)
            monitor.open(cell_states, tasks, report, keep_going=keep_going)
            compute_tasks(tasks, run.limits, monitor, folder, cluster)
            monitor.finish()
            if folder is None:
                return results_of(run.spec, cell_states)
            publish(folder, run.spec, cell_states, command)
            if not returned:
                return Results({}, run.spec.text, run.spec.sha256, run.spec.name)
            return load(folder.results)  # before another run may replace it
