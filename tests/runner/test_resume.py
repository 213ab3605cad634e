"""Runs on top of earlier ones: what is kept, what is computed again, and why."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import runner
from roughbench.errors import IncompleteError
from roughbench.planning.cells import Cell
from roughbench.rundir import checkpoint as checkpoints
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.journal import log_task
from roughbench.rundir.shards import Shard
from roughbench.runner import inspection, monitor, preparation
from roughbench.spec import load_spec
from tests.engines.fakes import Fake, Misdeed, Steps

Tree = dict[str, Any]

SMOOTH: Tree = {
    "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
    "pressures": [0.01],
    "models": [{"kind": "bem", "grid": 32}],
}
"""A surface for the exact solver that takes no time."""


@pytest.fixture
def output(tmp_path: Path) -> Path:
    return tmp_path / "r.h5"


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of the tasks that are computed from now on."""
    names: list[str] = []
    before = log_task

    def spy(task: Any, *rest: Any) -> None:
        names.append(str(task))
        before(task, *rest)

    monkeypatch.setattr(monitor, "log_task", spy)
    return names


def reasons(tree: Tree, output: Path, **options: Any) -> dict[str, str]:
    parts = runner.preview(tree, output=output, **options)
    return {f"{part.model}:{part.first}-{part.last}": part.reason for part in parts}


def test_a_finished_run_has_nothing_to_do(
    small_spec: Tree, output: Path, computed: list[str]
) -> None:
    first = rb.run(small_spec, output=output)
    assert len(computed) == 2
    before = output.stat()
    again = rb.run(small_spec, output=output)
    assert len(computed) == 2
    assert output.stat().st_mtime_ns == before.st_mtime_ns  # not even written
    for name, values in first["main"]["foundation"].variables.items():
        np.testing.assert_array_equal(values, again["main"]["foundation"][name])
    assert set(reasons(small_spec, output).values()) == {"done"}


def test_a_lost_results_file_is_made_from_the_shards(
    small_spec: Tree, output: Path, computed: list[str]
) -> None:
    rb.run(small_spec, output=output)
    data = output.read_bytes()
    output.write_bytes(data[:100])
    rb.run(small_spec, output=output)
    assert output.read_bytes() == data
    output.unlink()
    rb.run(small_spec, output=output, jobs=None)
    assert output.read_bytes() == data
    assert len(computed) == 2


def test_more_realizations_keep_what_is_there(
    small_spec: Tree, output: Path, computed: list[str]
) -> None:
    rb.run(small_spec, output=output)
    more = small_spec | {"realizations": 25}
    assert reasons(more, output) == {
        "main/foundation:1-20": "done",
        "main/foundation:21-25": "new",
        "main/persson:1-1": "done",
    }
    del computed[:]
    rb.run(more, output=output)
    assert computed == ["main/foundation, realizations 21 to 25 of 25"]
    rb.run(more, output=output.with_name("fresh.h5"))
    assert output.read_bytes() == output.with_name("fresh.h5").read_bytes()
    fewer = small_spec | {"realizations": 7}
    rb.run(fewer, output=output)
    rb.run(fewer, output=output.with_name("few.h5"))
    assert output.read_bytes() == output.with_name("few.h5").read_bytes()


def test_more_pressures_keep_iterated_states(output: Path, computed: list[str]) -> None:
    models = [*SMOOTH["models"], {"kind": "persson"}]
    tree = SMOOTH | {"pressures": [0.001, 0.03], "models": models}
    rb.run(tree, output=output)
    before = rb.load(output)["main"]
    more = tree | {"pressures": [0.001, 0.01, 0.03, 0.1]}
    found = reasons(more, output)
    assert found["main/bem:1-1"] == "2 of 4 pressures are new"
    assert found["main/persson:1-1"].startswith("changed: pressures: 2 from 0.001 to 0.03 (")
    rb.run(more, output=output)
    after = rb.load(output)["main"]
    fresh = rb.run(more)["main"]
    for name in ("area", "separation", "stiffness"):
        np.testing.assert_array_equal(after["bem"][name][:, [0, 2]], before["bem"][name])
        np.testing.assert_allclose(after["bem"][name], fresh["bem"][name], rtol=1e-3)
        np.testing.assert_array_equal(after["persson"][name], fresh["persson"][name])
    assert after["bem"].n_unconverged == 0
    del computed[:]
    rb.run(tree | {"pressures": [0.1, 1e-3]}, output=output)
    assert computed == ["main/persson"]
    assert rb.load(output)["main"]["bem"]["pressure"].tolist() == [1e-3, 0.1]


