"""Samples for the models: random streams, heights from files, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from roughbench.errors import SurfaceError
from roughbench.models.base import Sample
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.models.persson import Persson
from roughbench.planning.samples import check_sample, describe, make_sample, rms_of
from roughbench.spec import FileSurface, SelfAffineSurface

LINE, PERSSON = Foundation(springs=64), Persson()


@pytest.fixture
def surface() -> SelfAffineSurface:
    return SelfAffineSurface.model_validate({"H": 0.7, "q0": 1.0, "q1": 16.0, "slope": 0.1})


def file_surface(folder: Path, **options: Any) -> FileSurface:
    tree = {"kind": "file", "length": 2.0, **options}
    return FileSurface.model_validate(tree, context={"folder": folder})


def heights_of(sample: Sample) -> np.ndarray[Any, np.dtype[np.float64]]:
    assert sample.heights is not None
    return sample.heights


def test_realizations_depend_on_seed_and_index_alone(surface: SelfAffineSurface) -> None:
    again = [heights_of(make_sample(surface, LINE, 7, index)) for index in (3, 0, 3)]
    np.testing.assert_array_equal(again[0], again[2])
    assert not np.allclose(again[0], again[1])
    other_seed = heights_of(make_sample(surface, LINE, 8, 3))
    assert not np.allclose(again[0], other_seed)


def test_sample_has_the_dimension_that_the_model_wants(surface: SelfAffineSurface) -> None:
    assert heights_of(make_sample(surface, LINE, 0, 0)).shape == (64,)
    assert make_sample(surface, PERSSON, 0, 0).heights is None
    assert make_sample(surface, PERSSON, 0, 0).spectrum == surface.spectrum()


def test_surface_has_the_grid_of_the_model(surface: SelfAffineSurface) -> None:
    sample = make_sample(surface, HalfSpace(grid=48), 0, 0)
    assert heights_of(sample).shape == (48, 48)
    assert sample.length == surface.length
    # Fixed amplitudes: the lattice sum of the squared modes, the same in each realization.
    other = make_sample(surface, HalfSpace(grid=48), 0, 1)
    assert rms_of(sample) == pytest.approx(rms_of(other), rel=1e-12)


def test_undersampled_line_loses_slope_on_request_only(surface: SelfAffineSurface) -> None:
    with pytest.raises(SurfaceError, match="too coarse"):
        make_sample(surface, Foundation(springs=16), 0, 0)
    with pytest.raises(SurfaceError, match="too coarse"):
        check_sample(surface, Foundation(springs=16))
    cut = make_sample(surface, Foundation(springs=16, undersampled="truncate"), 0, 0)
    assert rms_of(cut)[1] < rms_of(make_sample(surface, LINE, 0, 0))[1]


def test_gaussian_amplitudes_reach_the_heights() -> None:
    tree = {"H": 0.7, "q0": 1.0, "q1": 16.0, "slope": 0.1, "amplitude": "gaussian"}
    gaussian = SelfAffineSurface.model_validate(tree)
    slopes = [rms_of(make_sample(gaussian, LINE, 0, index))[1] for index in range(4)]
    assert np.ptp(slopes) > 1e-3


def test_rms_of_spectrum_where_there_are_no_heights(surface: SelfAffineSurface) -> None:
    height, slope = rms_of(make_sample(surface, PERSSON, 0, 0))
    assert height == surface.spectrum().rms_height
    assert slope == pytest.approx(0.1, rel=1e-12)
    with pytest.raises(SurfaceError, match="needs heights or a spectrum"):
        rms_of(Sample(None, 1.0))


def test_heights_from_files(tmp_path: Path, rng: np.random.Generator) -> None:
    line = rng.normal(size=32) + 5.0
    np.save(tmp_path / "line.npy", line)
    with h5py.File(tmp_path / "line.h5", "w") as file:
        file["measured/line"] = line
    for path in ("line.npy", "line.h5:/measured/line"):
        given = file_surface(tmp_path, path=path)
        check_sample(given, Foundation())
        one, other = (make_sample(given, LINE, seed, index) for seed, index in ((0, 0), (5, 3)))
        np.testing.assert_allclose(heights_of(one), line - line.mean(), atol=1e-14)
        np.testing.assert_array_equal(heights_of(one), heights_of(other))
        assert one.length == 2.0
        measured = make_sample(given, PERSSON, 0, 0)
        assert measured.spectrum is not None
        assert measured.spectrum.rms_height == pytest.approx(line.std(), rel=1e-12)


def test_refuses_heights_of_another_dimension(tmp_path: Path) -> None:
    np.save(tmp_path / "line.npy", np.arange(8.0))
    with pytest.raises(
        SurfaceError,
        match=r"line.npy: its shape is \(8,\), but bem needs 2 dimensions; "
        "give a two-dimensional array, or remove bem",
    ):
        check_sample(file_surface(tmp_path, path="line.npy"), HalfSpace())
    with pytest.raises(SurfaceError, match="no such file"):
        check_sample(file_surface(tmp_path, path="missing.npy"), PERSSON)


def test_describes_the_surface_and_the_resolved_options(surface: SelfAffineSurface) -> None:
    found = describe(surface, Foundation(springs=64, label="springs", realizations=3))
    assert found == {
        "surface": "self-affine",
        "length": surface.length,
        "hurst": 0.7,
        "q_min": 1.0,
        "q_rolloff": 1.0,
        "q_max": 16.0,
        "below_rolloff": "rolloff",
        "amplitude": "fixed",
        "rms_height": surface.spectrum().rms_height,
        "rms_slope": surface.spectrum().rms_slope,
        "grid_points": 64,
        "springs": 64,
        "ends": "periodic",
        "undersampled": "error",
    }
    assert describe(surface, PERSSON)["gamma"] == 0.45
    assert "grid_points" not in describe(surface, PERSSON)


def test_describes_heights_from_a_file_by_themselves(tmp_path: Path) -> None:
    np.save(tmp_path / "line.npy", [0.0, 1.0, 0.0, 5.0])
    found = describe(file_surface(tmp_path, path="line.npy"), Foundation())
    assert found["springs"] == found["grid_points"] == 4
    assert found["rms_height"] == pytest.approx(np.std([0.0, 1.0, 0.0, 5.0]))
    assert found["heights"] == "line.npy"
    assert "undersampled" not in found
