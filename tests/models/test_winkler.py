"""The springs under the surface: exact arithmetic, closed forms, limits, a prototype."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.errors import SolverError, SurfaceError
from roughbench.models.base import Sample
from roughbench.models.winkler import (
    Winkler,
    gaussian_winkler_curve,
    matched_modulus,
    winkler_curve,
)
from roughbench.spectrum import Spectrum, mode_power, self_affine, wavenumbers
from roughbench.surface import make_surface, realization_generator

FloatArray = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
SIDE = 2 * math.pi


def spectrum(q_rolloff: float, q_max: float) -> Spectrum:
    return self_affine(hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def surface(q_rolloff: float = 2, q_max: float = 16, points: int = 64) -> FloatArray:
    return make_surface(spectrum(q_rolloff, q_max), points, SIDE, realization_generator(3, 0))


@pytest.mark.parametrize("decimals", [1, 17])  # with ties and without
@pytest.mark.parametrize("points", [1, 2, 3, 7, 40])
def test_every_value_agrees_with_rational_arithmetic(points: int, decimals: int) -> None:
    heights = np.round(np.random.default_rng(points).standard_normal(points), decimals)
    h = [Fraction(float(x)) for x in heights]
    mean = sum(h, Fraction(0)) / points
    modulus = 1.7
    top = max(modulus * (float(mean) - heights.min()), 0.1)
    pressures = np.geomspace(1e-9, 1.5, 23) * top
    curve = winkler_curve(heights, pressures, modulus)
    levels = sorted(h, reverse=True)
    for i, p in enumerate(pressures):
        load = points * Fraction(float(p)) / Fraction(modulus)
        for k in range(1, points + 1):
            plane = (sum(levels[:k], Fraction(0)) - load) / k
            if plane <= levels[k - 1] and (k == points or plane > levels[k]):
                break
        delta = [max(x - plane, Fraction(0)) for x in h]
        compression = sum(delta, Fraction(0)) / points
        variance = sum((d * d for d in delta), Fraction(0)) / points - compression**2
        c = Fraction(sum(x >= plane for x in h), points)
        stiffness = math.inf if c == 1 else modulus * float(c / (1 - c))
        assert curve.area[i] == float(c)
        assert curve.stiffness[i] == pytest.approx(stiffness, rel=4 * EPS)
        assert abs(curve.separation[i] - float(plane - mean + compression)) <= 4 * EPS
        assert curve.energy[i] == pytest.approx(modulus / 2 * float(variance), rel=1e-13)


def test_full_contact_holds_the_energy_of_the_half_space() -> None:
    """k_w = ½ΣPq/ΣP: U → ¼ΣPq = ¼M_1 of these heights, ū = 0, K = ∞ from p_f on."""
    heights = surface()
    modulus = matched_modulus(Sample(heights, SIDE))
    p_full = modulus * (heights.mean() - heights.min())
    curve = winkler_curve(heights, [p_full * (1 - 1e-9), p_full * (1 + 1e-12), 1.0], modulus)
    m1 = float((mode_power(heights) * wavenumbers(heights.shape, SIDE)).sum())
    np.testing.assert_allclose(curve.energy[1:], m1 / 4, rtol=1e-12)
    assert curve.separation[1:].tolist() == [0.0, 0.0]
    assert curve.area[1:].tolist() == [1.0, 1.0]
    assert np.isposinf(curve.stiffness).tolist() == [False, True, True]


def test_modulus_of_the_spectrum() -> None:
    """PHYSICS §4: 1.7024 and 8.8739 for the paper's spectra."""
    for q_rolloff, modulus in ((1, 1.7024), (8, 8.8739)):
        found = matched_modulus(Sample(None, 1.0, spectrum(q_rolloff, 8192)))
        assert abs(found - modulus) < 5e-5


def test_modulus_is_that_of_the_heights_where_there_are_any() -> None:
    """With fixed amplitudes the sum over the lattice is near the integral at q_r = 8 q0."""
    spec = spectrum(8, 32)
    heights = make_surface(spec, 64, SIDE, realization_generator(1, 0))
    of_heights = matched_modulus(Sample(heights, SIDE, spec))
    assert of_heights == matched_modulus(Sample(heights, SIDE))
    assert of_heights == pytest.approx(matched_modulus(Sample(None, SIDE, spec)), rel=5e-3)
    given_heights = Winkler().curve(Sample(heights, SIDE), np.array([1e-3]))
    np.testing.assert_array_equal(
        given_heights.area, winkler_curve(heights, [1e-3], of_heights).area
    )


