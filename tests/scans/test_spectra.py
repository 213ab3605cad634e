"""The normalisation of measured spectra, with and without a window."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.errors import SurfaceError
from roughbench.scans.measured_spectrum import HANN_WIDTH
from roughbench.scans.spectra import profile_spectrum, surface_spectrum
from roughbench.spectrum import self_affine
from roughbench.surface import make_surface, realization_generator, rms_height_and_slope

LAW = self_affine(hurst=0.7, q_min=1.0, q_rolloff=4.0, q_max=64.0, rms_slope=0.1)
SIDE = 2 * math.pi


def surface(seed: int = 0, n: int = 256) -> np.ndarray:
    return make_surface(LAW, n, SIDE, realization_generator(seed, 0), "gaussian")


def test_a_ring_has_the_spectrum_that_the_surface_was_made_of() -> None:
    heights = make_surface(LAW, 256, SIDE, realization_generator(1, 0), "fixed")
    found = surface_spectrum(heights, (SIDE, SIDE), window=False)
    inside = (found.q > 5.0) & (found.q < 63.0)
    assert found.power[inside] == pytest.approx(LAW.psd_2d(found.q[inside]), rel=0.02)
    assert found.crowding[inside] == pytest.approx(1.0, abs=0.03)  # fixed amplitudes
    height, slope = rms_height_and_slope(heights, SIDE)
    assert math.sqrt(found.moment(0)) == pytest.approx(height, rel=1e-9)
    assert math.sqrt(found.moment(2)) == pytest.approx(slope, rel=2e-3)  # rings have one q


def test_a_profile_is_the_integral_of_the_surface_across_it() -> None:
    heights = surface()
    along_x = profile_spectrum(heights, (SIDE, SIDE), 1, window=False)
    along_y = profile_spectrum(heights, (SIDE, SIDE), 0, window=False)
    centred = heights - heights.mean(axis=1, keepdims=True)
    assert along_x.moment(0) == pytest.approx(np.mean(centred**2), rel=1e-9)
    _, slope = rms_height_and_slope(heights, SIDE)
    assert along_x.moment(2) + along_y.moment(2) == pytest.approx(slope**2, rel=1e-9)
    # ∫ C2D dq_y over the lattice, at one q_x.
    qy = np.arange(-64, 65)
    expected = LAW.psd_2d(np.hypot(10.0, qy)).sum()
    error = along_x.error[9]
    assert 0.0 < error < 0.3 * expected
    assert along_x.power[9] == pytest.approx(expected, abs=4 * error)
    # Popov's mapping is another spectrum.
    assert abs(along_x.power[9] / LAW.psd_1d(10.0) - 1.0) > 0.2


@pytest.mark.parametrize("window", [False, True])
def test_rectangular_pixels_and_cells(window: bool) -> None:  # noqa: FBT001
    heights = surface(n=512)[:, ::2]
    size = (SIDE, SIDE)
    found = surface_spectrum(heights, size, window=window).binned()
    inside = (found.q > 10.0) & (found.q < 55.0)
    deviation = found.power[inside] / LAW.psd_2d(found.q[inside]) - 1.0
    assert np.all(np.abs(deviation) < 5 * found.error[inside] / found.power[inside] + 0.03)
    part = surface_spectrum(heights[:, :128], (SIDE, SIDE / 2), window=True).binned()
    inside = (part.q > 10.0) & (part.q < 55.0)
    deviation = part.power[inside] / LAW.psd_2d(part.q[inside]) - 1.0
    assert np.all(np.abs(deviation) < 5 * part.error[inside] / part.power[inside] + 0.05)


def test_the_window_keeps_the_power_and_stops_the_leakage() -> None:
    """On crops: the windowed spectrum is right on average, the bare one has leaked power."""
    steep = self_affine(hurst=0.9, q_min=1.0, q_rolloff=2.0, q_max=64.0, rms_slope=0.1)
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for seed in range(12):
        crop = make_surface(steep, 512, SIDE, realization_generator(seed, 0), "gaussian")
        crop = crop[:256, :256]
        for window, kept in ratios.items():
            found = surface_spectrum(crop, (SIDE / 2, SIDE / 2), window=window)
            inside = (found.q > 30.0) & (found.q < 60.0)
            kept.append(float(np.mean(found.power[inside] / steep.psd_2d(found.q[inside]))))
    assert np.mean(ratios[True]) == pytest.approx(1.0, abs=0.03)
    assert np.mean(ratios[False]) > 1.2


@pytest.mark.parametrize("window", [False, True])
def test_the_errors_are_the_scatter_of_an_ensemble(window: bool) -> None:  # noqa: FBT001
    """White noise: any bin scatters by its error, as far as 60 values can tell."""
    rng = np.random.default_rng(4)
    runs, surfaces, profiles = 60, [], []
    for _ in range(runs):
        noise = rng.standard_normal((64, 64))
        surfaces.append(surface_spectrum(noise, (1.0, 1.0), window=window).binned(6))
        profiles.append(profile_spectrum(noise, (1.0, 1.0), 1, window=window).binned(6))
    for kept in (surfaces, profiles):
        power = np.array([one.power for one in kept])[:, 2:]
        claimed = np.mean([one.error for one in kept], axis=0)[2:]
        scatter = power.std(axis=0, ddof=1) / claimed
        # The level of windowed powers is set by all points: their common part scatters less.
        assert (0.75 if window else 0.85) < np.mean(scatter) < 1.15


def test_hanns_window_makes_neighbours_share_their_power() -> None:
    rng = np.random.default_rng(5)
    n = 64
    w = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
    modes = np.fft.fft(w * rng.standard_normal((20000, n)))
    powers = np.abs(modes) ** 2
    correlation = [np.corrcoef(powers[:, 20], powers[:, 20 + k])[0, 1] for k in range(-3, 4)]
    assert sum(correlation) == pytest.approx(HANN_WIDTH, abs=0.05)


@pytest.mark.parametrize("window", [False, True])
def test_filled_places_do_not_take_power_away(window: bool) -> None:  # noqa: FBT001
    """Holes of five points in a row, filled from their rims: 6 % of all."""
    heights = surface(3)
    measured = np.ones(heights.shape, bool)
    rng = np.random.default_rng(3)
    for row, column in rng.integers(0, 250, (900, 2)):
        measured[row, column : column + 5] = False
    filled = np.where(measured, heights, 0.0)
    for _ in range(200):  # harmonic
        around = sum(np.roll(filled, step, axis) for step in (1, -1) for axis in (0, 1))
        filled = np.where(measured, heights, around / 4)
    size = (SIDE, SIDE)
    whole = surface_spectrum(heights, size, window=window)
    bare = surface_spectrum(filled, size, window=window)
    found = surface_spectrum(filled, size, window=window, measured=measured)
    assert bare.moment(2) < 0.99 * whole.moment(2)
    assert found.moment(2) == pytest.approx(whole.moment(2), rel=0.01)
    along = [
        profile_spectrum(filled, size, 1, window=window, measured=mask)
        for mask in (None, measured)
    ]
    assert along[1].moment(2) > along[0].moment(2)


@pytest.mark.parametrize(
    ("heights", "word"),
    [
        (np.zeros((3, 9)), "at least 4 × 4"),
        (np.where(np.eye(9) > 0, np.nan, 1.0), "fill or crop"),
    ],
)
def test_what_has_no_spectrum_is_refused(heights: np.ndarray, word: str) -> None:
    with pytest.raises(SurfaceError, match=word):
        surface_spectrum(heights, (1.0, 1.0), window=True)
