"""Area, separation and stiffness as printed: axes, colours, marks, and exact points apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

import roughbench as rb
from roughbench.cli import main
from roughbench.errors import StoreError
from roughbench.figures import FIGURES, join
from roughbench.results import ModelResult, Results
from roughbench.verdict.onset import onset_of, theory_of

Make = Callable[..., ModelResult]
Draw = Callable[[Results, str], Figure]
BLUE, RED = "#0072B2", "#D62728"
SURFACE = {"H": 0.7, "q0": 1.0, "q1": 1024.0, "slope": 0.1}


@pytest.fixture(scope="module")
def wide() -> Results:
    """Return foundation and theory from few contacts on."""
    return rb.run(
        {
            "name": "wide",
            "surface": SURFACE,
            "pressures": {"min": 1e-8, "max": 0.1, "points": 36},
            "realizations": 5,
            "models": [
                {"kind": "foundation", "springs": 4096, "ends": "open"},
                {"kind": "persson", "finite_size": "max"},
            ],
            "sweep": {"surface.qr": [8.0, 1.0]},
        }
    )


@pytest.fixture(scope="module")
def exact(wide: Results) -> Results:
    """Return points of the exact solver on surfaces of one roll-off, at other pressures."""
    few = _from(wide["surface.qr=8.0"]["persson"], 20)
    points = replace(few, kind="bem", label="bem", title="Exact (BEM)")
    return replace(wide, experiments={"main": {"bem": points}}, name="exact")


def lines(figure: Figure, gid: str) -> list[Line2D]:
    return [one for one in figure.findobj(Line2D) if one.get_gid() == gid]


def test_area_and_separation_stand_over_a_linear_axis(wide: Results, draw: Draw) -> None:
    figure = draw(wide, "printed_fig3")
    area, separation = figure.axes
    assert [axes.get_xscale() for axes in figure.axes] == ["linear", "linear"]
    assert (area.get_yscale(), separation.get_yscale()) == ("linear", "log")
    assert area.get_ylim() == (0.0, 1.0)
    theory = wide["surface.qr=1.0"]["persson"]
    left, right = area.get_xlim()
    assert left == 0.0
    assert np.interp(right, theory["pressure"], theory["area_mean"]) == pytest.approx(0.5)
    for experiment, colour in (("surface.qr=1.0", BLUE), ("surface.qr=8.0", RED)):
        for label in ("foundation", "persson"):
            for name in ("area", "separation"):
                (line,) = lines(figure, f"{experiment}/{label}/{name}")
                assert line.get_color() == colour
                assert line.get_linestyle() == {"foundation": "-", "persson": "--"}[label]


def test_theory_stands_above_the_foundation(wide: Results, exact: Results, draw: Draw) -> None:
    both = join(wide, exact)
    figure = draw(both, "printed_fig4")
    upper, lower = figure.axes
    gids = [{line.get_gid() for line in axes.lines} for axes in figure.axes]
    assert {one for one in gids[0] if one and "/" in one} == {
        "surface.qr=1.0/persson/stiffness",
        "surface.qr=8.0/persson/stiffness",
        "surface.qr=8.0/bem/stiffness",
    }
    assert {one for one in gids[1] if one and "/" in one} == {
        "surface.qr=1.0/foundation/stiffness",
        "surface.qr=8.0/foundation/stiffness",
    }
    assert upper.get_xlim() == lower.get_xlim()
    assert upper.get_ylim() == lower.get_ylim()
    (points,) = lines(figure, "surface.qr=8.0/bem/stiffness")
    bem = exact["main"]["bem"]
    scaled = bem["stiffness_mean"] * float(bem.attributes["rms_height"])
    np.testing.assert_allclose(np.asarray(points.get_ydata(), float), scaled)
    assert points.get_color() == RED


def test_few_states_of_springs_are_marked(wide: Results, draw: Draw) -> None:
    (few,) = lines(draw(wide, "printed_fig3"), "surface.qr=8.0/foundation/area")
    assert few.get_marker() == "."
    more = {
        name: {label: _doubled(one) for label, one in models.items()}
        for name, models in wide.experiments.items()
    }
    figure = draw(replace(wide, experiments=more), "printed_fig3")
    (many,) = lines(figure, "surface.qr=8.0/foundation/area")
    assert many.get_marker() == "None"


def test_missing_exact_points_are_said(wide: Results, exact: Results, draw: Draw) -> None:
    cases = ((wide, "points in these"), (join(wide, exact), "points for $q_"))
    for name in ("printed_fig3", "printed_fig4"):
        for results, said in cases:
            texts = [one.get_text() for one in draw(results, name).findobj(Text)]
            assert any(f"No exact {said}" in text for text in texts)
            assert not any("configs/paper/bem.yaml" in text for text in texts)
            assert any(
                r"$H = 0.7$; $\mathrm{rms\ slope} = 0.1$; $q_1/q_0 = 1024$" in text
                for text in texts
            )


def test_at_the_papers_cut_off_the_way_to_exact_points_is_said(
    wide: Results, exact: Results, draw: Draw
) -> None:
    results = join(wide, exact)
    large = {
        name: {label: _cut_off(one, 8192.0) for label, one in models.items()}
        for name, models in results.experiments.items()
    }
    for name in ("printed_fig3", "printed_fig4"):
        texts = [
            text.get_text()
            for text in draw(replace(results, experiments=large), name).findobj(Text)
        ]
        assert any("No exact points for $q_" in text for text in texts)
        assert any("13.5 GB and hours: configs/paper/bem.yaml" in text for text in texts)
    twice = large | {"surface.qr=1.0": large["surface.qr=8.0"] | large["surface.qr=1.0"]}
    texts = [
        text.get_text()
        for text in draw(replace(results, experiments=twice), "printed_fig3").findobj(Text)
    ]
    assert not any("xact points" in text for text in texts)


def test_marks_stand_where_the_foundation_deviates(wide: Results, draw: Draw) -> None:
    figure = draw(wide, "printed_fig4")
    for number, (experiment, colour) in enumerate(
        (("surface.qr=1.0", BLUE), ("surface.qr=8.0", RED))
    ):
        foundation = wide[experiment]["foundation"]
        theory = theory_of(foundation, 0.45)
        assert theory is not None
        _, deviates, linear = onset_of(theory, foundation["stiffness_mean"])
        for gid, place in (("deviates", deviates), ("linear", linear)):
            found = [line for line in lines(figure, gid) if line.get_color() == colour]
            assert len(found) == 2, (number, gid)
            assert {float(np.ravel(line.get_xdata())[0]) for line in found} == {place}


def test_without_few_contacts_there_is_no_mark_but_a_word(wide: Results, lay_out: Draw) -> None:
    late = {
        name: {label: _from(one, 25) for label, one in models.items()}
        for name, models in wide.experiments.items()
    }
    figure = lay_out(replace(wide, experiments=late), "printed_fig4")
    assert lines(figure, "deviates") == []
    words = " ".join(text.get_text() for text in figure.findobj(Text))
    assert words.count("no dashed line, no law of few contacts") == 2


def _cut_off(result: ModelResult, ratio: float) -> ModelResult:
    return replace(result, attributes={**result.attributes, "q_max": ratio})


def _from(result: ModelResult, first: int) -> ModelResult:
    """Return a result without its first pressures."""
    known = {
        name: array[..., first:] if array.shape[-1] == 36 else array
        for name, array in result.variables.items()
    }
    return replace(result, variables=known)


def _doubled(result: ModelResult) -> ModelResult:
    """Return a result with every pressure twice."""
    known = {
        name: np.repeat(array, 2, axis=-1) if array.shape[-1] == 36 else array
        for name, array in result.variables.items()
    }
    return replace(result, variables=known)


def test_other_sweeps_are_not_the_papers(make: Make, collect: Callable[..., Results]) -> None:
    alike = {"q_rolloff": 1.0, "q_min": 1.0}
    twice = collect(experiments={"a": [make(**alike)], "b": [make(**alike)]})
    for name in ("printed_fig3", "printed_fig4"):
        lack = FIGURES[name].missing(twice)
        assert lack == "experiments that differ in the roll-off alone, at most 6"
        assert FIGURES[name].missing(collect(make(**alike))) is None
        lack = FIGURES[name].missing(collect(make("gw", **alike)))
        assert lack is not None
        assert lack.startswith("a foundation or Persson's theory")


def test_exact_points_join_the_surfaces_that_they_are_of(wide: Results, exact: Results) -> None:
    both = join(wide, exact)
    assert list(both["surface.qr=8.0"]) == ["foundation", "persson", "bem"]
    assert list(both["surface.qr=1.0"]) == ["foundation", "persson"]
    assert list(wide["surface.qr=8.0"]) == ["foundation", "persson"]
    with pytest.raises(StoreError, match="has a model 'bem' already"):
        join(both, exact)
    other = exact["main"]["bem"]
    elsewhere = replace(other, attributes={**other.attributes, "q_max": 128.0})
    alien = replace(exact, experiments={"main": {"bem": elsewhere}})
    with pytest.raises(StoreError, match="are of other surfaces"):
        join(wide, alien)
    si = replace(exact, experiments={"main": {"bem": other.in_si(1e9)}})
    with pytest.raises(StoreError, match="has units"):
        join(wide, si)


def test_plot_joins_results_of_two_files(
    wide: Results, exact: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = {"wide.h5": wide, "exact.h5": exact}
    monkeypatch.setattr("roughbench.store.load", lambda path: known[Path(path).name])
    seen: list[Results] = []

    def note(results: Results, *_: object, **__: object) -> list[Path]:
        seen.append(results)
        return []

    monkeypatch.setattr("roughbench.figures.render", note)
    words = ["wide.h5", "--with", "exact.h5", "-o", str(tmp_path), "--figure", "printed_fig4"]
    done = CliRunner().invoke(main, ["plot", *words], catch_exceptions=False)
    assert done.exit_code == 0
    assert "bem" in seen[0]["surface.qr=8.0"]
