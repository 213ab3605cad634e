"""Where what is displaced is far less than h_rms, errors must be as small as that."""

from __future__ import annotations

import math
import tracemalloc
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace import memory
from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Rough

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi

KINDS = ("dimples", "groove", "plateau", "grooved plateau", "step", "outlier", "quantized")
FRACTIONS = (1e-9, 1e-7, 1e-5, 1e-3, 0.1, 0.9)
"""Loads, over that of full contact."""


def noise(shape: tuple[int, ...], seed: int) -> FloatArray:
    """Self-affine heights of unit rms value, H = 0.8, 4 points on the shortest wave."""
    waves = np.meshgrid(*(np.fft.fftfreq(n, 1 / n) for n in shape), indexing="ij")
    q = np.sqrt(sum(np.asarray(wave) ** 2 for wave in waves))
    with np.errstate(divide="ignore"):
        amplitude = np.where((q > 0) & (q <= max(shape) / 4), q**-1.8, 0.0)
    white = np.random.default_rng(seed).standard_normal(shape)
    heights = np.fft.ifftn(np.fft.fftn(white) * amplitude).real
    return np.asarray(heights / heights.std())


def make_heights(kind: str, shape: tuple[int, ...], seed: int, roughness: float) -> FloatArray:
    """Heights of about unit size, on a surface or a line."""
    rough = noise(shape, seed)
    x = np.arange(shape[-1]) / shape[-1] * np.ones(shape)
    place = tuple(n // 3 for n in shape)
    if kind == "dimples":
        offsets = np.meshgrid(*(np.arange(n) / n - 0.4 for n in shape), indexing="ij")
        return roughness * rough - np.exp(-50 * sum(np.asarray(o) ** 2 for o in offsets))
    if kind == "groove":
        return roughness * rough - (np.abs(x - 0.5) < 0.1)
    if kind == "plateau":
        return np.minimum(rough, 0.3)
    if kind == "grooved plateau":
        return 10 * np.minimum(rough, 0.0) + roughness * noise(shape, seed + 1)
    if kind == "step":
        return roughness * rough + (x > 0.5)
    if kind == "outlier":
        rough[place] += 50.0
        return rough
    return np.round(rough / max(roughness, 1e-3)) * max(roughness, 1e-3)


def full_load(heights: FloatArray) -> float:
    """−min σ_fc for E* = 1 and a cell of side 1 along the first axis."""
    n = heights.shape[0]
    waves = np.meshgrid(*(2 * math.pi * n * np.fft.fftfreq(m) for m in heights.shape))
    q = np.sqrt(sum(np.asarray(wave) ** 2 for wave in waves)).T
    return -float(np.fft.ifftn(q / 2 * np.fft.fftn(heights)).real.min())


def assert_same(state: ContactState, exact: ContactState) -> None:
    """Assert that A, K, U and the pressures agree to 1e-3."""
    assert exact.certificate.pressure_error < 1e-3
    assert state.status is Status.CONVERGED
    # Points that even the exact answer puts on the edge to rounding may go either way.
    p = exact.pressure
    edge = (p > 0) & (p < 1e-6 * p.mean()) | (p == 0) & (
        exact.gap < 1e-6 * exact.certificate.displacement * np.std(exact.gap)
    )
    differ = (state.pressure > 0) != (p > 0)
    assert np.count_nonzero(differ & ~edge) <= 1e-3 * np.count_nonzero(p)
    if not differ.any():
        assert state.stiffness() == pytest.approx(exact.stiffness(), rel=1e-3)
    assert state.energy == pytest.approx(exact.energy, rel=1e-3)
    assert np.linalg.norm(state.pressure - p) <= 1e-3 * np.linalg.norm(p)
    assert state.pressure.max() == pytest.approx(p.max(), rel=1e-3)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    kind=st.sampled_from(KINDS),
    shape=st.sampled_from([(40, 40), (33, 48), (256,)]),
    seed=st.integers(0, 1000),
    roughness=st.sampled_from([0.0, 1e-4, 1e-2]),
    fraction=st.sampled_from(FRACTIONS),
)
def test_the_default_tolerance_is_enough(
    kind: str, shape: tuple[int, ...], seed: int, roughness: float, fraction: float
) -> None:
    heights = make_heights(kind, shape, seed, roughness)
    pressure = fraction * full_load(heights)
    exact = solve_contact(heights, pressure, tolerance=1e-12, precision="double", threads=1)
    assert_same(solve_contact(heights, pressure, threads=1), exact)


