"""A results file that cannot be written is an error, wherever the disk ends, and no crash."""

from __future__ import annotations

import io
import os
import resource
import subprocess
import sys
import weakref
from pathlib import Path

import h5py
import numpy as np
import pytest

from roughbench import store
from roughbench.errors import StoreError
from roughbench.results import MadeWhenAsked, ModelResult, Results
from roughbench.seal import seal
from roughbench.sink import Sink
from roughbench.store import load, opened, write_results
from tests.test_store import assert_equal, model_result, results

FULL = """
import io, sys
from roughbench import store
from roughbench.store.writing import write_file
from tests.test_store import results

class Full(io.BytesIO):
    def __init__(self, room):
        super().__init__()
        self.room = room
    def write(self, data):
        if self.tell() + memoryview(data).nbytes > self.room:
            raise OSError(28, "No space left on device")
        return super().write(data)

whole = len(store.image(results()))
told = 0
for room in [*range(0, whole, 997), whole - 1]:
    try:
        write_file(results(), Full(room))
    except OSError as error:
        assert error.errno == 28, error
        told += 1
print(told, len([*range(0, whole, 997)]) + 1)
"""


def test_a_disk_that_is_full_anywhere_is_told_and_nothing_crashes() -> None:
    """In a process of its own: HDF5 would end it."""
    root = Path(store.__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", FULL],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(root)},
    )
    assert done.returncode == 0, done.stderr
    told, expected = done.stdout.split()
    assert told == expected


LIMITED = """
import sys
from roughbench.errors import StoreError
from roughbench.seal import seal
from roughbench.store import write_results
from tests.test_store import results

try:
    write_results(results(shift=9.0), sys.argv[1])
except StoreError as error:
    print(error)
"""


@pytest.mark.usefixtures("no_bytecode")
@pytest.mark.parametrize("size", [100, 5_000, 60_000])
def test_a_limit_on_files_leaves_the_old_one(tmp_path: Path, size: int) -> None:
    path = write_results(results(), tmp_path / "r.h5")
    root = Path(store.__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, path],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(root)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"cannot write {path}: File too large")
    assert_equal(load(path), results())
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.h5"]


DISTURBED = """
import random, signal
from roughbench import store
from tests.test_store import results

class Stop(Exception):
    pass

def stop(*_):
    raise Stop

signal.signal(signal.SIGALRM, stop)
whole, stopped = store.image(results()), 0
chosen = random.Random(1)
for _ in range(300):
    try:
        signal.setitimer(signal.ITIMER_REAL, chosen.uniform(1e-4, 0.06))
        assert store.image(results()) == whole
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    except Stop:
        stopped += 1
assert store.image(results()) == whole
print(stopped)
"""


def test_a_signal_waits_until_hdf5_has_written() -> None:
    """What a handler raises in the middle would go through HDF5, and leave its file open."""
    root = Path(store.__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", DISTURBED],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(root)},
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) > 50


def test_a_refusal_counts_once_and_for_all() -> None:
    class Refusing(io.BytesIO):
        def write(self, _: object) -> int:
            raise OSError(5, "Input/output error")

    sink = Sink(Refusing())
    sink.check()
    assert sink.write(b"four") == 4
    buffer = bytearray(b"xxx")
    assert (sink.readinto(buffer), bytes(buffer)) == (3, b"\0\0\0")
    sink.flush()
    with pytest.raises(OSError, match="Input/output error"):
        sink.check()


def test_the_results_of_one_model_at_a_time_are_in_memory(tmp_path: Path) -> None:
    """While the next are made, those before are gone."""
    alive: list[weakref.ref[ModelResult]] = []

    def make() -> ModelResult:
        assert [one for one in alive if one() is not None] == []
        made = model_result()
        made = _Watched(made.label, made.kind, made.title, made.attributes, made.variables)
        alive.append(weakref.ref(made))
        return made

    models = MadeWhenAsked(dict.fromkeys(("bem", "again", "third"), make))
    assert len(models) == 3
    path = write_results(Results({"main": models}, "", ""), tmp_path / "r.h5")
    assert len(alive) == 3
    assert [*load(path)["main"]] == ["bem", "again", "third"]


class _Watched(ModelResult):
    __slots__ = ("__weakref__",)


def test_variables_are_read_when_asked_for(tmp_path: Path) -> None:
    path = write_results(results(), tmp_path / "r.h5")
    with opened(path) as content:
        assert_equal(content, results())
        bem = content["qr=8"]["aa"]
        np.testing.assert_array_equal(bem["area"], model_result("aa", 5)["area"])
    with pytest.raises(StoreError, match="damaged"):
        bem["area"]


def test_a_damage_is_named_when_it_is_met(tmp_path: Path) -> None:
    path = write_results(results(), tmp_path / "r.h5")
    with h5py.File(path) as file:
        place = file["qr=8/aa/area"].id.get_chunk_info(0).byte_offset
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(seal(bytes(data)))
    with opened(path) as content:
        assert content["qr=8"]["zz"]["area"].size == 6
        with pytest.raises(StoreError, match=r"r\.h5: damaged"):
            content["qr=8"]["aa"]["area"]
