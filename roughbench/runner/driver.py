"""``run``: a spec in, results out, and a results file if one is wanted."""

from __future__ import annotations

import os
from collections.abc import Sequence

from roughbench.errors import RoughbenchError
from roughbench.publish import check_writable
from roughbench.results import ModelResult, Results
from roughbench.runner.assemble import assemble
from roughbench.runner.plan import Cell, Task, check, plan, tasks_of
from roughbench.runner.pool import Advanced, compute_all
from roughbench.runner.progress import Progress, Report
from roughbench.spec import Source, load_spec
from roughbench.store import write_results


def run(
    spec: Source,
    *,
    output: str | os.PathLike[str] | None = None,
    jobs: int = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    progress: Report | None = None,
) -> Results:
    """Compute everything that a spec asks for.

    Parameters
    ----------
    spec : path, str, mapping or Spec
        What to compute; see :func:`roughbench.spec.load_spec`.
    output : path, optional
        Results file to write; replaced in one step at the end, if it exists.
    jobs : int
        Tasks at once; more than 1 starts as many processes.
    threads : int, optional
        Threads of each task; default: cores / jobs. At equal ``threads`` the results
        are the same to the bit for every ``jobs``.
    overrides : sequence of str
        ``key=value`` each, as ``--set`` on the command line.
    progress : callable, optional
        Called with a :class:`~roughbench.runner.Progress` whenever something is done.

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
        If a model refuses its input; no results file is written then.
    StoreError
        If the results file cannot be written.

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
    for name, value in (("jobs", jobs), ("threads", threads)):
        if value is not None and value < 1:
            raise RoughbenchError(f"{name} must be at least 1, got {value}")
    resolved = load_spec(spec, overrides)
    if output is not None:
        check_writable(output)
    cells = plan(resolved)
    check(cells)
    tasks = [task for cell in cells for task in tasks_of(cell)]
    blocks = compute_all(
        tasks,
        jobs=jobs,
        threads=threads or max(1, available_cores() // jobs),
        advanced=_counter(cells, progress),
    )
    experiments: dict[str, dict[str, ModelResult]] = {}
    for cell in cells:
        own = [block for task, block in zip(tasks, blocks, strict=True) if task.cell is cell]
        experiments.setdefault(cell.experiment, {})[cell.model.name] = assemble(cell, own)
    results = Results(experiments, resolved.text, resolved.sha256, resolved.name)
    if output is not None:
        write_results(results, output)
    return results


def _counter(cells: Sequence[Cell], progress: Report | None) -> Advanced:
    """Return a callable that adds up finished states and tells ``progress``."""
    total = sum(cell.n_states for cell in cells)
    all_work = sum(cell.n_realizations * cell.work for cell in cells)
    done, work = 0, 0.0
    done_of: dict[Task, int] = {}
    if progress is not None:
        progress(Progress(done, total, 0.0, "starting"))

    def advanced(task: Task, done_here: int) -> None:
        nonlocal done, work
        n_states = done_here - done_of.get(task, 0)
        done_of[task] = done_here
        done += n_states
        work += n_states * task.cell.work / len(task.cell.pressures)
        share = 1.0 if done == total else work / all_work
        if progress is not None:
            progress(Progress(done, total, share, task.place(done_here)))

    return advanced


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
