"""Transforms against NumPy's, and the care taken of FFTW's plans."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench import transform as transform_module
from roughbench.transform import FEWEST_POINTS, RealTransform, cache_folder, plans, wisdom

SHAPES = [
    *((1, n) for n in (2, 3, 4, 16, 17, 1000)),
    *((2, 2), (2, 3), (3, 2), (8, 8), (7, 9), (9, 8), (16, 10), (30, 31), (64, 64)),
]
PRECISIONS = [(np.float64, 1e-14), (np.float32, 1e-6)]


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep these plans out of the user's cache."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("ROUGHBENCH_CACHE", str(folder))
    return folder


@pytest.fixture(params=["pyfftw", "scipy"])
def _backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROUGHBENCH_FFT", request.param)


@pytest.mark.usefixtures("_backend")
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("dtype", "error"), PRECISIONS)
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_forward_and_backward_are_those_of_numpy(
    shape: tuple[int, int], dtype: type, error: float, threads: int, rng: np.random.Generator
) -> None:
    transform = RealTransform(shape, dtype, threads)
    values: NDArray[np.floating] = rng.standard_normal(shape).astype(dtype)
    transform.real[...] = values
    np.testing.assert_array_equal(transform.real, values)
    transform.forward()
    expected = np.fft.rfft2(values.astype(np.float64))
    size = float(np.abs(expected).max())
    np.testing.assert_allclose(transform.spectral, expected, rtol=0, atol=error * size)
    transform.backward()
    np.testing.assert_allclose(
        transform.real, values.size * values, rtol=0, atol=10 * error * values.size
    )


@pytest.mark.usefixtures("_backend")
@pytest.mark.parametrize(("dtype", "_error"), PRECISIONS)
def test_one_buffer_of_the_right_shapes(dtype: type, _error: float) -> None:
    transform = RealTransform((6, 9), dtype)
    assert transform.shape == transform.real.shape == (6, 9)
    assert transform.spectral.shape == (6, 5)
    assert transform.dtype == transform.real.dtype == dtype
    assert transform.spectral.dtype == np.result_type(dtype, np.complex64)
    assert np.shares_memory(transform.real, transform.spectral)
    assert (transform.real == 0).all()  # measured plans leave nothing behind
    assert (transform.spectral == 0).all()


@pytest.mark.parametrize(("dtype", "error"), PRECISIONS)
@pytest.mark.parametrize(
    ("shape", "threads", "fewest"),
    [((512, 300), 2, FEWEST_POINTS), ((401, 43), 3, 17_000), ((2, 7000), 2, 14_000)],
)
def test_threads_share_the_work_on_large_fields(
    shape: tuple[int, int],
    threads: int,
    fewest: int,
    dtype: type,
    error: float,
    rng: np.random.Generator,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """To plan long odd lines takes long: of these shapes less is called large."""
    monkeypatch.setattr(transform_module, "FEWEST_POINTS", fewest)
    assert shape[0] * shape[1] >= fewest
    transform = RealTransform(shape, dtype, threads)
    values: NDArray[np.floating] = rng.standard_normal(shape).astype(dtype)
    transform.real[...] = values
    transform.forward()
    expected = np.fft.rfft2(values.astype(np.float64))
    size = float(np.abs(expected).max())
    np.testing.assert_allclose(transform.spectral, expected, rtol=0, atol=error * size)
    busy = {thread.name for thread in threading.enumerate()}
    transform.backward()
    np.testing.assert_allclose(
        transform.real, values.size * values, rtol=0, atol=10 * error * values.size
    )
    assert len(busy) > 1  # the pool's threads are there


def test_two_transforms_share_nothing(rng: np.random.Generator) -> None:
    one, other = RealTransform((8, 8), np.float64), RealTransform((8, 8), np.float64)
    values = rng.standard_normal((8, 8))
    one.real[...] = values
    other.real[...] = 1.0
    other.forward()
    np.testing.assert_array_equal(one.real, values)


def test_plans_are_kept(own_cache: Path) -> None:
    RealTransform((12, 10), np.float64)
    kept = own_cache / "fftw-wisdom.json"
    parts = json.loads(kept.read_text())
    assert len(parts) == 3  # double, single, long double
    before = kept.stat().st_mtime_ns, kept.read_bytes()
    RealTransform((12, 10), np.float64)
    assert (kept.stat().st_mtime_ns, kept.read_bytes()) == before
    RealTransform((11, 10), np.float32)
    assert kept.read_bytes() != before[1]
    assert [path.name for path in own_cache.glob("*.tmp")] == []


@pytest.mark.parametrize(
    "spoilt",
    [
        b"",
        b"[",
        b"[1, 2, 3]",
        b'"text"',
        b"\xff\xfe",
        b"null",
        b'["QUJD", "QUJD", "QUJD"]',  # three parts, none of them wisdom
        b"{}",
        b'["%%%"]',
    ],
)
def test_spoilt_wisdom_is_measured_anew(
    own_cache: Path, spoilt: bytes, rng: np.random.Generator
) -> None:
    own_cache.mkdir()
    kept = own_cache / "fftw-wisdom.json"
    kept.write_bytes(spoilt)
    transform = RealTransform((10, 14), np.float64)
    values = rng.standard_normal((10, 14))
    transform.real[...] = values
    transform.forward()
    np.testing.assert_allclose(transform.spectral, np.fft.rfft2(values), rtol=0, atol=1e-13)
    assert len(json.loads(kept.read_text())) == 3


def test_without_a_writable_cache_plans_are_measured_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not even root can make a folder in a file."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("ROUGHBENCH_CACHE", str(tmp_path / "file" / "cache"))
    transform = RealTransform((6, 6), np.float64)
    transform.real[...] = 2.0
    transform.forward()
    assert transform.spectral[0, 0] == 72.0


def test_place_of_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.setenv("ROUGHBENCH_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "roughbench"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "roughbench"


PROGRAM = """\
import hashlib, sys
assert "pyfftw" not in sys.modules
import numpy as np
from roughbench.transform import RealTransform
assert "pyfftw" not in sys.modules
transform = RealTransform((420, 426), np.float64, threads=2)
transform.real[...] = np.random.default_rng(0).standard_normal((420, 426))
transform.forward()
transform.backward()
print(hashlib.sha256(transform.real.tobytes()).hexdigest())
"""


def test_processes_that_start_together_use_the_same_plans() -> None:
    """The first measures, the others wait for it and take what it kept.

    Also: pyFFTW loads only where it is needed.
    """
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[1])}
    command = [sys.executable, "-c", PROGRAM]
    running = [
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
        for _ in range(3)
    ]
    printed = [process.communicate()[0].strip() for process in running]
    assert [process.returncode for process in running] == [0, 0, 0]
    assert len(set(printed)) == 1
    assert len(printed[0]) == 64


# -- locks, and what takes long --------------------------------------------------------------

HOLDER = """\
import fcntl, os, sys, time
file = open(sys.argv[1], "a")
fcntl.flock(file, fcntl.LOCK_EX)
print("held", flush=True)
while True:
    time.sleep(0.1)
    if sys.argv[2] == "alive":
        os.utime(file.fileno())