def test_work_is_done_against_the_mean_pressure() -> None:
    """-dU/dū = p and K = -dp/dū, between two pressures with the same points in contact."""
    heights, modulus = surface(points=32).ravel(), 3.0
    p = np.geomspace(1e-5, 0.05, 400)
    curve = winkler_curve(heights, p, modulus)
    near = winkler_curve(heights, p * (1 + 1e-5), modulus)
    same = (near.area == curve.area) & np.isfinite(curve.stiffness) & (curve.area < 1)
    assert same.sum() > 100
    fall = (curve.separation - near.separation)[same]
    np.testing.assert_allclose(
        (near.energy - curve.energy)[same] / fall, (p * (1 + 5e-6))[same], rtol=1e-6
    )
    np.testing.assert_allclose(1e-5 * p[same] / fall, curve.stiffness[same], rtol=1e-6)


# The Gaussian limit ----------------------------------------------------------------------


def test_gaussian_limit_follows_its_equations() -> None:
    from scipy.special import erfc

    t = np.array([-5.0, -2.0, -0.5, 0.0, 0.7, 2.0, 4.0])
    phi, q = np.exp(-t * t / 2) / math.sqrt(2 * math.pi), erfc(t / math.sqrt(2)) / 2
    excess = phi - t * q
    h, modulus = 0.02, 5.0
    curve = gaussian_winkler_curve(h, modulus * h * excess, modulus)
    np.testing.assert_allclose(curve.area, q, rtol=1e-12)
    np.testing.assert_allclose(curve.separation, h * (t + excess), rtol=1e-9, atol=1e-16)
    np.testing.assert_allclose(curve.stiffness, modulus * q / (1 - q), rtol=1e-9)
    variance = (1 + t * t) * q - t * phi - excess**2
    np.testing.assert_allclose(curve.energy, modulus / 2 * h * h * variance, rtol=1e-9)


def test_gaussian_limit_is_consistent_far_out() -> None:
    """-dU/dū = p and K = -dp/dū by central differences, where the equations cancel."""
    step = 1e-4
    p = np.array([1e-200, 1e-40, 1e-12, 1e-4, 1e-2, 0.2, 0.5, 1.0, 3.0])
    middle, up, down = (
        gaussian_winkler_curve(1.0, p * (1 + s), 1.0) for s in (0.0, step, -step)
    )
    fall = down.separation - up.separation
    # Differences of ū keep 1e-16 ū / (ū step) of their digits, and are good to step².
    np.testing.assert_allclose(2 * step * p / fall, middle.stiffness, rtol=1e-6)
    np.testing.assert_allclose((up.energy - down.energy) / fall, p, rtol=1e-6)


def test_gaussian_limit_is_the_limit_of_realized_heights() -> None:
    """Stratified normal heights; N Q = 354 of them lie above t = 3."""
    from scipy.special import ndtri

    n, h = 1 << 18, 0.01
    edges = ndtri(np.arange(1, n) / n)
    density = np.exp(-edges * edges / 2) / math.sqrt(2 * math.pi)
    heights = -h * n * np.diff(density, prepend=0.0, append=0.0)
    p = np.array([4e-6, 1e-4, 1e-3, 5e-3])
    realized, limit = winkler_curve(heights, p, 1.0), gaussian_winkler_curve(h, p, 1.0)
    np.testing.assert_allclose(realized.separation, limit.separation, rtol=1e-6)
    np.testing.assert_allclose(realized.area, limit.area, rtol=1 / 354)
    np.testing.assert_allclose(realized.stiffness, limit.stiffness, rtol=1 / 354)
    np.testing.assert_allclose(realized.energy, limit.energy, rtol=1 / 354)


def test_gaussian_limit_at_the_papers_cut_off() -> None:
    """PHYSICS §7, q_r = 8, q1 = 8192: K h = 2.74e-4, 2.26e-3, 3.71e-2."""
    spec = spectrum(8, 8192)
    curve = Winkler(heights="gaussian").curve(
        Sample(None, SIDE, spec), np.array([1e-4, 1e-3, 1e-2])
    )
    found = curve.stiffness * spec.rms_height
    np.testing.assert_allclose(found, [2.74e-4, 2.26e-3, 3.71e-2], rtol=2e-3)


# Properties ------------------------------------------------------------------------------

heights_of = st.lists(
    st.floats(-1, 1, allow_subnormal=False).map(lambda x: round(x, 3)), min_size=1, max_size=30
).map(np.array)
loads = st.lists(st.floats(1e-6, 4.0), min_size=1, max_size=8).map(np.array)


