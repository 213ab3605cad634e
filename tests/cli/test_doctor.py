"""What a machine offers: told, and what a run would miss, with a remedy."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest

from roughbench.models.winkler import Winkler
from roughbench.planning.resources import largest_grid, resource_limits
from roughbench.runner import doctor, dry_run
from roughbench.runner.doctor import FolderState, diagnose, folder_state
from roughbench.runner.speed import Speeds
from roughbench.transform import fft_backend
from tests.cli.conftest import SPEC, Invoke


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Time small transforms, whose plans take no time."""
    monkeypatch.setattr(doctor, "_POINTS", 32)


def test_a_machine_and_a_spec_in_words(folder: Path, invoke: Invoke) -> None:
    text = SPEC.replace("  - kind: foundation\n    springs: 128\n", "")
    (folder / "persson.yaml").write_text(text)
    done = invoke("doctor", "persson.yaml")
    assert done.exit_code == 0, done.output
    for word in ("python ", "numpy ", "cores ", "memory ", "up to ", "FFT ", "knows locks"):
        assert word in done.stdout
    assert "spec         1 tasks, about" in done.stdout
    found = json.loads(invoke("doctor", "--json").stdout)
    assert found["largest_grid"] >= 256
    assert found["cores"] >= 1
    assert found["estimate"] is None
    assert found["faults"] == []
    assert found["transform_seconds"]["1"] > 0.0
    assert found["transforms"] == fft_backend()
    assert f"FFT          {fft_backend()}: " in done.stdout
    assert [path.name for path in folder.iterdir() if "doctor" in path.name] == []


@pytest.mark.usefixtures("folder")
def test_a_spec_that_cannot_be_read_is_named(invoke: Invoke) -> None:
    done = invoke("doctor", "none.yaml")
    assert (done.exit_code, "none.yaml: error: no such file" in done.stderr) == (2, True)


def test_what_a_run_would_miss_comes_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: Path, invoke: Invoke
) -> None:
    found = diagnose()
    bare = FolderState(tmp_path, writable=True, locks=False, free=1)
    gone = FolderState(tmp_path, writable=False, locks=None, free=0)
    without = dataclasses.replace(found, cache=bare, working=bare)
    assert [fault.partition(": ")[2][:12] for fault in without.faults] == [
        "start no two",
        "processes th",
    ]
    closed = dataclasses.replace(found, cache=gone, working=gone)
    assert ["cannot be written" in fault for fault in closed.faults] == [True, True]
    monkeypatch.setattr("roughbench.runner.doctor.try_lock", lambda _: None)
    assert folder_state(tmp_path).locks is False
    (folder / "file").write_text("")
    assert folder_state(folder / "file" / "below") == FolderState(
        folder / "file" / "below", writable=False, locks=None, free=0
    )
    monkeypatch.setattr("roughbench.runner.doctor.folder_state", lambda _: gone)
    done = invoke("doctor")
    assert done.exit_code == 1
    assert "warning: " in done.stdout


def test_an_estimate_shares_the_work_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limits = resource_limits()
    start = 0.5
    monkeypatch.setattr(Speeds, "starting", lambda *_: [start])
    monkeypatch.setattr(Speeds, "slowness", lambda *_: 1.0)
    found = dry_run.estimate(folder / "small.yaml")
    computing = found.core_seconds - start
    assert computing > 0.0
    assert computing / limits.cores <= found.seconds - start <= computing
    monkeypatch.setattr(Speeds, "slowness", lambda *_: 3.0)
    slower = dry_run.estimate(folder / "small.yaml")
    assert slower.core_seconds - start == pytest.approx(3.0 * computing)


def test_the_largest_grid_is_what_fits() -> None:
    model = Winkler()
    fits = largest_grid(model, 2**31)
    assert 300 * 2**20 + model.memory(fits**2) <= 2**31
    assert 300 * 2**20 + model.memory(4 * fits**2) > 2**31
    assert largest_grid(model, 1000) == 0
