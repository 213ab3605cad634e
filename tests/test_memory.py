"""What memory can be had, whoever limits it, and that nothing is taken before it is asked."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import memory
from roughbench import system as operating_system
from roughbench.heights_file import load_heights
from roughbench.memory import AvailableMemory, available_memory
from roughbench.models.foundation import foundation_curve
from roughbench.models.gw import counted_gw_curve
from roughbench.models.hertz_top import asperity_of_heights
from roughbench.models.winkler import winkler_curve
from roughbench.spectrum import measured_spectrum

GROUP = (
    "the memory limit of the control group: ask for more where the job or container is started"
)
FREE = 10**9


class System:
    """What /proc and /sys/fs/cgroup say."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write("proc/meminfo", f"MemFree: 1 kB\nMemAvailable: {FREE // 1000} kB\n")
        self.write("proc/self/status", "Name: x\nVmSize:\t  3000 kB\nVmData:\t  1000 kB\n")

    def write(self, name: str, text: object) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{text}\n")


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> System:
    monkeypatch.setattr(memory, "_PROC", tmp_path / "proc")
    monkeypatch.setattr(operating_system, "_PROC", tmp_path / "proc")
    monkeypatch.setattr(memory, "_CGROUP", tmp_path / "cgroup")
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY,) * 2)
    return System(tmp_path)


