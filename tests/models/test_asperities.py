"""Greenwood-Williamson, elliptic asperities, counted summits, Bush-Gibson-Thomas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SolverError, SurfaceError
from roughbench.models._asperities import counted_curve
from roughbench.models._gaussian_excess import log_excess
from roughbench.models._summits import find_summits
from roughbench.models.base import CompleteCurve, Sample
from roughbench.models.bgt import BushGibsonThomas, bgt_curve
from roughbench.models.gw import (
    GreenwoodWilliamson,
    counted_gw_curve,
    gw_curve,
    summit_statistics,
)
from roughbench.models.gw_elliptic import (
    Elliptic,
    counted_elliptic_curve,
    elliptic_curve,
    make_weight,
)
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import make_surface, realization_generator

FloatArray = NDArray[np.float64]
SIDE = 2 * math.pi


def spectrum(q_rolloff: float = 8, q_max: float = 128, q_min: float = 1) -> Spectrum:
    return self_affine(hurst=0.7, q_min=q_min, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def slopes(curve: CompleteCurve) -> FloatArray:
    """κ = A ξ/p with ξ = 0.1."""
    return curve.area * 0.1 / curve.pressure


# Moments of the normal distribution --------------------------------------------------------


@pytest.mark.parametrize("order", [0.0, 0.5, 1.0, 1.5, 2.0, 2.5])
def test_moments_above_a_level_agree_with_adaptive_quadrature(order: float) -> None:
    from scipy.integrate import quad

    for t in (-30.0, -9.0, -2.0, 0.0, 0.5, 3.0, 12.0, 38.0):
        above = max(t, 0.0)

        def density(y: float, t: float = t, above: float = above) -> float:
            return 2 * y ** (2 * order + 1) * math.exp((above**2 - (t + y * y) ** 2) / 2)

        end = math.sqrt(max(-t, 0.0) + 10)
        places = {0.5 / (1 + above), max(0.2, -t - 3), max(0.2, -t), max(0.3, 3 - t)}
        inner = sorted(math.sqrt(x) for x in places if math.sqrt(x) < end)
        value = quad(density, 0, end, points=inner, epsabs=0, epsrel=1e-12, limit=500)[0]
        expected = math.log(value) - above**2 / 2 - math.log(2 * math.pi) / 2
        assert abs(log_excess((order,), [t])[0, 0] - expected) < 1e-12


def test_many_levels_are_done_in_blocks() -> None:
    t = np.linspace(-3, 3, 1000)
    together = log_excess((0.5, 1.5), t)
    assert together.shape == (2, 1000)
    one_by_one = np.concatenate([log_excess((0.5, 1.5), [x]) for x in t[::90]], axis=1)
    np.testing.assert_array_equal(together[:, ::90], one_by_one)
    assert log_excess((0.5,), []).shape == (1, 0)


def test_a_weight_enters_under_the_integral() -> None:
    """With V(s) = s² at t = 0: ∫ s^(n+2) φ ds."""
    plain = log_excess((3.0,), [0.0])[0, 0]
    weighted = log_excess((1.0,), [0.0], lambda s: s * s)[0, 0]
    assert plain == pytest.approx(weighted, abs=1e-13)


# Greenwood and Williamson -----------------------------------------------------------------


def test_gw_follows_its_equations() -> None:
    """PHYSICS §4, with F_n by adaptive quadrature."""
    from scipy.integrate import quad

    spec = spectrum()
    found = summit_statistics(spec)
    m0, m2, m4 = spec.moment(0), spec.moment(2) / 2, 3 * spec.moment(4) / 8
    alpha = m0 * m4 / m2**2
    eta, radius = m4 / (6 * math.pi * math.sqrt(3) * m2), 3 * math.sqrt(math.pi / m4) / 8
    sigma, mean = math.sqrt((1 - 0.8968 / alpha) * m0), 4 * math.sqrt(m0 / math.pi / alpha)
    assert found.density == pytest.approx(eta, rel=1e-14)
    assert found.radius == pytest.approx(radius, rel=1e-14)
    assert found.deviation == pytest.approx(sigma, rel=1e-14)
    assert found.mean == pytest.approx(mean, rel=1e-14)

    def f(n: float, t: float) -> float:
        def integrand(y: float) -> float:
            return 2 * y ** (2 * n + 1) * math.exp(-((t + y * y) ** 2) / 2)

        return float(quad(integrand, 0, 4, epsrel=1e-13)[0]) / math.sqrt(2 * math.pi)

    for t in (-1.0, 0.5, 2.0, 4.0):
        p = 4 / 3 * eta * math.sqrt(radius) * sigma**1.5 * f(1.5, t)
        curve = gw_curve(spec, [p])
        assert curve.separation[0] == pytest.approx(mean + sigma * t, rel=1e-9)
        assert curve.area[0] == pytest.approx(math.pi * eta * radius * sigma * f(1, t), 1e-9)
        stiffness = 2 * eta * math.sqrt(radius * sigma) * f(0.5, t)
        assert curve.stiffness[0] == pytest.approx(stiffness, rel=1e-9)


def test_areas_at_the_papers_cut_off() -> None:
    """PHYSICS §4: A ξ/p = 0.38, 0.35, 0.33, 0.31 (elliptic), 0.32 … 0.25 (GW)."""
    spec, p = spectrum(1, 8192), [1e-6, 1e-4, 1e-3, 1e-2]
    np.testing.assert_allclose(
        slopes(elliptic_curve(spec, p)), [0.38, 0.35, 0.33, 0.31], atol=5e-3
    )
    found = slopes(gw_curve(spec, p))
    np.testing.assert_allclose(found[[0, -1]], [0.32, 0.25], atol=5e-3)
    assert (np.diff(found) < 0).all()


@pytest.mark.parametrize("curve_of", [gw_curve, elliptic_curve, bgt_curve])
def test_stiffness_and_work_are_derivatives(curve_of) -> None:  # type: ignore[no-untyped-def]
    """K = -dp/dū, -dU/dū = p, by central differences of 1e-4 in ln p: to step²."""
    step = 1e-4
    p = np.array([1e-12, 1e-6, 1e-4, 1e-2, 0.1])
    middle, up, down = (curve_of(spectrum(), p * (1 + s)) for s in (0.0, step, -step))
    fall = down.separation - up.separation
    np.testing.assert_allclose(2 * step * p / fall, middle.stiffness, rtol=1e-7)
    np.testing.assert_allclose((up.energy - down.energy) / fall, p, rtol=1e-7)


@pytest.mark.parametrize("curve_of", [gw_curve, elliptic_curve, bgt_curve])
def test_units_scale_out(curve_of) -> None:  # type: ignore[no-untyped-def]
    """All lengths times four, and the order of the pressures."""
    p = np.array([1e-3, 1e-6, 1e-2])
    one = curve_of(spectrum(), p)
    four = curve_of(spectrum(2, 32, 0.25), p[::-1])
    np.testing.assert_allclose(four.area[::-1], one.area, rtol=1e-12)
    np.testing.assert_allclose(four.separation[::-1], 4 * one.separation, rtol=1e-11)
    np.testing.assert_allclose(four.stiffness[::-1], one.stiffness / 4, rtol=1e-12)
    np.testing.assert_allclose(four.energy[::-1], 4 * one.energy, rtol=1e-11)


# The elliptic model ------------------------------------------------------------------------


@pytest.mark.parametrize("q_max", [10.0, 128.0])
def test_the_density_of_summits_is_nayaks(q_max: float) -> None:
    """∫D = η = m4/(6√3π m2), whatever the correlation of height and curvature."""
    spec = spectrum(8, q_max)
    weight = make_weight(3.0, math.sqrt(1.5 / spec.nayak))
    (total,) = np.exp(log_excess((0.0,), [-12.0], weight)[0])
    m2, m4 = spec.moment(2) / 2, 3 * spec.moment(4) / 8
    per_area = 2 * m4 / (3 * math.pi * m2)
    assert per_area * total == pytest.approx(summit_statistics(spec).density, rel=1e-10)


def test_elliptic_model_agrees_with_the_integral_over_its_density() -> None:
    """A and p from D(z, κ_m, g) on a grid of Gauss-Legendre points, in its raw variables."""
    spec = spectrum(8, 24)
    m0, m2, m4 = spec.moment(0), spec.moment(2) / 2, 3 * spec.moment(4) / 8
    points, weights = np.polynomial.legendre.leggauss(120)
    points, weights = (points + 1) / 2, weights / 2
    d = 1.5 * math.sqrt(m0)
    # z = d + y², κ_m from 0, g = κ_m v
    reach_y, reach_k = math.sqrt(6 * math.sqrt(m0)), 9 * math.sqrt(2 * m4 / 3)
    y = (reach_y * points)[:, None, None]
    k = (reach_k * points)[None, :, None]
    g = k * points[None, None, :]
    z = d + y * y
    jacobian = 2 * y * reach_y * reach_k * k
    volume = weights[:, None, None] * weights[None, :, None] * weights[None, None, :]
    v11, v22, v12 = m0, 2 * m4 / 3, m2
    det = v11 * v22 - v12**2
    normal = np.exp(-(v22 * z * z - 2 * v12 * z * k + v11 * k * k) / (2 * det))
    normal = normal / (2 * math.pi * math.sqrt(det))
    density = 3 * g**3 / (2 * math.pi * m2 * m4)
    density = density * np.exp(-3 * (k * k - g * g) / (2 * m4)) * normal * jacobian * volume
    x = z - d
    area = float((math.pi * x / g * density).sum())
    p = float((4 / 3 * x**1.5 / np.sqrt(g) * density).sum())
    curve = elliptic_curve(spec, [p])
    assert curve.separation[0] == pytest.approx(d, rel=1e-7)
    assert curve.area[0] == pytest.approx(area, rel=1e-7)


def test_asperities_tend_to_the_line_of_bush_gibson_and_thomas() -> None:
    """A ξ/p → √(2π), A → φ(t)/2t: deviations fall as 1/t², below 1 % at t = 35."""
    spec = spectrum(4, 8)
    assert spec.nayak < 2.5  # α enters the deviations
    p = np.array([1e-20, 1e-60, 1e-180, 1e-270])
    elliptic, line = elliptic_curve(spec, p), bgt_curve(spec, p)
    t = elliptic.separation / spec.rms_height
    assert t[-1] > 35
    deviation = elliptic.area / line.area - 1
    assert (np.abs(deviation) < 4.5 / t**2).all()
    assert abs(deviation[-1]) < 5e-3
    np.testing.assert_allclose(elliptic.separation, line.separation, rtol=5e-3)
    np.testing.assert_allclose(slopes(line), math.sqrt(2 * math.pi), rtol=1e-12)


def test_line_of_bgt_follows_its_equations() -> None:
    from scipy.special import exp1

    spec = spectrum()
    h = spec.rms_height
    t = np.array([0.05, 0.9, 2.0, 5.0, 20.0])
    area = np.exp(-t * t / 2) / math.sqrt(2 * math.pi) / (2 * t)
    p = 0.1 * area / math.sqrt(2 * math.pi)
    curve = bgt_curve(spec, p)
    np.testing.assert_allclose(curve.separation, h * t, rtol=1e-11)
    np.testing.assert_allclose(curve.area, area, rtol=1e-13)
    np.testing.assert_allclose(
        curve.energy, 0.1 * h / (8 * math.pi) * exp1(t * t / 2), rtol=1e-9
    )


def test_area_falls_below_the_line_at_a_moderate_cut_off() -> None:
    """PHYSICS §4: at q1/q0 = 128 the elliptic area is low by a factor of about 1.8."""
    p = [1e-3]
    exact = 2.1  # κ of the exact solution, q_r = q0, p/E* = 1e-3
    ratio = exact / slopes(elliptic_curve(spectrum(1, 128), p))[0]
    assert 1.7 < ratio < 2.0


# Counted summits ---------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(64, 64), (45, 45), (32, 96)])
def test_summits_of_an_egg_box(shape: tuple[int, int]) -> None:
    """cos kx cos ky: two per cell, of height 1 and both curvatures k², off the grid."""
    spacing = 0.1
    length = spacing * shape[0]
    x, y = (np.arange(n) / n for n in shape)
    waves = (3, 3 * shape[1] // shape[0])
    heights = 0.2 * np.outer(
        np.cos(2 * np.pi * (waves[0] * x - 0.21)), np.cos(2 * np.pi * (waves[1] * y + 0.13))
    )
    summits = find_summits(heights + 7.0, length)
    k = 2 * np.pi * 3 / length
    assert summits.height.size == 2 * waves[0] * waves[1]
    assert summits.nominal_area == pytest.approx(length * spacing * shape[1])
    # One Newton step from the grid point: an error of fourth order in the offset.
    offset = k * spacing / math.sqrt(2)
    np.testing.assert_allclose(summits.height, 0.2, rtol=offset**4 / 4)
    np.testing.assert_allclose(summits.mean_curvature, 0.2 * k * k, rtol=offset**2)
    np.testing.assert_allclose(summits.effective_curvature, 0.2 * k * k, rtol=offset**2)


def test_summits_of_gaussian_surfaces_are_nayaks() -> None:
    """Density, mean curvature, heights within 4 standard errors, plus the grid's share.

    16 points on the shortest wave miss (2.5 ± 1) % of the summits, the lowest ones, as
    the density at 4, 8 and 16 points per wave (0.83, 0.954, 0.988) tells.
    """
    spec, n = spectrum(4, 24), 40
    theory = summit_statistics(spec)
    found = []
    for r in range(n):
        heights = make_surface(spec, 384, SIDE, realization_generator(1, r), "gaussian")
        summits = find_summits(heights, SIDE)
        found.append(
            [
                summits.height.size / SIDE**2 / theory.density,
                summits.mean_curvature.mean() * theory.radius,
                summits.height.mean() / theory.mean,
                np.sqrt(np.mean((summits.height - theory.mean) ** 2)) / theory.deviation,
            ]
        )
    error = np.std(found, axis=0, ddof=1) / math.sqrt(n)
    assert (error < 0.02).all()  # it is a test
    missed = np.array([0.025, 0.0, 0.02, 0.0])
    assert (np.abs(np.mean(found, axis=0) - 1) < 4 * error + missed).all()


def test_counted_summits_carry_hertz_contacts() -> None:
    """Two equal spheres and a lower one that touches later."""
    heights, curvatures = np.array([0.5, 1.0, 1.0]), np.array([8.0, 2.0, 2.0])
    nominal = 100.0
    delta = np.array([0.1, 0.4, 0.9])
    force = 2 * 4 / 3 * delta**1.5 / math.sqrt(2)
    late = np.maximum(delta - 0.5, 0)
    force += 4 / 3 * late**1.5 / math.sqrt(8)
    curve = counted_curve(heights, curvatures, nominal, (force / nominal)[::-1])
    np.testing.assert_allclose(curve.separation[::-1], 1 - delta, rtol=1e-12)
    area = math.pi * (2 * delta / 2 + late / 8) / nominal
    np.testing.assert_allclose(curve.area[::-1], area, rtol=1e-12)
    stiffness = 2 * (2 * np.sqrt(delta / 2) + np.sqrt(late / 8)) / nominal
    np.testing.assert_allclose(curve.stiffness[::-1], stiffness, rtol=1e-12)
    energy = 8 / 15 * (2 * delta**2.5 / math.sqrt(2) + late**2.5 / math.sqrt(8)) / nominal
    np.testing.assert_allclose(curve.energy[::-1], energy, rtol=1e-12)
    assert curve.diagnostics["summits_in_contact"].tolist() == [3, 2, 2]


def test_counted_summits_keep_their_accuracy_at_tiny_loads() -> None:
    curve = counted_curve(np.array([1.0, 0.5]), np.array([2.0, 2.0]), 1.0, np.array([1e-30]))
    delta = (0.75e-30 * math.sqrt(2)) ** (2 / 3)
    assert curve.stiffness[0] == pytest.approx(2 * math.sqrt(delta / 2), rel=1e-12)


def test_models_of_one_egg_box_agree() -> None:
    """All summits alike: spheres of one radius are the elliptic model."""
    x = np.arange(32) / 32
    heights = 0.1 * np.outer(np.cos(4 * np.pi * x), np.cos(4 * np.pi * x))
    p = np.array([1e-4, 1e-3])
    one, other = (f(heights, p, 1.0) for f in (counted_gw_curve, counted_elliptic_curve))
    for name in ("area", "separation", "stiffness", "energy"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12)
    # Eight summits of curvature h0 k² carry the load.
    g = 0.1 * (4 * math.pi) ** 2
    delta = (0.75 * p / 8 * math.sqrt(g)) ** (2 / 3)
    np.testing.assert_allclose(one.separation, 0.1 - delta, rtol=1e-12)


def test_counted_and_integrated_summits_agree_on_large_surfaces() -> None:
    """30 Gaussian surfaces of 8 points per wave, where 5 % of the summits go unseen.

    Those are low and flat: at these pressures the area lacks at most 5 %.
    """
    spec, n, p = spectrum(8, 48), 30, np.array([3e-4, 3e-3])
    for theory, counted in (
        (gw_curve, counted_gw_curve),
        (elliptic_curve, counted_elliptic_curve),
    ):
        values = []
        for r in range(n):
            heights = make_surface(spec, 384, SIDE, realization_generator(4, r), "gaussian")
            curve = counted(heights, p, SIDE)
            values.append([curve.area, curve.separation / spec.rms_height])
        mean = np.mean(values, axis=0)
        error = np.std(values, axis=0, ddof=1) / math.sqrt(n)
        reference = theory(spec, p)
        assert (np.abs(mean[0] / reference.area - 1) < 0.05 + 4 * error[0] / mean[0]).all()
        difference = np.abs(mean[1] - reference.separation / spec.rms_height)
        assert (difference < 0.03 + 4 * error[1]).all()


# The models --------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [GreenwoodWilliamson, Elliptic])
def test_options_choose_the_sample(model: type[GreenwoodWilliamson] | type[Elliptic]) -> None:
    assert (model().dimension, model(summits="counted").dimension) == (0, 2)
    assert model(summits="counted").unused_options() == {}
    assert "grid" in model().unused_options()
    assert "counted" in model(summits="counted").title
    assert model(summits="counted", grid=40).grid_points(spectrum(1, 16), SIDE) == 40
    with pytest.raises(SurfaceError, match="too coarse"):
        model(summits="counted", grid=16).grid_points(spectrum(1, 16), SIDE)
    with pytest.raises(SurfaceError, match="needs a spectrum"):
        model().curve(Sample(None, 1.0), np.array([1e-3]))
    with pytest.raises(SolverError, match="needs heights"):
        model(summits="counted").curve(Sample(None, 1.0), np.array([1e-3]))
    sample = Sample(make_surface(spectrum(1, 8), 32, SIDE, realization_generator(0, 0)), SIDE)
    curve = model(summits="counted").curve(sample, np.array([1e-5, 1e-3]))
    assert (np.diff(curve.area) > 0).all()


def test_refuses_heights_without_summits() -> None:
    p = np.array([1e-3])
    for heights, message in (
        (np.zeros((8, 8)), "no summit"),
        (np.zeros(8), "heights of a surface"),
        (np.full((8, 8), math.nan), "finite"),
    ):
        with pytest.raises(SolverError, match=message):
            counted_gw_curve(heights, p, 1.0)
    with pytest.raises(SurfaceError, match="needs a spectrum"):
        BushGibsonThomas().curve(Sample(None, 1.0), p)
    curve = BushGibsonThomas().curve(Sample(None, 1.0, spectrum()), p)
    assert curve.area[0] == pytest.approx(math.sqrt(2 * math.pi) * 1e-2)