@given(heights_of, loads)
def test_lengths_and_modulus_scale_out(heights: FloatArray, p: FloatArray) -> None:
    one = winkler_curve(heights, p, 1.5)
    four = winkler_curve(4 * heights, p, 1.5 / 4)
    np.testing.assert_array_equal(four.area, one.area)
    np.testing.assert_array_equal(four.separation, 4 * one.separation)
    np.testing.assert_array_equal(four.stiffness, one.stiffness / 4)
    np.testing.assert_array_equal(four.energy, 4 * one.energy)


@given(heights_of, loads, st.randoms(use_true_random=False))
def test_places_and_order_do_not_matter_and_curves_are_monotone(
    heights: FloatArray, p: FloatArray, random: object
) -> None:
    random.shuffle(shuffled := heights.tolist())  # type: ignore[attr-defined]
    curve = winkler_curve(heights, np.sort(p), 1.5)
    again = winkler_curve(shuffled, np.sort(p)[::-1], 1.5)
    for name in ("area", "separation", "stiffness", "energy"):
        np.testing.assert_array_equal(getattr(curve, name), getattr(again, name)[::-1])
    assert (np.diff(curve.area) >= 0).all()
    assert (np.diff(curve.separation) <= 0).all()
    assert (np.diff(curve.energy) >= 0).all()
    assert (curve.stiffness[1:] >= curve.stiffness[:-1]).all()


# The prototype ---------------------------------------------------------------------------

# PHYSICS §4: q_r = 8, q1 = 128, N = 512, 12 surfaces of fixed amplitude; lengths over
# h_lat = 5.0356e-3. Its standard errors were not noted and are taken to be ours.
PRESSURES = np.array([1e-5, 1e-4, 1e-3, 1e-2, 5e-2])
PROTOTYPE = {
    "area": (1.0, [1.14e-3, 8.76e-3, 0.0675, 0.410, 0.926]),
    "separation": (1 / 5.0356e-3, [3.095, 2.387, 1.527, 0.523, 0.0325]),
    "stiffness": (5.0356e-3, [3.87e-5, 2.99e-4, 2.45e-3, 0.0235, 0.423]),
}


def test_ensemble_agrees_with_the_prototype() -> None:
    model, spec = Winkler(), spectrum(8, 128)
    curves = []
    for r in range(12):
        n = model.grid_points(spec, SIDE)
        heights = make_surface(spec, n, SIDE, realization_generator(2013, r))
        curves.append(model.curve(Sample(heights, SIDE, spec), PRESSURES))
    assert n == 512
    for name, (unit, reference) in PROTOTYPE.items():
        values = np.array([getattr(curve, name) for curve in curves]) * unit
        error = values.std(axis=0, ddof=1) / math.sqrt(12) * math.sqrt(2)
        assert (np.abs(values.mean(axis=0) - reference) < 3.5 * error).all(), name


# The model -------------------------------------------------------------------------------


def test_options_choose_the_sample() -> None:
    assert (Winkler().dimension, Winkler(heights="gaussian").dimension) == (2, 0)
    assert "Gaussian" in Winkler(heights="gaussian").title
    assert Winkler().unused_options() == {}
    assert "grid" in Winkler(heights="gaussian").unused_options()
    with pytest.raises(SurfaceError, match="too coarse"):
        Winkler(grid=16).grid_points(spectrum(1, 16), SIDE)
    heights = surface()
    stiff = Winkler(modulus=9.0).curve(Sample(heights, SIDE), np.array([1e-3]))
    np.testing.assert_array_equal(stiff.area, winkler_curve(heights, [1e-3], 9.0).area)


def test_refuses_what_it_cannot_press() -> None:
    with pytest.raises(SolverError, match="heights of a surface"):
        Winkler().curve(Sample(np.zeros(4), 1.0, spectrum(1, 2)), np.array([1.0]))
    with pytest.raises(SolverError, match="heights of a surface"):
        Winkler().curve(Sample(None, 1.0), np.array([1.0]))
    with pytest.raises(SurfaceError, match="needs heights or a spectrum"):
        matched_modulus(Sample(None, 1.0))
    with pytest.raises(SurfaceError, match="set modulus"):
        Winkler().curve(Sample(np.zeros((4, 4)), 1.0), np.array([1.0]))
    with pytest.raises(SurfaceError, match="needs the spectrum"):
        Winkler(heights="gaussian", modulus=1.0).curve(Sample(None, 1.0), np.array([1.0]))
    with pytest.raises(SolverError, match="finite heights"):
        winkler_curve([0.0, math.nan], [1.0], 1.0)
    with pytest.raises(SolverError, match="modulus must be positive"):
        winkler_curve([0.0], [1.0], 0.0)
    with pytest.raises(SolverError, match="pressures must be positive"):
        winkler_curve([0.0], [0.0], 1.0)
