"""Measured surfaces: what every model gets of them, and their twins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roughbench.errors import SurfaceError
from roughbench.models.base import Model
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.models.line import Line
from roughbench.models.persson import Persson
from roughbench.planning.measured import heights_of, read_heights
from roughbench.planning.plan import LINES, plan
from roughbench.planning.samples import check_sample, describe, make_sample, rms_of
from roughbench.spec import FileSurface, load_spec
from roughbench.spectrum import mode_power, self_affine
from roughbench.surface import make_surface, realization_generator

BEM, SPRINGS, PERSSON = HalfSpace(), Foundation(springs=512), Persson()


@pytest.fixture
def heights(tmp_path: Path) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return a rough cell of 48 × 96 points, which heights.npy holds."""
    spectrum = self_affine(hurst=0.7, q_min=1.0, q_rolloff=2.0, q_max=24.0, rms_slope=0.1)
    square = make_surface(spectrum, 96, 2 * np.pi, realization_generator(1, 0))
    half = np.ascontiguousarray(square[:48])
    np.save(tmp_path / "heights.npy", half)
    return half


@pytest.fixture
def surface(tmp_path: Path, heights: object) -> FileSurface:
    del heights
    tree = {"kind": "file", "path": "heights.npy", "length": np.pi}
    return FileSurface.model_validate(tree, context={"folder": tmp_path})


def test_lines_have_the_spectrum_of_the_surface(surface: FileSurface) -> None:
    known = read_heights(surface)
    assert known.longest_side == pytest.approx(2 * np.pi)
    lines = [make_sample(surface, SPRINGS, 7, k, known) for k in (0, 1, 0)]
    for line in lines:
        assert line.heights is not None
        assert line.heights.shape == (512,)
        assert line.length == pytest.approx(2 * np.pi)
        height, slope = rms_of(line)
        # All of the waves' power is in the line; the slope is that of the shells' centres.
        assert height == pytest.approx(known.rms_height, rel=1e-12)
        assert slope == pytest.approx(known.rms_slope, rel=0.02)
    first, second, again = (np.asarray(line.heights) for line in lines)
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, second)


def test_a_line_too_coarse_for_the_surface_is_refused(surface: FileSurface) -> None:
    with pytest.raises(SurfaceError, match="64 points per side are too coarse"):
        check_sample(surface, Foundation(springs=64))
    check_sample(surface, Line())


def test_twins_have_the_same_waves_and_other_phases(
    surface: FileSurface, heights: np.ndarray[Any, np.dtype[np.float64]]
) -> None:
    twins = surface.twins()
    assert twins.is_twins
    assert not twins.original().is_twins
    known = read_heights(twins)
    one, two, again = (make_sample(twins, BEM, 3, k, known).heights for k in (0, 1, 0))
    assert one is not None
    assert two is not None
    np.testing.assert_allclose(mode_power(one), mode_power(heights), rtol=1e-9, atol=1e-20)
    np.testing.assert_array_equal(one, again)
    assert np.corrcoef(one.ravel(), two.ravel())[0, 1] < 0.5
    assert abs(one.mean()) < 1e-15
    itself = make_sample(surface, BEM, 3, 0, known).heights
    np.testing.assert_allclose(np.asarray(itself), heights - heights.mean(), atol=1e-16)


def test_twins_of_skewed_heights_are_not_skewed(tmp_path: Path) -> None:
    """So that a comparison with them shows what the distribution of heights does."""
    rng = np.random.default_rng(5)
    spectrum = self_affine(hurst=0.5, q_min=4.0, q_rolloff=8.0, q_max=64.0, rms_slope=0.1)
    gaussian = make_surface(spectrum, 256, 2 * np.pi, rng)
    np.save(tmp_path / "skewed.npy", np.exp(gaussian / gaussian.std()))
    tree = {"kind": "file", "path": "skewed.npy", "length": 1.0}
    given = FileSurface.model_validate(tree, context={"folder": tmp_path})

    def skewness(surface: FileSurface) -> float:
        h = make_sample(surface, BEM, 0, 0).heights
        assert h is not None
        return float(np.mean(h**3) / np.mean(h**2) ** 1.5)

    assert skewness(given) > 2.0
    assert abs(skewness(given.twins())) < 0.3


def test_what_is_drawn_is_said(surface: FileSurface) -> None:
    assert "drawn" not in describe(surface, BEM)
    assert describe(surface.twins(), BEM)["drawn"] == "twins"
    found = describe(surface, SPRINGS)
    assert (found["drawn"], found["springs"], found["undersampled"]) == ("lines", 512, "error")
    assert found["length"] == pytest.approx(2 * np.pi)
    assert "drawn" not in describe(surface.twins(), PERSSON)


def test_a_file_that_changes_is_noticed(surface: FileSurface) -> None:
    known = read_heights(surface)
    np.save(surface.file, np.zeros((48, 96)))
    with pytest.raises(SurfaceError, match="changed since the run began"):
        heights_of(surface, known)


def cells(tmp_path: Path, **keys: Any) -> dict[str, tuple[int, bool]]:
    tree = {
        "surface": {"kind": "file", "path": str(tmp_path / "heights.npy"), "length": np.pi},
        "pressures": [1e-3],
        "models": [{"kind": "bem"}, {"kind": "foundation"}, {"kind": "persson"}],
        **keys,
    }
    return {str(c): (c.n_realizations, c.is_random) for c in plan(load_spec(tree))}


@pytest.mark.usefixtures("heights")
def test_realizations_of_what_is_measured(tmp_path: Path) -> None:
    assert cells(tmp_path) == {
        "main/bem": (1, False),
        "main/foundation": (LINES, True),
        "main/persson": (1, False),
    }
    assert cells(tmp_path, realizations=3, twins=5) == {
        "main/bem": (1, False),
        "main/foundation": (3, True),
        "main/persson": (1, False),
        "twins/bem": (5, True),
        "twins/foundation": (3, True),
        "twins/persson": (1, False),
    }


def test_a_line_from_a_file_is_one_realization(tmp_path: Path) -> None:
    np.save(tmp_path / "line.npy", np.cos(np.arange(64.0)))
    tree = {
        "surface": {"kind": "file", "path": str(tmp_path / "line.npy"), "length": 1.0},
        "pressures": [1e-3],
        "models": [{"kind": "foundation"}],
    }
    [cell] = plan(load_spec(tree))
    assert (cell.n_realizations, cell.n_points, cell.is_random) == (1, 64, False)


def test_options_of_lines_are_refused_where_the_line_is_there(tmp_path: Path) -> None:
    np.save(tmp_path / "line.npy", np.cos(np.arange(64.0)))
    tree = {"kind": "file", "path": "line.npy", "length": 1.0}
    given = FileSurface.model_validate(tree, context={"folder": tmp_path})
    model: Model = Foundation(springs=512)
    with pytest.raises(SurfaceError, match="springs of foundation has no meaning for measured"):
        check_sample(given, model)
