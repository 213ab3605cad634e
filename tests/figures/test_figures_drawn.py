"""What stands in the figures: the artists' data against the results, and the layout."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

import roughbench as rb
from roughbench.figures import departures
from roughbench.figures.curves import curve_of
from roughbench.figures.pressed import WINDOW, choose_window, most_telling, pressed_lines
from roughbench.figures.spectrum import RINGS_PER_DECADE, realized_spectrum
from roughbench.figures.style import publication_style
from roughbench.figures.styles import curve_styles, experiment_shades, lighter
from roughbench.planning.samples import make_sample
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult, Results
from roughbench.spec import SelfAffineSurface, load_spec

Make = Callable[..., ModelResult]
Collect = Callable[..., Results]
Draw = Callable[[Results, str], Figure]
FloatArray = NDArray[np.float64]
FLOOR = QUANTITIES["separation"].lowest
CEILING = QUANTITIES["stiffness"].highest


def by_gid(figure: Figure, gid: str) -> list[Line2D]:
    return [line for line in figure.findobj(Line2D) if line.get_gid() == gid]


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


def legend_words(figure: Figure) -> list[str]:
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    return [text.get_text() for legend in legends if legend for text in legend.get_texts()]


def without_zero_and_inf(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values) & (values > 0.0), values, np.nan)


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_lines_hold_the_results(computed: Results, draw: Draw, name: Any) -> None:
    figure = draw(computed, name)
    for experiment, result in computed.models():
        (line,) = by_gid(figure, f"{experiment}/{result.label}/{name}")
        height = result.attributes["rms_height"]
        unit = {"area": 1.0, "separation": height, "stiffness": 1.0 / float(height)}[name]
        statistic = "median" if np.isinf(result[f"{name}_mean"]).any() else "mean"
        np.testing.assert_array_equal(line.get_xdata(), result["pressure"])
        np.testing.assert_array_equal(
            line.get_ydata(), without_zero_and_inf(result[f"{name}_{statistic}"] / unit)
        )
    assert curve_of(computed["surface.qr=4.0"]["foundation"], "stiffness").is_median.all()


def test_both_halves_of_fig_3_are_those_of_its_parts(computed: Results, draw: Draw) -> None:
    whole = draw(computed, "fig3")
    for name in ("area", "separation"):
        part = draw(computed, name)
        for experiment, result in computed.models():
            gid = f"{experiment}/{result.label}/{name}"
            (a,), (b,) = by_gid(whole, gid), by_gid(part, gid)
            np.testing.assert_array_equal(a.get_xydata(), b.get_xydata())
            assert a.get_color() == b.get_color()


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_the_colour_is_the_models_and_the_shade_the_experiments(
    computed: Results, draw: Draw, name: str
) -> None:
    chosen = curve_styles(computed.models())
    shades = experiment_shades(list(computed))
    if name == "stiffness":
        shades = dict.fromkeys(computed, 0.0)  # a panel each
    figure = draw(computed, name)
    for experiment, result in computed.models():
        (line,) = by_gid(figure, f"{experiment}/{result.label}/{name}")
        assert line.get_color() == lighter(chosen[result.label].colour, shades[experiment])


@pytest.mark.parametrize("name", ["area", "separation", "stiffness"])
def test_a_band_that_reaches_zero_does_not_move_the_axis(
    make: Make, collect: Collect, draw: Draw, name: str
) -> None:
    for kind in ("bem", "foundation"):
        result = make(kind, height=1.0)
        mean = result[f"{name}_mean"]
        wide = {f"{name}_sem": np.array([1.0, 1.5, 0.5, 1.0 - 1e-15]) * mean}
        results = collect(replace(result, variables={**result.variables, **wide}))
        bottom, top = draw(results, name).axes[0].get_ylim()
        assert bottom == pytest.approx(mean.min() / 2.0)
        assert top == pytest.approx(2.0 * mean.max())


@pytest.mark.parametrize("name", ["area", "separation", "stiffness", "fig3"])
def test_full_contact_of_all_realizations_is_no_fault(
    make: Make, collect: Collect, lay_out: Draw, name: str
) -> None:
    """Warnings and floating-point errors raise here."""
    stiffness = np.array([[1.0, 2.0, np.inf, np.inf], [2.0, 3.0, 4.0, np.inf], [4.0] * 4])
    stiffness[2, 3] = np.inf
    lay_out(collect(*(make(kind, stiffness=stiffness) for kind in ("bem", "foundation"))), name)


def test_bars_and_bands_are_the_standard_errors(
    make: Make, collect: Collect, draw: Draw
) -> None:
    results = collect(make("bem", n=4), make("foundation", n=4))
    figure = draw(results, "separation")
    axes = figure.axes[0]
    height = results["main"]["bem"].attributes["rms_height"]
    mean = results["main"]["bem"]["separation_mean"] / height
    sem = results["main"]["bem"]["separation_sem"] / height
    (bars,) = [c for c in axes.collections if isinstance(c, LineCollection)]
    segments = np.array(bars.get_segments())
    np.testing.assert_allclose(segments[:, 0, 1], mean - sem, rtol=1e-12)
    np.testing.assert_allclose(segments[:, 1, 1], mean + sem, rtol=1e-12)
    (band,) = [c for c in axes.collections if isinstance(c, PolyCollection)]
    corners = np.asarray(band.get_paths()[0].vertices)
    for edge in (mean - sem, mean + sem):
        for y in edge:
            assert np.isclose(corners[:, 1], y, rtol=1e-12).any()


def test_one_realization_has_neither_bars_nor_bands(
    make: Make, collect: Collect, draw: Draw
) -> None:
    figure = draw(collect(make("bem", n=1), make(n=1)), "area")
    axes = figure.axes[0]
    assert not [c for c in axes.collections if isinstance(c, PolyCollection)]
    (bars,) = [c for c in axes.collections if isinstance(c, LineCollection)]
    assert all(np.isnan(segment).any() or not len(segment) for segment in bars.get_segments())


def test_full_contact_is_marked_and_left_out(make: Make, collect: Collect, draw: Draw) -> None:
    stiffness = np.array([[1.0, 2.0, np.inf, np.inf], [2.0, 3.0, 4.0, np.inf], [4.0] * 4])
    results = collect(make(stiffness=stiffness))
    figure = draw(results, "stiffness")
    (line,) = by_gid(figure, "main/foundation/stiffness")
    np.testing.assert_array_equal(line.get_ydata(), [1.0, 1.5, 2.0, np.nan])
    (mark,) = by_gid(figure, "full contact")
    assert mark.get_xdata() == [1e-1]
    assert mark.get_transform() != figure.axes[0].transData
    assert "full contact" in legend_words(figure)
    assert any("Medians" in word for word in words(figure))


def test_zero_separation_is_marked_and_the_axis_cut(computed: Results, draw: Draw) -> None:
    figure = draw(computed, "separation")
    marks = by_gid(figure, "full contact")
    for experiment in computed:
        result = computed[experiment]["foundation"]
        first = result["pressure"][result["separation_mean"] == 0.0][0]
        assert first in [mark.get_xdata()[0] for mark in marks]  # type: ignore[index]
    bottom, top = figure.axes[0].get_ylim()
    assert bottom == FLOOR
    assert top > max(
        r["separation_mean"].max() / r.attributes["rms_height"] for _, r in computed.models()
    )


def test_the_inset_has_a_linear_ordinate_and_the_same_curves(
    computed: Results, draw: Draw
) -> None:
    figure = draw(computed, "separation")
    (inset,) = figure.axes[0].child_axes
    assert inset.get_yscale() == "linear"
    drawn = sorted(np.asarray(line.get_ydata())[0] for line in inset.get_lines())
    first = [curve_of(result, "separation").value[0] for _, result in computed.models()]
    assert drawn == sorted(first)


def test_negative_gaps_of_a_theory_do_not_press_the_inset_flat(
    make: Make, collect: Collect, lay_out: Draw
) -> None:
    """Greenwood and Williamson's goes to -10 h_rms where all others are closed."""
    result = make()
    gaps = np.array([3.0, 2.0, 1.0, -10.0]) * float(result.attributes["rms_height"])
    fallen = replace(result, variables={**result.variables, "separation_mean": gaps})
    (inset,) = lay_out(collect(fallen), "separation").axes[0].child_axes
    low, high = inset.get_ylim()
    (line,) = inset.get_lines()
    assert np.asarray(line.get_ydata()).min() < -1.0
    assert -0.1 * high < low < 0.0 < np.asarray(line.get_ydata()).max() <= high


