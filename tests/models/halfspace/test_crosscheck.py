"""Whole states against the slow, obvious way: dense matrices and an active-set method."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from roughbench.models.halfspace.contact import solve_contact
from roughbench.models.halfspace.options import Precision

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

SHAPES = [(64,), (63,), (12, 12), (11, 13), (7, 20), (20, 7)]


@pytest.mark.parametrize("pressure", [0.01, 0.1, 0.4, 1.0, 2.0])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_white_noise(
    shape: tuple[int, ...],
    pressure: float,
    rng: np.random.Generator,
    reference: type[Reference],
) -> None:
    """Independent heights at every point: the roughest surface that a grid can hold."""
    heights = rng.standard_normal(shape)
    own = reference(heights, length=2.5, modulus=0.7)
    slow = own.solve(pressure)
    state = own.verify(
        solve_contact(heights, pressure, length=2.5, modulus=0.7, tolerance=1e-10),
        pressure,
        1e-10,
    )
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    np.testing.assert_allclose(
        state.pressure.ravel(), slow.pressure, rtol=0, atol=1e-8 * slow.pressure.max()
    )
    assert state.mean_separation == pytest.approx(slow.separation, abs=1e-9 * own.rms)
    assert state.energy == pytest.approx(slow.energy, rel=1e-8)


@pytest.mark.parametrize("precision", ["mixed", "double"])
@pytest.mark.parametrize("pressure", [1e-3, 1e-2, 5e-2])
def test_rough_surface_at_the_default_tolerance(
    pressure: float, precision: Precision, rough: Rough, reference: type[Reference]
) -> None:
    """What a tolerance of 1e-6 promises: the contact set, and ū to 1e-6 h_rms."""
    heights = rough(16, per_wave=2.0, seed=3)
    own = reference(heights, length=2 * np.pi)
    slow = own.solve(pressure)
    state = own.verify(
        solve_contact(heights, pressure, length=2 * np.pi, precision=precision), pressure
    )
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    assert state.mean_separation == pytest.approx(slow.separation, abs=1e-6 * own.rms)
    assert state.energy == pytest.approx(slow.energy, rel=1e-5)
    assert state.stiffness() == pytest.approx(slow.stiffness, rel=1e-4)


@pytest.mark.parametrize("pressure", [3e-3, 3e-2, 0.1])
def test_precisions_agree(pressure: float, rough: Rough, reference: type[Reference]) -> None:
    """Iterating in float32 may cost accuracy below the tolerance, not above it."""
    heights = rough(128, per_wave=2.0, seed=11)
    own = reference(heights, length=2 * np.pi)
    tight = solve_contact(
        heights, pressure, length=2 * np.pi, precision="double", tolerance=1e-12
    )
    for tolerance in (1e-4, 1e-6, 1e-8):
        mixed = own.verify(
            solve_contact(heights, pressure, length=2 * np.pi, tolerance=tolerance),
            pressure,
            tolerance,
        )
        # A state whose complementarity is below the tolerance has a ū within it of the
        # exact one, and hence an area within a few points.
        assert abs(mixed.mean_separation - tight.mean_separation) <= tolerance * own.rms
        points = abs(mixed.area_fraction_raw - tight.area_fraction_raw) * heights.size
        assert points <= max(2.0, 10 * tolerance * heights.size)


def test_area_and_separation_approach_the_exact_ones_with_the_tolerance(
    rough: Rough,
) -> None:
    heights = rough(128, seed=12)
    states = [
        solve_contact(heights, 1e-2, length=2 * np.pi, precision="double", tolerance=t)
        for t in (1e-3, 1e-5, 1e-7, 1e-12)
    ]
    exact = states.pop()
    errors = [abs(s.mean_separation - exact.mean_separation) for s in states]
    assert errors[0] < 1e-3 * heights.std()
    assert errors[-1] < 1e-7 * heights.std()
    certificates = [s.certificate.complementarity for s in (*states, exact)]
    assert certificates[-1] <= 1e-12
    assert all(c <= t for c, t in zip(certificates, (1e-3, 1e-5, 1e-7), strict=False))
