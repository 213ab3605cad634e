"""Jobs of Slurm that compute shares of a run, and one behind them that assembles it.

No process waits for the jobs, and they need no network among each other: they meet in the run
directory, which all nodes have to share.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from roughbench.engines.profiles import JobProfile
from roughbench.errors import RoughbenchError, explained
from roughbench.text import on_one_line

_UNSAFE = re.compile(r"[\x00-\x1f\x7f]")


@dataclass(frozen=True, slots=True)
class ShareJobs:
    """An array of jobs, and the job behind it.

    Attributes
    ----------
    name : str
        Of the run.
    program : tuple of str
        Words that call roughbench, up to its commands.
    folder : Path
        Absolute; where relative paths in the spec start.
    spec, output : Path
        Absolute: the file that the jobs read the spec from, and the results file.
    logs : Path
        Absolute; folder for what the jobs say.
    shares : int
        How many jobs there are.
    profile : JobProfile
    memory : str
        Of each job, as ``16G``.
    """

    name: str
    program: tuple[str, ...]
    folder: Path
    spec: Path
    output: Path
    logs: Path
    shares: int
    profile: JobProfile
    memory: str

    def array_script(self) -> str:
        """Return the script that computes a share in each of its jobs."""
        share = f'--share "${{SLURM_ARRAY_TASK_ID}}/{self.shares}"'
        return self._script([f"--array=1-{self.shares}"], "%A-%a.out", share)

    def assembling_script(self) -> str:
        """Return the script that computes what shares have left, and writes the results."""
        return self._script([], "%j-assemble.out", "")

    def _script(self, options: Sequence[str], log: str, share: str) -> str:
        profile = self.profile
        given = [
            f"--job-name={self.name}",
            *options,
            f"--time={profile.walltime}",
            "--ntasks=1",
            f"--cpus-per-task={profile.cpus}",
            f"--mem={self.memory}",
            *([f"--partition={profile.partition}"] if profile.partition else []),
            *([f"--account={profile.account}"] if profile.account else []),
            f"--output={self.logs / log}",
            *profile.options,
        ]
        for one in given:
            if _UNSAFE.search(one):
                raise RoughbenchError(
                    f"{on_one_line(one)!r} cannot stand in a script; an option is one line"
                )
        words = [*self.program, "run", "-", "-o", str(self.output)]
        words += ["--threads", str(profile.cpus), "-j", "1", "-q"]
        call = " ".join(filter(None, [shlex.join(words), share]))
        lines = [
            "#!/bin/bash",
            *(f"#SBATCH {_quoted(one)}" for one in given),
            *([profile.setup.rstrip("\n")] if profile.setup else []),
            f"cd {shlex.quote(str(self.folder))} || exit 1",
            f"exec {call} < {shlex.quote(str(self.spec))}",
        ]
        return "\n".join(lines) + "\n"


def submit(array: Path, assembling: Path) -> tuple[str, str]:
    """Submit an array of jobs, and the job that begins when all of them have ended.

    However they end: what a killed one has left is computed by the last.

    Returns
    -------
    (str, str)
        The numbers that Slurm gave them.

    Raises
    ------
    RoughbenchError
        If there is no Slurm here, or it refuses.
    """
    if shutil.which("sbatch") is None:
        raise RoughbenchError(
            "Slurm's command sbatch is not on the PATH; where it is, submit these: "
            f"ID=$(sbatch --parsable {shlex.quote(str(array))}); "
            f"sbatch --dependency=afterany:$ID {shlex.quote(str(assembling))}"
        )
    first = _sbatch(array)
    try:
        return first, _sbatch(assembling, f"--dependency=afterany:{first}")
    except RoughbenchError as error:
        error.add_note(
            f"the jobs {first} are submitted; when they have ended: sbatch "
            f"{shlex.quote(str(assembling))}; or end them: scancel {first}"
        )
        raise


def _sbatch(script: Path, *options: str) -> str:
    words = ["sbatch", "--parsable", *options, str(script)]
    try:
        found = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
    except OSError as error:
        raise RoughbenchError(f"sbatch cannot be started: {explained(error)}") from error
    number = found.stdout.strip().partition(";")[0]
    if found.returncode or not number.isdigit():
        said = on_one_line((found.stderr or found.stdout).strip()) or "nothing"
        raise RoughbenchError(f"sbatch refuses {script}; it says: {said}")
    return number


def _quoted(option: str) -> str:
    """Return an option as Slurm reads it in a script: in quotes where it has blanks."""
    name, equals, value = option.partition("=")
    return f'{name}{equals}"{value}"' if equals and re.search(r"\s", value) else option
