"""Figures shown from Python: into panels that are there, in other styles and formats."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

import roughbench as rb
from roughbench import figures
from roughbench.results import ModelResult, Results

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]


@pytest.fixture(autouse=True)
def no_screen() -> Iterator[None]:
    plt.switch_backend("Agg")
    yield
    plt.close("all")


def lines_of(axes: Axes) -> list[tuple[str, list[list[float]]]]:
    return [
        (str(line.get_gid()), np.asarray(line.get_xydata()).tolist())
        for line in axes.get_lines()
    ]


@pytest.fixture
def one(make: Make, collect: Collect) -> Results:
    return collect(make("bem", rms_slope=0.1), make("persson", n=1, rms_slope=0.1))


def test_a_figure_is_one_that_pyplot_shows(one: Results) -> None:
    axes = rb.plot(one, "area")
    assert isinstance(axes, Axes)
    assert plt.get_fignums() == [axes.figure.number]  # type: ignore[union-attr]
    assert [text.get_text() for text in axes.figure.legends[0].get_texts()] == [
        "Exact (BEM), $n = 3$",
        "Persson",
    ]
    # Fonts are those of the style, whenever it is shown.
    assert axes.xaxis.label.get_fontfamily() == ["STIXGeneral"]
    assert axes.get_xticklabels()[0].get_fontfamily() == ["STIXGeneral"]


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_a_panel_that_is_there_gets_the_same_curves(one: Results, name: str) -> None:
    before = dict(mpl.rcParams)
    figure, panels = plt.subplots(1, 2)
    size = figure.get_size_inches().tolist()
    drawn, own = rb.plot(one, name, ax=panels[1]), rb.plot(one, name)
    assert drawn is panels[1]
    assert isinstance(drawn, Axes)
    assert isinstance(own, Axes)
    assert lines_of(drawn) == lines_of(own)
    assert drawn.get_ylim() == own.get_ylim()
    assert not panels[0].lines
    legend = drawn.get_legend()
    assert legend is not None
    assert len(legend.get_texts()) >= 2
    assert figure.get_size_inches().tolist() == size
    assert dict(mpl.rcParams) == before
    if name != "area":
        assert "rms height of the spectrum" in drawn.get_xlabel()
    if drawn.child_axes:  # the legend leaves the inset free
        figure.canvas.draw()
        inset = drawn.child_axes[0].get_window_extent()
        assert not inset.overlaps(legend.get_window_extent())


def test_other_figures_of_one_panel(computed: Results, observed: Results) -> None:
    for results, name in ((computed, "spectrum"), (computed, "area")):
        _, axes = plt.subplots()
        assert rb.plot(results, name, ax=axes) is axes
        assert axes.has_data()
        assert axes.get_legend() is not None
    with pytest.raises(rb.StoreError, match="has 4 panels, and ax is 1: give ax as many"):
        rb.plot(observed, "pressure_pdf", ax=plt.figure().subplots())


def test_several_panels_are_a_list(computed: Results) -> None:
    both = rb.plot(computed, "fig3")
    assert isinstance(both, list)
    assert [axes.get_title(loc="left") for axes in both] == ["(a)", "(b)"]
    figure, given = plt.subplots(1, 2)
    into = rb.plot(computed, "fig3", ax=given)
    assert isinstance(into, list)
    assert into == list(given)
    assert str([*map(lines_of, into)]) == str([*map(lines_of, both)])  # nan as nan
    assert into[0].get_xlim() == into[1].get_xlim()
    assert into[0].get_legend() is not None
    assert not figure.legends
    assert "rms height of the spectrum" in into[1].get_xlabel()
    with pytest.raises(rb.StoreError, match="has 2 panels"):
        rb.plot(computed, "fig3", ax=plt.figure().subplots())
    with pytest.raises(rb.StoreError, match="has one panel, and ax is 2"):
        rb.plot(computed, "area", ax=list(given))
    with pytest.raises(rb.StoreError, match="ax is no panel of Matplotlib"):
        rb.plot(computed, "area", ax=3)  # type: ignore[arg-type]
    with pytest.raises(rb.StoreError, match="has 2 panels"):
        rb.plot(computed, "stiffness", ax=plt.figure().subplots())


def test_what_is_not_there_is_refused_as_by_render(one: Results) -> None:
    with pytest.raises(rb.StoreError, match="there is no figure 'areas'"):
        rb.plot(one, "areas")
    with pytest.raises(rb.StoreError, match="'contact' needs fields"):
        rb.plot(one, "contact")
    with pytest.raises(rb.StoreError, match="either ax or style"):
        rb.plot(one, "area", ax=plt.figure().subplots(), style="ggplot")
    assert not plt.figure().axes
    alone = plt.figure().subplots()
    alone.remove()
    with pytest.raises(rb.StoreError, match="ax is in no figure"):
        rb.plot(one, "area", ax=alone)
    part = plt.figure().add_subfigure(GridSpec(1, 2)[0]).subplots()
    assert rb.plot(one, "area", ax=part) is part


def test_a_figure_from_outside_has_panels_of_its_own(
    one: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(
        "from matplotlib.figure import Figure\n"
        "class Mine:\n"
        "    def missing(self, results): return None\n"
        "    def draw(self, results):\n"
        "        figure = Figure(); figure.subplots(); return figure\n"
    )
    assert isinstance(rb.plot(one, "mine.py:Mine"), Axes)
    with pytest.raises(rb.StoreError, match="makes panels of its own; leave out ax"):
        rb.plot(one, "mine.py:Mine", ax=plt.figure().subplots())


def test_styles_by_name_and_by_file(one: Results, tmp_path: Path) -> None:
    grey = rb.plot(one, "area", style="grayscale")
    assert isinstance(grey, Axes)
    assert isinstance(grey.figure, Figure)
    assert mpl.colors.to_hex(grey.figure.get_facecolor()) == "#bfbfbf"
    (tmp_path / "mine.mplstyle").write_text("axes.linewidth: 3\n")
    mine = rb.plot(one, "area", style=tmp_path / "mine.mplstyle")
    assert isinstance(mine, Axes)
    assert mine.spines["left"].get_linewidth() == 3.0
    assert mine.xaxis.label.get_fontsize() == 9.0  # the rest is as always


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("axes.linewdith: 3\n", "Bad key axes.linewdith"),
        ("axes.linewidth: thick\n", "axes.linewidth: thick"),
        ("axes.linewidth\n", "Missing colon"),
        (b"\xff\xfe\x00", "no style sheet that can be read"),
        (None, "there is no style .*grayscale"),
    ],
)
def test_a_bad_style_is_refused(
    one: Results, tmp_path: Path, text: str | bytes | None, message: str
) -> None:
    path = tmp_path / "bad.mplstyle"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(rb.StoreError, match=message):
        figures.render(one, "area", tmp_path, style=path)
    assert not list(tmp_path.glob("area.*"))


def test_formats(one: Results, tmp_path: Path) -> None:
    paths = figures.render(one, "area", tmp_path / "a", "my.h5", formats=["svg", "png"])
    assert [path.name for path in paths] == ["area.svg", "area.png"]
    assert figures.drawn_of(tmp_path / "a") == {"my.h5"}
    svg = paths[0].read_bytes()
    figures.render(one, "area", tmp_path / "a", "my.h5", formats=["svg"])  # over its own
    assert paths[0].read_bytes() == svg
    assert svg.startswith(b"<?xml")
    assert b"<dc:date>" not in svg
    (tmp_path / "area.svg").write_text("<svg>somebody else's</svg>")
    with pytest.raises(rb.StoreError, match="no figure that roughbench wrote"):
        figures.render(one, "area", tmp_path, formats=["svg"])
    with pytest.raises(rb.StoreError, match="no format 'eps'; choose pdf, png, svg"):
        figures.render(one, "area", tmp_path, formats=["eps"])
