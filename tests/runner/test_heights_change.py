"""Heights files that change under a run: each number belongs to the heights of its key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import runner
from roughbench.cli.tables import as_text
from roughbench.engines.compute import compute
from roughbench.heights_file import load_heights
from roughbench.planning import measured
from roughbench.planning.cells import Cell
from roughbench.planning.plan import plan
from roughbench.planning.tasks import Task
from roughbench.rundir.folder import RunFolder
from roughbench.spec import load_spec

MOST_READS = 3
"""Once for the plan, which takes the spectrum, and once for each model of surfaces."""


@pytest.fixture
def heights(tmp_path: Path, rng: np.random.Generator) -> list[Path]:
    """Return two files of heights, of which the first stands under the name in the spec."""
    for name, scale in (("one.npy", 1.0), ("other.npy", 3.0)):
        np.save(tmp_path / name, 0.05 * scale * rng.normal(size=(16, 16)))
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: heights.npy, length: 3.0}\n"
        "pressures: [0.1, 0.5]\n"
        "models: [{kind: bem}, {kind: winkler}, {kind: persson}]\n"
    )
    put(tmp_path / "one.npy")
    return [tmp_path / "one.npy", tmp_path / "other.npy"]


def put(chosen: Path) -> None:
    (chosen.parent / "heights.npy").write_bytes(chosen.read_bytes())


def numbers(results: rb.Results) -> dict[str, float]:
    found = {}
    for name, model in results["main"].items():
        found[name] = float(model["separation"][0, 0])
        found[f"{name} attribute"] = float(model.attributes["rms_height"])
        found[f"{name} realized"] = float(model["rms_height"][0])
    return found


@pytest.mark.parametrize("reads", range(1, MOST_READS + 1))
@pytest.mark.parametrize("kept", [False, True])
def test_a_swap_after_any_read_ends_the_run_or_changes_nothing(
    heights: list[Path], monkeypatch: pytest.MonkeyPatch, reads: int, *, kept: bool
) -> None:
    """Swapped after each number of reads; then a quiet run, on what was kept."""
    folder = heights[0].parent
    expected = {}
    for path in reversed(heights):
        put(path)
        expected[path] = numbers(rb.run(folder / "spec.yaml"))
    real, calls = load_heights, []

    def load(*arguments: Any) -> Any:
        found = real(*arguments)
        calls.append(1)
        if len(calls) == reads:
            put(heights[1])
        return found

    monkeypatch.setattr(measured, "load_heights", load)
    output = folder / "r.h5" if kept else None
    if reads < MOST_READS:
        with pytest.raises(rb.SolverError, match="changed since the run began"):
            rb.run(folder / "spec.yaml", output=output)
    else:
        assert numbers(rb.run(folder / "spec.yaml", output=output)) == expected[heights[0]]
        assert len(calls) == MOST_READS
    monkeypatch.setattr(measured, "load_heights", real)
    assert numbers(rb.run(folder / "spec.yaml", output=output)) == expected[heights[1]]
    put(heights[0])
    assert numbers(rb.run(folder / "spec.yaml", output=output)) == expected[heights[0]]


def test_workers_refuse_what_the_plan_did_not_see(heights: list[Path]) -> None:
    """All that read the heights: a theory has the spectrum that the plan saw."""
    folder = heights[0].parent
    cells = [c for c in plan(load_spec(folder / "spec.yaml")) if c.model.dimension == 2]
    put(heights[1])
    news: list[runner.Progress] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("roughbench.runner.preparation.plan", lambda _: cells)
        with pytest.raises(rb.SolverError, match="changed since the run began"):
            rb.run(folder / "spec.yaml", output=folder / "r.h5", jobs=2, progress=news.append)
    assert [RunFolder(folder / "r.h5").shards(key) for key in _keys(folder)] == []
    assert news[-1].done == 0


def _keys(folder: Path) -> list[str]:
    return RunFolder(folder / "r.h5").computations()


def test_a_task_computes_with_the_bytes_that_it_checked(
    heights: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = plan(load_spec(heights[0].parent / "spec.yaml"))[0]
    real, calls = load_heights, []

    def load(*arguments: Any) -> Any:
        calls.append(arguments)
        return real(*arguments)

    monkeypatch.setattr(measured, "load_heights", load)
    compute(Task(cell, range(1), cell.pressures))
    assert len(calls) == 1


def test_a_cell_without_its_heights_is_no_cell(heights: list[Path]) -> None:
    spec = load_spec(heights[0].parent / "spec.yaml")
    with pytest.raises(ValueError, match="heights belong to surfaces from a file"):
        Cell("main", spec.models[0], spec.surface, spec.pressures, 1, 0)


def test_files_that_cannot_be_read_are_told_together(heights: list[Path]) -> None:
    folder = heights[0].parent
    for path in heights:
        path.write_text("no heights")
    tree = {
        "surface": {"kind": "file", "path": str(heights[0]), "length": 1.0},
        "pressures": [0.1],
        "models": [{"kind": "persson"}],
        "sweep": {"surface.path": [str(path) for path in heights]},
    }
    with pytest.raises(rb.SurfaceError) as caught:
        rb.run(tree, output=folder / "r.h5")
    assert [line.rpartition(": not a")[2][:9] for line in str(caught.value).split("\n")] == [
        " .npy fil",
        " .npy fil",
    ]
    assert not (folder / "r.h5.rbrun").exists()


def test_what_is_shown_names_the_file_and_not_an_option(heights: list[Path]) -> None:
    """Springs have an option of that name: it read heights realized."""
    spec = heights[0].parent / "spec.yaml"
    both = as_text(
        rb.run(spec, overrides=['models=[{"kind":"winkler"},{"kind":"persson"}]']), "r"
    )
    assert "surface file, heights heights.npy, " in both
    alone = as_text(rb.run(spec, overrides=['models=[{"kind":"winkler"}]']), "r")
    assert "surface file, length 3, " in alone
    assert "realized" not in both.splitlines()[3] + alone
