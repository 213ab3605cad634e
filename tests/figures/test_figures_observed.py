"""Pictures of fields: what stands in the artists."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from roughbench import figures
from roughbench.errors import StoreError
from roughbench.figures.contact import MOST_GROUPS, ContactMap, contact_maps
from roughbench.figures.observed import DECADES, MOST_PANELS, THEORY, ObservedLine, panels
from roughbench.figures.style import publication_style
from roughbench.figures.styles import CurveStyle, curve_styles
from roughbench.observables import OBSERVABLES
from roughbench.results import ModelResult, Results

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]
X = np.geomspace(1.0, 100.0, 5)
STYLES = {"A": CurveStyle("", (), "#000000", 1), "B": CurveStyle("", (3, 1), "#009E73", 1)}


def line(title: str, scale: float = 1.0, *, theory: bool = False) -> ObservedLine:
    y = scale * X**-2.0
    look = THEORY if theory else STYLES[title]
    return ObservedLine(title, X, y, 0.1 * y, look, is_theory=theory)


def drawn(figure: Figure) -> Figure:
    figure.draw_without_rendering()
    return figure


def legend_words(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_curves_hold_the_values_and_keep_their_styles() -> None:
    with publication_style():
        given = {
            "low": [line("B", 0.01), line("T", theory=True)],
            "high": [line("A"), line("B", 0.1), line("T", theory=True)],
        }
        figure = drawn(panels(given, "q", "C"))
    assert legend_words(figure) == ["B", "T", "A"]
    for axes, scale in zip(figure.axes, (0.01, 0.1), strict=True):
        lines = {found.get_gid(): found for found in axes.get_lines()}
        np.testing.assert_allclose(np.asarray(lines["B"].get_ydata(), float), scale * X**-2.0)
        np.testing.assert_array_equal(lines["B"].get_xdata(), X)
        assert len(axes.collections) == len(lines) - 1  # the theory has no band
        assert len({found.get_color() for found in lines.values()}) == len(lines)
    colours: dict[object, object] = {}
    for axes in figure.axes:
        for found in axes.get_lines():
            assert colours.setdefault(found.get_gid(), found.get_color()) == found.get_color()
    handles = {h.get_label(): h.get_color() for h in figure.legends[0].legend_handles}  # type: ignore[union-attr]
    assert handles == colours


def test_what_a_logarithmic_axis_cannot_show_is_left_out() -> None:
    y = np.array([math.nan, 0.0, 1.0, 1e-9, 2.0])
    with publication_style():
        figure = drawn(panels({"": [ObservedLine("A", X, y, 2 * y, STYLES["A"])]}, "q", "C"))
    (axes,) = figure.axes
    (found,) = axes.get_lines()
    np.testing.assert_array_equal(found.get_ydata(), [1.0, 1e-9, 2.0])
    bottom, top = axes.get_ylim()
    assert bottom == pytest.approx(2.0 * DECADES)
    assert top == pytest.approx(6.0)


def test_of_many_pressures_four_are_drawn_ends_included(observed: Results) -> None:
    main = observed["main"]
    with publication_style():
        figure = drawn(figures.FIGURES["pressure_pdf"].draw(observed))
    assert len(figure.axes) == MOST_PANELS
    heads = [axes.get_title(loc="left") for axes in figure.axes]
    assert r"1.0\times10^{-4}" in heads[0]
    assert r"1.0\times10^{-1}" in heads[-1]
    assert figure.axes[0].get_xscale() == "linear"
    lines = {found.get_gid(): found for found in figure.axes[-1].get_lines()}
    assert list(lines) == ["Popov (1D foundation)", "Winkler (2D springs)", "Persson"]
    for label in ("foundation", "winkler"):
        found = lines[main[label].title]
        mean = main[label]["pressure_pdf_mean"][-1]
        np.testing.assert_array_equal(found.get_ydata(), mean[mean > 0.0])
        assert found.get_color() == curve_styles(observed.models())[label].colour


def test_a_line_stands_for_its_surface(observed: Results) -> None:
    with publication_style():
        figure = drawn(figures.FIGURES["stress_spectrum"].draw(observed))
    lines = {found.get_gid(): found for found in figure.axes[-1].get_lines()}
    result = observed["main"]["foundation"]
    q = result["stress_spectrum_bin"]
    mean = result["stress_spectrum_mean"][-1]
    np.testing.assert_allclose(
        np.asarray(lines[result.title].get_ydata(), float), (mean / (np.pi * q))[mean > 0.0]
    )
    assert r"Persson, $\gamma = 0.45$" in lines


def test_two_experiments_have_panels_of_their_own(observed: Results) -> None:
    twice = Results(
        {"surface.qr=1.0": observed["main"], "surface.qr=4.0": observed["main"]},
        observed.spec_text,
        observed.spec_sha256,
    )
    with publication_style():
        figure = drawn(figures.FIGURES["clusters"].draw(twice))
    heads = [axes.get_title(loc="left") for axes in figure.axes]
    assert ["q_r/q_0 = 1" in head for head in heads] == [True, True, False, False]
    assert ["q_r/q_0 = 4" in head for head in heads] == [False, False, True, True]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_contact_map_is_white_where_nothing_touches(count: int) -> None:
    pressure = np.zeros((8, 8))
    pressure[2:4, 5] = [0.5, 3.0]
    stripe = np.zeros(16)
    stripe[3] = 0.1
    maps = [ContactMap("A", pressure), ContactMap("B", stripe), ContactMap("C", pressure)]
    with publication_style():
        figure = drawn(contact_maps({"p": maps[:count]}))
    drawn_panels = images(figure)
    assert len(drawn_panels) == count
    shown = drawn_panels[0].get_array()
    assert shown is not None
    values: NDArray[np.float64] = np.ma.filled(shown, math.nan)
    np.testing.assert_array_equal(np.isnan(values), pressure == 0.0)
    assert values[2, 5] == pytest.approx(0.5)
    assert drawn_panels[0].get_clim() == (0.0, 1.0)
    assert tuple(drawn_panels[0].get_cmap().get_bad()) == (1.0, 1.0, 1.0, 1.0)
    words = [text.get_text() for text in figure.findobj(Text)]
    assert any("3.12 % of the points" in word for word in words)


def images(figure: Figure) -> list[AxesImage]:
    """Return the contact maps, without the colour bar."""
    return [image for axes in figure.axes if axes.get_title() for image in axes.get_images()]


def test_states_of_many_groups_are_left_out_with_a_word(observed: Results) -> None:
    with publication_style():
        figure = drawn(figures.FIGURES["contact"].draw(observed))
    assert len(images(figure)) == 2 * MOST_GROUPS
    words = [text.get_text() for text in figure.findobj(Text)]
    assert "2 more are in the results." in words  # 4 pressures × 2 realizations
    assert sum("realization 1" in word for word in words) == MOST_GROUPS - 4
    field = observed["main"]["winkler"]["field_pressure"][0]
    shown = images(figure)[1].get_array()
    assert shown is not None
    np.testing.assert_array_equal(np.ma.filled(shown, 0.0) > 0.0, field > 0.0)


def test_files_are_the_same_for_the_same_data(observed: Results, tmp_path: Path) -> None:
    for folder in ("one", "other"):
        figures.render(observed, "clusters", tmp_path / folder)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes()


def test_results_say_which_figures_they_allow(
    observed: Results, computed: Results, make: Make, collect: Collect
) -> None:
    own = [*(one.variable for one in OBSERVABLES.values()), "contact"]
    assert figures.available(observed)[-len(own) :] == own
    assert set(figures.available(computed)) & set(own) == {"contact"}
    with pytest.raises(StoreError, match="needs the observable clusters, which a spec asks"):
        figures.render(computed, "clusters", Path("nowhere"))
    with pytest.raises(StoreError, match="needs fields, which a spec asks for with save_fi"):
        figures.render(collect(make()), "contact", Path("nowhere"))


def test_no_line_is_drawn_twice() -> None:
    with publication_style():
        figure = drawn(panels({"": [line("A"), line("B")]}, "q", "C"))
    found = [
        artist for axes in figure.axes for artist in axes.findobj(Line2D) if artist.get_gid()
    ]
    assert sorted(str(artist.get_gid()) for artist in found) == ["A", "B"]
