"""Sa … Sdr and the moments against closed forms, and against SurfaceTopography."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.errors import SurfaceError
from roughbench.scans.roughness import roughness


def wave(n: int = 512, waves: int = 4, amplitude: float = 0.01) -> np.ndarray:
    return amplitude * np.cos(2 * np.pi * waves * np.arange(n) / n) * np.ones((n // 2, 1))


def test_a_cosine() -> None:
    a, q = 0.01, 8 * math.pi
    found = roughness(wave(), (0.5, 1.0))
    assert found.Sq == pytest.approx(a / math.sqrt(2), rel=1e-12)
    assert found.Sa == pytest.approx(2 * a / math.pi, rel=1e-3)
    assert found.Ssk == pytest.approx(0.0, abs=1e-12)
    assert found.Sku == pytest.approx(1.5, rel=1e-12)
    assert found.peak_to_valley == pytest.approx(2 * a, rel=1e-12)
    # Differences see sin(qΔ/2)/(qΔ/2) of the slope: 1 − (qΔ)²/24. No difference is taken
    # across the border, so that one of 512 is missing.
    assert found.Sdq == pytest.approx(a * q / math.sqrt(2), rel=2e-3)
    assert found.slopes[0] == 0.0
    assert found.m0 == pytest.approx(a**2 / 2)
    assert found.m2 == pytest.approx(found.Sdq**2 / 2)
    assert found.m4 == pytest.approx(a**2 * q**4 / 2 / 2, rel=5e-3)  # along x; none along y
    assert found.nayak == pytest.approx(2.0, rel=1e-2)  # (a²/2)(a²q⁴/4)/(a²q²/4)²
    assert (found.anisotropy, abs(found.direction)) == (math.inf, 0.0)
    assert found.band == pytest.approx((2 * math.pi, 512 * math.pi))
    assert found.points == (256, 512)


def test_a_tilted_plane() -> None:
    y, x = np.mgrid[:40, :50]
    found = roughness(0.3 * x * 0.1 + 0.4 * y * 0.2, (8.0, 5.0))
    assert found.Sdq == pytest.approx(0.5, rel=1e-12)
    assert found.Sdr == pytest.approx(math.sqrt(1.25) - 1.0, rel=1e-12)
    assert found.slopes == pytest.approx((0.4, 0.3))
    assert found.direction == pytest.approx(math.degrees(math.atan2(0.4, 0.3)))
    assert found.m4 == pytest.approx(0.0, abs=1e-20)
    assert found.Ssk == pytest.approx(0.0, abs=1e-12)
    # Uniform in both directions: the kurtosis of a sum is that of its parts, weighed.
    sx, sy = (0.03**2 * (50**2 - 1) / 12), (0.08**2 * (40**2 - 1) / 12)
    assert found.Sq == pytest.approx(math.sqrt(sx + sy), rel=1e-12)


def test_the_area_of_a_spherical_cap() -> None:
    """A cap of radius R over a square: area by quadrature, converging as the square of Δ."""
    radius, side = 1.0, 1.0
    fine = (np.arange(2000) + 0.5) / 2000 - 0.5
    exact = np.mean(radius / np.sqrt(radius**2 - fine**2 - fine[:, None] ** 2)) - 1.0
    errors = []
    for n in (65, 129):
        x = np.linspace(-0.5, 0.5, n)
        cap = np.sqrt(radius**2 - x**2 - x[:, None] ** 2)
        spacing = side / (n - 1)
        errors.append(abs(roughness(cap, (n * spacing, n * spacing)).Sdr - exact))
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_small_slopes_gain_half_of_their_square() -> None:
    found = roughness(1e-9 * wave(), (0.5, 1.0))
    assert found.Sdr == pytest.approx(found.Sdq**2 / 2, rel=1e-3)


def test_gaussian_heights(rng: np.random.Generator) -> None:
    n = 300
    found = roughness(rng.standard_normal((n, n)), (1.0, 1.0))
    assert found.Sq == pytest.approx(1.0, abs=4 / math.sqrt(2 * n * n))
    assert found.Ssk == pytest.approx(0.0, abs=4 * math.sqrt(6) / n)
    assert found.Sku == pytest.approx(3.0, abs=4 * math.sqrt(24) / n)
    assert found.Sdq == pytest.approx(2 * n, rel=0.02)  # √2 along each axis
    assert found.anisotropy == pytest.approx(1.0, abs=0.02)


def test_missing_points_are_left_out(rng: np.random.Generator) -> None:
    heights = wave() + 3.0
    whole = roughness(heights, (0.5, 1.0))
    holed = heights.copy()
    holed[rng.random(heights.shape) < 0.05] = np.nan
    found = roughness(holed, (0.5, 1.0))
    assert found.missing == pytest.approx(0.05, abs=0.003)
    for name in ("Sa", "Sq", "Sku", "Sdq", "Sdr", "m4"):
        assert getattr(found, name) == pytest.approx(getattr(whole, name), rel=0.02), name


def test_units_and_places_are_immaterial(rng: np.random.Generator) -> None:
    heights = rng.standard_normal((30, 40)).cumsum(0).cumsum(1)
    metres, nanometres = roughness(heights, (3, 4)), roughness(1e9 * heights, (3e9, 4e9))
    assert nanometres.Sq == pytest.approx(1e9 * metres.Sq)
    assert nanometres.m4 == pytest.approx(1e-18 * metres.m4)
    for name in ("Ssk", "Sku", "Sdq", "Sdr", "nayak", "anisotropy", "direction"):
        assert getattr(nanometres, name) == pytest.approx(getattr(metres, name)), name
    turned = roughness(heights.T, (4, 3))
    assert turned.Sdq == pytest.approx(metres.Sdq)
    assert turned.slopes == pytest.approx(metres.slopes[::-1])
    assert (turned.direction + metres.direction - 90.0) % 180.0 == pytest.approx(0.0)


@pytest.mark.filterwarnings("ignore:Function/property `Sq` is deprecated")
@pytest.mark.parametrize("holes", [0.0, 0.03])
def test_sq_and_sdq_are_those_of_surfacetopography(
    rng: np.random.Generator, holes: float
) -> None:
    topography = pytest.importorskip("SurfaceTopography")
    heights = rng.standard_normal((60, 50)).cumsum(0).cumsum(1)
    missing = rng.random(heights.shape) < holes
    missing[0, 7] = holes > 0  # its mask goes around the border
    # Where positions are rounded, SurfaceTopography's mask moves by a point here and there.
    theirs = topography.Topography(np.ma.masked_array(heights, missing), (120.0, 50.0))
    found = roughness(np.where(missing, np.nan, heights), (120.0, 50.0))
    assert found.Sq == pytest.approx(theirs.rms_height_from_area(), rel=1e-12)
    assert found.Sdq == pytest.approx(theirs.rms_gradient(), rel=1e-12)


def test_blocks_are_immaterial(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = rng.standard_normal((23, 17)).cumsum(0)
    heights[rng.random(heights.shape) < 0.03] = np.nan
    whole = roughness(heights, (1.0, 2.0))
    for points in (1, 40, 200):
        monkeypatch.setattr("roughbench.scans.rms._BLOCK", points)
        found = roughness(heights, (1.0, 2.0))
        for name in ("Sa", "Sq", "Ssk", "Sku", "Sdq", "Sdr", "m4", "direction"):
            assert getattr(found, name) == pytest.approx(getattr(whole, name)), name


@pytest.mark.parametrize(
    ("heights", "size", "word"),
    [
        (np.zeros((4, 4)), (1.0, 1.0), "all heights are the same"),
        (np.full((4, 4), np.nan), (1.0, 1.0), "all points are missing"),
        (np.full((4, 4), np.inf), (1.0, 1.0), "got inf"),
        (np.arange(8.0).reshape(2, 4), (1.0, 1.0), "at least 3 × 3"),
        (np.arange(16.0).reshape(4, 4), (1.0, 0.0), "size along x must be a positive"),
        (np.where(np.eye(4) > 0, np.arange(4.0), np.nan), (1.0, 1.0), "for a slope"),
    ],
)
def test_what_cannot_be_described_is_refused(
    heights: np.ndarray, size: tuple[float, float], word: str
) -> None:
    with pytest.raises(SurfaceError, match=word):
        roughness(heights, size)