def test_the_inset_hides_no_curve(computed: Results, lay_out: Draw) -> None:
    for shift in (1.0, 0.1, 0.01):  # contact closes earlier and earlier
        groups = {
            name: [
                replace(r, variables={**r.variables, "pressure": r["pressure"] * shift})
                if r.kind == "foundation"
                else r
                for r in models.values()
            ]
            for name, models in computed.items()
        }
        shifted = Results({n: {r.label: r for r in g} for n, g in groups.items()}, "", "")
        axes = lay_out(shifted, "separation").axes[0]
        for inset in axes.child_axes:
            box = inset.bbox
            for line in axes.get_lines():
                if line.get_gid() == "full contact":
                    continue
                xy = axes.transData.transform(np.asarray(line.get_xydata()))
                xy = xy[np.isfinite(xy).all(axis=1)]
                fine = np.linspace(0, len(xy) - 1, 2000)
                x, y = (np.interp(fine, np.arange(len(xy)), column) for column in xy.T)
                assert not ((x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)).any()


def test_long_names_keep_the_legend_inside(make: Make, collect: Collect, lay_out: Draw) -> None:
    labels = ["a-rather-long-label-of-a-model", "another-rather-long-label", "third"]
    results = collect(*(make(label=label, n=1) for label in labels))
    for name in ("separation", "stiffness", "fig3"):
        figure = lay_out(results, name)
        with publication_style():
            for text in figure.legends[0].get_texts():
                assert text.get_window_extent().x1 <= figure.bbox.x1


