"""Realized heights against explicit sums of cosines and the statistics of their spectrum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import (
    Amplitude,
    Undersampled,
    check_grid,
    highest_mode,
    make_profile,
    make_surface,
    realization_generator,
    rms_height_and_slope,
    wavenumbers,
)

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi
AMPLITUDES: tuple[Amplitude, ...] = ("fixed", "gaussian")


def spectrum_to(q_max: float, q_rolloff: float = 1.0, hurst: float = 0.7) -> Spectrum:
    return self_affine(hurst=hurst, q_min=1, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def surface(spectrum: Spectrum, n: int, realization: int = 0, **options: Any) -> FloatArray:
    length = options.pop("length", CELL)
    return make_surface(spectrum, n, length, realization_generator(7, realization), **options)


def profile(spectrum: Spectrum, n: int, realization: int = 0, **options: Any) -> FloatArray:
    length = options.pop("length", CELL)
    return make_profile(spectrum, n, length, realization_generator(7, realization), **options)


def lattice_moment(spectrum: Spectrum, order: int, length: float = CELL) -> float:
    """Σ (2π/L)² q^k C2D over the modes of the square cell."""
    n = highest_mode(spectrum, length)
    step = 2 * math.pi / length
    q = step * np.hypot(*np.mgrid[-n : n + 1, -n : n + 1])
    q = q[q > 0]
    return float((step**2 * q**order * spectrum.psd_2d(q)).sum())


def line_moment(spectrum: Spectrum, order: int, length: float = CELL) -> float:
    """Σ (2π/L) |q|^k C1D over the modes of the line, both signs."""
    step = 2 * math.pi / length
    q = step * np.arange(1, highest_mode(spectrum, length) + 1)
    return float((2 * step * q**order * spectrum.psd_1d(q)).sum())


def cosine_sum_2d(fine: FloatArray, n_points: int, n_modes: int) -> FloatArray:
    """Return Σ h_q e^{iq·x} on a coarser grid, wave by wave, with the modes of a fine one."""
    h_q = np.fft.fft2(fine, norm="forward")
    x = 2 * np.pi * np.arange(n_points) / n_points
    total = np.zeros((n_points, n_points))
    for nx in range(-n_modes, n_modes + 1):
        for ny in range(-n_modes, n_modes + 1):
            phase = nx * x[:, None] + ny * x[None, :]
            total += (h_q[nx, ny] * np.exp(1j * phase)).real
    return total


# The grid ---------------------------------------------------------------------------------


@pytest.mark.parametrize("n_points", [16, 17, 18, 21, 40])
@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_surfaces_are_the_sum_of_their_waves_on_every_grid(
    n_points: int, amplitude: Amplitude
) -> None:
    """Down to 16 points for 8 waves, where the highest ones alternate from point to point."""
    spectrum = spectrum_to(8)
    fine = surface(spectrum, 64, amplitude=amplitude)
    coarse = surface(spectrum, n_points, amplitude=amplitude)
    expected = cosine_sum_2d(fine, n_points, 8)
    np.testing.assert_allclose(coarse, expected, atol=1e-14 * np.abs(fine).max())


@pytest.mark.parametrize("n_points", [16, 17, 18, 21, 40])
@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_lines_are_the_sum_of_their_waves_on_every_grid(
    n_points: int, amplitude: Amplitude
) -> None:
    spectrum = spectrum_to(8)
    h_n = np.fft.fft(profile(spectrum, 64, amplitude=amplitude), norm="forward")
    x = 2 * np.pi * np.arange(n_points) / n_points
    expected = sum(2 * (h_n[n] * np.exp(1j * n * x)).real for n in range(1, 9))
    found = profile(spectrum, n_points, amplitude=amplitude)
    np.testing.assert_allclose(found, expected - np.mean(expected), atol=1e-15)


def test_raising_the_cut_off_only_adds_waves() -> None:
    """Same amplitudes C0: all modes of the smaller q1 are those of the larger."""
    small = spectrum_to(8)
    large = Spectrum((1.0, 16.0), small.prefactors, small.exponents)
    for make, transform in ((surface, np.fft.fft2), (profile, np.fft.fft)):
        a, b = (transform(make(s, 48), norm="forward") for s in (small, large))
        common = np.abs(a) > 1e-9 * np.abs(a).max()
        assert common.sum() > 8
        np.testing.assert_allclose(a[common], b[common], rtol=1e-10)


def test_the_roll_off_does_not_change_the_phases() -> None:
    a, b = (np.fft.fft2(surface(spectrum_to(8, qr), 32)) for qr in (1.0, 4.0))
    common = np.abs(a) > 1e-9 * np.abs(a).max()
    ratio = b[common] / a[common]
    np.testing.assert_allclose(ratio.imag, 0.0, atol=1e-10)
    assert (ratio.real > 0).all()


@pytest.mark.parametrize("n_points", [32, 33])
def test_surfaces_are_isotropic_up_to_a_circle(n_points: int) -> None:
    """|h_q| = (2π/L)√C2D inside q0 … q1, nothing outside: the corners stay empty."""
    spectrum = spectrum_to(12, 3)
    heights = surface(spectrum, n_points, realization=1)
    q = wavenumbers(heights.shape, CELL)
    found = np.abs(np.fft.rfft2(heights, norm="forward"))
    np.testing.assert_allclose(found, np.sqrt(spectrum.psd_2d(q)), atol=1e-16)
    assert (found[q > 12.0001] < 1e-16).all()
    assert found[0, 0] < 1e-16


@pytest.mark.parametrize("length", [CELL, 2.5 * CELL, 10.0])
def test_longer_cells_have_more_waves_of_the_same_roughness(length: float) -> None:
    spectrum = spectrum_to(8, 2)
    n = 2 * highest_mode(spectrum, length) + 1
    height, slope = rms_height_and_slope(surface(spectrum, n, length=length), length)
    assert height**2 == pytest.approx(lattice_moment(spectrum, 0, length), rel=1e-12)
    assert slope**2 == pytest.approx(lattice_moment(spectrum, 2, length), rel=1e-12)
    height, slope = rms_height_and_slope(profile(spectrum, n, length=length), length)
    assert height**2 == pytest.approx(line_moment(spectrum, 0, length), rel=1e-12)
    assert slope**2 == pytest.approx(line_moment(spectrum, 2, length), rel=1e-12)


def test_lattice_sums_tend_to_the_continuum_with_the_cell() -> None:
    spectrum = spectrum_to(8, 2)
    for moment in (lattice_moment, line_moment):
        for order in (0, 2):
            error = [
                abs(moment(spectrum, order, f * CELL) / spectrum.moment(order) - 1)
                for f in (1, 32)
            ]
            assert error[1] < 0.02
            assert error[1] < error[0]


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("make", [surface, profile])
def test_heights_are_real_periodic_numbers_with_zero_mean(
    make: Any, amplitude: Amplitude
) -> None:
    heights = make(spectrum_to(8), 20, amplitude=amplitude)
    assert heights.dtype == np.float64
    assert heights.flags.c_contiguous
    assert abs(heights.mean()) < 1e-17


# The line and its mapping -------------------------------------------------------------------


def test_lines_are_two_sided() -> None:
    """Height and full slope of the line are those of the surface: √2 would be an error.

    Negative control: C1D taken as one-sided loses √2 in both.
    """
    spectrum = spectrum_to(256, 8)
    length = 8 * CELL
    height, slope = rms_height_and_slope(profile(spectrum, 8192, length=length), length)
    # The lattice sum of the line is within 1/(8 · 8 · 8) of the integral.
    assert height == pytest.approx(spectrum.rms_height, rel=0.01)
    assert slope == pytest.approx(spectrum.rms_slope, rel=0.001)
    assert height / math.sqrt(2) != pytest.approx(spectrum.rms_height, rel=0.2)


def test_a_scan_of_the_surface_is_another_line() -> None:
    """It keeps the height but has half of the squared slope."""
    spectrum = spectrum_to(32, 4)
    heights = surface(spectrum, 128)
    whole = rms_height_and_slope(heights, CELL)
    scans = np.array([rms_height_and_slope(row, CELL) for row in heights])
    assert np.mean(scans[:, 1] ** 2) == pytest.approx(whole[1] ** 2 / 2, rel=0.02)
    assert profile(spectrum, 128).std() == pytest.approx(whole[0], rel=0.05)


@pytest.mark.parametrize(
    ("undersampled", "slope"), [("truncate", "0.0812"), ("alias", "0.0863")]
)
def test_the_papers_springs_lose_slope(undersampled: Undersampled, slope: str) -> None:
    """8192 springs for 8192 waves (design notes, §1); in expectation over aliased phases."""
    spectrum = spectrum_to(8192)
    found = [
        rms_height_and_slope(profile(spectrum, 8192, r, undersampled=undersampled), CELL)[1]
        for r in range(20)
    ]
    # The interference of n with 8192 - n averages out: 0.1 % over 20 lines.
    assert np.mean(found) == pytest.approx(float(slope), abs=1e-4)
    full = rms_height_and_slope(profile(spectrum, 16384), CELL)[1]
    assert full == pytest.approx(0.1001, abs=5e-5)


def test_undersampled_lines_are_samples_or_truncations_of_the_full_one() -> None:
    spectrum = spectrum_to(64)
    full = profile(spectrum, 256)
    sampled = full[::4]
    np.testing.assert_allclose(
        profile(spectrum, 64, undersampled="alias"), sampled - sampled.mean(), atol=1e-15
    )
    h_n = np.fft.fft(full, norm="forward")
    h_n[33:-32] = 0.0
    kept = np.fft.ifft(h_n, norm="forward").real[::4]
    np.testing.assert_allclose(
        profile(spectrum, 64, undersampled="truncate"), kept - kept.mean(), atol=1e-15
    )
    for choice in ("error", "truncate", "alias"):  # the same where nothing is lost
        np.testing.assert_array_equal(profile(spectrum, 256, undersampled=choice), full)


# Statistics ---------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [surface, profile])
def test_fixed_amplitudes_do_not_scatter(make: Any) -> None:
    spectrum = spectrum_to(16)
    moment = lattice_moment if make is surface else line_moment
    for r in range(3):
        height, slope = rms_height_and_slope(make(spectrum, 40, r), CELL)
        assert height**2 == pytest.approx(moment(spectrum, 0), rel=1e-12)
        assert slope**2 == pytest.approx(moment(spectrum, 2), rel=1e-12)


def pair_powers(make: Any, spectrum: Spectrum) -> FloatArray:
    """Mean share of h_rms² of each pair of modes ±q."""
    n = highest_mode(spectrum, CELL)
    if make is profile:
        return np.asarray(2 * spectrum.psd_1d(np.arange(1, n + 1)))
    nx, ny = np.mgrid[-n : n + 1, 0 : n + 1]
    once = (ny > 0) | (nx > 0)
    return np.asarray(2 * spectrum.psd_2d(np.hypot(nx[once], ny[once])))


@pytest.mark.parametrize(
    ("make", "q_rolloff", "printed"),
    [(surface, 1, "0.41"), (surface, 8, "0.049"), (profile, 1, "0.74"), (profile, 8, "0.23")],
)
def test_scatter_of_gaussian_heights_is_that_of_the_notes(
    make: Any, q_rolloff: float, printed: str
) -> None:
    """σ/mean of h_rms²: each pair of modes adds an exponential variable."""
    power = pair_powers(make, spectrum_to(512 if make is surface else 8192, q_rolloff))
    scatter = math.sqrt((power**2).sum()) / power.sum()
    assert scatter == pytest.approx(float(printed), abs=0.51 * 10.0 ** (2 - len(printed)))


@pytest.mark.parametrize("q_rolloff", [1, 8])
@pytest.mark.parametrize("make", [surface, profile])
def test_gaussian_amplitudes_scatter_as_their_modes(make: Any, q_rolloff: float) -> None:
    """Mean and variance of h_rms² over the realizations.

    Each pair ±q adds an exponential variable of mean m, so that the mean is Σm and the
    variance Σm². Tolerances: 4 σ/√n for the mean. The sample variance of n realizations
    has the standard error √((κ - 1 + 2/n)/n) σ², and κ = 3 + 6 Σm⁴/(Σm²)², since an
    exponential variable has the excess 6.
    """
    spectrum, runs = spectrum_to(16, q_rolloff), 400
    power = pair_powers(make, spectrum)
    mean, variance = power.sum(), (power**2).sum()
    found = np.array(
        [
            rms_height_and_slope(make(spectrum, 32, r, amplitude="gaussian"), CELL)[0] ** 2
            for r in range(runs)
        ]
    )
    assert abs(found.mean() - mean) < 4 * math.sqrt(variance / runs)
    kurtosis = 3 + 6 * (power**4).sum() / variance**2
    spread = math.sqrt((kurtosis - 1 + 2 / runs) / runs)
    assert abs(found.var(ddof=1) / variance - 1) < 4 * spread


def test_mode_amplitudes_have_the_theoretical_mean() -> None:
    """⟨|h_q|²⟩ = (2π/L)²C, mode by mode; and a negative control that must fail.

    |h_q|² is exponential: over n = 400 realizations its mean has the standard error
    1/√n. Of 100 modes none exceeds 5 of them in 99.98 % of the seeds (the exponential
    tail of a mean of 400 is near the normal one).
    """
    spectrum, runs = spectrum_to(6), 400
    modes = [
        np.fft.rfft2(surface(spectrum, 16, r, amplitude="gaussian"), norm="forward")
        for r in range(runs)
    ]
    power = np.mean(np.abs(modes) ** 2, axis=0)
    q = wavenumbers((16, 16), CELL)
    used = (q >= 1) & (q <= 6)
    deviation = (power[used] / spectrum.psd_2d(q[used]) - 1) * math.sqrt(runs)
    assert np.abs(deviation).max() < 5
    wrong = spectrum_to(6, hurst=0.5).psd_2d(q[used])
    assert np.abs((power[used] / wrong - 1) * math.sqrt(runs)).max() > 5


def test_phases_are_uniform_and_independent() -> None:
    """⟨e^{iφ}⟩ and ⟨e^{i(φ - φ')}⟩ of neighbours vanish as 1/√n."""
    spectrum, runs = spectrum_to(6), 400
    modes = np.array(
        [np.fft.rfft2(surface(spectrum, 16, r), norm="forward") for r in range(runs)]
    )
    q = wavenumbers((16, 16), CELL)
    # One mode of each pair: n_y > 0, and n_y = 0 with n_x > 0.
    once = (q >= 1) & (q <= 6)
    once[9:, 0] = False
    unit = modes[:, once] / np.abs(modes[:, once])
    assert np.abs(unit.mean(axis=0)).max() < 4.5 / math.sqrt(runs)
    product = np.abs(unit.conj().T @ unit / runs)
    np.fill_diagonal(product, 0.0)
    # |sum of n unit vectors|²/n is exponential: P(> 4.5²) = 2e-9 for each of 1600 pairs.
    assert product.max() < 4.5 / math.sqrt(runs)


def test_realizations_have_streams_of_their_own() -> None:
    a, again, other, seed = (
        realization_generator(*pair).random(4) for pair in [(1, 0), (1, 0), (1, 1), (2, 0)]
    )
    np.testing.assert_array_equal(a, again)
    assert not np.isin(a, other).any()
    assert not np.isin(a, seed).any()


# Grids that are refused ----------------------------------------------------------------------


def test_the_nyquist_grid_is_enough_and_no_coarser_one() -> None:
    spectrum = spectrum_to(64)
    assert check_grid(128, spectrum, CELL) == 64
    assert check_grid(129, spectrum, CELL) == 64
    with pytest.raises(SurfaceError, match=r"127 points.*64 waves.*at least 128.*256 resolve"):
        check_grid(127, spectrum, CELL)
    with pytest.raises(SurfaceError, match="at least 128"):
        surface(spectrum, 127)
    with pytest.raises(SurfaceError, match="undersampled: truncate or alias"):
        profile(spectrum, 127)
    with pytest.raises(SurfaceError, match="q1; or else"):
        check_grid(2, spectrum, CELL, remedy="q1; or else")


@given(st.integers(1, 10_000), st.floats(1e-6, 1e6))
@settings(max_examples=50)
def test_rounding_of_the_length_costs_no_mode(n: int, q0: float) -> None:
    spectrum = Spectrum((q0, q0 * (n + 1)), (1.0,), (0.0,))
    assert highest_mode(spectrum, 2 * math.pi / q0) == n + 1


@pytest.mark.parametrize("undersampled", ["error", "truncate", "alias"])
def test_a_cell_without_a_wave_is_refused(undersampled: Undersampled) -> None:
    with pytest.raises(SurfaceError, match="shorter than the shortest wavelength"):
        profile(spectrum_to(8), 64, length=0.5, undersampled=undersampled)
    with pytest.raises(SurfaceError, match="enlarge length or q1"):
        surface(spectrum_to(8), 64, length=0.5)


# Measures -----------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(8,), (9,), (8, 8), (9, 9), (8, 12), (9, 6)])
def test_height_and_slope_of_one_wave(shape: tuple[int, ...]) -> None:
    length = 3.0
    grids = np.meshgrid(*(np.arange(n) * length / shape[0] for n in shape), indexing="ij")
    q = [2 * math.pi * 2 / (n * length / shape[0]) for n in shape]
    heights = 5.0 + 0.3 * np.cos(sum(k * x for k, x in zip(q, grids, strict=True)))
    height, slope = rms_height_and_slope(heights, length)
    assert height == pytest.approx(0.3 / math.sqrt(2))
    assert slope == pytest.approx(0.3 / math.sqrt(2) * math.hypot(*q))


@pytest.mark.parametrize("shape", [(6,), (7,), (6, 8), (7, 5)])
def test_wavenumbers_are_those_of_the_transform(shape: tuple[int, ...]) -> None:
    spacing = 2.0 / shape[0]
    q = wavenumbers(shape, 2.0)
    assert q.shape == np.fft.rfftn(np.zeros(shape)).shape
    last = 2 * math.pi * np.fft.rfftfreq(shape[-1], spacing)
    if len(shape) == 1:
        np.testing.assert_allclose(q, last)
    else:
        first = 2 * math.pi * np.fft.fftfreq(shape[0], spacing)
        np.testing.assert_allclose(q, np.hypot(first[:, None], last))
