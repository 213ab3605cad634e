"""A results file says with what it was made, and can be verified alone."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import roughbench as rb
from roughbench.cli import main
from roughbench.rundir.folder import RunFolder, folder_of
from roughbench.rundir.identity import Identity
from roughbench.rundir.usage import machine
from roughbench.runner import made_with as making
from roughbench.runner import verify
from roughbench.runner.origins import differences, origins


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("made") / "small.h5"
    spec = {
        "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
        "pressures": [1e-3, 1e-2],
        "realizations": 5,
        "models": [{"kind": "foundation", "springs": 128}, {"kind": "persson"}],
    }
    rb.run(spec, output=path)
    return path


def test_the_file_says_with_what_it_was_made(made: Path) -> None:
    here = machine()
    with h5py.File(made) as file:
        for place in (file, file["main/foundation"]):
            said = json.loads(place.attrs["made_with"])
            for package in ("roughbench", "python", "numpy", "numba", "h5py", "platform"):
                assert said[package] == here[package]
            assert len(said["code"]) == 12
            assert not {"host", "cpu"} & set(said)
    results = rb.load(made)
    foundation = results["main"]["foundation"]
    key = RunFolder(made).provenance()["models"]["main/foundation"]["identity"]
    assert foundation.made_with["code"] == key["code"]
    assert not [name for name in foundation.attributes if name.startswith("made")]
    shown = json.loads(CliRunner().invoke(main, ["show", "--json", str(made)]).stdout)
    assert shown["made_with"] == dict(results.made_with)
    theirs = shown["experiments"]["main"]["foundation"]["made_with"]
    assert theirs == dict(foundation.made_with)


def test_shards_of_several_versions_are_all_named() -> None:
    versions = [{"numpy": "2.1", "host": "b"}, {"numpy": "1.26", "host": "a"}] * 2
    assert making._of(versions) == {"numpy": "1.26 and 2.1"}
    identity: Identity = {"model.kind": "bem", "fft": "scipy", "threads": 2, "code": "abc"}
    assert making._of_identity(identity) == {"fft": "scipy", "threads": 2, "code": "abc"}


def test_other_versions_put_the_file_together_anew(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "small.h5"
    shutil.copy(made, copy)
    shutil.copytree(folder_of(made), folder_of(copy))
    before = copy.read_bytes()
    spec = rb.load(made).spec_text
    rb.run(spec, output=copy)
    assert copy.read_bytes() == before
    other: dict[str, Any] = {**machine(), "h5py": "99.1"}
    monkeypatch.setattr(making, "machine", lambda: other)
    rb.run(spec, output=copy)
    results = rb.load(copy)
    assert results.made_with["h5py"] == "99.1"
    assert results["main"]["persson"].made_with["h5py"] == machine()["h5py"]  # as computed


def test_a_file_alone_is_verified(made: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.h5"
    shutil.copy(made, alone)
    assert verify(alone) == (1, [])
    whole = alone.read_bytes()
    rng = np.random.default_rng(3)
    for place in rng.integers(len(whole), size=20).tolist():
        spoilt = bytearray(whole)
        spoilt[place] ^= 1 << int(rng.integers(8))
        alone.write_bytes(spoilt)
        sound, faults = verify(alone)
        assert (sound, len(faults)) == (0, 1), place
        assert str(alone) in faults[0]
    alone.write_bytes(whole[: len(whole) // 2])
    done = CliRunner().invoke(main, ["verify", str(alone)])
    assert done.exit_code == 1
    assert done.stdout == "0 files are sound, 1 damaged\n"
    alone.write_text("nothing of ours")
    with pytest.raises(rb.RoughbenchError, match="is no results file, run directory or spec"):
        verify(alone)


def test_a_file_alone_says_where_it_comes_from(made: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.h5"
    shutil.copy(made, alone)
    mine, with_run = origins(alone), origins(made)
    assert mine["main/persson"]["numpy"] == machine()["numpy"]
    assert differences(mine, with_run) == []
    mine["main/persson"]["numpy"] = "1.0"
    assert differences(mine, with_run) == [f"numpy: 1.0 → {machine()['numpy']} (main/persson)"]
