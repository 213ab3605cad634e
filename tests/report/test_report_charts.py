"""The charts hold the numbers of the results, and only what can be drawn."""

from __future__ import annotations

import io
import json
import math
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

from roughbench.figures.curves import curve_of
from roughbench.report.charts import ReportChart
from roughbench.report.curves import charted, pressure_charts
from roughbench.report.maps import MOST_MAPS, field_maps
from roughbench.report.observables import (
    drawn_pressures,
    observable_charts,
)
from roughbench.report.pictures import MOST_POINTS
from roughbench.report.sources import ReportSource
from roughbench.report.styles import experiment_dashes, page_styles
from roughbench.report.text import plotly_text
from roughbench.results import Results
from tests.report.conftest import EXPERIMENTS, LABELS, Change, Page, page_of


def parsed(chart: ReportChart) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(json.dumps(chart.data, allow_nan=False))
    return data


def charts_of(results: Results) -> dict[str, dict[str, Any]]:
    source = ReportSource("r.h5", results)
    styles = page_styles([source])
    charts = [*pressure_charts(source, styles), *observable_charts(source, styles)]
    return {chart.key: parsed(chart) for chart in charts}


def curves(chart: dict[str, Any], **meta: str) -> list[dict[str, Any]]:
    return [t for t in chart["curves"] if meta.items() <= t["meta"].items()]


def test_every_quantity_has_a_chart_with_every_curve(small: Results) -> None:
    charts = charts_of(small)
    assert list(charts) == [plot.key for plot in charted()]
    for chart in charts.values():
        found = [(t["meta"]["experiment"], t["meta"]["model"]) for t in curves(chart)]
        assert found == [(e, m) for e in EXPERIMENTS for m in LABELS]


def test_a_curve_holds_the_numbers_of_the_results(small: Results) -> None:
    charts = charts_of(small)
    result = small["surface.qr=4.0"]["bem"]
    pressure, height = result["pressure"], result.attributes["rms_height"]
    stiffness = curve_of(result, "stiffness").value
    expected = {
        "area": result["area_mean"],
        "kappa": result["area_mean"] * 0.1 / pressure,
        "separation": result["separation_mean"] / height,
        "stiffness": stiffness,
        "stiffness-by-pressure": stiffness / pressure,
    }
    for key, values in expected.items():
        (trace,) = curves(charts[key], model="bem", experiment="surface.qr=4.0")
        assert trace["x"] == pytest.approx(pressure, rel=1e-6)
        there = [math.nan if y is None else y for y in trace["y"]]
        assert there == pytest.approx(
            np.where(np.isinf(values), math.nan, values), rel=1e-6, nan_ok=True
        )
        assert len(trace["text"]) == len(pressure)


def test_a_band_is_one_standard_error_wide(small: Results) -> None:
    (trace,) = curves(charts_of(small)["area"], model="bem", experiment="surface.qr=1.0")
    result = small["surface.qr=1.0"]["bem"]
    mean, error = result["area_mean"], result["area_sem"]
    assert trace["upper"] == pytest.approx(mean + error, rel=1e-6)
    assert trace["lower"] == pytest.approx(mean - error, rel=1e-6)


def test_a_theory_has_no_band(small: Results) -> None:
    found = curves(charts_of(small)["area"], model="persson")
    assert found
    assert not any({"lower", "upper"} & set(trace) for trace in found)


def test_hovering_shows_value_and_error(small: Results) -> None:
    (trace,) = curves(charts_of(small)["area"], model="bem", experiment="surface.qr=1.0")
    result = small["surface.qr=1.0"]["bem"]
    first = trace["text"][0]
    assert first.startswith("p/E* = 0.001<br>A/A<sub>0</sub> = 0.0")
    shown = float(first.rpartition("= ")[2].partition(" ±")[0].strip("("))
    assert shown == pytest.approx(result["area_mean"][0], abs=result["area_sem"][0] / 10)


def test_a_band_that_reaches_zero_and_a_gap(small: Results, change: Change) -> None:
    mean = np.array([1e-3, 2e-3, np.nan, 4e-3, 5e-3, 6e-3])
    changed = change(small, area_mean=mean, area_sem=2.0 * mean)
    chart = charts_of(changed)["area"]
    (curve,) = curves(chart, model="bem", experiment="surface.qr=1.0")
    for name in ("y", "lower", "upper"):
        assert [value is None for value in curve[name]] == [k == 2 for k in range(6)]
    assert min(y for y in curve["lower"] if y is not None) == pytest.approx(1e-6)


def test_full_contact_is_no_point_and_no_zoom(small: Results, change: Change) -> None:
    mean = np.array([1e-3, 1e-2, 0.1, 1.0, 1e9, np.inf]) / 0.02
    changed = change(small, stiffness_mean=mean, stiffness_median=mean)
    chart = charts_of(changed)["stiffness"]
    (curve,) = curves(chart, model="bem", experiment="surface.qr=1.0")
    assert curve["y"][5] is None
    assert curve["y"][4] > 1e8
    assert chart["ranges"]["log"][1] < 3.0


def test_models_look_different_and_the_same_in_all_files(small: Results) -> None:
    other = Results({"main": dict(reversed(list(small["surface.qr=1.0"].items())))}, "", "")
    styles = page_styles([ReportSource("a", small), ReportSource("b", other)])
    assert list(styles) == list(LABELS)
    assert len({(style.colour, style.symbol) for style in styles.values()}) == 3
    assert page_styles([ReportSource("a", small)]) == styles
    assert len(set(experiment_dashes(EXPERIMENTS).values())) == 2