def test_vertical_lines_stand_at_the_departures(computed: Results, draw: Draw) -> None:
    figure = draw(computed, "stiffness")
    expected: list[float] = []
    for found in departures(computed).values():
        assert found is not None
        expected += found.pressures
    assert len(expected) >= 2
    drawn = [line.get_xdata()[0] for line in by_gid(figure, "departure")]  # type: ignore[index]
    assert drawn == expected
    assert "Popov/Persson = 2, 1/2" in legend_words(figure)


@pytest.mark.parametrize(("ratio", "where"), [(1.5, "everywhere"), (5.0, "nowhere")])
def test_no_departure_is_said(
    make: Make, collect: Collect, lay_out: Draw, ratio: float, where: str
) -> None:
    pressure = np.logspace(-5, -2, 4)
    results = collect(
        make(stiffness=ratio * pressure, pressure=pressure),
        make("persson", n=1, stiffness=pressure, pressure=pressure),
    )
    figure = lay_out(results, "stiffness")
    assert by_gid(figure, "departure") == []
    assert any(f"agree {where}\nwithin a factor 2" in word for word in words(figure))
    assert not any("1/2" in word for word in legend_words(figure))


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_guides_have_the_slopes_they_say(
    make: Make, collect: Collect, draw: Draw, hurst: float
) -> None:
    pressure = np.logspace(-5, -2, 13)
    figure = draw(collect(make(pressure=pressure, hurst=hurst)), "stiffness")
    guides = [
        line for line in figure.findobj(Line2D) if (line.get_gid() or "").startswith("guide")
    ]
    slopes = []
    for line in guides:
        x, y = np.log(np.asarray(line.get_xydata())).T
        slopes.append((y[1] - y[0]) / (x[1] - x[0]))
    assert sorted(slopes) == pytest.approx(sorted([1.0, 1.0 / (1.0 + hurst)]), rel=1e-10)


