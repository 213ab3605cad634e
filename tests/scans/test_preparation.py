"""From a scan to heights for the models: the order of the steps, their record, the errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench import solve_curve
from roughbench.errors import SurfaceError
from roughbench.scans.preparation import Preparation, prepare
from roughbench.scans.roughness import roughness
from roughbench.scans.topography import Scan
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator, rms_height_and_slope

Heights = NDArray[np.float64]
SIZE = 10e-6


def rough(points: int = 128, shortest: int = 4, seed: int = 1) -> Heights:
    """Return a periodic surface of slope 0.1 and side SIZE, m, its shortest wave in points."""
    spectrum = self_affine(
        hurst=0.8, q_min=1, q_rolloff=4, q_max=points // shortest, rms_slope=0.1
    )
    generator = realization_generator(seed, 0)
    return make_surface(spectrum, points, 2 * np.pi, generator) * SIZE / (2 * np.pi)


def scan_of(heights: Heights, size: tuple[float, float] = (SIZE, SIZE)) -> Scan:
    return Scan(heights, size, source="plate.npy")


def test_a_periodic_scan_stays_as_it_is() -> None:
    heights = rough() + 3e-6
    prepared = prepare(scan_of(heights), Preparation(detrend="none", edges="periodic"))
    np.testing.assert_allclose(prepared.heights, heights - heights.mean(), atol=1e-20)
    assert prepared.length == SIZE
    assert [step.name for step in prepared.steps] == ["as read", "detrend", "edges"]
    assert prepared.raw.heights is heights
    # Differences of neighbours see less than the slope of the waves, at 4 points each.
    slope = rms_height_and_slope(prepared.heights, SIZE)[1]
    assert 0.8 * slope < prepared.steps[-1].Sdq < slope


def test_the_scan_itself_is_not_touched(rng: np.random.Generator) -> None:
    heights = rough(64)
    heights[rng.random(heights.shape) < 0.1] = np.nan
    before = heights.copy()
    preparation = Preparation("quadratic", 0.2, "taper", outliers=20.0, resample=50)
    prepared = prepare(scan_of(heights), preparation)
    np.testing.assert_array_equal(heights, before)
    assert [step.name for step in prepared.steps] == [
        "as read",
        "outliers",
        "detrend",
        "fill",
        "resample",
        "edges",
    ]
    assert np.isfinite(prepared.heights).all()
    assert abs(prepared.heights.mean()) < 1e-22
    assert prepared.heights.shape == (44, 44)
    assert prepared.length == pytest.approx(SIZE * 44 / 50)


def test_what_is_not_said_is_the_mean_and_periodic() -> None:
    heights = rough(32) + 1e-6
    said = prepare(scan_of(heights), Preparation(detrend="mean", edges="periodic"))
    not_said = prepare(scan_of(heights), Preparation())
    np.testing.assert_array_equal(said.heights, not_said.heights)
    assert "nothing else was said" in not_said.steps[-1].text


@pytest.mark.parametrize("degree", ["plane", "quadratic"])
def test_a_trend_and_holes_hardly_matter(rng: np.random.Generator, degree: Any) -> None:
    """The same heights with a tilt, a curvature and holes away from them."""
    heights = rough(256, seed=2)
    y, x = np.mgrid[-1:1:256j, -1:1:256j]
    tilted = heights + 0.2e-6 * y - 0.1e-6 * x + 5e-6
    if degree == "quadratic":
        tilted += 0.1e-6 * x * x + 0.05e-6 * x * y
    tilted[rng.random(heights.shape) < 0.02] = np.nan
    found = prepare(scan_of(tilted), Preparation(degree, 0.03, "mirror"))
    expected = prepare(scan_of(heights), Preparation(degree, 0.0, "mirror"))
    # 2 % of the points are filled, each off by about 0.04 Sq: 0.14·0.04 Sq in all.
    difference = (found.heights - expected.heights).std()
    assert difference < 0.01 * expected.heights.std()
    assert found.steps[-1].Sdq == pytest.approx(expected.steps[-1].Sdq, rel=0.01)
    slopes = "a slope of 40.2 nm/µm along y and -20.1 nm/µm along x"
    assert found.steps[1].text.startswith(f"{degree} subtracted: ")
    tilt = prepare(scan_of(tilted - heights), Preparation(degree, 0.03, "mirror")).steps[1]
    assert slopes in tilt.text


def test_a_hole_at_the_border_of_a_tilted_scan_is_filled_level() -> None:
    """Detrended first: a border without slope is right for roughness, not for a tilt."""
    tilted = np.repeat(np.linspace(0.0, 1e-6, 40)[:, None], 40, axis=1)
    tilted[30:, 10:30] = np.nan
    prepared = prepare(scan_of(tilted), Preparation("plane", 0.2, "mirror"))
    assert np.abs(prepared.heights).max() < 1e-18


def test_too_much_is_missing() -> None:
    heights = rough(64)
    heights[20:30, 40:44] = np.nan
    heights[5, 7] = np.nan
    with pytest.raises(SurfaceError) as caught:
        prepare(scan_of(heights), Preparation(fill=0.005))
    assert str(caught.value) == (
        "plate.npy: 1 % of the points are missing (41 points in 2 holes), and fill allows "
        "0.5 %; the largest, 40 points, lies about row 24, column 42 (y = 3.83 µm, x = 6.48 µm)"
        "; say fill: 1.1 % to fill them from their rims"
    )
    heights[:, 60:] = np.nan
    with pytest.raises(
        SurfaceError,
        match=r"its borders are missing: edges: crop would cut to rows 0:64 of 64 and columns "
        r"0:60 of 64, with 1\.07 % missing; say fill: 7\.3 % to fill",
    ):
        prepare(scan_of(heights), Preparation(fill=0.005, edges="mirror"))
    prepared = prepare(scan_of(heights), Preparation(fill=0.02, edges="crop"))
    assert [s.name for s in prepared.steps] == ["as read", "crop", "detrend", "fill", "edges"]
    assert prepared.steps[1].points == (64, 60)
    assert prepared.steps[1].size == pytest.approx((SIZE, SIZE * 60 / 64))
    heights[:40] = np.nan
    with pytest.raises(SurfaceError, match="or measure again"):
        prepare(scan_of(heights), Preparation())


def test_a_scan_without_any_slope_is_refused() -> None:
    """Before anything is computed on it: what is filled could not be judged."""
    heights = rough(64)
    heights[::2] = np.nan
    with pytest.raises(SurfaceError, match=r"^plate\.npy: .* nowhere enough neighbours"):
        prepare(scan_of(heights), Preparation(fill=0.6, edges="mirror"))
    with pytest.raises(SurfaceError, match="and fill allows 40 %"):
        prepare(scan_of(heights), Preparation(fill=0.4, edges="mirror"))


def test_outliers_count_as_missing() -> None:
    heights = rough(64)
    heights[10, 12] += 1e-6
    heights[40, 3] -= 1e-6
    with pytest.raises(SurfaceError, match=r"\(2 points in 2 holes\), and fill allows 0 %"):
        prepare(scan_of(heights), Preparation(outliers=20.0))
    prepared = prepare(scan_of(heights), Preparation("mean", 0.001, "periodic", outliers=20.0))
    assert "2 points (0.0488 %) further than 20 robust deviations" in prepared.steps[1].text
    assert np.abs(prepared.heights - rough(64)).max() < 0.3 * rough(64).std()


def test_rectangular_pixels_become_square() -> None:
    fine = rough(128, shortest=5)
    scan = scan_of(fine[:, ::2].copy())
    prepared = prepare(scan, Preparation("none", edges="periodic"))
    assert prepared.heights.shape == (128, 128)
    assert prepared.steps[-2].name == "resample"
    assert "pixels of 78.1 nm along y and 156 nm along x, now square: 78.1 nm" in (
        prepared.steps[-2].text
    )
    # Every second point carries all of its waves, of five points each.
    np.testing.assert_allclose(prepared.heights, fine, atol=1e-12 * fine.std())


def test_a_side_that_is_no_whole_number_of_pixels_is_stretched_and_says_so() -> None:
    scan = Scan(rough(64), (SIZE, 0.5 * SIZE))
    prepared = prepare(scan, Preparation("none", edges="periodic", resample=45))
    assert prepared.heights.shape == (45, 23)
    assert "x stretched by +2.2 %" in prepared.steps[-2].text
    assert prepared.steps[-1].size == pytest.approx((SIZE, SIZE * 23 / 45))


def test_fewer_points_say_how_much_slope_they_lose() -> None:
    prepared = prepare(scan_of(rough(256)), Preparation("none", edges="mirror", resample=64))
    step = prepared.steps[-2]
    lost = 100.0 * (1.0 - step.Sdq / prepared.steps[-3].Sdq)
    assert step.text == (
        f"from 256 × 256 points to 64 × 64; that took away {lost:.3g} % of the slope"
    )
    assert lost > 10.0
    assert prepared.heights.shape == (128, 128)
    assert prepared.length == 2 * SIZE


@pytest.mark.parametrize("edges", ["taper", "crop", "mirror", "periodic"])
def test_every_edge_says_its_numbers(edges: Any) -> None:
    scan = scan_of(rough(256)[:128, :100].copy(), (SIZE / 2, SIZE * 100 / 256))
    prepared = prepare(scan, Preparation("plane", edges=edges))
    last = prepared.steps[-1]
    assert last.points == prepared.heights.shape
    assert last.size[0] == prepared.length
    assert last.Sq == pytest.approx(prepared.heights.std())
    assert last.size[1] / last.points[1] == pytest.approx(prepared.length / last.points[0])
    words = {
        "taper": "the last 16 rows and 12 columns faded into the first, Sq",
        "crop": "before,",
        "mirror": "the scan and its three reflections, a cell of twice the size",
        "periodic": "taken as periodic as it is; step at the border",
    }
    assert words[edges] in last.text
    assert "\n" not in last.text
    # A cliff at the border is slope that nobody measured.
    slope = prepared.steps[-2].Sdq
    if edges == "mirror":
        assert last.Sdq == pytest.approx(slope, rel=0.01)
    elif edges == "taper":
        assert slope < last.Sdq < 1.15 * slope
    else:
        assert last.Sdq > 1.1 * slope


def test_the_mirror_of_an_even_surface_is_that_surface() -> None:
    """Cosines at half points are even about the borders: one quarter makes the whole."""
    rng = realization_generator(7, 0)
    x = (np.arange(64) + 0.5) / 64
    heights = np.zeros((64, 64))
    for i in range(12):
        for j in range(12):
            if 0 < i * i + j * j < 144:
                amplitude = rng.normal() / (i * i + j * j) ** 0.9
                heights += amplitude * np.outer(
                    np.cos(2 * np.pi * i * x), np.cos(2 * np.pi * j * x)
                )
    heights *= 0.05 * SIZE / np.ptp(heights)
    quarter = scan_of(heights[:32, :32].copy(), (SIZE / 2, SIZE / 2))
    prepared = prepare(quarter, Preparation("none", edges="mirror"))
    np.testing.assert_allclose(prepared.heights, heights - heights.mean(), atol=1e-20)
    found, expected = (
        solve_curve(h, [1e-3, 1e-2], length=SIZE, tolerance=1e-8)
        for h in (prepared.heights, heights)
    )
    np.testing.assert_allclose(found.area, expected.area, rtol=1e-6)
    np.testing.assert_allclose(found.separation, expected.separation, rtol=1e-6)
    np.testing.assert_allclose(found.stiffness, expected.stiffness, rtol=1e-4)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"detrend": "cubic"},
            "detrend must be one of none, mean, plane, quadratic, got 'cubic'",
        ),
        ({"edges": "hann"}, "edges must be one of periodic, mirror, taper, crop, got 'hann'"),
        ({"fill": 1.0}, "fill must be a share"),
        ({"fill": -0.1}, "fill must be a share"),
        ({"outliers": 0.0}, "outliers must be a positive number"),
        ({"resample": 3}, "resample must be at least 4, got 3"),
    ],
)
def test_what_cannot_be_prepared_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(SurfaceError, match=message):
        Preparation(**options)


def test_heights_that_are_none_are_refused() -> None:
    with pytest.raises(SurfaceError, match=r"plate\.npy: no point has a height"):
        prepare(scan_of(np.full((8, 8), np.nan)), Preparation())
    with pytest.raises(SurfaceError, match="must be finite"):
        prepare(scan_of(np.where(np.eye(8) > 0.0, np.inf, 0.0)), Preparation())
    with pytest.raises(SurfaceError, match="3 × 8 points are left"):
        prepare(Scan(np.eye(3, 8), (3e-6, 8e-6)), Preparation())


def test_steps_count_the_gradient_as_the_roughness_does() -> None:
    """Also around holes, whose rims are measured worst."""
    heights = 1e-8 * np.random.default_rng(3).normal(size=(40, 60))
    heights[5, 7] = heights[20:24, 30:33] = np.nan
    found = prepare(Scan(heights, (4e-6, 6e-6)), Preparation(detrend="none", fill=0.1))
    assert found.steps[0].Sdq == pytest.approx(roughness(heights, (4e-6, 6e-6)).Sdq, rel=1e-12)
