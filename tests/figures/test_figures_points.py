"""Points of a CSV file over the curves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import roughbench as rb
from roughbench.cli import main
from roughbench.figures import overlaid, shows_points
from roughbench.results import ModelResult, Results
from roughbench.store import write_results

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]
Draw = Callable[[Results, str], Figure]


@pytest.fixture
def one(make: Make, collect: Collect) -> Results:
    return collect(make("bem"), make("persson", n=1))


@pytest.fixture
def with_units(make: Make, collect: Collect) -> Results:
    return collect(make("bem", height=2e-9, contact_modulus=1e9))


def points_of(results: Results, text: str, folder: Path) -> ModelResult:
    path = folder / "measured.csv"
    path.write_text(text, encoding="utf-8")
    *_, found = overlaid(results, path)["main"].values()
    return found


def test_points_are_drawn_with_their_errors(one: Results, draw: Draw, tmp_path: Path) -> None:
    path = tmp_path / "rubber $5.csv"
    path.write_text(
        "\ufeff# a remark\n\npressure,area,area_error\n1e-2,0.03,0.01\n1e-3,2e-3,\n"
    )
    results = overlaid(one, path)
    assert list(one["main"]) == ["bem", "persson"]  # as it was
    figure = draw(results, "area")
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "Exact (BEM), $n = 3$",
        "Persson",
        r"rubber \$5",
    ]
    axes = figure.axes[0]
    bars = next(c for c in axes.containers if "rubber" in str(c.lines[0].get_gid()))  # type: ignore[attr-defined]
    drawn = bars.lines[0].get_xydata().tolist()  # type: ignore[attr-defined]
    assert drawn == [[1e-3, 2e-3], [1e-2, 0.03]]
    (segments,) = bars.lines[2]  # type: ignore[attr-defined]
    low, high = segments.get_segments()[1][:, 1]
    assert (low, high) == pytest.approx((0.02, 0.04))
    assert axes.get_ylim()[0] < 2e-4  # the curves are all there


def test_lengths_stand_in_rms_heights(one: Results, draw: Draw, tmp_path: Path) -> None:
    """h_rms is 0.5 here; a column is in the spec's unit, or in h_rms."""
    for heading in ("separation", "separation (length)", "separation [h_rms]"):
        value = 1.0 if "h_rms" in heading else 0.5
        found = points_of(one, f"pressure,{heading}\n1e-3,{value}\n", tmp_path)
        assert found["separation"].tolist() == [[0.5]]
    axes = draw(overlaid(one, tmp_path / "measured.csv"), "separation").axes[0]
    (drawn,) = (x for x in axes.get_lines() if "measured" in str(x.get_gid()))
    assert np.asarray(drawn.get_xydata()).tolist() == [[1e-3, 1.0]]


@pytest.mark.parametrize(
    ("heading", "value", "expected"),
    [
        ("pressure (MPa),area (%)", "2,30", (2e6, "area", 0.3)),
        ("pressure [E*],area", "2e-3,0.3", (2e6, "area", 0.3)),
        ("pressure (kPa),separation (um)", "2000,0.5", (2e6, "separation", 5e-7)),
        ("pressure (Pa),separation (h_rms)", "2e6,0.5", (2e6, "separation", 1e-9)),
        ("pressure (N/mm^2),stiffness (MPa/nm)", "2,3", (2e6, "stiffness", 3e15)),
        ("pressure (bar),stiffness (E*/h_rms)", "20,3", (2e6, "stiffness", 1.5e18)),
    ],
)
def test_units_are_those_of_the_columns(
    with_units: Results, tmp_path: Path, heading: str, value: str, expected: Any
) -> None:
    found = points_of(with_units, f"{heading}\n{value}\n", tmp_path)
    pressure, name, number = expected
    assert found["pressure"][0] == pytest.approx(pressure, rel=1e-12)
    assert found[name][0, 0] == pytest.approx(number, rel=1e-12)


