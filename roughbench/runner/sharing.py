"""``run --share k/n``: a part of a run, by a process that knows nothing of the others.

Shards appear whole or not at all, under names of their own, so that shares need no lock that
keeps others out. Whoever runs the spec without a share then finds what they have computed,
computes what a killed one has left, and writes the results.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from roughbench.engines.worker_pool import refuse_in_a_new_worker
from roughbench.errors import RoughbenchError
from roughbench.planning.plan import warnings
from roughbench.planning.shares import Share, parse_share, realizations_of_share
from roughbench.planning.tasks import Task
from roughbench.publish import make_folder
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import log, logged_to
from roughbench.runner.bar import reported
from roughbench.runner.computing import compute_tasks
from roughbench.runner.monitor import monitored
from roughbench.runner.preparation import prepare
from roughbench.runner.progress import ProgressListener
from roughbench.runner.provenance import request_of
from roughbench.runner.scan import CellState, refresh, scan
from roughbench.spec import Source, Spec


@dataclass(frozen=True, slots=True)
class ShareOutcome:
    """What a share has done, and what is left of the run.

    Attributes
    ----------
    share : str
        Such as ``3/40``.
    tasks : int
        How many it had to compute.
    states, done : int
        How many states the run has in all, and how many of them there are, of all shares.
    """

    share: str
    tasks: int
    states: int
    done: int

    @property
    def left(self) -> int:
        """How many states are missing."""
        return self.states - self.done


def run_share(
    spec: Source,
    output: str | os.PathLike[str],
    share: Share | str,
    *,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    progress: ProgressListener | bool | None = None,
    keep_going: bool = False,
    max_memory: int | str | None = None,
    log_file: str | os.PathLike[str] | None = None,
    command: str = "",
    assembling: str = "",
) -> ShareOutcome:
    """Compute a share of what a spec asks for, as far as it is not there already.

    No results are written: a run of the same spec without a share, at equal ``threads``, does
    that, and computes what is missing. Shares may run at once, on any machines that share the
    folder of the output.

    Parameters
    ----------
    spec, output
        As for :func:`roughbench.run`.
    share : Share or str
        ``"3/40"`` is the third of forty.
    threads : int, optional
        Of each task; default: 1, whatever the machine, so that all shares agree.
    jobs, overrides, progress, keep_going, max_memory, log_file, command
        As for :func:`roughbench.run`.
    assembling : str
        How to run the whole, for messages of others.

    Returns
    -------
    ShareOutcome
        How many tasks it computed, and how many states are left to others.

    Raises
    ------
    LockedError
        If another process computes this share, or everything.
    RoughbenchError
        If ``share`` reads like no share; else as :func:`roughbench.run`.

    Examples
    --------
    >>> import tempfile
    >>> import roughbench as rb
    >>> spec = {
    ...     "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
    ...     "pressures": [1e-3, 1e-2],
    ...     "models": [{"kind": "foundation", "springs": 64, "realizations": 2}],
    ...     "sweep": {"surface.H": [0.5, 0.8]},
    ... }
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = folder + "/shared.h5"
    ...     left = [run_share(spec, path, share).left for share in ("1/2", "2/2")]
    ...     results = rb.run(spec, output=path, threads=1)  # writes what is there
    >>> left, list(results)
    ([4, 0], ['surface.H=0.5', 'surface.H=0.8'])
    """
    refuse_in_a_new_worker()
    share = parse_share(share) if isinstance(share, str) else share
    run = prepare(
        spec,
        output,
        jobs=jobs,
        threads=threads or 1,
        overrides=overrides,
        max_memory=max_memory,
        log_file=log_file,
    )
    folder = run.folder
    if folder is None:
        raise RoughbenchError("shares meet in a run directory, and there is none")
    make_folder(folder.path.parent)
    with folder.shared(share, command or "a Python script"):
        logs = [folder.share_log(share)] + ([Path(log_file)] if log_file is not None else [])
        with (
            logged_to(logs),
            monitored(folder, command) as monitor,
            reported(progress) as report,
        ):
            for text in warnings(run.cells):
                log.warning("%s", text)
            cell_states = scan(run.cells, run.limits, folder)
            for cell_state in cell_states:
                for error in cell_state.damaged:
                    log.warning("%s; computed again where it belongs to this share", error)
            _note_request(folder, run.spec, cell_states, assembling)
            tasks = _missing(cell_states, share, run.limits.parts)
            monitor.open(cell_states, tasks, report, keep_going=keep_going, of_tasks=True)
            compute_tasks(tasks, run.limits, monitor, folder)
            monitor.check_failures()
            refresh(cell_states, folder)
    states = sum(cell_state.cell.n_states for cell_state in cell_states)
    done = sum(cell_state.n_known for cell_state in cell_states)
    return ShareOutcome(str(share), len(tasks), states, done)


def _missing(cell_states: Sequence[CellState], share: Share, parts: int) -> list[Task]:
    """Return what is missing of a share as tasks."""
    wanted = realizations_of_share([cell_state.cell for cell_state in cell_states], share)
    return [
        task
        for cell_state in cell_states
        if cell_state.cell in wanted
        for task in cell_state.tasks(parts, wanted[cell_state.cell])
    ]


def _note_request(
    folder: RunFolder, spec: Spec, cell_states: Sequence[CellState], command: str
) -> None:
    """Note what the run is asked for, unless another share has."""
    request = request_of(spec, cell_states, command)
    known = folder.request()
    if {**known, "command": ""} != {**request, "command": ""}:
        folder.write_request(request)
