"""Pictures of fields: what stands in the artists."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from roughbench.figures.observed import (
    DECADES,
    MOST_PANELS,
    ContactMap,
    Line,
    contact_maps,
    draw_contact_maps,
    draw_observable,
    observable,
)
from roughbench.figures.style import publication_style

X = np.geomspace(1.0, 100.0, 5)


def line(title: str, scale: float = 1.0, *, theory: bool = False) -> Line:
    y = scale * X**-2.0
    return Line(title, X, y, 0.1 * y, is_theory=theory)


def drawn(figure: Figure) -> Figure:
    figure.draw_without_rendering()
    return figure


def legend_words(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_curves_hold_the_values_and_keep_their_looks() -> None:
    with publication_style():
        panels = {p: [line("A"), line("B", p), line("T", theory=True)] for p in (0.1, 0.01)}
        figure = drawn(observable(panels, "q", "C"))
    assert legend_words(figure) == ["A", "B", "T"]
    for axes, pressure in zip(figure.axes, (0.01, 0.1), strict=True):
        lines = {found.get_gid(): found for found in axes.get_lines()}
        np.testing.assert_allclose(
            np.asarray(lines["B"].get_ydata(), float), pressure * X**-2.0
        )
        np.testing.assert_array_equal(lines["A"].get_xdata(), X)
        assert len(axes.collections) == 2  # the theory has no band
        assert len({found.get_color() for found in lines.values()}) == 3
    colours = [
        {found.get_gid(): found.get_color() for found in axes.get_lines()}
        for axes in figure.axes
    ]
    assert colours[0] == colours[1]
    handles = {h.get_label(): h.get_color() for h in figure.legends[0].legend_handles}  # type: ignore[union-attr]
    assert handles == colours[0]


def test_what_a_logarithmic_axis_cannot_show_is_left_out() -> None:
    y = np.array([math.nan, 0.0, 1.0, 1e-9, 2.0])
    with publication_style():
        figure = drawn(observable({0.1: [Line("A", X, y, 2 * y)]}, "q", "C"))
    (axes,) = figure.axes
    (found,) = axes.get_lines()
    np.testing.assert_array_equal(found.get_ydata(), [1.0, 1e-9, 2.0])
    bottom, top = axes.get_ylim()
    assert bottom == pytest.approx(2.0 * DECADES)
    assert top == pytest.approx(6.0)


def test_of_many_pressures_four_are_drawn_ends_included() -> None:
    panels = {p: [line("A")] for p in np.geomspace(1e-5, 1e-1, 9)}
    with publication_style():
        figure = drawn(observable(panels, "q", "C", "linear"))
    assert len(figure.axes) == MOST_PANELS
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "10^{-5}" in titles[0]
    assert "10^{-1}" in titles[-1]
    assert figure.axes[0].get_xscale() == "linear"


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_contact_map_is_white_where_nothing_touches(count: int) -> None:
    pressure = np.zeros((8, 8))
    pressure[2:4, 5] = [0.05, 0.3]
    stripe = np.zeros(16)
    stripe[3] = 0.1
    maps = [ContactMap("A", pressure), ContactMap("B", stripe), ContactMap("C", pressure)]
    with publication_style():
        figure = drawn(contact_maps(maps[:count], 0.1))
    panels = [axes for axes in figure.axes if axes.get_images()][:count]
    assert len(panels) == count
    image = panels[0].get_images()[0]
    shown = image.get_array()
    assert shown is not None
    values: NDArray[np.float64] = np.ma.filled(shown, math.nan)
    np.testing.assert_array_equal(np.isnan(values), pressure == 0.0)
    assert values[2, 5] == pytest.approx(0.5)
    assert image.get_clim() == (0.0, 1.0)
    assert tuple(image.get_cmap().get_bad()) == (1.0, 1.0, 1.0, 1.0)
    words = [text.get_text() for text in figure.findobj(Text)]
    assert any("3.12 % of the points" in word for word in words)


def test_files_are_the_same_for_the_same_data(tmp_path: Path) -> None:
    for folder in ("one", "other"):
        paths = draw_observable({0.1: [line("A")]}, "q", "C", "x", tmp_path / folder)
        paths += draw_contact_maps([ContactMap("A", np.eye(4))], 0.1, "map", tmp_path / folder)
        assert [path.name for path in paths] == ["x.pdf", "x.png", "map.pdf", "map.png"]
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes()


def test_no_line_is_drawn_twice() -> None:
    with publication_style():
        figure = drawn(observable({0.1: [line("A"), line("B")]}, "q", "C"))
    found = [
        artist for axes in figure.axes for artist in axes.findobj(Line2D) if artist.get_gid()
    ]
    assert sorted(str(artist.get_gid()) for artist in found) == ["A", "B"]
