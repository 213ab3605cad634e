"""What ``run(progress=True)`` shows: one line of plain text on standard error."""

from __future__ import annotations

import io
import sys
from types import ModuleType
from typing import Any

import pytest

import roughbench as rb
from roughbench.runner import bar
from roughbench.runner.bar import reported
from roughbench.runner.pace import Pace, counts_of
from roughbench.runner.progress import Progress


@pytest.mark.parametrize("in_notebook", [False, True])
def test_a_run_shows_how_far_it_is(
    small_spec: dict[str, Any],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    *,
    in_notebook: bool,
) -> None:
    if in_notebook:
        monkeypatch.setitem(sys.modules, "ipykernel", ModuleType("ipykernel"))
    rb.run(small_spec, progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    last = err.rstrip().rpartition("\r")[2]
    assert last.startswith("100%|")
    assert ", 63/63 states: main/" in last
    assert len(last) < 80
    assert "\x1b" not in err  # no cursor moves: every notebook shows it


@pytest.mark.parametrize("columns", [40, 60, 200])
def test_the_percentage_is_that_of_the_counts_and_the_line_fits(
    monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    """It was 100 % at 62999 of 63000 states, in 79 columns whatever the terminal has."""
    shown = io.StringIO()
    monkeypatch.setattr(shown, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setattr(bar, "columns_of_terminal", lambda: columns)
    with reported(True) as report:  # noqa: FBT003
        assert report is not None
        text = "main/foundation, realizations 1 to 20 of 20, pressure 3 of 20"
        report(Progress(62999, 63000, 0.3, text))
    lines = [line for line in shown.getvalue().split("\r") if line.strip()]
    assert lines[-1].startswith(" 99%|")
    assert "62999/" in lines[-1]
    assert all(len(line.rstrip("\n")) <= min(columns, 79) for line in lines)


@pytest.mark.parametrize("progress", [None, False])
def test_a_run_is_silent_unless_asked(
    small_spec: dict[str, Any], capsys: pytest.CaptureFixture[str], *, progress: bool | None
) -> None:
    rb.run(small_spec, progress=progress)
    assert capsys.readouterr() == ("", "")


def test_a_callable_is_told_as_before(small_spec: dict[str, Any]) -> None:
    message: list[Progress] = []
    rb.run(small_spec, progress=message.append)
    assert message[-1].done == 63
    assert message[-1].share == pytest.approx(1.0)


def test_the_line_ends_where_a_run_fails(capsys: pytest.CaptureFixture[str]) -> None:
    def fail() -> None:
        with reported(True) as report:  # noqa: FBT003
            assert report is not None
            report(Progress(1, 4, 0.25, "main/bem, realization 1 of 4"))
            raise ValueError("bad")

    with pytest.raises(ValueError, match="bad"):
        fail()
    assert "25%|" in capsys.readouterr().err


def test_no_time_is_left_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pace, "left", lambda _: ", 1 s left")
    assert counts_of(Progress(3, 4, 0.9, "a"), Pace(), 60) == "3/4 states, 1 s left: a"
    assert counts_of(Progress(4, 4, 1.0, "a"), Pace(), 60) == "4/4 states: a"