@pytest.mark.parametrize("outlier", [0.0, 50.0])
@pytest.mark.parametrize("loads", [(1e-7, 1e-5, 1e-3, 0.1), (1e-8, 1e-3)], ids=str)
def test_jumps_of_the_load_cost_no_more_than_cold_starts(
    loads: tuple[float, ...], outlier: float, rough: Rough
) -> None:
    """A state of a few pixels says nothing of one at a hundred times its load."""
    heights = rough(512, q_rolloff=8.0)
    heights[100, 200] += outlier * heights.std()
    cold = [solve_contact(heights, load, length=CELL, threads=1) for load in loads]
    tracemalloc.start()
    curve = solve_curve(heights, loads, length=CELL, threads=1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert curve.status.tolist() == [Status.CONVERGED] * len(loads)
    iterations = [state.iterations for state in cold]
    assert curve.diagnostics["iterations"].sum() <= sum(iterations) + len(loads)
    assert curve.area_raw == pytest.approx([s.area_fraction_raw for s in cold], rel=1e-3)
    assert peak <= memory.needed(heights.size, double=False)


def test_rounding_errors_of_the_load_are_not_blown_up() -> None:
    """Where one point carries all, the exact step was a quotient of rounding errors."""
    heights = make_heights("outlier", (128, 128), 1, 0.0)
    state = solve_contact(heights, 1e-4 * full_load(heights), threads=1)
    assert state.status is Status.CONVERGED
    assert np.count_nonzero(state.pressure) == 1
    assert state.iterations <= 5


@pytest.mark.parametrize("exponent", [-17, -15, -12, -9])
@pytest.mark.parametrize("shape", [(48, 48), (256,)], ids=str)
def test_flat_tops_at_vanishing_loads(shape: tuple[int, ...], exponent: int) -> None:
    """All lengths are as small as the load: an answer is as good as at any other."""
    heights = make_heights("plateau", shape, 3, 0.0)
    load = 10.0**exponent * full_load(heights)
    state = solve_contact(heights, load, threads=1)
    more = 10.0 ** (-6 - exponent)
    usual = solve_contact(heights, more * load, threads=1, tolerance=1e-10)
    assert state.status is Status.CONVERGED
    assert np.array_equal(state.pressure > 0, usual.pressure > 0)
    np.testing.assert_allclose(state.pressure * more, usual.pressure, rtol=0.03)
    assert state.energy * more**2 == pytest.approx(usual.energy, rel=1e-4)


@pytest.mark.parametrize("shape", [(48, 48), (256,)], ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_just_below_full_contact(kind: str, shape: tuple[int, ...]) -> None:
    """The last gap closes in proportion to what is missing of the load."""
    heights = make_heights(kind, shape, 5, 1e-2)
    full = full_load(heights)
    before = math.inf
    for missing in (1e-7, 1e-8, 1e-9, 1e-10):
        state = solve_contact(heights, (1 - missing) * full, threads=1)
        assert state.status is Status.CONVERGED
        assert 0.0 < state.mean_separation < before
        before = state.mean_separation
        # So close to full contact the set no longer changes, and K is constant.
        if state.area_fraction_raw < 1.0 and missing <= 1e-9:
            assert state.stiffness() * before == pytest.approx(missing * full, rel=0.1)
    state = solve_contact(heights, full * (1 + 1e-12), threads=1)
    assert state.mean_separation == 0.0
    assert math.isinf(state.stiffness())


def test_full_contact_has_a_certificate_of_its_own() -> None:
    heights = noise((64, 63), 2)
    load = 2 * full_load(heights)
    state = solve_contact(heights, load, threads=1)
    curve = solve_curve(heights, [load, 3 * load], threads=1)
    n, m = heights.shape
    q = 2 * math.pi * np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], n * np.fft.fftfreq(m))
    q[0, 0] = math.inf
    gap = np.fft.ifft2(np.fft.fft2(state.pressure) * 2 / q).real - heights + heights.mean()
    wrong = np.abs(state.pressure * gap).sum() / state.pressure.sum() / heights.std()
    assert 0.0 < state.certificate.complementarity < 1e-13
    assert state.certificate.complementarity == pytest.approx(wrong, abs=1e-15)
    assert curve.diagnostics["complementarity"][0] == state.certificate.complementarity
    assert 0.0 < curve.diagnostics["penetration"][1] < 1e-13
