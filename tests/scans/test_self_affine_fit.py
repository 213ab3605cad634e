"""Fits of synthetic surfaces whose parameters are known, and of what is not self-affine."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.scans.self_affine_fit import FitOutcome, SelfAffineFit, fit_self_affine
from roughbench.scans.spectra import surface_spectrum
from roughbench.spectrum import self_affine
from roughbench.surface import (
    Amplitude,
    make_surface,
    realization_generator,
    rms_height_and_slope,
)

SIDE = 2 * math.pi
N = 512


def made(
    hurst: float,
    q_rolloff: float,
    q_max: float,
    seed: int = 0,
    n: int = N,
    amplitude: Amplitude = "fixed",
) -> np.ndarray:
    law = self_affine(hurst=hurst, q_min=1.0, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)
    return make_surface(law, n, SIDE, realization_generator(seed, 0), amplitude)


def fitted(heights: np.ndarray, side: float = SIDE, *, window: bool = True) -> SelfAffineFit:
    outcome = fit_self_affine(surface_spectrum(heights, (side, side), window=window))
    assert outcome.fit is not None, outcome.remarks
    return outcome.fit


def outcome_of(heights: np.ndarray) -> FitOutcome:
    return fit_self_affine(surface_spectrum(heights, (1.0, 1.0), window=True), "m")


@pytest.mark.parametrize("window", [False, True])
@pytest.mark.parametrize(
    ("hurst", "q_rolloff", "q_max"),
    [
        (0.3, 1.0, 64.0),
        (0.5, 4.0, 128.0),
        (0.7, 8.0, 128.0),
        (0.8, 16.0, 128.0),
        (0.9, 2.0, 64.0),
    ],
)
def test_what_a_surface_was_made_of_is_found(
    hurst: float,
    q_rolloff: float,
    q_max: float,
    window: bool,  # noqa: FBT001
) -> None:
    heights = made(hurst, q_rolloff, q_max)
    fit = fitted(heights, window=window)
    assert fit.hurst == pytest.approx(hurst, abs=0.05 if window else 0.01)
    assert fit.rms_slope == pytest.approx(0.1, rel=0.02)
    _, realized = rms_height_and_slope(heights, SIDE)
    assert fit.rms_slope == pytest.approx(realized, rel=0.015 if window else 0.003)
    assert fit.q_max == pytest.approx(q_max, rel=0.01)
    assert fit.q_min == pytest.approx(1.0, abs=fit.q_min_error)
    assert fit.q_rolloff == pytest.approx(q_rolloff, abs=3 * fit.q_rolloff_error)
    assert fit.scatter < 0.05
    again = fit.spectrum()
    assert again.rms_slope == pytest.approx(fit.rms_slope)
    assert again.hurst == fit.hurst


def test_a_crop_of_a_larger_surface() -> None:
    fit = fitted(made(0.7, 16.0, 128.0, n=1024)[:512, :512], SIDE / 2)
    assert fit.hurst == pytest.approx(0.7, abs=0.05)
    assert fit.rms_slope == pytest.approx(0.1, rel=0.02)
    assert fit.q_max == pytest.approx(128.0, rel=0.02)
    assert fit.q_rolloff == pytest.approx(16.0, abs=3 * fit.q_rolloff_error)
    assert fit.q_min == pytest.approx(2.0)


def test_units_are_immaterial() -> None:
    heights = made(0.7, 8.0, 64.0, n=256)
    one = fitted(heights)
    other = fitted(1e-9 * heights, 1e-9 * SIDE)
    for name, value in one.to_dict().items():
        scale = 1e9 if name.startswith("q") else 1.0
        assert other.to_dict()[name] == pytest.approx(scale * value, rel=1e-6), name


@pytest.mark.parametrize("window", [False, True])
def test_the_errors_cover(window: bool) -> None:  # noqa: FBT001
    """Of 40 Gaussian surfaces, within one and two standard deviations 68 and 95 %.

    At least 50 and 85 % of 40 have a chance of 99 % and more.
    """
    truth = {"H": 0.6, "qr": 6.0, "slope": 0.1}
    fits = [
        fitted(made(0.6, 6.0, 60.0, seed, 192, "gaussian"), window=window).to_dict()
        for seed in range(40)
    ]
    for name, value in truth.items():
        off = np.array([abs(fit[name] - value) / fit[f"{name}_error"] for fit in fits])
        assert np.mean(off < 1.0) >= 0.5, name
        assert np.mean(off < 2.0) >= 0.85, name
        if name == "H":
            assert np.mean(off < 0.1) < 0.3  # and are not far too large


def test_noise_at_the_end_of_the_spectrum_is_left_out() -> None:
    rng = np.random.default_rng(1)
    heights = made(0.8, 4.0, 256.0) + 6e-4 * rng.standard_normal((N, N))
    outcome = fit_self_affine(surface_spectrum(heights, (SIDE, SIDE), window=True))
    assert outcome.fit is not None
    assert outcome.fit.hurst == pytest.approx(0.8, abs=0.05)
    assert outcome.fit.q_max < 200.0
    assert any("an instrument's noise" in remark for remark in outcome.remarks)


def test_a_filter_at_the_end_of_the_spectrum_is_left_out() -> None:
    from scipy.ndimage import gaussian_filter

    heights = gaussian_filter(made(0.6, 1.0, 256.0), 1.0, mode="wrap")
    outcome = fit_self_affine(surface_spectrum(heights, (SIDE, SIDE), window=False))
    assert outcome.fit is not None
    assert outcome.fit.hurst == pytest.approx(0.6, abs=0.1)
    assert outcome.fit.q_max < 150.0
    assert any("a filter, a tip" in remark for remark in outcome.remarks)


def test_form_at_the_beginning_of_the_spectrum_is_left_out() -> None:
    x = np.linspace(0.0, SIDE, N, endpoint=False)
    heights = made(0.7, 8.0, 128.0) + 0.05 * np.cos(2 * x)
    outcome = fit_self_affine(surface_spectrum(heights, (SIDE, SIDE), window=False))
    assert outcome.fit is not None
    assert outcome.fit.hurst == pytest.approx(0.7, abs=0.05)
    assert outcome.fit.q_min > 2.0
    assert any("waviness" in remark for remark in outcome.remarks)


def test_a_spectrum_that_begins_within_the_scan() -> None:
    law = self_affine(hurst=0.7, q_min=8.0, q_rolloff=8.0, q_max=128.0, rms_slope=0.1)
    heights = make_surface(law, N, SIDE, realization_generator(1, 0))
    outcome = fit_self_affine(surface_spectrum(heights, (SIDE, SIDE), window=False))
    assert outcome.fit is not None
    assert outcome.fit.q_min == pytest.approx(8.0, rel=0.15)
    assert outcome.fit.hurst == pytest.approx(0.7, abs=0.05)
    assert any("hardly any power" in remark for remark in outcome.remarks)


def test_roughness_to_the_last_point_is_said_to_go_on() -> None:
    outcome = fit_self_affine(
        surface_spectrum(made(0.7, 4.0, 256.0), (SIDE, SIDE), window=False), "m"
    )
    assert outcome.fit is not None
    assert outcome.fit.q_max == pytest.approx(256.0)
    assert any("does not end within the scan" in remark for remark in outcome.remarks)


X = np.arange(256) / 256 * np.ones((256, 1))
Y = X.T


def spheres() -> np.ndarray:
    rng = np.random.default_rng(2)
    heights = np.zeros((256, 256))
    for x, y in rng.random((60, 2)):
        inside = np.maximum(0.05**2 - (X - x) ** 2 - (Y - y) ** 2, 0.0)
        heights = np.maximum(heights, np.sqrt(inside))
    return heights


@pytest.mark.parametrize(
    ("heights", "word"),
    [
        pytest.param(np.cos(2 * np.pi * 7.3 * X), "no self-affine law fits", id="wave"),
        pytest.param(np.sign(np.cos(46 * X)), "few hold all the power", id="grating"),
        pytest.param(
            np.maximum(0.003 - (X % 0.125 - 0.06) ** 2 - (Y % 0.125 - 0.06) ** 2, 0.0),
            "few hold all the power",
            id="lattice",
        ),
        pytest.param(
            np.random.default_rng(0).standard_normal((256, 256)), "white noise", id="noise"
        ),
        pytest.param(spheres(), "edges, caps", id="spheres"),
        pytest.param(
            np.sqrt(np.maximum(0.09 - (X - 0.5) ** 2 - (Y - 0.5) ** 2, 0.0)),
            "edges, caps",
            id="sphere",
        ),
        pytest.param(made(0.7, 2.0, 8.0, n=256), "no self-affine law fits", id="narrow"),
        pytest.param(np.cos(X + 3 * Y)[:6, :6], "too few points", id="few points"),
    ],
)
def test_what_is_not_self_affine_is_not_fitted(heights: np.ndarray, word: str) -> None:
    outcome = outcome_of(heights)
    assert outcome.fit is None
    assert word in outcome.remarks[0]