def test_heights_from_a_file_have_no_hurst_exponent(
    make: Make, collect: Collect, lay_out: Draw
) -> None:
    given = make(pressure=np.logspace(-5, -2, 13), surface="file")
    known = {key: value for key, value in given.attributes.items() if key != "hurst"}
    figure = lay_out(collect(replace(given, attributes=known)), "stiffness")
    assert "slope 1" in words(figure)
    assert r"slope $1/(1+H)$" not in words(figure)
    assert any("rms height of the given heights" in word for word in words(figure))


def test_stiffness_beyond_the_ceiling_is_cut(make: Make, collect: Collect, draw: Draw) -> None:
    stiffness = np.array([1.0, 10.0, 1e5, 1e9])
    figure = draw(collect(make(n=1, stiffness=stiffness)), "stiffness")
    assert figure.axes[0].get_ylim()[1] == 2.0 * CEILING


def test_states_that_did_not_converge_are_reported(
    make: Make, collect: Collect, draw: Draw
) -> None:
    status = np.zeros((3, 4), int)
    status[0, :2] = 1, 2
    groups = {"one": [make("bem", status=status)], "two": [make("bem"), make()]}
    for name in ("area", "separation", "stiffness", "fig3"):
        text = "\n".join(words(draw(collect(experiments=groups), name))).splitlines()
        remark = "Exact (BEM): 2 of 24 states did not converge and are left out."
        assert [word for word in text if "converge" in word] == [remark]
    assert not any("converge" in word for word in words(draw(collect(make()), "area")))


def test_a_pressure_at_which_nothing_converged_leaves_a_gap(
    make: Make, collect: Collect, draw: Draw
) -> None:
    status = np.zeros((3, 4), int)
    status[:, 1] = 1
    figure = draw(collect(make("bem", status=status), make(status=status)), "area")
    for label in ("bem", "foundation"):
        (line,) = by_gid(figure, f"main/{label}/area")
        assert np.isnan(line.get_ydata()).tolist() == [False, True, False, False]


def test_each_experiment_has_a_panel_in_fig_4(make: Make, collect: Collect, draw: Draw) -> None:
    for n in (1, 2, 5):
        groups = {f"surface.qr={i}.0": [make(), make("persson", n=1)] for i in range(1, n + 1)}
        figure = draw(collect(experiments=groups), "stiffness")
        assert len(figure.axes) == n
        titles = [axes.get_title(loc="left") for axes in figure.axes]
        assert titles == (
            [""] if n == 1 else [f"({'abcde'[i]})  $q_r/q_0 = {i + 1}$" for i in range(n)]
        )


# -- the spectrum, Fig. 2 ------------------------------------------------------------------


def test_the_spectrum_and_its_wavevectors(computed: Results, draw: Draw) -> None:
    figure = draw(computed, "spectrum")
    for name, spec in load_spec(computed.spec_text).experiments():
        assert isinstance(spec.surface, SelfAffineSurface)
        spectrum = spec.surface.spectrum()
        (line,) = by_gid(figure, f"{name}/theory")
        xy = np.asarray(line.get_xydata())
        np.testing.assert_allclose(xy[:, 1], spectrum.psd_2d(xy[:, 0]), rtol=1e-12)
        assert (xy[0, 0], xy[-1, 0]) == (1.0, 32.0)
        (points,) = by_gid(figure, f"{name}/line")
        q, power = np.asarray(points.get_xydata()).T
        np.testing.assert_allclose(power, spectrum.psd_2d(q), rtol=0.06)
        assert (q.min(), q.max()) == (pytest.approx(1.0), pytest.approx(32.0, rel=0.1))
    text = words(figure)
    assert {"$q_0 = q_r$", "$q_r$", "$q_1$"} <= set(text)
    assert r"$\propto q^{-2(1+H)}$, $H = 0.7$ above $q_r$" in text


def test_a_swept_hurst_exponent_is_in_no_label(
    small_spec: dict[str, Any], lay_out: Draw
) -> None:
    small_spec["sweep"] = {"surface.H": [0.5, 0.9]}
    text = legend_words(lay_out(rb.run(small_spec), "spectrum"))
    assert r"$\propto q^{-2(1+H)}$ above $q_r$" in text
    assert [word for word in text if "$H = " in word] == ["$H = 0.5$", "$H = 0.9$"]