"""
SLOW = 0.3


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wisdom, "PATIENCE", 1.0)
    monkeypatch.setattr(wisdom, "SILENCE", SLOW)
    monkeypatch.setattr(wisdom, "_said", set())


@pytest.fixture
def hold(own_cache: Path) -> Iterator[Callable[[str], subprocess.Popen[str]]]:
    holders: list[subprocess.Popen[str]] = []

    def start(how: str) -> subprocess.Popen[str]:
        own_cache.mkdir(exist_ok=True)
        command = [sys.executable, "-c", HOLDER, str(own_cache / "fftw-wisdom.lock"), how]
        holder = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        holders.append(holder)
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        return holder

    yield start
    for holder in holders:
        holder.kill()
        holder.communicate()


def transforms_right(shape: tuple[int, int] = (6, 8)) -> None:
    transform = RealTransform(shape, np.float64)
    transform.real[...] = 2.0
    transform.forward()
    assert transform.spectral[0, 0] == 2.0 * shape[0] * shape[1]


@pytest.mark.usefixtures("quick")
def test_plans_that_somebody_keeps_locked_are_not_waited_for_for_ever(
    own_cache: Path,
    hold: Callable[[str], subprocess.Popen[str]],
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Two lines are said, once; then the process goes on with plans of its own."""
    hold("idle")
    start = time.monotonic()
    transforms_right((6, 8))
    assert 1.0 <= time.monotonic() - start < 10.0
    start = time.monotonic()
    transforms_right((6, 10))
    transforms_right((6, 12))
    assert time.monotonic() - start < 1.0
    told = [record.getMessage() for record in caplog.records]
    assert len(told) == 2
    assert told[0].startswith("waiting for another process that measures FFTW's plans")
    assert "locked; going on with plans of this one's own" in told[1]
    assert not (own_cache / "fftw-wisdom.json").exists()


