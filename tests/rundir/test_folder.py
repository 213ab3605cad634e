"""The run directory: shards that are right or refused, one run at a time, no leftovers."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughbench as rb
from roughbench.engines.compute import compute
from roughbench.errors import LockedError
from roughbench.planning.cells import Cell
from roughbench.planning.plan import plan
from roughbench.planning.tasks import Block, Task
from roughbench.publish import publish
from roughbench.rundir.folder import RunFolder
from roughbench.rundir.identity import Identity, identity, key_of
from roughbench.rundir.shards import Shard, ShardError
from roughbench.rundir.usage import Meter
from roughbench.spec import load_spec
from tests.engines.fakes import Fake


@pytest.fixture
def task(small_spec: dict[str, Any]) -> Task:
    spec = load_spec(small_spec)
    cell = Cell("main", Fake(), spec.surface, spec.pressures, 6, spec.seed)
    return Task(cell, range(2, 5), spec.pressures)


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return RunFolder(tmp_path / "r.h5")


def written(folder: RunFolder, task: Task) -> tuple[Path, Block, Identity]:
    block, its = compute(task), identity(task.cell, 1)
    with folder.locked("test"):
        return folder.write(task, block, its, Meter().read()).path, block, its


def assert_same(shard: Shard, task: Task, block: Block) -> None:
    assert (shard.realizations, shard.cell) == (range(2, 5), "main/fake")
    assert shard.pressures.tolist() == list(task.pressures)
    assert list(shard.block) == list(block)
    for name, values in block.items():
        assert shard.block[name].dtype == values.dtype
        np.testing.assert_array_equal(shard.block[name], values)


def test_a_shard_holds_its_task(folder: RunFolder, task: Task) -> None:
    path, block, its = written(folder, task)
    shard = folder.read(path)
    assert_same(shard, task, block)
    assert shard.identity == its
    assert shard.usage["seconds"] >= 0.0
    assert shard.usage["peak_memory"] > 10**7
    assert {"host", "cpu", "numpy", "pyfftw"} <= set(shard.usage["machine"])
    assert path.name.startswith("000002-000004.")
    assert folder.shards(key_of(its)) == [path]
    assert folder.computations() == [key_of(its)]


def test_the_same_task_has_the_same_numbers_in_its_shard(folder: RunFolder, task: Task) -> None:
    first, _, _ = written(folder, task)
    second, _, _ = written(folder, task)
    one, other = folder.read(first), folder.read(second)
    for name in one.block:
        np.testing.assert_array_equal(one.block[name], other.block[name])


@settings(max_examples=500, deadline=None)
@given(data=st.data())
def test_a_damaged_shard_is_named_or_right(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder, path, original, task, block = _shard(tmp_path_factory)
    bytes_ = bytearray(original)
    kind = data.draw(st.sampled_from(["change", "cut", "append", "swap"]))
    place = data.draw(st.integers(0, len(bytes_) - 1))
    if kind == "change":
        bytes_[place] = data.draw(st.integers(0, 255))
    elif kind == "cut":
        del bytes_[place:]
    elif kind == "append":
        bytes_ += data.draw(st.binary(min_size=1, max_size=20))
    else:
        half = len(bytes_) // 2
        bytes_ = bytes_[half:] + bytes_[:half]
    path.write_bytes(bytes_)
    if bytes_ == original:
        assert_same(folder.read(path), task, block)
        return
    with pytest.raises(ShardError, match="does not match the checksum") as caught:
        folder.read(path)
    assert str(caught.value).startswith(str(path))


_made: list[tuple[RunFolder, Path, bytes, Task, Block]] = []


def _shard(factory: pytest.TempPathFactory) -> tuple[RunFolder, Path, bytes, Task, Block]:
    """Make one shard for all examples."""
    if not _made:
        surface = {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1}
        spec = load_spec(
            {"surface": surface, "pressures": [0.1], "models": [{"kind": "persson"}]}
        )
        cell = Cell("main", Fake(), spec.surface, spec.pressures, 6, 1)
        task = Task(cell, range(2, 5), spec.pressures)
        folder = RunFolder(factory.mktemp("damage") / "r.h5")
        path, block, _ = written(folder, task)
        _made.append((folder, path, path.read_bytes(), task, block))
    return _made[0]


def test_foreign_shards_are_refused(folder: RunFolder, task: Task) -> None:
    path, _, _ = written(folder, task)
    other = path.parent.with_name("0" * 20)
    other.mkdir()
    moved = other / path.name
    moved.write_bytes(path.read_bytes())
    with pytest.raises(ShardError, match="belongs to another computation"):
        folder.read(moved)
    notes = other / "notes.txt"
    notes.write_text("x")
    with pytest.raises(ShardError, match=r"notes\.txt: is no shard of roughbench"):
        folder.read(notes)
    with pytest.raises(ShardError, match="cannot be read: No such file"):
        folder.read(other / "000000-000001.0123456789abcdef.npz")


def named(path: Path, data: bytes) -> Path:
    """Write a file with the checksum that it needs."""
    import hashlib

    name = f"000000-000000.{hashlib.sha256(data).hexdigest()[:16]}.npz"
    target = path / name
    target.write_bytes(data)
    return target


@pytest.mark.parametrize(
    ("arrays", "fault"),
    [
        ({"area": np.zeros((1, 1))}, "roughbench"),
        ({"meta": "else"}, "has the format 'else'"),
        ({"meta": "", "area": np.zeros((2, 1))}, r"area has the shape \(2, 1\)"),
        ({"meta": "", "area": np.zeros((1, 1), np.float16)}, "area has the shape"),
        ({"meta": ""}, "has no status"),
        ({"meta": "", "area": np.array([[object()]])}, "area claims"),
    ],
)
def test_what_looks_like_a_shard_is_not_trusted(
    folder: RunFolder, arrays: dict[str, Any], fault: str
) -> None:
    import io

    with folder.locked("test"):
        pass
    its: dict[str, str | int | float] = {"seed": 1}
    place = folder.path / "shards" / key_of(its)
    place.mkdir()
    form = arrays.pop("meta", None)
    if form is not None:
        meta = {
            "format": form or "roughbench shard 1",
            "identity": its,
            "cell": "",
            "usage": {},
        }
        arrays["roughbench"] = np.frombuffer(json.dumps(meta).encode(), np.uint8)
    image = io.BytesIO()
    np.savez(image, pressure=np.ones(1), **arrays)
    with pytest.raises(ShardError, match=fault):
        folder.read(named(place, image.getvalue()))


def test_one_run_at_a_time(folder: RunFolder) -> None:
    assert folder.holder() == {}
    with folder.locked("the first"):
        assert folder.holder()["command"] == "the first"
        with (
            pytest.raises(LockedError, match=rf"process {os.getpid()} on .* \(the first\)"),
            folder.locked("the second"),
        ):
            pass
    assert folder.holder() == {}
    with folder.locked("the third"):
        pass


def test_who_looks_who_is_there_is_not_taken_for_a_run(folder: RunFolder) -> None:
    """However many look at once, and whatever a run that was killed left in the file."""
    with folder.locked("a run"):
        pass
    (folder.path / "lock").write_text('{"process": 1, "command": "killed"}')
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda _: folder.holder(), range(200))) == [{}] * 200


@pytest.mark.parametrize("fault", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP])
def test_where_locks_do_not_work_a_run_goes_on_and_says_so(
    folder: RunFolder,
    task: Task,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    fault: int,
) -> None:
    def flock(*_: object) -> None:
        raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr(fcntl, "flock", flock)
    path, block, _ = written(folder, task)
    assert_same(folder.read(path), task, block)
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert caplog.records[0].getMessage() == (
        f"the file system of {folder.path} knows no locks: a second run with the same output "
        "would not be kept out; start none while this one works"
    )
    assert folder.holder() == {}


def test_a_link_in_place_of_the_lock_overwrites_nothing(
    folder: RunFolder, tmp_path: Path
) -> None:
    precious = tmp_path / "precious"
    precious.write_text("words")
    folder.path.mkdir()
    (folder.path / "lock").symlink_to(precious)
    with pytest.raises(rb.StoreError, match="cannot write"), folder.locked("test"):
        pass
    assert precious.read_text() == "words"


def test_a_killed_process_leaves_no_lock_and_no_leftovers(
    folder: RunFolder, task: Task
) -> None:
    folder.path.mkdir()
    code = (
        "import os, signal, sys\n"
        "from pathlib import Path\n"
        "from roughbench.publish import publish\n"
        "from roughbench.rundir.folder import RunFolder\n"
        "folder = RunFolder(sys.argv[1])\n"
        "with folder.locked('killed'):\n"
        "    die = lambda file: (file.write(b'half'), os.kill(os.getpid(), signal.SIGKILL))\n"
        "    publish(die, Path(sys.argv[2]))\n"
    )
    for target in (folder.results, folder.path / "run.json"):
        environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
        done = subprocess.run(
            [sys.executable, "-c", code, folder.results, target], check=False, env=environment
        )
        assert done.returncode == -9
        assert not target.exists()
        assert list(target.parent.glob(".*.tmp"))
    assert folder.holder() == {}
    neighbour = folder.results.with_name(".r.h5x.1.0.tmp")
    neighbour.touch()
    written(folder, task)
    assert list(folder.path.parent.rglob(".*.tmp")) == [neighbour]


def test_a_folder_that_cannot_be_written_is_an_error(folder: RunFolder) -> None:
    folder.path.touch()
    with (
        pytest.raises(rb.StoreError, match=r"cannot write .*r\.h5\.rbrun: File exists"),
        folder.locked("test"),
    ):
        pass


def test_set_aside_and_forget(folder: RunFolder, task: Task) -> None:
    path, block, its = written(folder, task)
    folder.set_aside(path)
    assert folder.shards(key_of(its)) == []
    assert [p.name for p in (folder.path / "set-aside").iterdir()] == [
        f"{key_of(its)}-{path.name}"
    ]
    again, _, _ = written(folder, task)
    assert_same(folder.read(again), task, block)
    folder.forget(key_of(its))
    assert folder.computations() == []


# -- identity ------------------------------------------------------------------------------


def identity_of(tree: dict[str, Any], threads: int = 1) -> Identity:
    spec = load_spec(tree)
    return identity(plan(spec)[0], threads)


def test_the_identity_names_what_numbers_depend_on(
    small_spec: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    its = identity_of(small_spec)
    assert its["surface.H"] == 0.7
    assert its["surface.qr"] == 4.0
    assert its["seed"] == 7
    assert its["model.kind"] == "foundation"
    assert its["model.grid"] == 128
    assert "threads" not in its  # the foundation uses one
    assert json.loads(json.dumps(its)) == its
    bem = {**small_spec, "models": [{"kind": "bem", "grid": 128}]}
    assert identity_of(bem, 2)["threads"] == 2
    assert "pressures" not in identity_of(bem)
    assert identity_of(bem)["code"] != its["code"]
    persson = identity_of({**small_spec, "models": [{"kind": "persson"}]})
    assert "seed" not in persson
    assert [one.get("fft") for one in (its, persson)] == [None, None]  # they transform nothing
    kinds = [{"kind": "line"}, {"kind": "bem", "grid": 128}]
    for backend in ("pyfftw", "scipy"):
        monkeypatch.setenv("ROUGHBENCH_FFT", backend)
        for kind in kinds:
            assert identity_of({**small_spec, "models": [kind]})["fft"] == backend
    assert "surface.amplitude" not in persson


@pytest.mark.parametrize(
    ("change", "matters"),
    [
        ({"name": "other"}, False),
        ({"realizations": 3}, False),
        ({"pressures": [0.5]}, True),
        ({"pressures": [1e-2, 1e-3, 1e-4]}, False),
        ({"models": [{"kind": "foundation", "springs": 128, "label": "x"}]}, False),
        ({"models": [{"kind": "foundation", "springs": 128, "ends": "periodic"}]}, False),
        ({"models": [{"kind": "foundation", "springs": 128, "ends": "open"}]}, True),
        ({"seed": 8}, True),
        ({"surface": {"H": 0.7, "q0": 1.0, "qr": 4.0, "q1": 31.0, "slope": 0.1}}, True),
    ],
)
def test_the_key_changes_with_the_numbers_and_only_then(
    small_spec: dict[str, Any], change: dict[str, Any], *, matters: bool
) -> None:
    before, after = identity_of(small_spec), identity_of(small_spec | change)
    assert (key_of(before) != key_of(after)) == matters


def test_heights_count_by_their_content(tmp_path: Path) -> None:
    surface = {"kind": "file", "path": str(tmp_path / "a.npy"), "length": 1.0}
    tree = {"surface": surface, "pressures": [0.1], "models": [{"kind": "foundation"}]}
    np.save(tmp_path / "a.npy", np.arange(8.0))
    one = identity_of(tree)
    np.save(tmp_path / "b.npy", np.arange(8.0))
    tree["surface"] = surface | {"path": str(tmp_path / "b.npy")}
    assert identity_of(tree) == one
    np.save(tmp_path / "b.npy", np.arange(8.0)[::-1])
    assert identity_of(tree) != one


def test_publish_leaves_nothing_behind_when_it_fails(tmp_path: Path) -> None:
    def fail(_: object) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        publish(fail, tmp_path / "x")
    assert list(tmp_path.iterdir()) == []