def test_a_single_rolloff_is_compared_with_none(small_spec: dict[str, Any], draw: Draw) -> None:
    results = rb.run(small_spec)
    (line,) = by_gid(draw(results, "spectrum"), "without roll-off")
    q, power = np.log(np.asarray(line.get_xydata())).T
    assert (power[1] - power[0]) / (q[1] - q[0]) == pytest.approx(-3.4)
    small_spec["surface"]["qr"] = 1.0
    figure = draw(rb.run(small_spec), "spectrum")
    assert by_gid(figure, "without roll-off") == []


@pytest.mark.parametrize("amplitude", ["fixed", "gaussian"])
def test_the_periodogram_of_a_line_is_the_spectrum(
    small_spec: dict[str, Any], amplitude: str
) -> None:
    """Fixed amplitudes carry C exactly; those of Gaussian ones scatter as 1/√modes."""
    small_spec["surface"] |= {"amplitude": amplitude, "q1": 2000.0, "qr": 1.0}
    small_spec["models"][0]["springs"] = 4096
    spec = load_spec(small_spec)
    assert isinstance(spec.surface, SelfAffineSurface)
    realized = realized_spectrum(spec, spec.surface)
    assert realized is not None
    kind, q, power = realized
    ratio = power / spec.surface.spectrum().psd_2d(q)
    assert kind == "line"
    # A mean over values within e^±w of each other is at most cosh w above the geometric one.
    bend = np.cosh(3.4 * np.log(10.0) / RINGS_PER_DECADE / 2.0) - 1.0
    if amplitude == "fixed":
        assert ratio.min() > 1.0 - 1e-9
        assert ratio.max() < 1.0 + bend
    else:  # one mode's power has a relative deviation of 1; a ring of width dq holds dq of them
        modes = np.maximum(q * np.log(10.0) / RINGS_PER_DECADE, 1.0)
        deviation = (ratio - 1.0) * np.sqrt(modes)
        assert (np.abs(deviation) < 4.5 + bend * np.sqrt(modes)).all()
        assert np.abs(deviation).max() > 0.5


# -- the foundation, Fig. 1 ----------------------------------------------------------------


def test_the_springs_are_those_of_the_results(computed: Results, draw: Draw) -> None:
    pressed = most_telling(computed)
    result = computed[pressed.experiment]["foundation"]
    length, height = float(result.attributes["length"]), pressed.rms_height
    chosen = int(np.flatnonzero(result["pressure"] == pressed.pressure)[0])
    separation = result["separation"][0, chosen]
    compression = np.maximum(-pressed.clearance, 0.0)
    assert 4.0 / np.pi * compression.mean() / length == pytest.approx(pressed.pressure)
    assert pressed.separation == pytest.approx(separation, rel=1e-9)
    assert pressed.share == pytest.approx(result["springs_in_contact"][0, chosen] / 128)
    # The line itself, made again: clearance is d - h, with d = ū + <h> - <δ>.
    spec = dict(load_spec(computed.spec_text).experiments())[pressed.experiment]
    assert isinstance(spec.surface, SelfAffineSurface)
    heights = make_sample(spec.surface, spec.models[0], spec.seed, 0).heights
    assert heights is not None
    level = separation + heights.mean() - compression.mean()
    np.testing.assert_allclose(pressed.clearance, level - heights, atol=1e-12 * height)

    figure = draw(computed, "foundation")
    (punch,) = by_gid(figure, "punch")
    np.testing.assert_array_equal(punch.get_ydata(), pressed.clearance / height)
    (springs,) = [c for c in figure.findobj(LineCollection) if c.get_gid() == "springs"]
    window = choose_window(pressed.clearance < 0.0)
    index = window.start + window.step * np.arange(window.count)
    ends = np.array([segment[-1] for segment in springs.get_segments()])
    np.testing.assert_allclose(ends[:, 0], index)
    np.testing.assert_allclose(ends[:, 1], np.minimum(pressed.clearance[index] / height, 0.0))
    colours = np.asarray(springs.get_colors())
    compressed = pressed.clearance[index] < 0.0
    assert len(np.unique(colours[compressed], axis=0)) == 1
    assert np.any(colours[compressed][0] != colours[~compressed], axis=1).all()