def test_a_changed_parameter_reruns_what_depends_on_it(
    small_spec: Tree, output: Path, computed: list[str]
) -> None:
    rb.run(small_spec, output=output)
    assert reasons(small_spec | {"seed": 8}, output) == {
        "main/foundation:1-20": "changed: seed: 7 → 8",
        "main/persson:1-1": "done",
    }
    changed = reasons(small_spec, output, overrides=["surface.H=0.8", "seed=9"])
    assert changed["main/foundation:1-20"] == "changed: seed: 7 → 9, surface.H: 0.7 → 0.8"
    assert changed["main/persson:1-1"] == "changed: surface.H: 0.7 → 0.8"
    many = ["surface.q0=0.5", "surface.qr=2", "surface.q1=31", "surface.slope=0.2", "seed=9"]
    assert reasons(small_spec, output, overrides=many)["main/foundation:1-20"].endswith(
        "and 2 more"
    )
    del computed[:]
    rb.run(small_spec, output=output, overrides=["seed=8"])
    assert computed == ["main/foundation, realizations 1 to 20 of 20"]
    rb.run(small_spec, output=output)  # and back
    assert len(computed) == 1


def test_an_added_model_or_experiment_is_new(small_spec: Tree, output: Path) -> None:
    rb.run(small_spec, output=output)
    more = [*small_spec["models"], {"kind": "foundation", "springs": 256, "label": "fine"}]
    assert reasons(small_spec | {"models": more}, output)["main/fine:1-20"] == "new"
    swept = reasons(small_spec | {"sweep": {"surface.qr": [4.0, 8.0]}}, output)
    assert swept["surface.qr=4.0/foundation:1-20"] == "done"
    assert swept["surface.qr=8.0/foundation:1-20"] == "new"


def test_other_code_is_a_change(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rb.run(small_spec, output=output)
    monkeypatch.setattr("roughbench.rundir.identity.code_digest", lambda _: "f" * 12)
    assert reasons(small_spec, output)["main/persson:1-1"].startswith("changed: code: ")


def test_force_computes_everything_again(
    small_spec: Tree, output: Path, computed: list[str]
) -> None:
    rb.run(small_spec, output=output)
    data = output.read_bytes()
    assert set(reasons(small_spec, output, force=True).values()) == {"forced"}
    rb.run(small_spec, output=output, force=True)
    assert len(computed) == 4
    assert output.read_bytes() == data
    assert len(list(output.with_name("r.h5.rbrun").glob("shards/*/*"))) == 2


def test_only_some_tasks(small_spec: Tree, output: Path, computed: list[str]) -> None:
    with pytest.raises(rb.RoughbenchError, match="not written yet"):
        rb.run(small_spec, output=output, only=["main/foundation:3-5", "main/foundation:9"])
    assert computed == [
        "main/foundation, realizations 3 to 5 of 20",
        "main/foundation, realization 9 of 20",
    ]
    assert reasons(small_spec, output)["main/foundation:6-8"] == "new"
    rb.run(small_spec, output=output)
    rb.run(small_spec, output=output.with_name("fresh.h5"))
    assert output.read_bytes() == output.with_name("fresh.h5").read_bytes()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("main/bam", "no such model here; there are main/foundation, main/persson"),
        ("main/foundation:0", "has the realizations 1 to 20"),
        ("main/foundation:21", "has the realizations 1 to 20"),
        ("main/foundation:5-4", "has the realizations 1 to 20"),
        ("main/foundation:x", "write main/foundation:1 or main/foundation:1-20"),
    ],
)
def test_only_refuses_what_there_is_not(small_spec: Tree, name: str, message: str) -> None:
    with pytest.raises(rb.RoughbenchError, match=message):
        rb.run(small_spec, only=[name])


