"""Where results come from: what varies between runs, kept apart from the results file."""

from __future__ import annotations

import contextlib
import hashlib
import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roughbench.rundir.folder import RunFolder
from roughbench.rundir.identity import assembly_digest
from roughbench.rundir.usage import machine, now
from roughbench.runner.made_with import written_with
from roughbench.runner.scan import CellState
from roughbench.spec import Spec


def provenance(
    results_sha256: str,
    inputs_sha256: str,
    spec: Spec,
    cell_states: Sequence[CellState],
    command: str,
) -> dict[str, Any]:
    """Return where a results file comes from: hashes, seeds, machines, versions, times.

    Parameters
    ----------
    results_sha256 : str
        Of the results file.
    inputs_sha256 : str
        See :func:`inputs_of`.
    spec : Spec
    cell_states : sequence of CellState
    command : str

    Returns
    -------
    dict
        For JSON.
    """
    return {
        "results_sha256": results_sha256,
        "inputs_sha256": inputs_sha256,
        "spec_sha256": spec.sha256,
        "command": command,
        "written": now(),
        "git_commit": _git_commit(),
        "machine": machine(),
        "models": {str(cell_state.cell): _of_model(cell_state) for cell_state in cell_states},
    }


def inputs_of(spec: Spec, cell_states: Sequence[CellState]) -> str:
    """Return a digest of all that the bytes of a results file are made of.

    The spec and its name, the shards, which are named after their content, and the code
    that puts them together.
    """
    content = [spec.text, spec.name, spec.sha256, assembly_digest()]
    content += [f"{name} {value}" for name, value in written_with().items()]
    for cell_state in cell_states:
        content += [str(cell_state.cell), cell_state.key]
        content += sorted(shard.path.name for shard in cell_state.shards)
    return hashlib.sha256("\0".join(content).encode()).hexdigest()


def _of_model(cell_state: CellState) -> dict[str, Any]:
    return {
        "identity": dict(cell_state.identity),
        "key": cell_state.key,
        "seed": cell_state.cell.seed,
        "threads": cell_state.threads,
        "realizations": cell_state.cell.n_realizations,
        "pressures": len(cell_state.cell.pressures),
        "states": cell_state.cell.n_states,
        "unconverged": cell_state.n_unconverged,
    } | spent(cell_state.usages)


def spent(usages: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what tasks took together: seconds summed up, the largest memory, the machines."""
    machines: dict[str, dict[str, str]] = {}
    for usage in usages:
        its = dict(usage["machine"])
        machines[f"{its.get('host')}: {its.get('cpu')}"] = its
    return {
        "tasks": len(usages),
        "seconds": sum(float(usage["seconds"]) for usage in usages),
        "cpu_seconds": sum(float(usage["cpu_seconds"]) for usage in usages),
        "peak_memory": max((int(usage["peak_memory"]) for usage in usages), default=0),
        "machines": [*machines.values()],
    }


def _git_commit() -> str:
    """Return the commit of the folder that the run was started in; empty for none."""
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        found = subprocess.run(
            ["git", "rev-parse", "HEAD"],  # noqa: S607
            capture_output=True,
            text=True,
            timeout=5.0,
            check=False,
        )
        if found.returncode == 0:
            return found.stdout.strip()
    return ""


def request_of(spec: Spec, cell_states: Sequence[CellState], command: str) -> dict[str, object]:
    """Return what a run was asked for, for ``status`` and ``clean``."""
    return {
        "spec": spec.text,
        "name": spec.name,
        "folder": str(spec.folder.absolute()),
        "spec_sha256": spec.sha256,
        "command": command,
        "threads": {str(cell_state.cell): cell_state.threads for cell_state in cell_states},
        "keys": sorted({cell_state.key for cell_state in cell_states}),
    }


@dataclass(frozen=True, slots=True)
class Account:
    """What a run has made of one model, and what that took.

    Attributes
    ----------
    name : str
        Such as ``main/bem``.
    realizations, pressures : int
    states, unconverged : int
        How many states there are, and how many of them did not converge.
    seconds : float
        Of all tasks.
    memory : int
        Most bytes of one task.
    """

    name: str
    realizations: int
    pressures: int
    states: int
    unconverged: int
    seconds: float
    memory: int


def accounts(results: str | os.PathLike[str]) -> list[Account]:
    """Return what the run behind a results file has made, model by model.

    Empty where no run directory tells. A file of many models takes long to look through.
    """
    models = RunFolder(results).provenance().get("models", {})
    numbers = ("realizations", "pressures", "states", "unconverged", "seconds", "peak_memory")
    return [
        Account(name, *(model[number] for number in numbers)) for name, model in models.items()
    ]