def test_the_state_with_the_most_regions_is_shown(computed: Results) -> None:
    states = list(pressed_lines(computed))
    assert {(one.experiment, one.pressure) for one in states} == {
        (name, pressure)
        for name, models in computed.items()
        for pressure in models["foundation"]["field_nominal_pressure"].tolist()
        if models["foundation"]["separation"][
            0, models["foundation"]["pressure"].tolist().index(pressure)
        ]
    }
    shown = most_telling(computed)
    assert 0.05 <= shown.share <= 0.35
    assert shown.regions == max(one.regions for one in states if 0.05 <= one.share <= 0.35)


@pytest.mark.parametrize("n", [3, 47, 48, 500, 8192])
def test_a_window_is_found_on_every_line(n: int, rng: np.random.Generator) -> None:
    smooth = np.convolve(rng.normal(size=n + 8), np.ones(9), mode="valid")
    for share in (0.0, 0.02, 0.4, 1.0):
        in_contact = smooth > np.quantile(smooth, 1.0 - share) - (share == 1.0)
        window = choose_window(in_contact)
        assert 0 <= window.start < window.stop <= n
        assert window.count == min(WINDOW, len(in_contact[:: window.step]))


def test_the_window_shows_three_regions_if_it_can() -> None:
    in_contact = np.zeros(1000, bool)
    for start in (500, 512, 530):
        in_contact[start : start + 8] = True
    window = choose_window(in_contact)
    seen = in_contact[window.start : window.stop : window.step]
    assert window.step == 1
    assert np.count_nonzero(np.diff(np.concatenate([[0], seen.astype(int)])) == 1) == 3
    assert 0.3 <= seen.mean() <= 0.6


# -- layout --------------------------------------------------------------------------------


def boxes(figure: Figure) -> list[tuple[str, Any]]:
    """Return what is written, and where, in pixels; tick labels of the same axis excepted."""
    ticks = {
        id(label)
        for axes in figure.axes
        for part in (axes, *axes.child_axes)
        if isinstance(part, Axes)
        for axis in (part.xaxis, part.yaxis)
        for label in axis.get_ticklabels(which="both")
    }
    found = []
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text.get_text().strip() and text.get_visible() and id(text) not in ticks:
            found.append((text.get_text(), text.get_window_extent()))
    return found


@pytest.mark.parametrize(
    "name", ["foundation", "spectrum", "area", "separation", "stiffness", "fig3"]
)
@pytest.mark.parametrize("single", [False, True])
def test_no_text_overlaps_another_or_leaves_the_figure(
    computed: Results, lay_out: Draw, name: str, *, single: bool
) -> None:
    results = computed
    if single:
        tree = load_spec(computed.spec_text).as_given()
        del tree["sweep"]
        results = rb.run(tree)
    figure = lay_out(results, name)
    with publication_style():  # fonts are looked up when text is measured
        written = boxes(figure)
        places = [legend.get_window_extent() for legend in figure.legends]
    assert all(axes.get_legend() is None for axes in figure.axes)
    for place, axes in itertools.product(places, figure.axes):  # off the data
        assert not place.overlaps(axes.get_window_extent())
    for axes in figure.axes:  # which rms height stands below, not on an axis
        assert "continuum" not in axes.get_ylabel()
        assert "\n" not in axes.get_ylabel()
    assert len(written) >= 3
    for text, box in written:
        assert box.x0 >= -0.5, text
        assert box.y0 >= -0.5, text
        assert box.x1 <= figure.bbox.x1 + 0.5, text
        assert box.y1 <= figure.bbox.y1 + 0.5, text
    for (text, box), (other, place) in itertools.combinations(written, 2):
        assert not box.overlaps(place), f"{text!r} overlaps {other!r}"
