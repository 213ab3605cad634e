"""The figure of a measured surface."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from roughbench.figures import available, render
from roughbench.results import Results
from tests.figures.conftest import Draw, Make
from tests.recorded import FIT, SIZE, a_record, with_record

Collect = Callable[..., Results]


@pytest.fixture
def scanned(make: Make, collect: Collect) -> Results:
    return with_record(collect(make("bem")), "main", a_record())


def lines(figure: Figure) -> dict[str | None, np.ndarray]:
    return {
        line.get_gid(): np.asarray(line.get_xydata())
        for axes in figure.axes
        for line in axes.get_lines()
    }


def test_it_shows_the_map_in_its_size(scanned: Results, draw: Draw) -> None:
    figure = draw(scanned, "surface")
    axes = figure.axes[0]
    [image] = axes.get_images()
    assert list(image.get_extent()) == pytest.approx([0, SIZE[1] * 1e6, 0, SIZE[0] * 1e6])
    np.testing.assert_allclose(np.asarray(image.get_array()), a_record().heights * 1e9)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (µm)", "y (µm)")
    assert axes.get_title(loc="left") == "(a)  plate.al3d"
    [note] = [text for text in (figure.get_supxlabel(),) if text]
    assert note == "$S_q$ = 82 nm, $S_{dq}$ = 0.12, 1 warning in the report"


def test_spectrum_and_law_are_in_the_units_of_the_axes(scanned: Results, draw: Draw) -> None:
    figure = draw(scanned, "surface")
    drawn = lines(figure)
    q, power = a_record().spectrum
    np.testing.assert_allclose(drawn["measured"][:, 0], q * 1e-6)
    ratio = drawn["measured"][:, 1] / power
    np.testing.assert_allclose(ratio, ratio[0])
    assert drawn["law"][0, 0] == pytest.approx(FIT["q0"] * 1e-6)
    assert drawn["law"][-1, 0] == pytest.approx(FIT["q1"] * 1e-6)
    assert figure.axes[1].get_xlabel() == "wavevector $q$ (1/µm)"
    heights = drawn["heights"]
    assert float(trapezoid(heights[:, 1], heights[:, 0])) == pytest.approx(1.0, abs=0.01)


def test_without_a_law_the_spectrum_stands_alone(scanned: Results, draw: Draw) -> None:
    alone = with_record(scanned, "main", a_record(fit=None, parameters={}, warnings=()))
    assert "law" not in lines(draw(alone, "surface"))


def test_only_measured_surfaces_have_it(scanned: Results, make: Make, collect: Collect) -> None:
    assert available(scanned)[0] == "surface"
    assert "surface" not in available(collect(make("bem")))


def test_it_is_drawn_the_same_every_time(scanned: Results, tmp_path: Path) -> None:
    first = [path.read_bytes() for path in render(scanned, "surface", tmp_path / "a")]
    assert first == [path.read_bytes() for path in render(scanned, "surface", tmp_path / "b")]
