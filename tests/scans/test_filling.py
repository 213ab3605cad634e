"""Filled holes: the Laplace equation, its closed forms, and its slow solution."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.scans.filling import RESIDUAL, fill_holes, find_holes

Mask = NDArray[np.bool_]
Heights = NDArray[np.float64]


def disc(shape: tuple[int, int], place: tuple[int, int], radius: float) -> Mask:
    y, x = np.ogrid[: shape[0], : shape[1]]
    found: Mask = (y - place[0]) ** 2 + (x - place[1]) ** 2 < radius**2
    return found


def departure(heights: Heights, missing: Mask, weights: tuple[float, float]) -> float:
    """Largest difference of a filled height from the mean of its neighbours in the scan."""
    wide = np.pad(heights, 1, constant_values=np.nan)
    total, weight = np.zeros_like(heights), np.zeros_like(heights)
    for axis, w in enumerate(weights):
        for step in (-1, 1):
            other = np.roll(wide, step, axis)[1:-1, 1:-1]
            there = np.isfinite(other)
            total[there] += w * other[there]
            weight += w * there
    found: float = np.abs(heights - total / weight)[missing].max()
    return found


_NOISE = np.random.default_rng(5).random((60, 90))
MASKS: dict[str, Mask] = {
    "points": _NOISE < 0.1,
    "many": _NOISE < 0.6,
    "disc": disc((60, 90), (30, 40), 20),
    "at the border": disc((60, 90), (0, 85), 25),
    "all but a corner": ~disc((60, 90), (0, 0), 3),
    "columns at the border": np.broadcast_to(np.arange(90) > 80, (60, 90)),
    "two close": disc((60, 90), (30, 30), 12) | disc((60, 90), (30, 55), 12),
}


@pytest.mark.parametrize("name", MASKS)
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (2e-6, 0.7e-6)])
def test_filled_heights_are_the_means_of_their_neighbours(
    rng: np.random.Generator, name: str, spacing: tuple[float, float]
) -> None:
    missing = MASKS[name]
    heights = 1e-9 * rng.normal(size=missing.shape).cumsum(axis=0) + 5e-6
    before = heights.copy()
    heights[missing] = np.nan
    known = heights[~missing]
    fill_holes(heights, spacing)
    np.testing.assert_array_equal(heights[~missing], before[~missing])
    weights = (spacing[1] / spacing[0], spacing[0] / spacing[1])
    # Heights of 5e-6 are rounded to 1e-21; the residual counts the range of the rims, which
    # is at most that of all heights.
    assert departure(heights, missing, weights) < RESIDUAL * np.ptp(known) + 2e-21
    assert heights.min() >= known.min()  # the maximum principle: no new summit or pit
    assert heights.max() <= known.max()


def test_a_large_hole_as_the_dense_equations_have_it(rng: np.random.Generator) -> None:
    missing = disc((50, 60), (20, 59), 17)
    heights = rng.normal(size=missing.shape)
    heights[missing] = np.nan
    number = {place: k for k, place in enumerate(zip(*np.nonzero(missing), strict=True))}
    matrix, right = np.zeros((len(number), len(number))), np.zeros(len(number))
    for (i, j), k in number.items():
        for row, column in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if not (0 <= row < 50 and 0 <= column < 60):
                continue
            matrix[k, k] += 1.0
            if (row, column) in number:
                matrix[k, number[row, column]] -= 1.0
            else:
                right[k] += heights[row, column]
    fill_holes(heights, (1.0, 1.0))
    np.testing.assert_allclose(heights[missing], np.linalg.solve(matrix, right), atol=1e-9)


def harmonic(name: str) -> tuple[Any, tuple[float, float]]:
    """Return a discrete harmonic function of row and column, and its spacing."""
    if name == "plane":
        return (lambda y, x: 3.0 - 0.4 * y + 0.3 * x), (1.0, 0.5)
    if name == "saddle":
        return (lambda y, x: x * x - y * y), (1.0, 1.0)
    k = 0.3  # sin(kx) sinh(my) with 2 - 2 cos k = 2 cosh m - 2
    m = np.arccosh(2.0 - np.cos(k))
    return (lambda y, x: np.sin(k * x) * np.sinh(m * (y - 20.0))), (1.0, 1.0)


@pytest.mark.parametrize("name", ["plane", "saddle", "wave"])
def test_harmonic_functions_come_back(rng: np.random.Generator, name: str) -> None:
    function, spacing = harmonic(name)
    y, x = np.mgrid[:40, :50].astype(float)
    exact = function(y, x)
    missing = np.zeros(exact.shape, bool)
    missing[1:-1, 1:-1] = rng.random((38, 48)) < 0.4
    missing |= disc(exact.shape, (18, 25), 12)
    heights = np.where(missing, np.nan, exact)
    fill_holes(heights, spacing)
    np.testing.assert_allclose(heights, exact, atol=1e-8 * np.ptp(exact))


def test_at_the_border_nothing_slopes_and_a_periodic_cell_goes_on() -> None:
    ramp = np.repeat(np.arange(12.0)[:, None], 8, axis=1)
    ramp[9:] = np.nan
    flat, around = ramp.copy(), ramp.copy()
    fill_holes(flat, (1.0, 1.0))
    np.testing.assert_allclose(flat[9:], 8.0, atol=1e-9)
    fill_holes(around, (1.0, 1.0), periodic=True)  # from 8 in row 8 to 0 in row 12
    np.testing.assert_allclose(around[8:, 3], [8.0, 6.0, 4.0, 2.0], atol=1e-9)


def test_a_mirrored_cell_is_filled_as_the_scan_in_it(rng: np.random.Generator) -> None:
    heights = rng.normal(size=(24, 32)).cumsum(axis=1)
    heights[disc(heights.shape, (0, 31), 9)] = np.nan
    mirrored = np.block([[heights, heights[:, ::-1]], [heights[::-1], heights[::-1, ::-1]]])
    fill_holes(mirrored, (1.0, 1.0), periodic=True)
    fill_holes(heights, (1.0, 1.0))
    np.testing.assert_allclose(mirrored[:24, :32], heights, atol=1e-8)


def test_holes_are_counted_by_their_sides() -> None:
    missing = np.zeros((10, 10), bool)
    missing[0, 0] = missing[1, 1] = missing[4:7, 4:8] = True
    holes = find_holes(missing)
    assert (holes.points, holes.count, holes.largest, holes.place) == (14, 3, 12, (5.0, 5.5))
    assert find_holes(np.zeros((3, 3), bool)).count == 0


def test_nothing_missing_and_everything_missing() -> None:
    heights = np.eye(5)
    fill_holes(heights, (1.0, 1.0))
    np.testing.assert_array_equal(heights, np.eye(5))
    with pytest.raises(SurfaceError, match="every point"):
        fill_holes(np.full((4, 4), np.nan), (1.0, 1.0))
