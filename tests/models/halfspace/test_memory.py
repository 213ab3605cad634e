"""The exact solver refuses a grid that does not fit, and says what would."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roughbench as rb
from roughbench.memory import available_memory
from roughbench.models.halfspace import memory


@pytest.fixture
def meminfo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "meminfo"
    path.write_text("MemTotal: 900 kB\nMemAvailable:   1000 kB\n")
    monkeypatch.setattr(rb.memory, "_PROC", tmp_path)
    monkeypatch.setattr("roughbench.system._PROC", tmp_path)
    return path


@pytest.mark.usefixtures("meminfo")
def test_a_grid_that_does_not_fit_is_refused_with_numbers() -> None:
    assert available_memory() == rb.memory.AvailableMemory(1000 * 1024)
    message = (
        "the exact solver needs up to 0.0 GB for 40000 points, and 0.0 GB are available; "
        "a grid of 152 × 152 points would fit"
    )
    with pytest.raises(rb.SolverError) as caught:
        rb.solve_contact(np.zeros((200, 200)), 0.1)
    assert str(caught.value) == message
    assert rb.solve_contact(np.zeros((152, 152)), 0.1).area_fraction == 1.0


@pytest.mark.usefixtures("meminfo")
def test_double_precision_needs_more_and_says_so() -> None:
    memory.check((152, 152), double=False)
    with pytest.raises(rb.SolverError, match="119 × 119 points would fit, and so may"):
        memory.check((152, 152), double=True)


@pytest.mark.usefixtures("meminfo")
def test_a_line_is_counted_in_points() -> None:
    with pytest.raises(rb.SolverError, match="; 23272 points would fit"):
        memory.check((30000,), double=False)


@pytest.mark.parametrize("text", ["", "MemAvailable:\n", "MemAvailable: many kB\n"])
def test_a_system_that_does_not_say_is_trusted(meminfo: Path, text: str) -> None:
    meminfo.write_text(text)
    assert available_memory() is None
    memory.check((10**6, 10**6), double=True)


@pytest.mark.usefixtures("meminfo")
def test_the_advice_is_only_what_helps() -> None:
    """Precision: mixed does not, where the tolerance asks for float64."""
    heights = np.zeros((150, 150))
    told = []
    for options in (
        {"precision": "double"},
        {"tolerance": 1e-8},
        {"tolerance": 1e-8, "precision": "double"},
    ):
        with pytest.raises(rb.SolverError) as caught:
            rb.solve_contact(heights, 0.1, **options)
        told.append(str(caught.value).partition("would fit")[2])
    assert told == [
        ", and so may precision: mixed",
        ", and so may tolerance: 2e-07",
        ", and so may precision: mixed with tolerance: 2e-07",
    ]
    with pytest.raises(rb.SolverError, match=r"would fit$"):  # nothing but a smaller grid
        rb.solve_contact(np.zeros((160, 160)), 0.1, precision="double")
    rb.solve_contact(np.zeros((150, 150), np.float32), 0.1)
    with pytest.raises(rb.SolverError, match="140 × 140 points would fit"):  # a copy as well
        rb.solve_contact(np.zeros((150, 150), np.int16), 0.1)
