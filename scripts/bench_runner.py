"""Time what a durable run costs beyond the bare computation, and a resume.

    python scripts/bench_runner.py [overhead] [resume] [planning] [assembly]

Bare: 10,000 realizations of the foundation (8192 springs, 20 pressures), made and solved one
after the other in this process, after one that compiles the loops. Run: the same through
``run`` with a results file, so with shards, averages and the file. Then a finished run of
1,000 tasks of one realization each is resumed by the command, as a process of its own.
Planning: after a change of the pressures, ``run -n`` over 100 and 600 shards of as many
experiments; and a finished sweep of 2,000 tasks is resumed. Assembly: peak memory, and its
ratio to the results file, of a run that keeps fields, of the same run when only its results
file is missing, of ``show`` and of ``show --json``.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from _machine import describe_machine

import roughbench as rb
from roughbench.models.foundation import foundation_curve
from roughbench.planning.cells import Cell
from roughbench.planning.samples import make_sample
from roughbench.runner import plan, preview

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


def planning(folder: Path) -> None:
    """Print how long it takes to find out what changed, and to resume a finished sweep."""
    for count in (100, 600):
        tree = swept(count, [{"kind": "persson"}])
        output = folder / f"sweep{count}.h5"
        rb.run(tree, output=output)
        begin = time.perf_counter()
        parts = preview(tree | {"pressures": [1e-4, 1e-2]}, output=output)
        seconds = time.perf_counter() - begin
        assert all(part.reason.startswith("changed: pressures: ") for part in parts)
        print(f"plan after a change of pressures, {count} shards: {seconds:.2f} s")
    models = [{"kind": "foundation", "springs": 512}, {"kind": "persson"}]
    spec = folder / "sweep.yaml"
    spec.write_text(rb.load_spec(swept(1000, models)).text)
    for what in ("first", "again"):
        seconds, _ = command(folder, "run", "sweep.yaml", "-q", "-o", "sweep.h5")
        print(f"run of a sweep of 2000 tasks, {what}: {seconds:.2f} s")


def swept(count: int, models: list[dict[str, object]]) -> dict[str, object]:
    """Return a spec of so many experiments."""
    slopes = [0.1 + 1e-4 * number for number in range(count)]
    surface = SPEC["surface"]
    assert isinstance(surface, dict)
    return {
        "name": "sweep",
        "surface": surface,
        "pressures": [1e-4, 1e-3],
        "models": models,
        "sweep": {"surface.slope": slopes},
    }


def assembly(folder: Path) -> None:
    """Print the most memory of processes that make or read a file of fields."""
    surface = {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1}
    tree = {
        "name": "fields",
        "surface": surface,
        "pressures": [1e-3, 1e-2, 1e-1, 0.2],
        "realizations": 8,
        "models": [{"kind": "winkler", "grid": 1024}],
        "save_fields": {"pressures": [1e-3, 1e-2, 1e-1, 0.2], "realizations": [*range(8)]},
    }
    (folder / "fields.yaml").write_text(rb.load_spec(tree).text)
    parts = preview(folder / "fields.yaml", output=folder / "fields.h5")
    print(f"fields planned: {max(part.memory for part in parts) / 1e9:.2f} GB a task")
    run = ("run", "fields.yaml", "-q", "-j", "1", "-o", "fields.h5")
    for what, arguments in (
        ("first run", run),
        ("file lost", run),
        ("file there", run),
        ("show", ("show", "fields.h5")),
        ("show --json", ("show", "fields.h5", "--json")),
    ):
        if what == "file lost":
            (folder / "fields.h5").unlink()
        seconds, peak = command(folder, *arguments)
        size = (folder / "fields.h5").stat().st_size
        print(
            f"fields, {what}: {seconds:.1f} s, peak memory {peak / 1e9:.2f} GB for a file of "
            f"{size / 1e9:.2f} GB, {peak / size:.1f} times"
        )


def command(folder: Path, *arguments: str) -> tuple[float, int]:
    """Run a command in a process of its own; returns its seconds and its peak memory."""
    begin = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "roughbench", *arguments],
        cwd=folder,
        stdout=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{arguments} ended with {status}")
    return time.perf_counter() - begin, 1024 * usage.ru_maxrss


if __name__ == "__main__":
    print(describe_machine("numpy", "numba"))
    parts = sys.argv[1:] or ["overhead", "resume", "planning", "assembly"]
    for part in parts:
        with tempfile.TemporaryDirectory() as name:
            globals()[part](Path(name))
