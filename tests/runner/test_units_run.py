"""Results with units: in SI, the same physics as without, and resumed like any other."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pint
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

import roughbench as rb
from roughbench.errors import StoreError
from roughbench.fits import fit
from roughbench.runner import preview, status, verify
from roughbench.store import write_results
from roughbench.verdict import judge

_REGISTRY: pint.UnitRegistry[float] = pint.UnitRegistry()

MODULUS = 2.5e9 / (1 - 0.25)  # Pa
LENGTH = 10e-6  # m, of the bare spec's 2π

PLATE: dict[str, Any] = {
    "name": "plate",
    "surface": {
        "H": 0.8,
        "longest": "10 um",
        "rolloff": "2.5 um",
        "shortest": "625 nm",
        "rms_height": "12 nm",
    },
    "modulus": {"E": "2.5 GPa", "nu": 0.5},
    "pressures": {"min": "100 kPa", "max": "100 MPa", "points": 7},
    "realizations": 3,
    "seed": 5,
    "models": [{"kind": "bem"}, {"kind": "foundation", "springs": 256}, {"kind": "persson"}],
}
BARE: dict[str, Any] = PLATE | {
    "surface": {"H": 0.8, "q0": 1.0, "qr": 4.0, "q1": 16.0, "rms_height": 2.4e-3 * math.pi},
    "modulus": None,
    "pressures": {"min": 1e5 / MODULUS, "max": 1e8 / MODULUS, "points": 7},
}
del BARE["modulus"]
FIELDS = {
    "observables": ["stress_spectrum", "energy", "pressure_pdf", "clusters"],
    "save_fields": {"pressures": ["10 MPa"]},
}


@pytest.fixture(scope="module")
def plate() -> rb.Results:
    return rb.run(PLATE)


@pytest.fixture(scope="module")
def bare() -> rb.Results:
    return rb.run(BARE)


def test_the_numbers_are_those_of_the_bare_spec_in_si(
    plate: rb.Results, bare: rb.Results
) -> None:
    unit = LENGTH / (2 * math.pi)  # m, of the bare spec
    scales = {"Pa": MODULUS, "1": 1.0, "m": unit, "Pa/m": MODULUS / unit}
    scales["J/m^2"] = MODULUS * unit
    for label, expected in bare["main"].items():
        found = plate["main"][label]
        assert set(found) == set(expected)
        for name in expected:
            if name in ("iterations", "transform_pairs", "complementarity", "load_error"):
                continue
            scale = scales[found.units(name)]
            np.testing.assert_allclose(
                found[name], expected[name] * scale, rtol=1e-5, atol=1e-12 * scale
            )
        np.testing.assert_allclose(found["area"], expected["area"], rtol=1e-9)


def test_the_variables_say_their_units(plate: rb.Results, tmp_path: Path) -> None:
    path = tmp_path / "plate.h5"
    rb.run(PLATE, output=path)
    expected = {
        "pressure": ("Pa", "nominal pressure p"),
        "area": ("1", "real contact area A/A0"),
        "separation_sem": ("m", "mean separation, standard error of the mean"),
        "stiffness": ("Pa/m", "contact stiffness K"),
        "stiffness_harmonic": ("Pa/m", "harmonic mean of the contact stiffness K"),
        "energy_median": ("J/m^2", "elastic energy U/A0, median"),
        "rms_height": ("m", "rms height of the realized surface"),
        "rms_slope": ("1", "rms slope of the realized surface"),
    }
    with h5py.File(path) as file:
        group = file["main/bem"]
        for name, (unit, words) in expected.items():
            assert (group[name].attrs["units"], group[name].attrs["long_name"]) == (unit, words)
            _REGISTRY.Unit(unit)  # pint understands it
        assert group.attrs["contact_modulus"] == MODULUS
        assert group.attrs["length"] == pytest.approx(LENGTH, rel=1e-15)
        assert group.attrs["rms_height"] == pytest.approx(12e-9, rel=1e-12)
    with xarray.open_dataset(path, group="main/bem", engine="h5netcdf") as data:
        stiffness = data["stiffness_mean"]
        assert stiffness.dims == ("pressure",)
        first = _REGISTRY.Quantity(float(stiffness[0]), stiffness.attrs["units"])
        assert first.to("MPa/nm").magnitude == pytest.approx(float(stiffness[0]) * 1e-15)
    again = rb.load(path)["main"]["bem"]
    assert (again.has_units, again.modulus) == (True, MODULUS)
    assert again["pressure"][0] == pytest.approx(1e5, rel=1e-15)
    for name in again:
        np.testing.assert_array_equal(again[name], plate["main"]["bem"][name])


def test_reduced_results_are_without_units(plate: rb.Results, bare: rb.Results) -> None:
    reduced = plate.reduced()["main"]["bem"]
    assert not reduced.has_units
    assert "contact_modulus" not in reduced.attributes
    np.testing.assert_allclose(reduced["pressure"], bare["main"]["bem"]["pressure"], rtol=1e-14)
    assert reduced.units("stiffness") == "1/length"
    assert bare.reduced() is bare
    result = bare["main"]["bem"]
    assert result.reduced() is result


def test_fits_and_verdicts_are_those_of_the_bare_spec(
    plate: rb.Results, bare: rb.Results
) -> None:
    one, other = (fit(results, resamples=20)["main"] for results in (plate, bare))
    compared = 0
    for label, names in other.items():
        for name, expected in names.items():
            if name in ("u0", "u0_from_stiffness"):  # lengths
                continue
            found = one[label][name]
            assert found.value == pytest.approx(expected.value, rel=1e-6, nan_ok=True)
            assert found.is_given == expected.is_given
            compared += math.isfinite(expected.value)
    assert compared > 20
    verdicts, known = (judge([("x", results)], resamples=20) for results in (plate, bare))
    assert [(v.key, v.outcome) for v in verdicts] == [(v.key, v.outcome) for v in known]


def spelled(
    lengths: str, pressures: str, factors: Mapping[str, float], shape: float
) -> dict[str, Any]:
    """Return a spec in the given units."""
    per_m, per_pa = factors[lengths], factors[pressures]
    of = {
        "longest": 1e-5,
        "rolloff": 1e-5 / shape,
        "shortest": 5e-7,
        "rms_height": 2e-8,
    }
    return {
        "surface": {"H": 0.7, **{k: f"{v * per_m!r} {lengths}" for k, v in of.items()}},
        "modulus": {"E": f"{2.5e9 * per_pa!r} {pressures}", "nu": 0.3},
        "pressures": [f"{p * per_pa!r} {pressures}" for p in (1e5, 1e6, 3e7)],
        "realizations": 2,
        "models": [
            {"kind": "foundation", "springs": 128},
            {"kind": "persson"},
            {"kind": "bem"},
        ],
    }


@settings(max_examples=10, deadline=None)
@given(
    st.sampled_from([*itertools.product(("um", "nm", "m"), ("GPa", "MPa", "Pa"))]),
    st.floats(1.0, 8.0),
)
def test_the_same_physics_in_other_units(units: tuple[str, str], shape: float) -> None:
    factors = {"m": 1.0, "um": 1e6, "nm": 1e9, "Pa": 1.0, "MPa": 1e-6, "GPa": 1e-9}
    one = rb.run(spelled("m", "Pa", factors, shape))["main"]
    other = rb.run(spelled(*units, factors, shape))["main"]
    for label in ("foundation", "persson"):
        for name in ("area", "separation", "stiffness", "energy", "pressure"):
            np.testing.assert_allclose(other[label][name], one[label][name], rtol=1e-10)
        np.testing.assert_allclose(other[label]["area"], one[label]["area"], rtol=1e-12)
    np.testing.assert_allclose(other["bem"]["area"], one["bem"]["area"], rtol=1e-12)


def test_fields_and_observables_are_in_si() -> None:
    spec = PLATE | FIELDS
    bem = rb.run(spec)["main"]["bem"]
    assert bem.units("field_pressure") == "Pa"
    assert bem["field_pressure"].mean() == pytest.approx(1e7, rel=1e-3)
    assert bem["field_nominal_pressure"].tolist() == pytest.approx([1e7], rel=1e-14)
    assert (bem.units("field_gap"), bem.units("x")) == ("m", "m")
    assert bem["field_gap"].max() < 1e-7
    assert bem["x"][-1] == pytest.approx(LENGTH * (1 - 1 / bem["x"].size), rel=1e-12)
    k = bem["pressure"].tolist().index(bem["field_nominal_pressure"][0])
    q, density = bem["stress_spectrum_bin"], bem["stress_spectrum_mean"][k]
    assert (bem.units("stress_spectrum_bin"), bem.units("stress_spectrum")) == (
        "1/m",
        "Pa^2*m^2",
    )
    edges = bem["stress_spectrum_edges"]
    variance = np.nansum(2 * math.pi * q * density * np.diff(edges))
    assert variance == pytest.approx(bem["field_pressure"].var(), rel=0.2)
    assert bem.units("stress_spectrum_variance_mean") == "Pa^2"
    assert bem["stress_spectrum_variance_mean"][k] == pytest.approx(variance, rel=0.2)
    assert bem.long_name("stress_spectrum") == "power spectrum C(q) of the contact pressure"
    assert bem.units("energy_spectrum_total") == "J/m^2"
    np.testing.assert_allclose(bem["energy_spectrum_total"], bem["energy"], rtol=1e-4)
    assert bem.units("pressure_pdf") == "1"
    for name in bem:
        _REGISTRY.Unit(bem.units(name))


def test_added_pressures_resume(tmp_path: Path) -> None:
    path = tmp_path / "plate.h5"
    few = PLATE | {"pressures": ["100 kPa", "10 MPa"], "models": [{"kind": "bem"}]}
    more = few | {"pressures": ["0.1 MPa", "1 MPa", "1e7 Pa"]}
    first = rb.run(few, output=path)["main"]["bem"]
    assert status(path).state == "complete"
    assert [part.reason for part in preview(few, output=path)] == ["done"]
    [row] = preview(more, output=path)
    assert (row.reason, row.done, row.states) == ("1 of 3 pressures are new", 6, 9)
    resumed = rb.run(more, output=path)["main"]["bem"]
    np.testing.assert_array_equal(resumed["area"][:, [0, 2]], first["area"])
    assert resumed["pressure"].tolist() == pytest.approx([1e5, 1e6, 1e7], rel=1e-15)
    assert verify(path)[1] == []
    assert status(path).done == 9


def test_another_modulus_keeps_what_depends_on_the_ratio_alone(tmp_path: Path) -> None:
    path = tmp_path / "plate.h5"
    rb.run(PLATE | {"pressures": ["100 kPa", "1 MPa", "100 MPa"]}, output=path)
    stiffer = PLATE | {
        "modulus": {"E": "20 GPa", "nu": 0.5},
        "pressures": ["800 kPa", "8 MPa", "800 MPa"],
    }
    rows = preview(stiffer, output=path)
    assert {row.reason for row in rows} == {"done"}
    bem = rb.run(stiffer, output=path)["main"]["bem"]
    assert bem["pressure"].tolist() == pytest.approx([8e5, 8e6, 8e8], rel=1e-15)
    assert bem.modulus == 8 * MODULUS


def test_heights_of_a_file_in_nanometers(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    wave = 2 * np.pi * np.arange(32) / 32
    heights = np.cos(wave)[:, None] * np.cos(2 * wave) + 0.1 * rng.standard_normal((32, 32))
    np.save(tmp_path / "h.npy", heights)
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: h.npy, length: 2 um, unit: nm}\n"
        "modulus: {E*: 3 GPa}\n"
        "pressures: [100 kPa, 3 MPa]\n"
        "models: [{kind: bem}, {kind: persson}]\n"
    )
    found = rb.run(tmp_path / "spec.yaml")["main"]
    expected = rb.solve_curve(heights * 1e-9, [1e5, 3e6], length=2e-6, modulus=3e9)
    np.testing.assert_allclose(found["bem"]["area"][0], expected.area, rtol=1e-4)
    np.testing.assert_allclose(found["bem"]["separation"][0], expected.separation, rtol=1e-5)
    np.testing.assert_allclose(found["bem"]["stiffness"][0], expected.stiffness, rtol=1e-3)
    np.testing.assert_allclose(found["bem"]["energy"][0], expected.energy, rtol=1e-5)
    assert found["bem"].attributes["rms_height"] == pytest.approx(heights.std() * 1e-9)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, 3])
def test_a_file_with_an_impossible_modulus_is_damaged(
    plate: rb.Results, tmp_path: Path, value: float
) -> None:
    result = plate["main"]["persson"]
    wrong = dataclasses.replace(
        result, attributes={**result.attributes, "contact_modulus": value}
    )
    path = tmp_path / "wrong.h5"
    write_results(rb.Results({"main": {"persson": wrong}}, "", ""), path)
    with pytest.raises(StoreError, match="contact_modulus"):
        rb.load(path)


def test_small_texts(plate: rb.Results) -> None:
    bem = plate["main"]["bem"]
    assert repr(bem).startswith(
        "ModelResult 'bem': Exact (BEM), 3 realizations, 7 pressures, p = 100 kPa … 100 MPa\n"
    )
    table = bem._repr_html_()
    assert "<th>p, MPa</th>" in table
    assert "<th>mean separation, nm</th>" in table
    assert "contact stiffness K, " in table