def test_an_experiment_is_shown_alone_where_there_are_many_curves(small: Results) -> None:
    models = small["surface.qr=1.0"]
    three = Results(dict.fromkeys("abc", models), small.spec_text, "", "")

    def ticked(results: Results) -> list[str | None]:
        boxes = [given for _, given in Page(page_of(results)).elements]
        return [b["value"] for b in boxes if b.get("name") == "experiment" and "checked" in b]

    assert ticked(three) == ["a"]
    assert ticked(small) == list(EXPERIMENTS)


# -- observables -------------------------------------------------------------------------


@pytest.fixture
def observed(small: Results, change: Change) -> Results:
    places = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
    mean = np.outer(np.arange(1.0, 7.0), [0.0, 1.0, np.nan, 0.5, 0.0])
    return change(
        small,
        pressure_pdf_bin=places,
        pressure_pdf_edges=np.arange(6.0),
        pressure_pdf_mean=mean,
        pressure_pdf_sem=0.1 * mean,
        pressure_pdf_persson=mean / 2.0,
    )


def test_observables_are_drawn_at_every_pressure_if_they_are_there(
    small: Results, observed: Results
) -> None:
    assert len(charts_of(small)) == 5
    charts = charts_of(observed)
    assert list(charts)[5:] == ["pressure-pdf"]
    chart = charts["pressure-pdf"]
    assert {t["meta"]["model"] for t in chart["curves"]} == {"bem"}
    assert len({t["meta"]["pressure"] for t in chart["curves"]}) == 6
    first = chart["curves"][0]["meta"]["pressure"]
    curve, theory = (
        t
        for t in chart["curves"]
        if t["meta"]["pressure"] == first and "1.0" in t["meta"]["experiment"]
    )
    assert curve["x"] == [1.0, 4.0]  # no empty ends, no bins that are none
    assert curve["y"] == [1.0, 0.5]
    assert theory["y"] == [0.5, 0.25]
    assert (curve["upper"], curve["lower"]) == ([1.1, 0.55], [0.9, 0.45])


def test_spectra_of_lines_stand_for_those_of_surfaces(small: Results, change: Change) -> None:
    q, mean = np.array([1.0, 2.0]), np.ones((6, 2))
    changed = change(
        small,
        "foundation",
        {"dimension": 1},
        contact_spectrum_bin=q,
        contact_spectrum_mean=mean,
        contact_spectrum_sem=0.0 * mean,
    )
    (curve, *_) = curves(charts_of(changed)["contact-spectrum"])
    assert curve["y"] == [0.3183, 0.1592]  # 1/(πq), to the digits of a picture


def test_only_some_of_many_pressures_are_drawn(small: Results, change: Change) -> None:
    pressure = np.geomspace(1e-4, 1.0, 40)
    changed = change(small, pressure=pressure, clusters_bin=np.ones(2))
    chosen = drawn_pressures(ReportSource("r.h5", changed))
    assert len(chosen) == 8
    assert chosen[0] == pressure[0]
    assert chosen[-1] == pressure[-1]
    assert drawn_pressures(ReportSource("r.h5", small)) == []


def test_fields_become_maps(small: Results, change: Change) -> None:
    field = np.zeros((1, 2 * MOST_POINTS, 8))
    field[0, :2, 1] = 0.1, 0.3  # of E* ξ, with ξ = 0.1: 1 and 3
    field[0, 4, 2] = 1e-9
    changed = change(
        small,
        field_pressure=field,
        field_realization=np.array([3]),
        field_nominal_pressure=np.array([0.01]),
    )
    maps = field_maps(ReportSource("r.h5", changed))
    assert [plotly_text(one.title) for one in maps] == [
        f"Exact (BEM), q<sub>r</sub>/q<sub>0</sub>\xa0=\xa0{qr}, p/E* = 0.01, realization 3"
        for qr in (1, 4)
    ]
    pixels = imread(io.BytesIO(maps[0].image), "png")[::-1, :, :3]  # the first row is below
    assert pixels.shape == (MOST_POINTS, 8, 3)
    touching = {
        (int(row), int(column)) for row, column in np.argwhere(pixels.min(axis=2) < 1.0)
    }
    assert touching == {(0, 1), (2, 2)}  # whatever touches is seen
    assert pixels[0, 1] == pytest.approx(np.array([0x1D, 0x2A, 0x5E]) / 255.0)
    assert field_maps(ReportSource("r.h5", small)) == []


def test_maps_stand_on_the_page_and_more_are_counted(small: Results, change: Change) -> None:
    changed = change(small, field_pressure=np.zeros((MOST_MAPS, 4, 4)))
    page = Page(page_of(changed))
    pictures = [given for tag, given in page.elements if tag == "img"]
    assert len(pictures) == MOST_MAPS
    assert all((given["src"] or "").startswith("data:image/png;base64,") for given in pictures)
    assert all(given["alt"] for given in pictures)
    assert f"{MOST_MAPS} more fields are in the file" in page.text


def test_a_stripe_is_a_line(small: Results, change: Change) -> None:
    changed = change(small, field_pressure=np.full((1, 16), 0.05))
    first = field_maps(ReportSource("r.h5", changed))[0]
    assert first.is_line
    assert imread(io.BytesIO(first.image), "png").shape[:2] == (1, 16)
