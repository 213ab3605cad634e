"""Trends, outliers, grids, edges and rms values of a scan, each alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughbench.errors import SurfaceError
from roughbench.scans.detrending import DETREND, fit_trend
from roughbench.scans.edges import border_jump, crop, mirror, taper, without_missing_border
from roughbench.scans.outliers import find_outliers
from roughbench.scans.preparation import Preparation, prepare
from roughbench.scans.resampling import resample, square_grid
from roughbench.scans.rms import rms_height_and_gradient
from roughbench.scans.roughness import roughness
from roughbench.scans.topography import Scan
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator

# -- trends --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [kind for kind in DETREND if kind != "none"])
def test_what_is_left_is_orthogonal_to_the_trend(rng: np.random.Generator, kind: str) -> None:
    heights = 1e-9 * rng.normal(size=(150, 201)) + 3e-4  # roughness on a large mean
    heights[rng.random(heights.shape) < 0.2] = np.nan
    y, x = np.mgrid[-1:1:150j, -1:1:201j]
    terms = {
        "mean": [np.ones_like(y)],
        "plane": [np.ones_like(y), y, x],
        "quadratic": [np.ones_like(y), y, x, y * y, x * y, x * x],
    }[kind]
    there = np.isfinite(heights)
    basis = np.stack([term[there] for term in terms], axis=1)
    about = heights[there] - 3e-4
    expected = about - basis @ np.linalg.lstsq(basis, about, rcond=None)[0]
    fit_trend(heights, (1e-8, 2e-8), kind).subtract_from(heights)  # type: ignore[arg-type]
    # The large mean is rounded to 5e-20.
    np.testing.assert_allclose(heights[there], expected, atol=3e-19)


def test_a_known_trend_in_physical_coordinates() -> None:
    dy, dx = 2e-8, 5e-8
    y, x = (np.arange(n) * d for n, d in ((400, dy), (300, dx)))
    my, mx = y.mean(), x.mean()
    paraboloid = (
        0.02 * y[:, None] - 0.01 * x + 300.0 * (y[:, None] - my) ** 2 + 40.0 * (x - mx) ** 2
    )
    paraboloid += 25.0 * (y[:, None] - my) * (x - mx)
    trend = fit_trend(paraboloid, (dy, dx), "quadratic")
    assert trend.tilt == pytest.approx((0.02, -0.01), rel=1e-9)
    assert trend.sag == pytest.approx((300.0 * my**2, 40.0 * mx**2), rel=1e-9)
    trend.subtract_from(paraboloid)
    assert np.abs(paraboloid).max() < 1e-20


def test_too_few_points_for_a_trend() -> None:
    heights = np.full((8, 8), np.nan)
    heights[3] = 1.0
    with pytest.raises(SurfaceError, match="plane cannot be fitted to 8 points that are there"):
        fit_trend(heights, (1.0, 1.0), "plane")
    assert fit_trend(heights, (1.0, 1.0), "mean").coefficients[0, 0] == 1.0


# -- outliers ------------------------------------------------------------------------------


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("per_wave", [2, 4, 8])
def test_spikes_are_found_and_nothing_else(hurst: float, per_wave: int) -> None:
    spectrum = self_affine(
        hurst=hurst, q_min=1, q_rolloff=2, q_max=256 // per_wave, rms_slope=0.1
    )
    heights = make_surface(spectrum, 256, 2 * np.pi, realization_generator(1, 0))
    heights += np.linspace(0.0, 1.0, 256)  # a slope is no outlier
    missing = realization_generator(1, 1).random(heights.shape) < 0.05
    missing[100:140, 200:] = True
    heights[missing] = np.nan
    spikes = [(0, 0), (5, 255), (130, 198), (60, 60), (60, 61), (61, 60), (200, 17)]
    for place in spikes:
        heights[place] = 1.0 + 0.5 * (-1) ** sum(place)
    found, deviation = find_outliers(heights, 15.0)
    assert set(map(tuple, np.argwhere(found).tolist())) == set(spikes)
    assert 0.0 < deviation < np.nanstd(heights)


def test_no_outliers_without_a_deviation() -> None:
    with pytest.raises(SurfaceError, match="in coarse steps"):
        find_outliers(np.repeat(np.arange(4.0), 32).reshape(8, 16), 5.0)
    with pytest.raises(SurfaceError, match="and the scan 4 × 9"):
        find_outliers(np.eye(4, 9), 5.0)


# -- grids ---------------------------------------------------------------------------------


@pytest.mark.parametrize("points", [(16, 30), (40, 15), (64, 60), (24, 30)])
def test_waves_that_both_grids_carry_come_through(points: tuple[int, int]) -> None:
    def cosines(rows: int, columns: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        y, x = ((np.arange(n) + 0.5) / n for n in (rows, columns))
        return np.cos(5 * np.pi * y)[:, None] * np.cos(3 * np.pi * x) + np.cos(np.pi * x)

    def waves(rows: int, columns: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        y, x = (2 * np.pi * np.arange(n) / n for n in (rows, columns))
        return np.sin(7 * y)[:, None] * np.cos(6 * x + 0.3) + np.sin(x + 0.2)

    np.testing.assert_allclose(
        resample(cosines(24, 30), points, periodic=False), cosines(*points), atol=1e-12
    )
    np.testing.assert_allclose(
        resample(waves(24, 30), points, periodic=True), waves(*points), atol=1e-12
    )


@pytest.mark.parametrize("periodic", [False, True])
def test_fewer_points_do_not_alias(*, periodic: bool) -> None:
    x = (np.arange(64) + 0.5) / 64
    wave = np.cos(40 * np.pi * x) + 0.0 * x[:, None]  # 20 waves; 32 points carry 16
    assert np.ptp(wave[:, ::2]) > 1.0
    assert np.abs(resample(wave, (64, 32), periodic=periodic)).max() < 1e-12


def test_the_grid_of_square_pixels() -> None:
    assert square_grid((100, 100), (1.0, 1.0)) == (100, 100)
    assert square_grid((100, 50), (1.0, 1.0)) == (100, 100)
    assert square_grid((100, 50), (3.0, 1.0)) == (150, 50)
    assert square_grid((300, 200), (3.0, 2.0), 90) == (90, 60)


# -- edges ---------------------------------------------------------------------------------


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_a_mirrored_scan_is_four_scans(rows: int, columns: int, seed: int) -> None:
    heights = np.random.default_rng(seed).normal(size=(rows, columns))
    cell = mirror(heights)
    assert cell.shape == (2 * rows, 2 * columns)
    np.testing.assert_array_equal(cell[:rows, :columns], heights)
    np.testing.assert_array_equal(cell, cell[::-1])
    np.testing.assert_array_equal(cell, cell[:, ::-1])
    assert border_jump(cell, 0)[0] == border_jump(cell, 1)[0] == 0.0


def test_a_mirrored_scan_keeps_heights_and_slopes() -> None:
    spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
    scan = make_surface(spectrum, 512, 2 * np.pi, realization_generator(1, 0))[:256, 100:400]
    assert mirror(scan).std() == pytest.approx(scan.std(), rel=1e-12)
    before = rms_height_and_gradient(scan, (0.01, 0.01), periodic=False)
    after = rms_height_and_gradient(mirror(scan), (0.01, 0.01), periodic=True)
    # 1 of 256 rows and 1 of 300 columns of differences are nought.
    assert after[1] / before[1] == pytest.approx(1.0, abs=0.004)


def test_taper_changes_a_strip_and_closes_the_cell() -> None:
    spectrum = self_affine(hurst=0.8, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
    ratios, slopes = [], []
    # The weights of a strip of w points change by π/2w from point to point.
    fading = sum((0.5 * np.pi / w) ** 2 * w / (n - w) for w, n in ((32, 256), (40, 320)))
    for realization in range(20):
        generator = realization_generator(3, realization)
        scan = make_surface(spectrum, 512, 2 * np.pi, generator)[:256, :320]
        scan = scan - scan.mean()
        cell = taper(scan)
        assert cell.shape == (224, 280)
        np.testing.assert_array_equal(cell[32:, 40:], scan[32:224, 40:280])
        for axis in (0, 1):
            jump, usual = border_jump(cell, axis)
            assert jump < 1.5 * usual < 0.5 * border_jump(scan, axis)[0]
        ratios.append(cell[:32].std() / scan.std())
        (_, before), (_, after) = (
            rms_height_and_gradient(h, (1.0, 1.0), periodic=periodic)
            for h, periodic in ((scan, False), (cell, True))
        )
        slopes.append((after**2 - before**2) / scan.std() ** 2)
    for found, expected in ((ratios, 1.0), (slopes, fading)):
        error = np.std(found) / np.sqrt(19)
        assert abs(np.mean(found) - expected) < 3.5 * error
        assert error < 0.4 * expected


def test_taper_of_opposite_borders_stays_finite() -> None:
    ramp = np.linspace(-1.0, 1.0, 64) + np.zeros((32, 1))
    assert np.abs(taper(ramp)).max() <= 2.0 + 1e-12


def test_crop_finds_the_period() -> None:
    y, x = np.mgrid[:110, :90]
    heights = np.sin(2 * np.pi * y / 96 + 0.3) + np.cos(2 * np.pi * x / 80)
    rows, columns = crop(heights)
    assert (rows.stop - rows.start, columns.stop - columns.start) == (97, 81)


def test_crop_leaves_what_is_periodic() -> None:
    spectrum = self_affine(hurst=0.8, q_min=1, q_rolloff=2, q_max=32, rms_slope=0.1)
    heights = make_surface(spectrum, 256, 2 * np.pi, realization_generator(1, 0))
    rows, columns = crop(heights)
    jumps = [border_jump(heights[rows, columns], axis)[0] for axis in (0, 1)]
    assert all(jump <= border_jump(heights, axis)[0] for axis, jump in enumerate(jumps))


def test_border_lines_are_cut_while_most_of_them_is_missing() -> None:
    heights = np.zeros((40, 60))
    heights[:3] = heights[:, 55:] = np.nan
    heights[3, 20:] = np.nan  # most of a row
    heights[4, :20] = heights[20:30, 10:20] = np.nan  # less than half, and a hole
    assert without_missing_border(heights) == (slice(4, 40), slice(0, 55))
    rows, columns = without_missing_border(np.full((4, 4), np.nan))
    assert 0 in ((rows.stop - rows.start), (columns.stop - columns.start))


# -- rms values ----------------------------------------------------------------------------


def test_rms_values_by_the_whole_array(rng: np.random.Generator) -> None:
    heights = rng.normal(size=(150, 70)) + 1e6
    dy, dx = np.diff(heights, axis=0) / 0.5, np.diff(heights, axis=1) / 0.3
    height, slope = rms_height_and_gradient(heights, (0.5, 0.3), periodic=False)
    assert height == pytest.approx(heights.std(), rel=1e-9)
    assert slope == pytest.approx(np.sqrt(np.mean(dy[:, :-1] ** 2 + dx[:-1] ** 2)), rel=1e-12)
    around = np.roll(heights, -1, 0) - heights, np.roll(heights, -1, 1) - heights
    _, slope = rms_height_and_gradient(heights, (0.5, 0.3), periodic=True)
    expected = np.sqrt(np.mean(around[0] ** 2 / 0.25 + around[1] ** 2 / 0.09))
    assert slope == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("periodic", [False, True])
def test_rms_values_beside_holes(rng: np.random.Generator, *, periodic: bool) -> None:
    """A place counts if no point within two steps is missing; place by place."""
    heights = rng.normal(size=(31, 23))
    heights[rng.random(heights.shape) < 0.1] = np.nan
    rows, columns = heights.shape
    found = []
    for i, j in np.ndindex(rows, columns) if periodic else np.ndindex(rows - 1, columns - 1):
        near = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        h = [heights[(i + down) % rows, (j + right) % columns] for down, right in near]
        if np.isfinite(h).all():
            found.append(((h[1] - h[0]) / 0.5) ** 2 + ((h[2] - h[0]) / 0.3) ** 2)
    height, slope = rms_height_and_gradient(heights, (0.5, 0.3), periodic=periodic)
    assert 0 < len(found) < 0.8 * heights.size
    assert height == pytest.approx(np.nanstd(heights), rel=1e-12)
    assert slope == pytest.approx(np.sqrt(np.mean(found)), rel=1e-12)
    heights[::2] = np.nan
    assert np.isnan(rms_height_and_gradient(heights, (0.5, 0.3), periodic=periodic)[1])


def test_sq_and_sdq_have_one_rule(rng: np.random.Generator) -> None:
    """In the record of a scan's steps, and among the numbers that describe it."""
    heights = rng.normal(size=(40, 30)).cumsum(0)
    heights[rng.random(heights.shape) < 0.05] = np.nan
    scan = Scan(heights, (4.0, 3.0))
    step = prepare(scan, Preparation(fill=0.1)).steps[0]
    described = roughness(heights, (4.0, 3.0))
    assert (step.Sq, step.Sdq) == (described.Sq, described.Sdq)