def test_a_damaged_shard_is_named_set_aside_and_computed_again(
    small_spec: Tree, output: Path, computed: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    rb.run(small_spec, output=output)
    data = output.read_bytes()
    shard = next(output.with_name("r.h5.rbrun").glob("shards/*/000000-000019.*"))
    shard.write_bytes(shard.read_bytes()[:-1])
    stranger = shard.with_name("stranger.npz")
    stranger.touch()
    assert reasons(small_spec, output)["main/foundation:1-20"].startswith(f"damaged: {shard}")
    del computed[:]
    rb.run(small_spec, output=output)
    assert computed == ["main/foundation, realizations 1 to 20 of 20"]
    assert output.read_bytes() == data
    assert f"{shard}: is damaged" in caplog.text
    assert f"{stranger}: is no shard" in caplog.text
    aside = [path.name for path in output.with_name("r.h5.rbrun").glob("set-aside/*")]
    assert sorted(aside) == sorted(f"{s.parent.name}-{s.name}" for s in (shard, stranger))


def test_a_resumed_run_has_the_threads_of_its_shards(
    output: Path, monkeypatch: pytest.MonkeyPatch, computed: list[str]
) -> None:
    monkeypatch.setattr("roughbench.planning.resources.available_cores", lambda: 4)
    rb.run(SMOOTH, output=output, jobs=2)  # two threads each
    del computed[:]
    for options in ({"jobs": 1}, {"jobs": 4}, {"jobs": None}, {"threads": 2}):
        rb.run(SMOOTH, output=output, **options)
    assert computed == []
    assert reasons(SMOOTH, output, threads=3) == {"main/bem:1-1": "changed: threads: 2 → 3"}


# -- tasks that fail or are killed ---------------------------------------------------------


@pytest.fixture
def cells(small_spec: Tree, monkeypatch: pytest.MonkeyPatch) -> list[Cell]:
    """Return what any spec plans: a cell that refuses, and one that does not."""
    spec = load_spec(small_spec)
    models: tuple[tuple[str, Misdeed], ...] = (("bad", "refuse"), ("good", "none"))
    found = [
        Cell("main", Fake(label=label, misdeed=deed), spec.surface, spec.pressures, 2, 1)
        for label, deed in models
    ]
    monkeypatch.setattr(preparation, "plan", lambda _: found)
    return found


@pytest.mark.usefixtures("cells")
@pytest.mark.parametrize("keep_going", [False, True])
def test_keep_going_finishes_the_others(
    small_spec: Tree, output: Path, computed: list[str], *, keep_going: bool
) -> None:
    command, cores = "roughbench run s.yaml", runner.available_cores()
    with pytest.raises(rb.SolverError, match="main/bad, realization 1 of 2: ref") as caught:
        rb.run(small_spec, output=output, keep_going=keep_going, command=command)
    assert computed == ["main/good, realizations 1 to 2 of 2"] * keep_going
    assert caught.value.__notes__ == [
        f"rerun it alone: {command} --only main/bad:1-2 -j 1 --threads {cores}",
        f"6 of 12 states are kept in {output}.rbrun; resume: {command}"
        if keep_going
        else f"run it again: {command}",
    ]
    assert not output.exists()


def test_all_failures_are_told(small_spec: Tree, output: Path, cells: list[Cell]) -> None:
    cells.append(
        Cell("more", Fake(misdeed="crash"), cells[0].surface, cells[0].pressures, 1, 1)
    )
    cores = runner.available_cores()
    with pytest.raises(rb.RoughbenchError) as caught:
        rb.run(small_spec, output=output, keep_going=True, command="c")
    assert re.sub(r"py:\d+", "py:LINE", str(caught.value)) == (
        "2 tasks failed:\nmain/bad, realization 1 of 2: refused\n"
        f"rerun it alone: c --only main/bad:1-2 -j 1 --threads {cores}\n"
        "more/fake: fakes.py:LINE: ZeroDivisionError: a fault of the model\n"
        f"rerun it alone: c --only more/fake -j 1 --threads {cores}"
    )


def steps(small_spec: Tree, stop: int) -> Cell:
    spec = load_spec(small_spec)
    pressures = tuple(np.geomspace(1e-4, 1e-2, 10).tolist())
    return Cell("main", Steps(stop=stop, label="steps"), spec.surface, pressures, 1, 1)


@pytest.mark.parametrize("damage", [False, True])
def test_a_killed_curve_goes_on_from_its_last_pressure(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch, *, damage: bool
) -> None:
    monkeypatch.setattr(checkpoints, "SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(checkpoints, "COST", 1e9)
    # The stop is what kills it, not what the numbers depend on.
    monkeypatch.setattr("roughbench.runner.scan.identity", lambda *_: {"model.kind": "steps"})
    monkeypatch.setattr(preparation, "plan", lambda _: [steps(small_spec, 7)])
    with pytest.raises(rb.SolverError, match="killed") as caught:
        rb.run(small_spec, output=output)
    assert caught.value.__notes__[-1] == f"7 of 10 states are kept in {output}.rbrun"
    monkeypatch.setattr(preparation, "plan", lambda _: [steps(small_spec, 10)])
    kept = list(output.with_name("r.h5.rbrun").glob("checkpoints/*.npz"))
    assert len(kept) == 1
    if damage:
        kept[0].write_bytes(kept[0].read_bytes()[:-30])
    else:
        assert reasons(small_spec, output) == {"main/steps:1-1": "7 of 10 pressures done"}
    news: list[runner.Progress] = []
    rb.run(small_spec, output=output, progress=news.append)
    assert [n.done for n in news] == [0, *range(1 if damage else 8, 11)]
    rb.run(small_spec, output=output.with_name("fresh.h5"))
    assert output.read_bytes() == output.with_name("fresh.h5").read_bytes()
    assert not kept[0].exists()


@pytest.mark.parametrize("options", [{"jobs": 2}, {"threads": 7}])
def test_a_killed_curve_is_seen_whatever_its_threads(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch, options: dict[str, Any]
) -> None:
    """No shard tells the threads yet: the last request does, and the checkpoint itself."""
    monkeypatch.setattr(checkpoints, "SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(checkpoints, "COST", 1e9)
    monkeypatch.setattr("roughbench.planning.resources.available_cores", lambda: 4)
    monkeypatch.setattr(
        "roughbench.runner.scan.identity",
        lambda _, threads: {"model.kind": "steps", "threads": threads},
    )
    for place in (preparation, inspection):
        monkeypatch.setattr(place, "plan", lambda _: [steps(small_spec, 7)])
    with pytest.raises(rb.SolverError, match="killed"):
        rb.run(small_spec, output=output, **options)
    assert [part.reason for part in runner.status(output).parts] == ["7 of 10 pressures done"]
    seen = {"main/steps:1-1": "7 of 10 pressures done"}
    assert reasons(small_spec, output, **options) == seen
    assert reasons(small_spec, output, threads=3) == {"main/steps:1-1": "new"}
    if "jobs" in options:  # other threads would do as well, and those of before are taken
        assert reasons(small_spec, output, jobs=1) == seen
        monkeypatch.setattr(preparation, "plan", lambda _: [steps(small_spec, 10)])
        news: list[runner.Progress] = []
        rb.run(small_spec, output=output, jobs=1, progress=news.append)
        assert [n.done for n in news] == [0, 8, 9, 10]


@pytest.mark.parametrize("threads", [None, 3, {"main/bem": "two"}])
def test_status_does_without_the_threads_of_the_request(output: Path, threads: Any) -> None:
    rb.run(SMOOTH, output=output, jobs=None)
    folder = RunFolder(output)
    folder.write_request(folder.request() | {"threads": threads})
    assert runner.status(output).state == "complete"


def test_clean_keeps_shards_of_more_threads_than_cores(
    output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("roughbench.planning.resources.available_cores", lambda: 2)
    rb.run(SMOOTH, output=output, threads=3)
    assert runner.clean(output, unused=True) == 0
    assert runner.status(output).state == "complete"


def test_a_checkpoint_is_worth_its_cost(tmp_path: Path) -> None:
    kept = checkpoints.Checkpoint(tmp_path / "c.npz")
    kept.offer(3, lambda: {"area": np.ones(3)})
    assert kept.load() is None  # ten seconds have not passed
    kept._last = time.monotonic() - 11.0
    kept.offer(4, lambda: {"area": np.ones(4)})
    found = kept.load()
    assert found is not None
    assert (found[0], found[1]["area"].tolist(), kept.done()) == (4, [1.0] * 4, 4)
    kept._last, kept._cost = time.monotonic() - 11.0, 1.0
    kept.offer(5, lambda: {"area": np.ones(5)})
    assert kept.done() == 4  # a second to write: not more often than every twenty
    kept.remove()
    assert kept.done() == 0


def test_a_disk_that_refuses_leaves_a_run_to_resume(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch, computed: list[str]
) -> None:
    from roughbench.rundir.folder import RunFolder

    real, calls = RunFolder.write, []

    def full(*arguments: Any) -> Shard:
        calls.append(1)
        if len(calls) == 2:
            raise rb.StoreError("cannot write shard: No space left on device")
        return real(*arguments)

    monkeypatch.setattr(RunFolder, "write", full)
    with pytest.raises(IncompleteError, match="No space left on device; main/pe") as caught:
        rb.run(small_spec, output=output, command="again")
    kept = f"60 of 63 states are kept in {output}.rbrun; resume: again"
    assert caught.value.__notes__ == [kept]
    rb.run(small_spec, output=output)
    assert computed == ["main/foundation, realizations 1 to 20 of 20", "main/persson"]


def test_stock_counts(small_spec: Tree, output: Path) -> None:
    rb.run(small_spec, output=output)
    state = runner.status(output)
    assert (state.state, state.done, state.states) == ("complete", 63, 63)
    output.unlink()
    assert runner.status(output).state == "incomplete"
