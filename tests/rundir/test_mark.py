"""Run directories bear a mark: what has none is neither filled nor removed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import roughbench as rb
from roughbench.rundir import mark
from roughbench.runner import clean


@pytest.fixture
def output(small_spec: dict[str, Any], tmp_path: Path) -> Path:
    """Return the results file of a run."""
    small_spec["models"] = [{"kind": "persson"}]
    rb.run(small_spec, output=tmp_path / "r.h5")
    return tmp_path / "r.h5"


def test_a_run_directory_says_what_it_is(output: Path) -> None:
    folder = output.with_name("r.h5.rbrun")
    assert mark.is_marked(folder)
    text = (folder / "README.txt").read_text()
    assert text.startswith("This is a run directory of roughbench.\n")
    assert clean(output) > 0
    assert not folder.exists()


@pytest.mark.parametrize("file", ["photo.jpg", "README.txt", "sub/photo.jpg", "shards.txt"])
def test_a_folder_of_somebody_else_is_left_alone(
    tmp_path: Path, small_spec: dict[str, Any], file: str
) -> None:
    photo = tmp_path / "photos.rbrun" / file
    photo.parent.mkdir(parents=True)
    photo.write_text("mine")
    for unused in (False, True):
        with pytest.raises(rb.RoughbenchError, match=r"photos\.rbrun does not say in README"):
            clean(tmp_path / "photos", unused=unused)
    with pytest.raises(rb.StoreError, match=r"is no run directory .* it holds '.*'; choose"):
        rb.run(small_spec, output=tmp_path / "photos")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [photo]
    assert photo.read_text() == "mine"


def test_a_run_directory_that_lost_its_mark_gets_it_back(
    output: Path, small_spec: dict[str, Any]
) -> None:
    folder = output.with_name("r.h5.rbrun")
    (folder / "README.txt").unlink()
    with pytest.raises(rb.RoughbenchError, match="the next run writes that"):
        clean(output)
    (folder / ".run.json.17.0.tmp").write_text("{")  # of a killed process
    small_spec["models"] = [{"kind": "persson"}]
    rb.run(small_spec, output=output)
    assert clean(output) > 0
    assert not folder.exists()


def test_a_run_directory_on_another_disk_is_removed_with_its_link(
    tmp_path: Path, small_spec: dict[str, Any]
) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    link = tmp_path / "r.h5.rbrun"
    link.symlink_to(scratch)
    rb.run(small_spec, output=tmp_path / "r.h5")
    assert mark.is_marked(scratch)
    assert clean(tmp_path / "r.h5") > 0
    assert [path.name for path in tmp_path.iterdir()] == ["r.h5"]
