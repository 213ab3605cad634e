"""The highest asperity alone: Hertz, exponent of eq. (10), the exact solver at low pressure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import roughbench as rb
from roughbench.errors import SolverError, SurfaceError
from roughbench.models.base import Sample, Status
from roughbench.models.hertz_top import (
    Asperity,
    HertzTop,
    asperity_of_heights,
    asperity_of_spectrum,
    finite_size_prefactor,
    hertz_top_curve,
)
from roughbench.models.persson import finite_size_stiffness
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import make_surface, realization_generator

FloatArray = NDArray[np.float64]
SIDE = 2 * math.pi


def spectrum(q_rolloff: float = 1, q_max: float = 64) -> Spectrum:
    return self_affine(hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def test_a_sphere_follows_hertz() -> None:
    radius, side = 3.0, 10.0
    sphere = Asperity(2.0, np.array([1.0]), np.array([1 / radius]))
    r = np.array([1e-9, 0.01, 0.5, 1.0])
    curve = hertz_top_curve(sphere, 4 / 3 * r**3 / radius / side**2, side)
    np.testing.assert_allclose(curve.area, math.pi * r**2 / side**2, rtol=1e-12)
    np.testing.assert_allclose(curve.stiffness, 2 * r / side**2, rtol=1e-12)
    np.testing.assert_allclose(2 - curve.separation, r**2 / radius, rtol=1e-9, atol=1e-15)
    energy = 8 / 15 * math.sqrt(radius) * (r**2 / radius) ** 2.5 / side**2
    np.testing.assert_allclose(curve.energy, energy, rtol=1e-12)


def test_the_tip_of_a_spectrum_is_a_sphere_of_its_rms_curvature() -> None:
    """Below r = c/q1 all waves count: 1/R = ½√M_4."""
    spec = spectrum()
    radius = 2 / math.sqrt(spec.moment(4))
    r = 1.0 / spec.q_max  # less than 1.75/q1
    p = 4 / 3 * r**3 / radius / SIDE**2
    curve = HertzTop(radius="spectrum").curve(Sample(None, SIDE, spec), np.array([p]))
    assert curve.stiffness[0] == pytest.approx(2 * r / SIDE**2, rel=1e-10)


@pytest.mark.parametrize("reach", [1.0, 1.75])
def test_stiffness_follows_equation_10_with_its_prefactor(reach: float) -> None:
    """Between c/q1 and c/q0, K is eq. (10) with θ(c); the waves below q0 that the law has
    and the spectrum has not make 0.5 (q0 r/c)^{4-2H} of M_4."""  # noqa: D209, D205
    spec = spectrum(1, 1e8)
    theta = finite_size_prefactor(spec, reach)
    pressures = np.geomspace(1e-12, 1e-10, 5)
    curve = hertz_top_curve(asperity_of_spectrum(spec, SIDE, reach), pressures, SIDE)
    expected = finite_size_stiffness(spec, pressures, SIDE, theta)
    r = curve.stiffness * SIDE**2 / 2
    assert (r < 3e-3 * reach).all()
    np.testing.assert_allclose(curve.stiffness, expected, rtol=1e-5)


def test_prefactor_is_that_of_the_notes() -> None:
    """PHYSICS §2: θ = 2.3 ± 0.15 with h_lat belongs to c between 1.5 and 2 (q_r = q0)."""
    spec = spectrum(1, 8192)
    lattice = 5.60372 / 4.395117  # h_lat2D/h_cont
    thetas = [finite_size_prefactor(spec, c) * lattice ** (1 / 1.7) for c in (1.5, 2.0)]
    assert 2.15 - 0.15 < thetas[1] < 2.3 < thetas[0] < 2.45 + 0.15


def test_stiffness_and_work_are_derivatives() -> None:
    """K = -dp/dū and -dU/dū = p; the load is a power of r on pieces 1 % wide."""
    step = 1e-5
    p = np.geomspace(1e-9, 1e-4, 6)
    asperity = asperity_of_spectrum(spectrum(), SIDE)
    middle, up, down = (
        hertz_top_curve(asperity, p * (1 + s), SIDE) for s in (0.0, step, -step)
    )
    fall = down.separation - up.separation
    np.testing.assert_allclose(2 * step * p / fall, middle.stiffness, rtol=1e-4)
    np.testing.assert_allclose((up.energy - down.energy) / fall, p, rtol=1e-4)


def test_heights_of_one_wave_have_its_radius() -> None:
    """h0 cos kx cos ky: 1/R = h0 k² at the top, and nothing is left beyond r = c/(√2 k)."""
    n, waves, h0 = 64, 4, 0.01
    x = np.arange(n) / n
    heights = h0 * np.outer(np.cos(2 * np.pi * waves * x), np.cos(2 * np.pi * waves * x))
    for shifted in (heights, np.roll(heights, (3, 5), (0, 1)) + 2.0):
        top = asperity_of_heights(shifted, 1.0, reach=1.0)
        assert top.top == pytest.approx(h0)
        k = 2 * math.pi * waves
        assert top.curvatures[0] == pytest.approx(h0 * k * k, rel=1e-12)
        assert top.radii[0] == pytest.approx(1 / (math.sqrt(2) * k))
        heavy = 4 / 3 * top.radii[0] ** 3 * h0 * k * k
        curve = hertz_top_curve(top, [heavy * 0.999, heavy * 1.001], 1.0)
        assert curve.status.tolist() == [Status.CONVERGED, Status.NOT_FINITE]
        assert np.isnan(curve.area[1])
        assert curve.area[0] > 0


def test_it_agrees_with_the_exact_solver_while_one_asperity_touches() -> None:
    """q1 = 8 on 512² points: contacts of 4.5 and 6 points radius, narrower than c/q1.

    The summit is an ellipse and its curvature falls outwards; both widen the contact by
    some percent.
    """
    spec, n = spectrum(1, 8), 512
    heights = make_surface(spec, n, SIDE, realization_generator(13, 0))
    asperity = asperity_of_heights(heights, SIDE)
    r = np.array([4.5, 6.0]) * SIDE / n
    assert (r < asperity.radii[0]).all()
    p = 4 / 3 * r**3 * asperity.curvatures[0] / SIDE**2
    exact = rb.solve_curve(heights, p, length=SIDE, threads=1)
    top = hertz_top_curve(asperity, p, SIDE)
    sunk = asperity.top - exact.separation
    np.testing.assert_allclose(asperity.top - top.separation, sunk, rtol=0.05)
    np.testing.assert_allclose(top.stiffness, exact.stiffness, rtol=0.06)
    np.testing.assert_allclose(top.area, exact.area, rtol=0.04)


def test_the_top_of_the_spectrum_is_that_of_surfaces_without_many_scales() -> None:
    """N(z) = ln 2 gives the median height of the top, where islands come alone."""
    spec, n = spectrum(8, 12), 60
    tops = [
        make_surface(spec, 64, SIDE, realization_generator(2, r), "gaussian").max()
        for r in range(n)
    ]
    expected = asperity_of_spectrum(spec, SIDE).top
    error = np.std(tops, ddof=1) / math.sqrt(n) * math.sqrt(math.pi / 2)  # of the median
    # A point of the grid is lower than the top by at most k²Δ²/4 of it, 3 % on average.
    assert -4 * error < expected - np.median(tops) < 4 * error + 0.06 * expected


def test_options_and_refusals() -> None:
    spec = spectrum()
    assert (HertzTop().dimension, HertzTop(radius="spectrum").dimension) == (2, 0)
    assert HertzTop().unused_options() == {}
    assert "grid" in HertzTop(radius="spectrum").unused_options()
    assert HertzTop(radius="spectrum").title != HertzTop().title
    assert HertzTop().grid_points(spec, SIDE) == 256
    with pytest.raises(SurfaceError, match="needs a spectrum"):
        HertzTop(radius="spectrum").curve(Sample(None, 1.0), np.array([1e-3]))
    with pytest.raises(SolverError, match="needs heights"):
        HertzTop().curve(Sample(None, 1.0), np.array([1e-3]))
    with pytest.raises(SolverError, match="flat heights"):
        asperity_of_heights(np.zeros((4, 4)), 1.0)
    with pytest.raises(SolverError, match="needs a surface"):
        asperity_of_heights(np.zeros(4), 1.0)
    with pytest.raises(SolverError, match="finite"):
        asperity_of_heights(np.full((4, 4), math.inf), 1.0)
    with pytest.raises(SolverError, match="reach must be positive"):
        asperity_of_spectrum(spec, 1.0, 0.0)
    with pytest.raises(SurfaceError, match="self-affine"):
        finite_size_prefactor(Spectrum((1.0, 2.0), (1.0,), (0.0,)))
    sample = Sample(make_surface(spec, 256, SIDE, realization_generator(0, 0)), SIDE, spec)
    curve = HertzTop().curve(sample, np.array([1e-7, 1e-6]))
    assert (curve.status == 0).all()
    assert (np.diff(curve.separation) < 0).all()
