"""Time what a durable run costs beyond the bare computation, and a resume.

    python scripts/bench_runner.py

Bare: 10,000 realizations of the foundation (8192 springs, 20 pressures), made and solved one
after the other in this process, after one that compiles the loops. Run: the same through
``run`` with a results file, so with shards, averages and the file. Then a finished run of
1,000 tasks of one realization each is resumed by the command, as a process of its own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from _machine import describe_machine

import roughbench as rb
from roughbench.models.foundation import foundation_curve
from roughbench.runner import plan
from roughbench.runner.plan import Cell
from roughbench.runner.samples import make_sample

REALIZATIONS, TASKS = 10_000, 1_000
SPEC = {
    "name": "overhead",
    "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 128.0, "slope": 0.1},
    "pressures": {"min": 1e-5, "max": 1e-2, "points": 20},
    "realizations": REALIZATIONS,
    "models": [{"kind": "foundation", "springs": 8192}],
}


def bare(realizations: range) -> list[np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """Return the areas of the realizations, computed without the runner."""
    spec = rb.load_spec(SPEC)
    areas = []
    for realization in realizations:
        sample = make_sample(spec.surface, spec.models[0], spec.seed, realization)
        assert sample.heights is not None
        areas.append(foundation_curve(sample.heights, spec.pressures, sample.length).area)
    return areas


def overhead(folder: Path) -> None:
    """Print the time of the bare computation and of the run, and compare their numbers."""
    bare(range(1))
    begin = time.perf_counter()
    areas = bare(range(REALIZATIONS))
    seconds = time.perf_counter() - begin
    begin = time.perf_counter()
    results = rb.run(SPEC, output=folder / "overhead.h5")
    there = time.perf_counter() - begin
    error = float(np.abs(results["main"]["foundation"]["area"] - np.array(areas)).max())
    shards = len([*folder.glob("overhead.h5.rbrun/shards/*/*")])
    print(f"bare computation of {REALIZATIONS} realizations: {seconds:.2f} s")
    print(f"run, {shards} shards: {there:.2f} s, {there / seconds:.3f} of it; error {error:g}")


def resume(folder: Path) -> None:
    """Print the time of a command that finds everything done, in 1,000 tasks."""
    tree = {**SPEC, "realizations": TASKS}
    spec = folder / "spec.yaml"
    spec.write_text(rb.load_spec(tree).text)
    sys.modules[Cell.__module__].__dict__["SECONDS_PER_TASK"] = 1e-9  # one realization each
    rb.run(spec, output=folder / "resume.h5")
    cells = plan(rb.load_spec(spec))
    shards = len([*folder.glob("resume.h5.rbrun/shards/*/*")])
    assert shards == TASKS == cells[0].n_realizations
    for what, before in (("results there", None), ("results lost", folder / "resume.h5")):
        times = []
        for _ in range(5):
            if before is not None:
                before.unlink()
            begin = time.perf_counter()
            subprocess.run(
                [sys.executable, "-m", "roughbench", "run", spec, "-q", "-o", "resume.h5"],
                cwd=folder,
                check=True,
                stdout=subprocess.DEVNULL,
            )
            times.append(time.perf_counter() - begin)
        fastest, median = min(times), sorted(times)[2]
        print(
            f"resume of {shards} finished tasks, {what}: {fastest:.2f} s, median {median:.2f}"
        )


if __name__ == "__main__":
    print(describe_machine("numpy", "numba"))
    with tempfile.TemporaryDirectory() as name:
        overhead(Path(name))
        resume(Path(name))
