"""The charts hold the numbers of the results, and only what can be drawn."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import numpy as np
import pytest

from roughbench.figures.curves import curve_of
from roughbench.report.charts import Chart
from roughbench.report.curves import PLOTS, curve_charts
from roughbench.report.looks import experiment_dashes, model_looks
from roughbench.report.observables import (
    MOST_POINTS,
    drawn_pressures,
    field_charts,
    observable_charts,
)
from roughbench.report.sources import Source
from roughbench.results import Results
from tests.report.conftest import EXPERIMENTS, LABELS, Change, Page, page_of


def parsed(chart: Chart) -> dict[str, Any]:
    def refuse(name: str) -> float:
        raise AssertionError(f"{name} is no JSON")

    content: dict[str, Any] = json.loads(chart.content, parse_constant=refuse)
    return content


def charts_of(results: Results) -> dict[str, dict[str, Any]]:
    source = Source("r.h5", results)
    looks = model_looks([source])
    charts = [*curve_charts(source, looks), *observable_charts(source, looks)]
    return {chart.key: parsed(chart) for chart in charts}


def traces(chart: dict[str, Any], role: str = "curve", **meta: str) -> list[dict[str, Any]]:
    wanted = {"role": role, **meta}
    return [t for t in chart["data"] if wanted.items() <= t["meta"].items()]


def test_every_quantity_has_a_chart_with_every_curve(small: Results) -> None:
    charts = charts_of(small)
    assert list(charts) == [plot.key for plot in PLOTS]
    for chart in charts.values():
        curves = [(t["meta"]["experiment"], t["meta"]["model"]) for t in traces(chart)]
        assert curves == [(e, m) for e in EXPERIMENTS for m in LABELS]


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
        (trace,) = traces(charts[key], model="bem", experiment="surface.qr=4.0")
        assert trace["x"] == pytest.approx(pressure, rel=1e-6)
        there = [math.nan if y is None else y for y in trace["y"]]
        assert there == pytest.approx(
            np.where(np.isinf(values), math.nan, values), rel=1e-6, nan_ok=True
        )
        assert len(trace["text"]) == len(pressure)


def test_a_band_is_one_standard_error_wide(small: Results) -> None:
    (band,) = traces(charts_of(small)["area"], "band", model="bem", experiment="surface.qr=1.0")
    result = small["surface.qr=1.0"]["bem"]
    mean, error = result["area_mean"], result["area_sem"]
    assert band["y"] == pytest.approx([*(mean + error), *(mean - error)[::-1]], rel=1e-6)
    assert band["fill"] == "toself"


def test_a_theory_has_no_band(small: Results) -> None:
    for band in traces(charts_of(small)["area"], "band", model="persson"):
        assert band["x"] == []


def test_hovering_shows_value_and_error(small: Results) -> None:
    (trace,) = traces(charts_of(small)["area"], model="bem", experiment="surface.qr=1.0")
    result = small["surface.qr=1.0"]["bem"]
    first = trace["text"][0]
    assert first.startswith("p/E* = 0.001<br>A/A<sub>0</sub> = 0.0")
    shown = float(first.rpartition("= ")[2].partition(" ±")[0].strip("("))
    assert shown == pytest.approx(result["area_mean"][0], abs=result["area_sem"][0] / 10)


def test_a_band_that_reaches_zero_and_a_gap(small: Results, change: Change) -> None:
    mean = np.array([1e-3, 2e-3, np.nan, 4e-3, 5e-3, 6e-3])
    changed = change(small, area_mean=mean, area_sem=2.0 * mean)
    chart = charts_of(changed)["area"]
    (band,) = traces(chart, "band", model="bem", experiment="surface.qr=1.0")
    assert band["x"].count(None) == 1  # two polygons
    assert min(y for y in band["y"] if y is not None) == pytest.approx(1e-6)
    (curve,) = traces(chart, model="bem", experiment="surface.qr=1.0")
    assert curve["y"][2] is None


def test_full_contact_is_no_point_and_no_zoom(small: Results, change: Change) -> None:
    mean = np.array([1e-3, 1e-2, 0.1, 1.0, 1e9, np.inf]) / 0.02
    changed = change(small, stiffness_mean=mean, stiffness_median=mean)
    chart = charts_of(changed)["stiffness"]
    (curve,) = traces(chart, model="bem", experiment="surface.qr=1.0")
    assert curve["y"][5] is None
    assert curve["y"][4] > 1e8
    assert chart["ranges"]["log"][1] < 3.0


def test_models_look_different_and_the_same_in_all_files(small: Results) -> None:
    other = Results({"main": dict(reversed(list(small["surface.qr=1.0"].items())))}, "", "")
    looks = model_looks([Source("a", small), Source("b", other)])
    assert list(looks) == list(LABELS)
    assert len({(look.colour, look.symbol) for look in looks.values()}) == 3
    assert model_looks([Source("a", small)]) == looks
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
    assert {t["meta"]["model"] for t in chart["data"]} == {"bem"}
    assert len({t["meta"]["pressure"] for t in chart["data"]}) == 6
    first = chart["data"][0]["meta"]["pressure"]
    band, curve, theory = (
        t
        for t in chart["data"]
        if t["meta"]["pressure"] == first and "1.0" in t["meta"]["experiment"]
    )
    assert curve["x"] == [1.0, 4.0]  # no empty ends, no bins that are none
    assert curve["y"] == [1.0, 0.5]
    assert theory["y"] == [0.5, 0.25]
    assert band["y"] == pytest.approx([1.1, 0.55, 0.45, 0.9])


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
    (curve, *_) = traces(charts_of(changed)["contact-spectrum"])
    assert curve["y"] == pytest.approx(1.0 / (np.pi * q), rel=1e-6)


def test_only_some_of_many_pressures_are_drawn(small: Results, change: Change) -> None:
    pressure = np.geomspace(1e-4, 1.0, 40)
    changed = change(small, pressure=pressure, clusters_bin=np.ones(2))
    chosen = drawn_pressures(Source("r.h5", changed))
    assert len(chosen) == 8
    assert chosen[0] == pressure[0]
    assert chosen[-1] == pressure[-1]
    assert drawn_pressures(Source("r.h5", small)) == []


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
    maps = field_charts(Source("r.h5", changed))
    assert [chart.title for chart in maps] == [
        f"bem, q<sub>r</sub>\xa0=\xa0{qr}, p/E* = 0.01, realization 3" for qr in (1, 4)
    ]
    z = parsed(maps[0])["data"][0]["z"]
    assert z["dtype"] == "u1"
    assert z["shape"] == f"{MOST_POINTS}, 8"
    pixels = np.frombuffer(base64.b64decode(z["bdata"]), np.uint8).reshape(MOST_POINTS, 8)
    assert pixels[0, 1] == 255
    assert pixels[2, 2] == 1  # whatever touches is seen
    assert np.count_nonzero(pixels) == 2
    assert field_charts(Source("r.h5", small)) == []
