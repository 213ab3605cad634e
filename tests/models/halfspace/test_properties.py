"""What must hold for every surface: scaling, symmetry, monotony, complementarity."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference

FloatArray = NDArray[np.float64]
SHAPES = [(48,), (33,), (12, 12), (9, 16), (15, 11), (2, 2), (3, 40)]
TIGHT = 1e-10
few = settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@st.composite
def surfaces(draw: st.DrawFn) -> FloatArray:
    """Heights of unit size: white or smooth noise, steps, spikes, few levels."""
    shape = draw(st.sampled_from(SHAPES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    heights = rng.standard_normal(shape)
    kind = draw(st.sampled_from(["white", "smooth", "levels", "plateau", "spikes"]))
    if kind == "smooth":
        waves = [np.fft.fftfreq(n, 1 / n) for n in shape]
        q2 = sum(np.asarray(w) ** 2 for w in np.meshgrid(*waves, indexing="ij"))
        heights = np.fft.ifftn(np.fft.fftn(heights) / (1 + q2)).real
    elif kind == "levels":
        heights = np.round(heights)
    elif kind == "plateau":
        heights = np.minimum(heights, 0.3)
    elif kind == "spikes":
        heights = np.where(heights > 1.2, heights, 0.0)
    size = float(heights.std())
    return heights / size if size > 0 else heights


pressures = st.floats(-3.0, 1.0).map(lambda x: 10.0**x)


def solve(
    heights: FloatArray, pressure: float, length: float = 1.0, modulus: float = 1.0
) -> ContactState:
    return solve_contact(
        heights, pressure, length=length, modulus=modulus, tolerance=TIGHT, threads=1
    )


def pressure_slack(state: ContactState, length: float = 1.0) -> float:
    """Error of the pressure that a gap of the tolerance allows, by the shortest wave."""
    return 10 * TIGHT * math.pi * state.pressure.shape[0] / length


def same_state(one: ContactState, other: ContactState, size: float = 1.0) -> None:
    """Assert equal states; ``size`` is the rms height."""
    assert one.status == other.status
    assert other.mean_separation == pytest.approx(one.mean_separation, abs=1e-8 * size)
    assert other.energy == pytest.approx(one.energy, rel=1e-7)
    assert other.area_fraction_raw == one.area_fraction_raw
    assert other.area_fraction == pytest.approx(one.area_fraction, abs=1e-14)
    if math.isinf(one.stiffness()):
        assert math.isinf(other.stiffness())
    else:
        assert other.stiffness() == pytest.approx(one.stiffness(), rel=3e-5)


def well_posed(state: ContactState) -> bool:
    """Whether the contact set is safe from rounding: no point is just about to touch."""
    touching = state.pressure > 0
    lowest = state.pressure[touching].min() / state.pressure.max()
    open_ = state.gap[~touching]
    return bool(lowest > 1e-6 and (open_.size == 0 or open_.min() > 1e-6))


@given(surfaces(), pressures, st.sampled_from([1e-4, 1e-6, 1e-8, 1e-11]))
@few
def test_every_state_is_one(
    reference: type[Reference], heights: FloatArray, pressure: float, tolerance: float
) -> None:
    """Complementarity, penetration and load of the returned fields, by another way."""
    state = solve_contact(heights, pressure, tolerance=tolerance, threads=1)
    reference(heights).verify(state, pressure, tolerance)


@given(surfaces(), pressures, st.floats(-12.0, 12.0))
@few
def test_scaling_of_the_modulus(heights: FloatArray, pressure: float, power: float) -> None:
    """E* and p times c: stresses and energies times c, the geometry as it was."""
    c = 10.0**power
    one, other = solve(heights, pressure), solve(heights, c * pressure, modulus=c)
    if not well_posed(one):
        return
    scaled = np.abs(other.pressure / c - one.pressure).max()
    assert scaled <= pressure_slack(one)
    assert other.energy == pytest.approx(c * one.energy, rel=1e-7)
    assert other.mean_separation == pytest.approx(one.mean_separation, abs=1e-8)
    assert np.array_equal(other.pressure > 0, one.pressure > 0)
    if math.isfinite(one.stiffness()):
        assert other.stiffness() == pytest.approx(c * one.stiffness(), rel=3e-5)


@given(surfaces(), pressures, st.floats(-9.0, 9.0))
@few
def test_scaling_of_the_heights(heights: FloatArray, pressure: float, power: float) -> None:
    """Heights and p times a: p and gaps times a, U times a², K as it was."""
    a = 10.0**power
    one, other = solve(heights, pressure), solve(a * heights, a * pressure)
    if not well_posed(one):
        return
    assert np.abs(other.pressure / a - one.pressure).max() <= pressure_slack(one)
    assert np.abs(other.gap / a - one.gap).max() <= 1e-8
    assert other.energy == pytest.approx(a * a * one.energy, rel=1e-7)
    assert other.area_fraction == pytest.approx(one.area_fraction, abs=1e-14)
    if math.isfinite(one.stiffness()):
        assert other.stiffness() == pytest.approx(one.stiffness(), rel=3e-5)


@given(surfaces(), pressures, st.floats(-9.0, 9.0))
@few
def test_scaling_of_the_cell(heights: FloatArray, pressure: float, power: float) -> None:
    """Cell times b and p over b: gaps as they were, p, U and K over b."""
    b = 10.0**power
    one, other = solve(heights, pressure), solve(heights, pressure / b, length=b)
    if not well_posed(one):
        return
    assert np.abs(b * other.pressure - one.pressure).max() <= pressure_slack(one)
    assert np.abs(other.gap - one.gap).max() <= 1e-8
    assert b * other.energy == pytest.approx(one.energy, rel=1e-7)
    if math.isfinite(one.stiffness()):
        assert b * other.stiffness() == pytest.approx(one.stiffness(), rel=3e-5)


@given(surfaces(), pressures, st.floats(-1e3, 1e3), st.integers(0, 50), st.integers(0, 50))
@few
def test_offset_and_translation(
    heights: FloatArray, pressure: float, offset: float, down: int, right: int
) -> None:
    """Where the wall stands, and where the cell begins, are conventions."""
    one = solve(heights, pressure)
    if not well_posed(one):
        return
    same_state(one, solve(heights + offset, pressure))
    shift, axes = ((down, right), (0, 1)) if heights.ndim == 2 else ((down,), (0,))
    moved = solve(np.roll(heights, shift, axes), pressure)
    same_state(one, moved)
    deviation = np.roll(one.pressure, shift, axes) - moved.pressure
    assert np.abs(deviation).max() <= pressure_slack(one)


@given(surfaces(), pressures)
@few
def test_mirrors_and_transposition(heights: FloatArray, pressure: float) -> None:
    one = solve(heights, pressure)
    if not well_posed(one):
        return
    for axis in range(heights.ndim):
        mirrored = solve(np.flip(heights, axis), pressure)
        same_state(one, mirrored)
        deviation = np.flip(mirrored.pressure, axis) - one.pressure
        assert np.abs(deviation).max() <= pressure_slack(one)
    if heights.ndim == 2:
        n, m = heights.shape
        turned = solve(heights.T, pressure, length=m / n)  # the pixels stay the same
        same_state(one, turned)
        assert np.abs(turned.pressure.T - one.pressure).max() <= pressure_slack(one)


@given(surfaces(), st.lists(pressures, min_size=2, max_size=6))
@few
def test_load_brings_the_walls_together(heights: FloatArray, loads: list[float]) -> None:
    """U rises and ū falls with p: the least energy is convex in p, and −ū its slope."""
    p = np.sort(loads)
    curve = solve_curve(heights, p, tolerance=TIGHT, threads=1)
    slack = 1e-8
    assert (curve.status == 0).all()
    assert (np.diff(curve.separation) <= slack).all()
    assert (np.diff(curve.energy) >= -slack * curve.energy[1:]).all()
    assert (curve.separation >= -slack).all()
    work = -np.diff(curve.separation)
    gain = np.diff(curve.energy)
    # −dU = p dū: between the least and the largest pressure of each step.
    assert (gain >= p[:-1] * work - 2 * slack * p[1:]).all()
    assert (gain <= p[1:] * work + 2 * slack * p[1:]).all()


@given(st.integers(0, 2**32 - 1))
@few
def test_contact_grows_with_the_load(seed: int) -> None:
    """A(p) of smooth surfaces rises; the kernel on the grid allows one point of slack."""
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(24, 1 / 24)[:, None], np.fft.fftfreq(24, 1 / 24))
    noise = np.fft.fft2(rng.standard_normal((24, 24)))
    heights = np.fft.ifft2(np.where((q > 0) & (q <= 6), noise, 0)).real
    heights /= heights.std()
    curve = solve_curve(heights, np.geomspace(1e-3, 30, 25), tolerance=1e-9, threads=1)
    assert curve.area_raw is not None
    assert (np.diff(curve.area_raw) >= -1.5 / heights.size).all()
    assert curve.area_raw[-1] > 0.9
    assert curve.area_raw[0] < 0.1


@given(surfaces(), st.permutations([0.01, 0.03, 0.2, 0.2, 1.0, 4.0, 50.0]))
@few
def test_order_of_the_pressures_does_not_matter(
    heights: FloatArray, loads: list[float]
) -> None:
    p = np.array(loads)
    curve = solve_curve(heights, p, threads=1)
    ordered = solve_curve(heights, np.sort(p), threads=1)
    back = np.argsort(p, kind="stable")
    for name in ("area", "area_raw", "separation", "stiffness", "energy", "status"):
        first, second = getattr(curve, name)[back], getattr(ordered, name)
        assert first.tobytes() == second.tobytes(), name


def test_pressures_come_back_as_they_were_given() -> None:
    """To the bit, so that curves of several surfaces share their axis."""
    rng = np.random.default_rng(1)
    p = 10.0 ** rng.uniform(-6, 2, 50)
    curves = [solve_curve(rng.standard_normal(17), p, threads=1) for _ in range(5)]
    for curve in curves:
        np.testing.assert_array_equal(curve.pressure, p)


@given(surfaces(), st.lists(pressures, min_size=1, max_size=5, unique=True))
@few
def test_a_curve_is_its_states(heights: FloatArray, loads: list[float]) -> None:
    """A warm start leads to the state that a cold start finds."""
    curve = solve_curve(heights, loads, tolerance=TIGHT, threads=1)
    for i, load in enumerate(loads):
        state = solve(heights, load)
        assert curve.status[i] == state.status
        assert curve.pressure[i] == pytest.approx(load, rel=1e-15)
        assert curve.separation[i] == pytest.approx(state.mean_separation, abs=1e-8)
        assert curve.energy[i] == pytest.approx(state.energy, rel=1e-7)
        if well_posed(state):
            assert curve.area_raw is not None
            assert curve.area_raw[i] == state.area_fraction_raw
            assert curve.area[i] == pytest.approx(state.area_fraction, abs=1e-14)
            if math.isfinite(state.stiffness()):
                assert curve.stiffness[i] == pytest.approx(state.stiffness(), rel=3e-5)
