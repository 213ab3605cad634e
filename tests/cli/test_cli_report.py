"""``roughbench report``: the file it writes, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from click.testing import Result

Invoke = Callable[..., Result]


def test_writes_the_page_and_prints_its_path(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    done = invoke("report", results, "--resamples", 5)
    assert done.exit_code == 0, done.stderr
    assert done.stdout == "report.html\n"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "Popov (1D foundation)" in page
    assert str(folder) not in page
    assert {path.name for path in folder.iterdir()} >= {"report.html", "small.h5"}
    assert not list(folder.glob(".*.tmp"))


def test_the_same_command_gives_the_same_bytes(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    for name, resamples in (("one.html", 6), ("one.html", 5), ("two.html", 5)):
        done = invoke("report", results, "-o", name, "--resamples", resamples)
        assert done.exit_code == 0
    assert (folder / "one.html").read_bytes() == (folder / "two.html").read_bytes()


def test_a_missing_or_damaged_file_is_named_and_nothing_is_written(
    results: Path, folder: Path, invoke: Invoke
) -> None:
    damaged = folder / "damaged.h5"
    damaged.write_bytes(results.read_bytes()[:-100])
    assert invoke("report", results, "--resamples", 5).exit_code == 0
    before = (folder / "report.html").read_bytes()
    for path, fault in ((folder / "none.h5", "no such file"), (damaged, "cut short")):
        done = invoke("report", results, path)
        assert done.exit_code == 1
        assert path.name in done.stderr
        assert fault in done.stderr
    assert (folder / "report.html").read_bytes() == before


def test_a_results_file_is_never_overwritten(results: Path, invoke: Invoke) -> None:
    before = results.read_bytes()
    done = invoke("report", results, "-o", results)
    assert done.exit_code == 2
    assert "is one of the results files" in done.stderr
    assert results.read_bytes() == before


def test_a_folder_that_is_not_there_is_made(results: Path, invoke: Invoke) -> None:
    done = invoke("report", results, "-o", "none/report.html", "--resamples", 5)
    assert (done.exit_code, done.stdout) == (0, "none/report.html\n")


def test_an_unknown_reference_and_too_few_resamples(results: Path, invoke: Invoke) -> None:
    done = invoke("report", results, "--reference", "bem")
    assert done.exit_code == 1
    assert "no model is named 'bem'" in done.stderr
    assert invoke("report", results, "--resamples", 1).exit_code == 2
    assert invoke("report").exit_code == 2
