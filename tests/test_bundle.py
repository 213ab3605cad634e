"""The archive for a supplement: what is in it, and that its bytes depend on that alone."""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import roughbench as rb
from roughbench.bundle import BUNDLE, make_bundle, pinned, requirements
from roughbench.cli import main
from roughbench.errors import RoughbenchError
from roughbench.outputs import check_output

MODEL = """\
from typing import ClassVar, Literal
import numpy as np
import roughbench as rb

class Half(rb.Model):
    \"\"\"A/A0 = 1/2.\"\"\"
    title: ClassVar[str] = "Half"
    needs: ClassVar[str] = "line"
    kind: Literal["half"] = "half"

    def curve(self, sample, pressures):
        return rb.Curve(pressure=pressures, area=np.full_like(pressures, 0.5))
"""
SPEC = """\
name: lines
surface: {kind: file, path: ../elsewhere/line.npy, length: 1.0}
pressures: [1.0e-4, 1.0e-3]
models:
  - {kind: foundation}
  - {kind: "half.py:Half"}
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a results file of heights from elsewhere and a model in a file."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "own").mkdir()
    (folder / "elsewhere").mkdir()
    line = 0.01 * np.cos(2 * np.pi * np.arange(64) / 64)
    np.save(folder / "elsewhere" / "line.npy", line)
    (folder / "own" / "half.py").write_text(MODEL)
    (folder / "own" / "lines.yaml").write_text(SPEC)
    rb.run(folder / "own" / "lines.yaml", output=folder / "own" / "lines.h5", threads=1)
    return folder / "own" / "lines.h5"


def content(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.mark.slow
def test_a_bundle_holds_all_that_it_takes_to_compute_it_again(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["bundle", str(finished), "--figure", "area", "--resamples", "2"]
    first = CliRunner().invoke(main, words)
    assert (first.exit_code, first.output) == (0, "lines-bundle.zip\n")
    found = content(tmp_path / "lines-bundle.zip")
    names = {name.removeprefix("lines/") for name in found}
    assert names == {
        *("lines.h5", "spec.yaml", "half.py", "inputs/line.npy", "figures/area.pdf"),
        *("figures/area.png", "report.html", "environment.json", "requirements.txt"),
        *("README.txt", "SHA256SUMS"),
    }
    assert found["lines/spec.yaml"].decode() == SPEC
    assert found["lines/lines.h5"] == finished.read_bytes()
    assert b"looks for it at ../elsewhere/line.npy" in found["lines/README.txt"]
    sums = dict(
        line.split("  ")[::-1]
        for line in found["lines/SHA256SUMS"].decode().split("\n")
        if line
    )
    assert set(sums) == names - {"SHA256SUMS"}
    for name, digest in sums.items():
        assert hashlib.sha256(found[f"lines/{name}"]).hexdigest() == digest
    environment = json.loads(found["lines/environment.json"])
    assert environment["computed_with"]["main/half"]["numpy"] == np.__version__
    assert "host" not in str(environment)
    assert f"numpy=={np.__version__}\n" in found["lines/requirements.txt"].decode()

    before = (tmp_path / "lines-bundle.zip").read_bytes()
    assert CliRunner().invoke(main, words).exit_code == 0
    assert (tmp_path / "lines-bundle.zip").read_bytes() == before, "bytes tell of the content"

    with zipfile.ZipFile(tmp_path / "lines-bundle.zip") as archive:
        archive.extractall(tmp_path / "there")
    (tmp_path / "there" / "elsewhere").mkdir()
    shutil.copy(tmp_path / "there/lines/inputs/line.npy", tmp_path / "there/elsewhere")
    again = ["reproduce", str(tmp_path / "there" / "lines" / "lines.h5"), "-q"]
    assert "agrees with" in CliRunner().invoke(main, again).output


def test_what_is_missing_or_in_the_way_is_named(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RoughbenchError, match="the same run needs it otherwise"):
        make_bundle(finished, finished)
    alone = shutil.copy(finished, tmp_path / "alone.h5")
    lost = CliRunner().invoke(main, ["bundle", str(alone)])
    assert lost.exit_code == 2
    assert "line.npy" in lost.output
    assert "--folder names another place" in lost.output
    (tmp_path / "mine.zip").write_bytes(b"PK mine")
    with pytest.raises(RoughbenchError, match="no bundle that roughbench wrote"):
        check_output(tmp_path / "mine.zip", BUNDLE)


def test_versions_of_the_computation_count_more_than_those_here() -> None:
    versions = pinned()
    assert {"roughbench", "numpy", "numba", "llvmlite"} <= set(versions)
    assert pinned(["no-such-package"]) == {}
    text = requirements("a.h5", {"numpy": "2.0", "click": "8.2"}, {"numpy": "1.26"})
    assert text.splitlines()[2:] == ["numpy==1.26", "click==8.2"]
