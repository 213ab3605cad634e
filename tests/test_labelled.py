"""Results and states as xarray's datasets and pandas' tables."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.results import ModelResult, Results

SWEEP = {"surface.qr": [1.0, 4.0], "seed": [7, 8, 9]}


@pytest.fixture(scope="module")
def results() -> Results:
    """Return what is only looked at."""
    return rb.run(
        {
            "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
            "pressures": [1e-4, 1e-3, 1e-2],
            "realizations": 20,
            "models": [{"kind": "foundation", "springs": 128}, {"kind": "persson"}],
            "sweep": SWEEP,
        }
    )


def test_the_sweep_is_a_dimension_for_each_key(results: Results) -> None:
    data = results.to_xarray("foundation")
    assert dict(data.sizes) == {"qr": 2, "seed": 3, "realization": 20, "pressure": 3}
    for experiment, models in results.items():
        qr, seed = (float(part.partition("=")[2]) for part in experiment.split(","))
        one = data.sel(qr=qr, seed=seed)
        for name in ("area", "stiffness_mean", "rms_height", "status"):
            np.testing.assert_array_equal(one[name], models["foundation"][name])
    assert data.stiffness.attrs["units"] == "1/length"
    assert data.attrs["label"] == "foundation"
    assert "seed" not in data.attrs  # of one experiment
    tree = results.to_xarray()
    assert list(tree.children) == ["foundation", "persson"]
    assert tree.attrs["spec_sha256"] == results.spec_sha256
    assert tree["persson"].dataset.area_mean.dims == ("qr", "seed", "pressure")


def test_what_is_no_product_goes_along_experiments(results: Results) -> None:
    kept = dict([*results.experiments.items()][:4])
    data = Results(kept, "", "").to_xarray("persson")
    assert data.area_mean.dims == ("experiment", "pressure")
    assert data.qr.values.tolist() == [1.0, 1.0, 1.0, 4.0]
    assert data.experiment.values.tolist() == [*kept]
    plain = Results(dict(zip("ab", kept.values(), strict=False)), "", "").to_xarray("persson")
    assert plain.area_mean.dims == ("experiment", "pressure")


def test_what_an_experiment_lacks_is_nan(small_spec: dict[str, Any]) -> None:
    first = rb.run(small_spec)["main"]
    second = rb.run(small_spec | {"pressures": [1e-3, 2e-2], "realizations": 5})["main"]
    data = Results({"a": first, "b": second}, "", "").to_xarray("foundation")
    assert data.pressure.values.tolist() == [1e-4, 1e-3, 1e-2, 2e-2]
    assert np.isnan(data.area.sel(experiment="b", pressure=1e-4)).all()
    found = data.area.sel(experiment="b", pressure=[1e-3, 2e-2]).dropna("realization")
    np.testing.assert_array_equal(found, second["foundation"]["area"])


def test_bins_that_differ_are_variables(results: Results) -> None:
    one = results["surface.qr=1.0,seed=7"]["foundation"]
    bins, pdf = np.array([1.0, 2.0]), np.zeros((20, 3, 2))

    def with_bins(bins: Any, pdf: Any = pdf) -> ModelResult:
        more = {"gap_pdf": pdf, "gap_pdf_bin": bins}
        return ModelResult(one.label, one.kind, one.title, {}, {**one.variables, **more})

    def joined(*models: ModelResult) -> Any:
        named = dict(zip("ab", ({"foundation": m} for m in models), strict=True))
        return Results(named, "", "").to_xarray("foundation")

    data = joined(with_bins(bins), with_bins(2 * bins))
    assert data.gap_pdf.dims == ("experiment", "realization", "pressure", "gap_pdf_bin")
    assert data.gap_pdf_bin_value.values.tolist() == [[1.0, 2.0], [2.0, 4.0]]
    assert joined(with_bins(bins), with_bins(bins)).gap_pdf_bin.values.tolist() == [1.0, 2.0]
    with pytest.raises(rb.RoughbenchError, match=r"gap_pdf_bin has 1 values in one .* and 2"):
        joined(with_bins(bins), with_bins(bins[:1], pdf[..., :1]))


def test_a_model_that_is_not_there(results: Results) -> None:
    with pytest.raises(rb.RoughbenchError, match="did you mean 'persson'"):
        results.to_xarray("person")


def test_a_table_of_all_curves(results: Results) -> None:
    frame = results.to_frame()
    assert len(frame) == 6 * 2 * 3
    assert list(frame.columns[:5]) == ["experiment", "qr", "seed", "model", "pressure"]
    row = frame[(frame.qr == 4.0) & (frame.seed == 9.0) & (frame.model == "persson")]
    expected = results["surface.qr=4.0,seed=9"]["persson"]
    assert row.stiffness_mean.tolist() == expected["stiffness_mean"].tolist()
    assert frame.attrs["units"]["separation_mean"] == "length"
    states = results.to_frame(averages=False)
    assert len(states) == 6 * (20 + 1) * 3
    foundation = results["surface.qr=1.0,seed=7"]["foundation"]
    own = foundation.to_frame(averages=False)
    assert own.area.tolist() == foundation["area"].ravel().tolist()
    assert own.rms_height.tolist() == np.repeat(foundation["rms_height"], 3).tolist()
    assert own.pressure.tolist() == [*foundation["pressure"]] * 20
    assert foundation.to_frame().area_mean.tolist() == foundation["area_mean"].tolist()


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_without_the_package_the_command_that_adds_it(
    results: Results, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(rb.RoughbenchError, match=rf"needs {package}.*pip install 'roughbench"):
        _ = results.to_xarray("persson") if package == "xarray" else results.to_frame()


def test_trees_need_an_xarray_that_has_them(
    results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    import xarray

    monkeypatch.delattr(xarray, "DataTree")
    with pytest.raises(rb.RoughbenchError, match=r"has no DataTree.*--upgrade"):
        results.to_xarray()
    assert "area" in results.to_xarray("persson")


def test_a_state_is_a_dataset() -> None:
    heights = 0.01 * np.cos(2 * np.pi * np.arange(64) / 64)
    state = rb.solve_contact(heights, 0.005, length=2.0)
    data = state.to_xarray()
    assert state.size == (2.0,)
    assert data.x.values[1] == pytest.approx(2.0 / 64)
    np.testing.assert_array_equal(data.pressure, state.pressure)
    np.testing.assert_array_equal(data.gap, state.gap)
    assert data.attrs["mean_separation"] == state.mean_separation
    assert data.attrs["status"] == "converged"
    assert data.attrs["complementarity"] == state.certificate.complementarity


def test_surfaces_from_a_seed_are_those_of_realization_0() -> None:
    spectrum = rb.self_affine(hurst=0.8, q_min=1, q_rolloff=2, q_max=8, rms_slope=0.1)
    for make in (rb.make_surface, rb.make_profile):
        seeded = make(spectrum, 32, 2 * np.pi, 5)
        drawn = make(spectrum, 32, 2 * np.pi, rb.realization_generator(5, 0))
        np.testing.assert_array_equal(seeded, drawn)
        with pytest.raises(rb.SurfaceError, match="seed of a surface must be a whole number"):
            make(spectrum, 32, 2 * np.pi, 0.5)  # type: ignore[arg-type]
