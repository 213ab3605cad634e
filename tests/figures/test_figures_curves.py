"""What is drawn of a contender: values, styles and words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from roughbench.figures.curves import curve_of, full_contact_pressure
from roughbench.figures.labels import experiment_label, height_remark, model_names
from roughbench.figures.styles import curve_styles, experiment_shades
from roughbench.models import MODELS
from roughbench.report.sources import ReportSource
from roughbench.report.styles import page_styles
from roughbench.results import ModelResult, Results

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]
Draw = Callable[[Results, str], Figure]


def test_a_curve_is_the_mean_with_its_standard_error(make: Make) -> None:
    result = make(n=3, height=0.25)
    for quantity, unit in (("area", 1.0), ("separation", 0.25), ("stiffness", 4.0)):
        curve = curve_of(result, quantity)
        mean, sem = result[f"{quantity}_mean"], result[f"{quantity}_sem"]
        np.testing.assert_array_equal(curve.value, mean / unit)
        np.testing.assert_allclose(curve.lower, (mean - sem) / unit, rtol=1e-14)
        np.testing.assert_allclose(curve.upper, (mean + sem) / unit, rtol=1e-14)
        assert not curve.is_median.any()


def test_pressures_ascend_whatever_their_order(make: Make) -> None:
    pressure = np.array([1e-2, 1e-4, 1e-3])
    curve = curve_of(make(pressure=pressure), "area")
    np.testing.assert_array_equal(curve.pressure, [1e-4, 1e-3, 1e-2])
    assert (np.diff(curve.value) > 0.0).all()


def test_an_infinite_mean_makes_the_whole_curve_a_median(make: Make) -> None:
    stiffness = np.array([[1.0, 2.0, 3.0, np.inf], [2.0, 3.0, np.inf, np.inf], [4.0] * 4])
    result = make(stiffness=stiffness, n=3, height=0.5)
    curve = curve_of(result, "stiffness")
    assert curve.is_median.all()
    np.testing.assert_array_equal(curve.value, [1.0, 1.5, 2.0, np.inf])
    np.testing.assert_array_equal(curve.lower, result["stiffness_q16"] * 0.5)
    np.testing.assert_array_equal(curve.upper, result["stiffness_q84"] * 0.5)
    assert full_contact_pressure(curve) == 1e-1


def test_points_are_medians_only_where_the_mean_is_infinite(make: Make) -> None:
    stiffness = np.array([[1.0, 2.0, 3.0, np.inf], [2.0, 3.0, np.inf, np.inf], [6.0] * 4])
    result = make("bem", stiffness=stiffness, height=1.0)
    curve = curve_of(result, "stiffness")
    np.testing.assert_array_equal(curve.is_median, [False, False, True, True])
    np.testing.assert_allclose(curve.value, [3.0, 11.0 / 3.0, 6.0, np.inf])
    np.testing.assert_array_equal(curve.lower[2:], result["stiffness_q16"][2:])
    sem = result["stiffness_sem"]
    np.testing.assert_allclose(curve.upper[:2], curve.value[:2] + sem[:2])


def test_one_realization_has_no_error(make: Make) -> None:
    curve = curve_of(make(n=1, stiffness=[1.0, 2.0, np.inf, np.inf]), "stiffness")
    assert not curve.is_median.any()
    assert np.isnan(curve.lower).all()
    assert np.isnan(curve.upper).all()
    assert full_contact_pressure(curve) == 1e-2
    assert full_contact_pressure(curve_of(make(n=1), "stiffness")) is None


def test_kinds_have_the_papers_styles(make: Make, collect: Collect) -> None:
    results = collect(make("bem"), make("foundation"), make("persson"))
    chosen = curve_styles(results.models())
    assert (chosen["bem"].marker, chosen["foundation"].marker) == ("s", "")
    assert chosen["foundation"].dashes == ()
    assert chosen["persson"].dashes
    assert chosen["bem"].order > chosen["foundation"].order > chosen["persson"].order


def test_models_of_one_kind_and_new_kinds_are_told_apart(make: Make, collect: Collect) -> None:
    labels = ["bem", "fine", "foundation", "open", "persson", "g1", "winkler", "other"]
    kinds = [kind for kind in ("bem", "foundation", "persson", "winkler") for _ in range(2)]
    models = [make(kind, label=label) for kind, label in zip(kinds, labels, strict=True)]
    chosen = curve_styles(collect(*models).models())
    assert len({(look.marker, look.dashes) for look in chosen.values()}) == len(labels)
    assert len({(look.dashes, look.colour) for look in chosen.values()}) >= len(labels) - 1
    names = model_names(collect(*models), ["main"], "area")
    assert names["bem"] == "Exact (BEM), $n = 3$"
    assert names["fine"] == "Exact (BEM), fine, $n = 3$"


def test_all_contenders_and_their_variants_are_told_apart(make: Make, collect: Collect) -> None:
    models = [make(kind, label=f"{kind}{i}") for kind in MODELS for i in range(2)]
    chosen = curve_styles(collect(*models).models())
    assert len({(look.marker, look.dashes) for look in chosen.values()}) == len(models)
    one_of_each = {chosen[f"{kind}0"].colour for kind in MODELS}
    assert len(one_of_each) == len(MODELS)


def test_figures_and_reports_have_one_colour_for_a_model(make: Make, collect: Collect) -> None:
    models = [make(kind, label=f"{kind}{i}") for kind in MODELS for i in range(2)]
    results = collect(*models)
    printed, shown = (
        curve_styles(results.models()),
        page_styles([ReportSource("r.h5", results)]),
    )
    assert {name: look.colour for name, look in printed.items()} == {
        name: look.colour for name, look in shown.items()
    }


def test_a_theory_has_no_number_of_realizations(make: Make, collect: Collect) -> None:
    theory = make("winkler", n=1, label="theory")
    counted = make("winkler", n=1, label="one", grid_points=64)
    measured = make("winkler", n=1, label="measured", surface="file")
    names = model_names(collect(theory, counted, measured), ["main"], "area")
    assert names["theory"] == "Winkler, theory"
    assert names["one"] == "Winkler, one, $n = 1$"
    assert names["measured"] == "Winkler, measured, $n = 1$"


def test_the_area_names_its_own_gamma(make: Make, collect: Collect) -> None:
    results = collect(make("persson", n=1, gamma=0.45, area_gamma=0.5))
    assert model_names(results, ["main"], "area")["persson"] == r"Persson, $\gamma_A = 0.5$"
    stiffness = model_names(results, ["main"], "stiffness")["persson"]
    assert stiffness == r"Persson, $\gamma = 0.45$"


@pytest.mark.parametrize("name", ["area", "separation", "stiffness", "fig3"])
def test_many_contenders_leave_the_panels_their_height(
    make: Make, collect: Collect, lay_out: Draw, name: str
) -> None:
    few = collect(*(make(kind) for kind in ("bem", "foundation", "persson")))
    many = collect(*(make(kind, label=f"{kind}{i}") for kind in MODELS for i in range(2)))
    heights = [
        figure.axes[0].get_position().height * figure.get_figheight()
        for figure in (lay_out(few, name), lay_out(many, name))
    ]
    assert heights[1] > 0.6 * heights[0]


def test_names_tell_parameters_and_numbers(make: Make, collect: Collect) -> None:
    stiffness = np.array([[1.0, 2.0, 3.0, np.inf], [2.0, 3.0, 4.0, 5.0]])
    few = [
        make(n=2, stiffness=stiffness),
        make("persson", n=1, gamma=0.45, finite_size="max"),
    ]
    results = collect(experiments={"few": few, "many": [make(n=5)]})
    names = model_names(results, ["few", "many"], "stiffness")
    assert names["foundation"] == "Popov (1D foundation), $n$ = 2–5, median"
    assert names["persson"] == r"Persson, $\gamma = 0.45$, finite size"
    assert model_names(results, ["few"], "area")["foundation"].endswith("$n = 2$")


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("main", ""),
        ("surface.qr=8.0", "$q_r/q_0 = 4$"),
        ("surface.H=0.75,surface.q1=128.0", "$H = 0.75$, $q_1/q_0 = 64$"),
        ("surface.length=12.566370614359172", "$L = 12.5664$"),
        ("surface.rms_height=2.5e-07", r"$h_\mathrm{rms} = 2.5\times10^{-7}$"),
        ("surface.below_qr=cutoff", "below_qr = cutoff"),
        ("seed=3", "seed = 3"),
        ("rough", "rough"),
    ],
)
def test_experiments_are_called_by_their_symbols(name: str, label: str) -> None:
    assert experiment_label(name, 2.0) == label


def test_without_q0_a_wavevector_is_what_the_spec_says() -> None:
    assert experiment_label("surface.qr=8.0") == "$q_r = 8$"


def test_each_experiment_has_its_shade() -> None:
    assert experiment_shades(["main"]) == {"main": 0.0}
    for n in (2, 7, 8, 30):
        assert len(set(experiment_shades([f"e{i}" for i in range(n)]).values())) == n


def test_the_rms_height_is_named(make: Make, collect: Collect) -> None:
    assert "of the spectrum (continuum)" in height_remark(collect(make()))
    assert "given heights" in height_remark(collect(make(surface="file")))
