"""Points that are no squares: the sides of the cell along both axes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from roughbench.errors import SolverError
from roughbench.models.base import Status
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.kernel import Kernel
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.states import solve_states
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

HEIGHT = 0.01
ASPECTS = [0.1, 0.5, 3.0, 10.0]
"""Spacing along the second axis over that along the first."""


def wave(points: int) -> np.ndarray:
    return HEIGHT * np.cos(2 * math.pi * np.arange(points) / points)


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_wavy_surface_is_the_wavy_line(axis: int, aspect: float) -> None:
    """Westergaard's wave along either axis, whatever the spacing along the other."""
    options: dict[str, Any] = {"tolerance": 1e-11, "precision": "double", "threads": 1}
    pressure = 0.4 * math.pi * HEIGHT
    line = solve_contact(wave(64), pressure, **options)
    spacing = (1 / 64, aspect / 64) if axis == 0 else (1 / 64 / aspect, 1 / 64)
    heights = np.tile(wave(64)[:, None], (1, 12)) if axis == 0 else np.tile(wave(64), (12, 1))
    sides = spacing[0] * heights.shape[0], spacing[1] * heights.shape[1]
    state = solve_contact(heights, pressure, length=sides, **options)
    assert state.status is Status.CONVERGED
    assert state.area_fraction_raw == line.area_fraction_raw
    assert state.mean_separation == pytest.approx(line.mean_separation, rel=1e-9)
    assert state.energy == pytest.approx(line.energy, rel=1e-9)
    assert state.stiffness() == pytest.approx(line.stiffness(), rel=1e-5)


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("shape", [(4, 6), (5, 3), (8, 8)], ids=str)
def test_the_operator_is_the_dense_matrix(
    shape: tuple[int, int],
    aspect: float,
    rng: np.random.Generator,
    reference: type[Reference],
) -> None:
    operator = HalfSpaceOperator(shape, np.float64, ThreadTeam(1), Kernel(aspect))
    values = rng.standard_normal(shape)
    own = reference(values, length=(float(shape[0]), shape[1] * aspect))
    for apply, power in ((operator.displace, -1.0), (operator.traction, 1.0)):
        operator.field[...] = values
        apply()
        expected = (own.matrix(power) @ values.ravel()).reshape(shape)
        np.testing.assert_allclose(operator.field, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("pressure", [1e-3, 1e-2, 5e-2])
def test_states_against_the_slow_way(
    pressure: float, aspect: float, rough: Rough, reference: type[Reference]
) -> None:
    """Same contact points as a dense active set; fields and certificate recomputed."""
    heights = rough(16, per_wave=2.0, seed=3)[:, :12]
    sides = (2 * math.pi, 2 * math.pi * 12 / 16 * aspect)
    own = reference(heights, length=sides)
    slow = own.solve(pressure)
    state = own.verify(solve_contact(heights, pressure, length=sides), pressure)
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    assert state.mean_separation == pytest.approx(slow.separation, abs=1e-6 * own.rms)
    assert state.energy == pytest.approx(slow.energy, rel=1e-5)
    if not slow.contact.all():
        assert state.stiffness() == pytest.approx(slow.stiffness, rel=1e-4)


@pytest.mark.parametrize("aspect", [0.25, 4.0])
def test_the_transposed_surface_is_the_same_contact(aspect: float, rough: Rough) -> None:
    heights = rough(128, q_rolloff=2.0)[:, :100]
    sides = (2 * math.pi, 2 * math.pi * 100 / 128 * aspect)
    loads = np.geomspace(1e-5, 2.0, 7)  # by the direct sum, by transforms, and full contact
    options: dict[str, Any] = {"tolerance": 1e-10, "threads": 1}
    curve = solve_curve(heights, loads, length=sides, **options)
    turned = solve_curve(heights.T, loads, length=sides[::-1], **options)
    assert (curve.status == 0).all()
    np.testing.assert_array_equal(turned.area_raw, curve.area_raw)
    assert curve.area[-1] == 1.0
    for name in ("area", "separation", "energy"):
        np.testing.assert_allclose(getattr(turned, name), getattr(curve, name), rtol=1e-6)
    # Each is solved for to 1e-5.
    np.testing.assert_allclose(turned.stiffness, curve.stiffness, rtol=2e-5)


def test_both_sides_of_square_points_are_the_same_numbers(rough: Rough) -> None:
    heights = rough(64)[:, :48]
    lengths: list[Any] = [2.0, (2.0, 1.5), [2.0, 1.5], np.array([2.0, 1.5])]
    states = [solve_contact(heights, 1e-2, length=length, threads=1) for length in lengths]
    assert len({state.pressure.tobytes() for state in states}) == 1
    assert len({state.area_fraction for state in states}) == 1
    (yielded,) = solve_states(heights, [1e-2], length=(2.0, 1.5), threads=1)
    assert yielded.separation == states[0].mean_separation


@pytest.mark.parametrize("aspect", [0.5, 4.0])
def test_full_contact_with_one_oblique_wave(aspect: float) -> None:
    """Closed form: p* = E*|q|h0/2, and U = h0 p*/4."""
    n, m = 24, 16
    sides = (1.0, m / n * aspect)
    y, x = np.mgrid[:n, :m]
    heights = HEIGHT * np.cos(2 * math.pi * (y / n + 2 * x / m))
    full = math.pi * HEIGHT * math.hypot(1 / sides[0], 2 / sides[1])
    state = solve_contact(heights, 1.001 * full, length=sides)
    assert state.area_fraction_raw == 1.0
    assert state.energy == pytest.approx(HEIGHT * full / 4, rel=1e-12)
    assert solve_contact(heights, 0.99 * full, length=sides).area_fraction_raw < 1.0


@pytest.mark.parametrize("shape", [(7, 21), (33, 50)], ids=str)
@pytest.mark.parametrize("kernel", [Kernel(0.2), Kernel(5.0), Kernel(2.0, 0.3)], ids=str)
def test_the_direct_sum_is_the_operator(
    kernel: Kernel, shape: tuple[int, int], rng: np.random.Generator
) -> None:
    operator = HalfSpaceOperator(shape, np.float64, ThreadTeam(1), kernel)
    direct = DirectOperator(operator)
    everywhere = np.ones(tile_grid(shape), np.uint8)
    sources = WorkingSet.on(shape, everywhere, np.float64)
    targets = WorkingSet.on(shape, everywhere, np.float64)
    row, column = (int(rng.integers(n)) for n in shape)
    tile = (row // 8) * everywhere.shape[1] + column // 8
    sources.p[:] = 0.0
    sources.p[tile * 64 + (row % 8) * 8 + column % 8] = 1.0
    direct.apply(sources, sources.p, targets, targets.p)
    operator.field[...] = 0.0
    operator.field[row, column] = 1.0
    operator.displace()
    found = targets.p.reshape(*everywhere.shape, 8, 8).swapaxes(1, 2)
    found = found.reshape(8 * everywhere.shape[0], -1)[: shape[0], : shape[1]]
    np.testing.assert_allclose(found, operator.field, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("heights", "length", "message"),
    [
        (np.eye(4), (1.0, 0.0), r"length\[1\] must be a positive number, got 0.0"),
        (np.eye(4), (math.nan, 1.0), r"length\[0\] must be a positive number, got nan"),
        (np.eye(4), (1.0, 2.0, 3.0), r"the two sides \(y, x\) of its cell, got \(1.0, 2.0, 3"),
        (np.eye(4), (1.0,), r"the two sides \(y, x\)"),
        (np.eye(4), (1.0, "2"), r"length\[1\] must be a number, got '2'"),
        (
            np.eye(4)[0],
            (1.0, 2.0),
            r"of its cell, got \(1.0, 2.0\) for heights of shape \(4,\)",
        ),
        (np.eye(4), (1.0, 2000.0), r"points of 0.25 × 500 are too oblong"),
        (np.eye(4), (1.0, 1e-4), r"neither side may be more than 1000 times the other"),
    ],
)
def test_lengths_that_cannot_be_used(heights: Any, length: Any, message: str) -> None:
    with pytest.raises(SolverError, match=message):
        solve_contact(heights, 0.1, length=length)
