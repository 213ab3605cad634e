"""Stiffness and energy against differences of states: K = −dp/dū, p = −dU/dū."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.models.base import CompleteCurve
from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi
STIFFNESS = 3e-5
"""Relative error of K, which is found to about 1e-5."""


def at(heights: FloatArray, pressure: float) -> ContactState:
    return solve_contact(
        heights, pressure, length=CELL, tolerance=1e-12, precision="double", threads=1
    )


@pytest.mark.parametrize("pressure", [1e-3, 1e-2, 5e-2, 0.1])
@pytest.mark.parametrize("line", [False, True], ids=["surface", "line"])
def test_differences_at_unchanged_contact(*, line: bool, pressure: float, rough: Rough) -> None:
    """Between two events everything is linear or quadratic: the differences are exact."""
    heights = rough(64, seed=5, line=line)
    low, high = at(heights, pressure), at(heights, pressure * (1 + 1e-5))
    assert np.array_equal(low.pressure > 0, high.pressure > 0)
    step = low.mean_separation - high.mean_separation
    difference = pressure * 1e-5 / step
    assert low.stiffness() == pytest.approx(difference, rel=STIFFNESS)
    assert high.stiffness() == pytest.approx(difference, rel=STIFFNESS)
    work = pressure * (1 + 0.5e-5) * step
    assert high.energy - low.energy == pytest.approx(work, rel=1e-6)


def test_work_along_a_curve(rough: Rough) -> None:
    """Through many events: the work of the trapezoidal rule, and K between two pressures."""
    heights = rough(64, seed=6)
    p = np.geomspace(1e-4, 0.15, 240)
    curve = solve_curve(heights, p, length=CELL, tolerance=1e-9, threads=1)
    step = -np.diff(curve.separation)
    assert (step > 0).all()
    work = 0.5 * (p[1:] + p[:-1]) * step
    np.testing.assert_allclose(np.diff(curve.energy), work, rtol=2e-3)
    total = curve.energy[-1] - curve.energy[0]
    assert work.sum() == pytest.approx(total, rel=2e-4)
    # K jumps by a few per cent where a point enters: take the mean of the two ends.
    contact_points = curve.area_raw * heights.size if curve.area_raw is not None else p
    many = contact_points[:-1] > 100
    ratio = np.diff(p) / step / np.sqrt(curve.stiffness[1:] * curve.stiffness[:-1])
    assert np.abs(np.log(ratio[many])).mean() < 0.01
    assert np.abs(np.log(ratio[many])).max() < 0.05


@pytest.mark.parametrize("shape", [(64,), (9, 12)], ids=str)
@pytest.mark.parametrize("pressure", [0.02, 0.5, 2.0])
def test_stiffness_is_that_of_the_dense_tangent_problem(
    shape: tuple[int, ...],
    pressure: float,
    rng: np.random.Generator,
    reference: type[Reference],
) -> None:
    heights = rng.standard_normal(shape)
    state = solve_contact(heights, pressure, tolerance=1e-10)
    slow = reference(heights).solve(pressure)
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    assert state.stiffness() == pytest.approx(slow.stiffness, rel=STIFFNESS)


def test_stiffness_of_a_single_point_is_the_self_compliance(
    reference: type[Reference],
) -> None:
    """One point of area Δ² under the whole load: 1/K = N G_00, the operator's diagonal."""
    heights = np.zeros((12, 12))
    heights[3, 4] = 1.0
    state = solve_contact(heights, 1e-6)
    assert (state.pressure > 0).sum() == 1
    diagonal = reference(heights).matrix()[0, 0]
    assert state.stiffness() == pytest.approx(1 / (144 * diagonal), rel=1e-5)


def test_stiffness_does_not_disturb_the_state(rough: Rough) -> None:
    heights = rough(64)
    state = at(heights, 1e-2)
    before = state.pressure.tobytes(), state.gap.tobytes(), state.energy
    first = state.stiffness()
    assert state.stiffness() == first
    assert (state.pressure.tobytes(), state.gap.tobytes(), state.energy) == before


def test_near_full_contact_the_stiffness_grows(rough: Rough) -> None:
    """Where ū itself is 1e-5 h_rms, K must still be −dp/dū, not noise."""
    heights = rough(64, seed=7)
    p = np.array([0.10, 0.12, 0.14, 0.15])
    curve: CompleteCurve = solve_curve(heights, p, length=CELL, threads=1)
    partial = curve.area < 1.0
    assert partial.sum() >= 3
    assert (np.diff(curve.stiffness[partial]) > 0).all()
    pressures, stiffness = p[partial], curve.stiffness[partial]
    for pressure, value in zip(pressures, stiffness, strict=True):
        high = at(heights, pressure * (1 + 1e-6))
        low = at(heights, pressure * (1 - 1e-6))
        slope = 2e-6 * pressure / (low.mean_separation - high.mean_separation)
        assert value == pytest.approx(slope, rel=0.01)