@pytest.mark.usefixtures("quick")
def test_a_process_that_goes_on_measuring_is_waited_for(
    own_cache: Path, hold: Callable[[str], subprocess.Popen[str]]
) -> None:
    holder = hold("alive")
    threading.Timer(2.5, holder.kill).start()
    start = time.monotonic()
    transforms_right()
    assert time.monotonic() - start > 2.0  # longer than the patience
    assert (own_cache / "fftw-wisdom.json").exists()


@pytest.mark.usefixtures("quick")
def test_long_planning_is_said_once_and_shows_life(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    plan = plans.make_plan
    stamps = []

    def slow(*args: Any, **options: Any) -> Any:
        time.sleep(2.5 * SLOW)
        stamps.append((own_cache / "fftw-wisdom.lock").stat().st_mtime_ns)
        return plan(*args, **options)

    monkeypatch.setattr(transform_module, "make_plan", slow)
    transforms_right((1, 16))
    transforms_right((1, 18))
    told = [record.getMessage() for record in caplog.records]
    assert len(told) == 1
    assert told[0].startswith(
        "measuring FFTW's plans for 16 points, once on this machine; that"
    )
    assert caplog.records[0].name == "roughbench.run.plans"  # with the log of a run
    assert len(set(stamps)) == len(stamps)


@pytest.mark.parametrize("fault", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL])
@pytest.mark.usefixtures("quick")
def test_where_locks_do_not_work_plans_are_kept_all_the_same(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch, fault: int
) -> None:
    def flock(*_: object) -> None:
        raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr(fcntl, "flock", flock)
    start = time.monotonic()
    transforms_right()
    assert time.monotonic() - start < SLOW + 5.0
    assert len(json.loads((own_cache / "fftw-wisdom.json").read_text())) == 3


@pytest.mark.parametrize("name", ["fftw-wisdom.lock", "fftw-wisdom.json"])
@pytest.mark.usefixtures("quick")
def test_a_link_in_the_cache_overwrites_nothing(
    own_cache: Path, tmp_path: Path, name: str
) -> None:
    precious = tmp_path / "precious"
    precious.write_text("words")
    own_cache.mkdir()
    (own_cache / name).symlink_to(precious)
    transforms_right((6, 14))
    assert precious.read_text() == "words"


def test_a_lock_file_keeps_what_is_in_it(own_cache: Path) -> None:
    own_cache.mkdir()
    lock = own_cache / "fftw-wisdom.lock"
    lock.write_text("words")
    transforms_right((6, 16))
    assert lock.read_text() == "words"