def test_the_free_memory_of_the_machine(system: System) -> None:
    assert available_memory() == AvailableMemory(FREE // 1000 * 1024)
    assert str(available_memory()) == "1.0 GB are available"
    system.write("proc/meminfo", "MemTotal: 3 kB")
    assert available_memory() is None


@pytest.mark.parametrize("inner", [True, False])
def test_control_groups_of_version_2(system: System, *, inner: bool) -> None:
    """The group's own limit, or that of one around it; pages of files are given up."""
    system.write("proc/self/cgroup", "0::/slurm/job7")
    system.write("cgroup/slurm/job7/memory.max", 500_000_000 if inner else "max")
    system.write("cgroup/slurm/job7/memory.current", 300_000_000)
    system.write("cgroup/slurm/job7/memory.stat", "anon 5\ninactive_file 200000000\n")
    system.write("cgroup/slurm/memory.max", "max" if inner else 600_000_000)
    system.write("cgroup/slurm/memory.current", 200_000_000)
    assert available_memory() == AvailableMemory(400_000_000, GROUP)
    system.write("cgroup/memory.max", 100)
    system.write("cgroup/memory.current", 200)
    assert available_memory() == AvailableMemory(0, GROUP)


def test_control_groups_of_version_1(system: System) -> None:
    """Also beside an empty tree of version 2, and seen from a container."""
    for path in ("/docker/abc", "/", "/../.."):
        system.write("proc/self/cgroup", f"5:cpu,cpuacct:/\n4:memory:{path}\n0::/")
        system.write("cgroup/memory/memory.limit_in_bytes", 500_000_000)
        system.write("cgroup/memory/memory.usage_in_bytes", 300_000_000)
        system.write("cgroup/memory/memory.stat", "cache 9\ntotal_inactive_file 100000000\n")
        assert available_memory() == AvailableMemory(300_000_000, GROUP)
    system.write("proc/self/cgroup", "4:memory:/docker/abc")
    system.write("cgroup/memory/docker/abc/memory.limit_in_bytes", 2**63 - 4096)
    system.write("cgroup/memory/docker/abc/memory.usage_in_bytes", 1)
    assert available_memory() == AvailableMemory(300_000_000, GROUP)
    system.write("cgroup/memory/memory.limit_in_bytes", 2**63 - 4096)
    assert available_memory() == AvailableMemory(FREE // 1000 * 1024)


@pytest.mark.parametrize("text", ["", "nonsense", "0::", "4:memory", "::\n:::"])
def test_a_system_that_says_nothing_of_groups(system: System, text: str) -> None:
    system.write("proc/self/cgroup", text)
    assert available_memory() == AvailableMemory(FREE // 1000 * 1024)


@pytest.mark.parametrize(
    ("kind", "option", "left"),
    [(resource.RLIMIT_AS, "-v", 5_000_000), (resource.RLIMIT_DATA, "-d", 7_048_000)],
)
@pytest.mark.usefixtures("system")
def test_limits_of_the_process(
    monkeypatch: pytest.MonkeyPatch, kind: int, option: str, left: int
) -> None:
    def limits(asked: int) -> tuple[int, int]:
        return (8_072_000, 9_000_000) if asked == kind else (resource.RLIM_INFINITY,) * 2

    monkeypatch.setattr(resource, "getrlimit", limits)
    assert available_memory() == AvailableMemory(
        left, f"the limit set by ulimit {option}: raise it"
    )


PROGRAM = """\
import resource
import numpy as np
import roughbench as rb
from roughbench.planning.resources import resource_limits
rb.solve_contact(np.eye(16), 0.1)
here = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (here + 300 * 2**20,) * 2)
# The end of the solver's threads may have given some back since.
assert resource_limits().memory < 0.4e9
try:
    rb.solve_contact(np.zeros((3000, 3000), np.float32), 0.1)
except rb.SolverError as error:
    print(error)
"""


def test_a_process_under_ulimit_refuses_before_it_fails() -> None:
    environment = os.environ | {"PYTHONPATH": str(Path(rb.__file__).parents[1])}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.stderr == ""
    assert "the exact solver needs up to 0.4 GB for 9000000 points, and 0." in done.stdout
    assert "GB are available (the limit set by ulimit -v: raise it); a grid of" in done.stdout


SIDE = 10**7
HUGE = np.broadcast_to(np.float64(0.5), (SIDE, SIDE))
LINE = np.broadcast_to(np.float64(0.5), (SIDE**2,))
TAKES: list[tuple[str, Any, Callable[[Any], object]]] = [
    ("solve_contact", HUGE, lambda h: rb.solve_contact(h, 1e-3)),
    (
        "whole numbers",
        np.broadcast_to(np.int8(1), HUGE.shape),
        lambda h: rb.solve_contact(h, 1e-3),
    ),
    ("solve_curve", HUGE, lambda h: rb.solve_curve(h, [1e-3])),
    ("line", LINE, lambda h: rb.solve_curve(h, [1e-3])),
    ("foundation", LINE, lambda h: foundation_curve(h, [1e-3], 1.0)),
    ("winkler", HUGE, lambda h: winkler_curve(h, [1e-3], 1.0)),
    ("gw", HUGE, lambda h: counted_gw_curve(h, [1e-3], 1.0)),
    ("hertz_top", HUGE, lambda h: asperity_of_heights(h, 1.0)),
    ("spectrum", HUGE, lambda h: measured_spectrum(h, 1.0)),
]


@pytest.mark.parametrize(
    ("heights", "take"), [case[1:] for case in TAKES], ids=[c[0] for c in TAKES]
)
def test_a_hundred_trillion_heights_are_refused_in_a_second(
    heights: Any, take: Callable[[Any], object]
) -> None:
    with pytest.raises(rb.RoughbenchError, match=r"GB are available.*points would fit"):
        take(heights)  # what is imported by the way takes longer than a second
    start = time.monotonic()
    with pytest.raises(rb.RoughbenchError, match=r"GB are available.*points would fit"):
        take(heights)
    assert time.monotonic() - start < 1.0


def test_a_file_of_many_heights_is_refused_before_it_is_read(
    tmp_path: Path, system: System
) -> None:
    np.save(tmp_path / "h.npy", np.arange(64.0).reshape(8, 8))
    system.write("proc/meminfo", "MemAvailable: 0 kB")
    with pytest.raises(rb.SurfaceError, match=r"h\.npy: to read 64 heights takes 0\.0 GB, and"):
        load_heights("h.npy", tmp_path)
    system.write("proc/meminfo", "MemAvailable: 1024 kB")
    assert load_heights("h.npy", tmp_path).shape == (8, 8)
