"""What is settled before anything is computed: the spec, its cells, limits, the outputs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from roughbench.engines.cluster import Cluster
from roughbench.errors import StoreError
from roughbench.outputs import Kind, check_output
from roughbench.planning.cells import Cell
from roughbench.planning.plan import check, plan
from roughbench.planning.resources import ResourceLimits, resource_limits
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import LOG
from roughbench.spec import MeasuredSurface, Source, Spec, load_spec
from roughbench.store import RESULTS, RESULTS_OR_STUMP, whose


@dataclass(frozen=True, slots=True)
class PreparedRun:
    """A run of which nothing is computed yet.

    Attributes
    ----------
    spec : Spec
    cells : list of Cell
        All that it asks for.
    limits : ResourceLimits
    folder : RunFolder or None
        None where nothing is to be written.
    notice : str
        What is to be said of results that are there; else empty.
    """

    spec: Spec
    cells: list[Cell]
    limits: ResourceLimits
    folder: RunFolder | None
    notice: str


def prepare(
    spec: Source,
    output: str | os.PathLike[str] | None,
    *,
    jobs: int | None = 1,
    threads: int | None = None,
    overrides: Sequence[str] = (),
    force: bool = False,
    max_memory: int | str | None = None,
    cluster: Cluster | None = None,
    log_file: str | os.PathLike[str] | None = None,
) -> PreparedRun:
    """Read and check all that a run needs; the arguments are those of :func:`run`.

    Raises
    ------
    RoughbenchError
        As :func:`run`, before anything is written.
    """
    resolved = load_spec(spec, overrides)
    if cluster is not None:  # the cores of this machine mean nothing there
        jobs, threads = None, threads or 1
    limits = resource_limits(jobs, threads, max_memory)
    cells = plan(resolved)
    _check_files(cells, output, log_file)
    check(cells)
    folder = RunFolder(output) if output is not None else None
    notice = _check_former(folder, resolved, force=force) if folder is not None else ""
    return PreparedRun(resolved, cells, limits, folder, notice)


def kind_of_results(folder: RunFolder) -> Kind:
    """Return what a results file may replace; what was written here is known by less."""
    return RESULTS_OR_STUMP if folder.provenance() else RESULTS


def _check_files(
    cells: Sequence[Cell],
    output: str | os.PathLike[str] | None,
    log_file: str | os.PathLike[str] | None,
) -> None:
    """Refuse outputs that would replace what they must not, or cannot be written."""
    heights = {c.surface.file for c in cells if isinstance(c.surface, MeasuredSurface)}
    if output is not None:
        check_output(output, kind_of_results(RunFolder(output)), heights)
    if log_file is not None:
        check_output(log_file, LOG, heights if output is None else {*heights, output})


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
