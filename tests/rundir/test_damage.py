"""Damage to what a run directory holds beside its shards, and results that are another's."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughbench as rb
from roughbench import runner
from roughbench.planning.cells import Cell
from roughbench.rundir import checkpoint as checkpoints
from roughbench.rundir.checkpoint import Checkpoint
from roughbench.rundir.folder import RunFolder
from roughbench.runner import preparation
from roughbench.spec import load_spec
from tests.engines.fakes import Steps

Tree = dict[str, Any]


@pytest.fixture
def output(tmp_path: Path) -> Path:
    return tmp_path / "r.h5"


def damaged(data: st.DataObject, original: bytes) -> bytes:
    """Return a file with a byte changed, cut, lengthened, or with its halves swapped."""
    found = bytearray(original)
    place = data.draw(st.integers(0, len(found) - 1))
    kind = data.draw(st.sampled_from(["change", "change", "cut", "append", "swap"]))
    if kind == "change":
        found[place] = data.draw(st.integers(0, 255))
    elif kind == "cut":
        del found[place:]
    elif kind == "append":
        found += data.draw(st.binary(min_size=1, max_size=20))
    else:
        half = len(found) // 2
        found = found[half:] + found[:half]
    return bytes(found)


# -- checkpoints ---------------------------------------------------------------------------


def written(path: Path, arrays: dict[str, Any], done: int = 4) -> Checkpoint:
    checkpoint = Checkpoint(path)
    checkpoint._last = -1e9
    checkpoint.offer(done, lambda: arrays)
    return checkpoint


_made: list[tuple[Checkpoint, bytes]] = []


@settings(max_examples=500, deadline=None)
@given(data=st.data())
def test_a_damaged_checkpoint_is_none(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    if not _made:
        path = tmp_path_factory.mktemp("checkpoint") / "c.npz"
        kept = written(path, {"area": np.arange(40.0), "p": np.ones((3, 3))})
        _made.append((kept, path.read_bytes()))
    kept, original = _made[0]
    spoilt = damaged(data, original)
    kept.path.write_bytes(spoilt)
    found = kept.load()
    if spoilt != original:
        assert (found, kept.done()) == (None, 0)
        return
    assert found is not None
    assert (found[0], found[1]["area"].tolist()) == (4, np.arange(40.0).tolist())


def test_a_checkpoint_of_another_task_is_none(tmp_path: Path) -> None:
    kept = written(tmp_path / "c.npz", {"area": np.ones(3)})
    assert kept.done() == 4
    other = Checkpoint(tmp_path / "other.npz")
    other.path.write_bytes(kept.path.read_bytes())
    assert (other.load(), other.done()) == (None, 0)


@pytest.fixture
def steps(small_spec: Tree, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a callable that plans a curve of ten steps, which is killed after so many."""
    monkeypatch.setattr(checkpoints, "SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(checkpoints, "COST", 1e9)
    # The stop is what kills it, not what the numbers depend on.
    monkeypatch.setattr("roughbench.runner.scan.identity", lambda *_: {"model.kind": "steps"})
    spec = load_spec(small_spec)
    pressures = tuple(np.geomspace(1e-4, 1e-2, 10).tolist())

    def planned(stop: int) -> None:
        cell = Cell("main", Steps(stop=stop, label="steps"), spec.surface, pressures, 1, 1)
        monkeypatch.setattr(preparation, "plan", lambda _: [cell])

    return planned


@pytest.mark.parametrize(
    ("arrays", "done"),
    [
        ({"area": np.array(["x"])}, 7),
        ({"area": np.zeros((3, 3))}, 7),
        ({"area": np.ones(7)}, 70),
        ({"area": np.ones(7)}, -1),
        ({"observed.field_pressure.x": np.ones(2)}, 7),
    ],
)
def test_a_crafted_checkpoint_costs_time_only(
    small_spec: Tree, output: Path, steps: Any, arrays: Tree, done: int
) -> None:
    """With a checksum that is right, and arrays that no such curve has."""
    steps(7)
    with pytest.raises(rb.SolverError, match="killed"):
        rb.run(small_spec, output=output)
    (path,) = output.with_name("r.h5.rbrun").glob("checkpoints/*.npz")
    written(path, arrays, done)
    steps(10)
    news: list[runner.Progress] = []
    rb.run(small_spec, output=output, progress=news.append)
    rb.run(small_spec, output=output.with_name("fresh.h5"))
    assert output.read_bytes() == output.with_name("fresh.h5").read_bytes()
    assert news[-1].done == 10


def test_a_fault_after_a_new_state_is_the_models_own(
    small_spec: Tree, output: Path, steps: Any
) -> None:
    steps(7)
    with pytest.raises(rb.SolverError, match="killed"):
        rb.run(small_spec, output=output)
    steps(10)

    def fail(news: runner.Progress) -> None:
        if news.done == 9:
            raise ZeroDivisionError("of the listener")

    with pytest.raises(ZeroDivisionError, match="of the listener"):
        rb.run(small_spec, output=output, progress=fail)


def test_checkpoints_of_committed_tasks_go_at_the_next_start(
    small_spec: Tree, output: Path, steps: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after a kill between the commit of the shard and the end of its checkpoint."""
    steps(7)
    with pytest.raises(rb.SolverError, match="killed"):
        rb.run(small_spec, output=output)
    folder = RunFolder(output)
    (path,) = folder.path.glob("checkpoints/*.npz")
    other = path.with_name(path.name.replace("-0-", "-1-"))  # of a task that is not done
    shutil.copy(path, other)
    steps(10)
    with monkeypatch.context() as patch:
        patch.setattr(Checkpoint, "remove", lambda _: None)
        rb.run(small_spec, output=output)
    assert path.exists()
    rb.run(small_spec, output=output)
    assert not path.exists()
    assert other.exists()
    runner.clean(output, unused=True)
    assert other.exists()  # its key is in use


def test_clean_takes_checkpoints_that_nothing_needs(small_spec: Tree, output: Path) -> None:
    rb.run(small_spec, output=output)
    kept = RunFolder(output).path / "checkpoints" / f"{'0' * 20}-0-abc.npz"
    kept.write_bytes(b"x")
    runner.clean(output, unused=True)
    assert not kept.exists()
    assert runner.status(output).state == "complete"


# -- notes ---------------------------------------------------------------------------------


@pytest.fixture
def finished(small_spec: Tree, output: Path) -> RunFolder:
    rb.run(small_spec, output=output)
    return RunFolder(output)


@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_a_damaged_request_deletes_nothing(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    if not _runs:
        output = tmp_path_factory.mktemp("request") / "r.h5"
        rb.run(SPEC, output=output)
        _runs.append((RunFolder(output), (RunFolder(output).path / "run.json").read_bytes()))
    folder, original = _runs[0]
    spoilt = damaged(data, original)
    path = folder.path / "run.json"
    path.write_bytes(spoilt)
    before = sorted(folder.path.glob("shards/*/*"))
    assert len(before) == 2
    try:
        same = json.loads(spoilt) == json.loads(original)
    except ValueError:
        same = False
    if same:  # the layout of JSON
        runner.clean(folder.results, unused=True)
    else:
        with pytest.raises(rb.RoughbenchError, match=r"run\.json is missing or damaged"):
            runner.clean(folder.results, unused=True)
        with pytest.raises(rb.RoughbenchError, match=r"run\.json is missing or damaged"):
            runner.status(folder.results)
    assert sorted(folder.path.glob("shards/*/*")) == before


SPEC: Tree = {
    "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
    "pressures": [1e-3, 1e-2],
    "realizations": 3,
    "models": [{"kind": "foundation", "springs": 128}, {"kind": "persson"}],
}
_runs: list[tuple[RunFolder, bytes]] = []


def test_clean_keeps_what_the_last_run_needed_whatever_the_code_says_now(
    finished: RunFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("roughbench.rundir.identity.code_digest", lambda _: "f" * 12)
    assert runner.clean(finished.results, unused=True) == 0


@pytest.mark.parametrize("name", ["run.json", "provenance.json"])
def test_damaged_notes_are_told(finished: RunFolder, name: str) -> None:
    path = finished.path / name
    text = path.read_text()
    path.write_text(text.replace("7", "8"))
    sound, faults = runner.verify(finished.results)
    assert faults[0] == f"{path}: is damaged; the next run writes it again"
    path.write_text("[" * 100_000)
    assert runner.verify(finished.results)[1][0].startswith(f"{path}: is damaged")
    path.write_text(text)
    assert runner.verify(finished.results) == (3, [])
    assert sound == 3


def test_the_next_run_writes_damaged_notes_again(finished: RunFolder, small_spec: Tree) -> None:
    data = finished.results.read_bytes()
    for name in ("run.json", "provenance.json"):
        (finished.path / name).write_text("{}")
    rb.run(small_spec, output=finished.results)
    assert finished.results.read_bytes() == data
    assert runner.verify(finished.results) == (3, [])
    assert runner.status(finished.results).state == "complete"


# -- the results file ----------------------------------------------------------------------


def another(finished: RunFolder, small_spec: Tree) -> None:
    other = finished.results.with_name("other.h5")
    rb.run(small_spec | {"seed": 9}, output=other)
    shutil.copy(other, finished.results)


def empty(finished: RunFolder, _: Tree) -> None:
    finished.results.write_bytes(b"")


def gone(finished: RunFolder, _: Tree) -> None:
    finished.results.unlink()


def folder_instead(finished: RunFolder, _: Tree) -> None:
    finished.results.unlink()
    finished.results.mkdir()


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (another, "is not the file that the run has written"),
        (empty, "is empty, or no file"),
        (gone, "is not there"),
        (folder_instead, "is empty, or no file"),
    ],
)
def test_results_that_are_not_the_runs_are_seen(
    finished: RunFolder, small_spec: Tree, spoil: Any, fault: str
) -> None:
    assert runner.status(finished.results).note == ""
    spoil(finished, small_spec)
    state = runner.status(finished.results)
    assert (state.state, state.done) == ("incomplete", 63)
    assert state.note.startswith(f"{finished.results}: {fault}; the same command writes")
    sound, faults = runner.verify(finished.results)
    assert sound == 2
    assert len(faults) == (spoil is not gone)
    if spoil is folder_instead:
        return
    rb.run(small_spec, output=finished.results)
    assert runner.verify(finished.results) == (3, [])
    assert runner.status(finished.results).state == "complete"


def test_a_folder_of_shards_that_cannot_be_read_is_told(finished: RunFolder) -> None:
    keys = sorted((finished.path / "shards").iterdir())
    shutil.rmtree(keys[0])
    keys[0].write_text("no folder")
    sound, faults = runner.verify(finished.results)
    assert sound == 2
    assert len(faults) == 1
    assert faults[0].startswith(f"cannot read the folder {keys[0]}: Not a directory; ")
    with pytest.raises(rb.StoreError, match="cannot read the folder"):
        runner.status(finished.results)
    shutil.rmtree(finished.path / "shards")
    (finished.path / "shards").write_text("no folder")
    assert "shards: Not a directory" in runner.verify(finished.results)[1][0]
