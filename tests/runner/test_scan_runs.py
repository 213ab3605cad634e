"""A measured scan from the spec to its results: every contender, twins, the record of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

import roughbench as rb
from roughbench.runner import plan
from roughbench.runner.recording import records
from roughbench.spec import load_spec
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

SIDE = 10e-6
SPEC = """\
name: plate
surface: {kind: scan, path: plate.npy, size: [10 um, 5 um], unit: nm, edges: mirror, SURFACE}
modulus: {E: 3 GPa, nu: 0.5}
pressures: [1 MPa, 10 MPa]
realizations: 3
twins: 2
models: [{kind: bem}, {kind: foundation}, {kind: persson}, {kind: winkler}]
"""


def rough(seed: int = 1) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return 48 × 96 heights in nm: half of a periodic surface."""
    spectrum = self_affine(
        hurst=0.8,
        q_min=2 * np.pi / SIDE,
        q_rolloff=8 * np.pi / SIDE,
        q_max=48 * np.pi / SIDE,
        rms_slope=0.05,
    )
    surface = make_surface(spectrum, 96, SIDE, realization_generator(seed, 0))
    return 1e9 * surface[:48]


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    np.save(tmp_path / "plate.npy", rough())
    path = tmp_path / "plate.yaml"
    path.write_text(SPEC.replace("SURFACE", "detrend: plane"))
    return path


def test_every_contender_gets_what_it_works_on(spec: Path) -> None:
    results = rb.run(spec)
    assert list(results) == ["scan", "twins"]
    for experiment, surfaces in (("scan", 1), ("twins", 2)):
        counts = {label: one.n_realizations for label, one in results[experiment].items()}
        assert counts == {"bem": surfaces, "foundation": 3, "persson": 1, "winkler": surfaces}
        for one in results[experiment].values():
            assert one.n_unconverged == 0
    scan, twins = results["scan"]["bem"], results["twins"]["bem"]
    assert not scan.is_random
    assert twins.is_random
    assert scan.attributes["grid_points"] == 96
    assert scan.attributes["length"] == pytest.approx(SIDE)
    np.testing.assert_allclose(twins["rms_slope"], scan["rms_slope"][0], rtol=1e-12)
    # Two twins, and few contacts at the lower pressure.
    np.testing.assert_allclose(scan["area"][0, 1], twins["area_mean"][1], rtol=0.05)
    theory = results["scan"]["persson"]
    # Persson's area is low by about a quarter where little touches.
    assert 1.1 < scan["area"][0, 1] / theory["area"][0, 1] < 1.6


def test_the_file_remembers_the_surface(spec: Path) -> None:
    output = spec.with_suffix(".h5")
    results = rb.run(spec, output=output)
    (spec.parent / "plate.npy").unlink()
    record = rb.load(output).surfaces["scan"]
    assert [step.name for step in record.steps] == ["as read", "detrend", "edges"]
    assert record.steps[-1].points == (96, 192)
    assert record.size == pytest.approx((SIDE, 2 * SIDE))
    assert record.heights.shape == (96, 192)
    assert record.source == "plate.npy"
    assert record.parameters["Sq"] == pytest.approx(
        np.sqrt(np.mean(record.heights**2)), rel=1e-9
    )
    heights, density = record.height_density
    assert (density * np.diff(heights).mean()).sum() == pytest.approx(1.0)
    q, power = record.spectrum
    assert (np.diff(q) > 0).all()
    assert power.max() > 0
    there, again = results.surfaces["scan"], rb.load(output).surfaces["scan"]
    np.testing.assert_array_equal(there.heights, again.heights)
    assert (there.steps, there.fit, there.parameters) == (
        again.steps,
        again.fit,
        again.parameters,
    )
    with h5py.File(output) as file:
        assert list(file) == ["scan", "twins"]
        assert file["scan/bem/surface_map"].attrs["units"] == "m"
        assert "surface_map" not in file["scan/persson"]
    assert list(rb.load(output).surfaces) == ["scan"]
    with xr.open_dataset(output, group="/scan/bem", engine="h5netcdf") as opened:
        assert opened["surface_map"].dims == ("surface_y", "surface_x")
        assert float(opened["surface_x"][-1]) == pytest.approx(2 * SIDE * 191 / 192)
        assert opened["pressure"].attrs["units"] == "Pa"
    assert "surface_map" not in rb.load(output)["scan"]["bem"]


def test_a_record_takes_the_scan_as_the_plan_prepared_it(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither prepared nor checked again, and as ``characterize`` describes it."""
    cells = plan(load_spec(spec))
    with monkeypatch.context() as patch:
        for name in ("steps.Preparing.__init__", "doubts.Case.of"):
            patch.delattr(f"roughbench.scans.{name}")
        [record] = records(cells).values()
    found = rb.characterize(
        spec.parent / "plate.npy",
        size="10 um, 5 um",
        unit="nm",
        detrend="plane",
        edges="mirror",
    )
    assert record.fit == (None if found.fit is None else found.fit.to_dict())
    assert record.warnings == found.warnings
    assert record.parameters["Sku"] == found.prepared.Sku
    np.testing.assert_array_equal(record.spectrum[1], found.surface.binned().power)


def test_the_bytes_do_not_depend_on_the_jobs(spec: Path) -> None:
    found = []
    for jobs in (1, 2):
        output = spec.with_name(f"{jobs}.h5")
        rb.run(spec, output=output, jobs=jobs, threads=1)
        found.append(output.read_bytes())
    assert found[0] == found[1]


def test_a_prepared_surface_counts_not_how_it_was_written(spec: Path) -> None:
    """So that a run goes on where only the file's name or its unit was changed."""
    before = plan(load_spec(spec))
    np.save(spec.parent / "other.npy", rough() * 1e-3)
    text = spec.read_text().replace("plate.npy", "other.npy").replace("unit: nm", "unit: um")
    spec.write_text(text)
    after = plan(load_spec(spec))
    for one, other in zip(before, after, strict=True):
        assert one.heights is not None
        assert other.heights is not None
        assert other.heights.rms_height == pytest.approx(one.heights.rms_height, rel=1e-12)
        assert other.n_points == one.n_points


def test_a_scan_that_changes_under_a_run_is_refused(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = plan(load_spec(spec))
    np.save(spec.parent / "plate.npy", rough(seed=2))
    plan(load_spec(spec))  # what this process prepared last is the other one
    monkeypatch.setattr("roughbench.runner.preparation.plan", lambda _: cells)
    with pytest.raises(rb.SolverError, match="changed since the run began"):
        rb.run(spec)


def test_sweeps_over_the_preparation(spec: Path) -> None:
    text = SPEC.replace("SURFACE", "detrend: plane")
    spec.write_text(text + "sweep: {surface.detrend: [mean, plane]}\n")
    results = rb.run(spec)
    assert list(results) == [
        "surface.detrend=mean",
        "twins,surface.detrend=mean",
        "surface.detrend=plane",
        "twins,surface.detrend=plane",
    ]
    mean, plane = (one.steps[1].text for one in results.surfaces.values())
    assert mean.startswith("mean of")
    assert plane.startswith("plane subtracted")


def test_twins_need_something_measured() -> None:
    text = "surface: {H: 0.7, q0: 1, q1: 8, slope: 0.1}\npressures: [0.1]\ntwins: 3\n"
    with pytest.raises(rb.SpecError, match="has random phases already; raise realizations"):
        rb.load_spec(text + "models: [{kind: persson}]\n")
