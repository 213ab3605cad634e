"""``submit``: a run as jobs of a batch system, which compute its shares."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from roughbench.engines.profiles import JobProfile
from roughbench.engines.sbatch import ShareJobs, submit
from roughbench.planning.resources import assembly_memory, memory_of
from roughbench.planning.tasks import Task
from roughbench.publish import commit, make_folder
from roughbench.rundir.folder import RunFolder
from roughbench.runner.preparation import prepare
from roughbench.spec import Source, Spec, load_spec

_MARGIN = 2**30
"""Bytes beyond the estimate: a job that takes more than it asked for is killed."""


@dataclass(frozen=True, slots=True)
class Submission:
    """Jobs that were submitted.

    Attributes
    ----------
    results : Path
        That they will write.
    array, assembling : Path
        Their scripts.
    jobs : tuple of str
        The numbers that Slurm gave the array, and the job behind it.
    """

    results: Path
    array: Path
    assembling: Path
    jobs: tuple[str, str]


def share_jobs(
    spec: Source,
    output: str | os.PathLike[str],
    shares: int,
    profile: JobProfile,
    *,
    overrides: Sequence[str] = (),
    force: bool = False,
) -> tuple[ShareJobs, str]:
    """Return the jobs that compute a spec, and the spec that they read; nothing is written.

    Parameters
    ----------
    spec, output, overrides, force
        As for :func:`roughbench.run`.
    shares : int
        How many jobs.
    profile : JobProfile

    Raises
    ------
    RoughbenchError
        As :func:`roughbench.run`, before anything is computed.
    """
    everything = 2**62  # what this machine has means nothing there
    run = prepare(
        spec,
        output,
        threads=profile.cpus,
        overrides=overrides,
        force=force,
        max_memory=everything,
    )
    target = Path(os.path.abspath(output))  # noqa: PTH100  (links stay as they are)
    folder = RunFolder(target).path / "jobs"
    tasks = [Task(cell, range(1), cell.pressures, profile.cpus) for cell in run.cells]
    largest = max([*map(memory_of, tasks), *map(assembly_memory, run.cells)])
    jobs = ShareJobs(
        name=run.spec.name,
        program=(sys.executable, "-m", "roughbench"),
        folder=Path(os.path.abspath(run.spec.folder)),  # noqa: PTH100
        spec=folder / "spec.yaml",
        output=target,
        logs=folder,
        shares=shares,
        profile=profile,
        memory=profile.memory or f"{math.ceil((largest + _MARGIN) / 2**20)}M",
    )
    return jobs, _named(run.spec)


def submit_shares(jobs: ShareJobs, spec: str) -> Submission:
    """Write the scripts of jobs, and submit them.

    Raises
    ------
    LockedError
        If a run, or shares of one, work for the same results.
    RoughbenchError
        As :func:`roughbench.engines.sbatch.submit`.
    """
    folder = RunFolder(jobs.output)
    make_folder(folder.path.parent)
    with folder.locked("roughbench submit"):
        jobs.logs.mkdir(exist_ok=True)
        array, assembling = jobs.logs / "array.sh", jobs.logs / "assemble.sh"
        commit(spec.encode(), jobs.spec)
        commit(jobs.array_script().encode(), array)
        commit(jobs.assembling_script().encode(), assembling)
    return Submission(jobs.output, array, assembling, submit(array, assembling))


def _named(spec: Spec) -> str:
    """Return the text of a spec that says its name, which a file would give it."""
    text = spec.text if "\n" in spec.text else f"{spec.text}\n"
    if load_spec(text, folder=spec.folder).name == spec.name:
        return text
    return load_spec(spec, [f"name={spec.name}"]).text