def test_labels_and_experiments(make: Make, collect: Collect, tmp_path: Path) -> None:
    results = collect(experiments={"qr=1": [make("bem")], "qr=8": [make("bem", height=0.1)]})
    path = tmp_path / "two.csv"
    path.write_text(
        "label,pressure,separation (h_rms),experiment\n"
        "steel,1e-3,1,qr=8\nglass,1e-3,2,qr=8\nsteel,1e-2,0.5,qr=1\nsteel,2e-2,,qr=1\n"
    )
    found = overlaid(results, path)
    assert [one.title for one in found["qr=8"].values()] == ["Exact (BEM)", "steel", "glass"]
    *_, steel = found["qr=1"].values()
    assert steel["pressure"].tolist() == [1e-2, 2e-2]
    np.testing.assert_array_equal(steel["separation"], [[0.25, np.nan]])
    assert [shows_points(found, name) for name in ("separation", "area", "fig3")] == [
        True,
        False,
        True,
    ]
    with pytest.raises(rb.StoreError, match="points called 'steel' are drawn already"):
        overlaid(found, path)
    path.write_text("pressure,area\n1e-3,1\n")
    with pytest.raises(rb.StoreError, match=r"add a column experiment .*: qr=1, qr=8"):
        overlaid(results, path)
    path.write_text("pressure,area,experiment\n1e-3,1,qr=2\n")
    with pytest.raises(rb.StoreError, match=r"two.csv:2: experiment: 'qr=2' is none"):
        overlaid(results, path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "bad.csv:0: the first line must name the columns"),
        ("1e-3,0.1\n", r"bad.csv:1: unknown column '1e-3'; columns are pressure, area"),
        ("pressure,aera\n", r"bad.csv:1: unknown column 'aera' \(did you mean 'area'"),
        ("pressure;area\n", "unknown column 'pressure;area'"),
        ("pressure\n1\n", "must name the columns, pressure and one of area"),
        ("pressure,area,area\n", "two columns are named 'area'"),
        ("pressure,area,stiffness_error\n", "the error of no column stiffness"),
        ("pressure,area\n", "no points; write a line of numbers"),
        ("pressure,area\n1e-3\n", r"bad.csv:2: 1 cells under 2 names"),
        ("pressure,area\n1e-3,x\n", r"bad.csv:2: area: must be a positive number, got 'x'"),
        ("pressure,area\n1e-3,0\n", "got '0': the axes are logarithmic; leave the line out"),
        ("pressure,area\n,0.1\n", r"bad.csv:2: pressure: must be a positive number, got ''"),
        ("pressure,area\ninf,0.1\n", "pressure: must be a positive number, got 'inf'"),
        (
            "pressure,area,area_error\n1,1,-1\n",
            r"area_error: must be a positive number, got '-1'$",
        ),
        ("pressure (MPa),area\n1,1\n", r"no units, so that the column must be in E\*"),
        ("pressure,area (m)\n1,1\n", "area: has no unit but %, got 'm'"),
        ('pressure,area\n"1,1\n', "bad.csv:2: no line of a CSV file"),
        (b"\xff\xfe", "no text in UTF-8"),
        (None, "no such file; give a CSV file"),
    ],
)
def test_what_is_refused(one: Results, tmp_path: Path, text: Any, message: str) -> None:
    path = tmp_path / "bad.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(rb.StoreError, match=message):
        overlaid(one, path)


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("pressure,area", r"pressure: the results have units; .* as in 'pressure \(Pa\)'"),
        (
            "pressure (m),area",
            r"pressure: 'm' is no unit like Pa; write one such as Pa, or E\*",
        ),
        ("pressure (MPam),area", "pressure: 'MPam' is no unit that can be read"),
        ("pressure (E*),separation (E*)", r"separation: .* write one such as m, or h_rms"),
    ],
)
def test_units_that_do_not_suit(
    with_units: Results, tmp_path: Path, heading: str, message: str
) -> None:
    with pytest.raises(rb.StoreError, match=rf"measured.csv:1: {message}"):
        points_of(with_units, f"{heading}\n1,1\n", tmp_path)


def test_plot_on_the_command_line(
    small_spec: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_results(rb.run(small_spec | {"models": [{"kind": "persson"}]}), "small.h5")
    Path("points.csv").write_text("pressure,area\n1e-3,0.02\n")
    command = ["plot", "small.h5", "--overlay", "points.csv", "--format", "svg"]
    done = CliRunner().invoke(main, [*command, "--figure", "area", "--figure", "spectrum"])
    assert done.exit_code == 0
    assert done.stdout.splitlines() == ["figures/area.svg", "figures/spectrum.svg"]
    assert done.stderr == "note: without the points of --overlay: spectrum\n"
    assert "points" in Path("figures/area.svg").read_text(encoding="utf-8")
    none = CliRunner().invoke(main, [*command, "--figure", "stiffness", "-o", "other"])
    assert none.exit_code != 0
    assert "none of the figures shows the points of --overlay: stiffness" in none.stderr
    assert not Path("other").exists()
    with pytest.raises(rb.StoreError, match=r"'stiffness' shows no column of points\.csv"):
        rb.plot(rb.load("small.h5"), "stiffness", overlay="points.csv")
