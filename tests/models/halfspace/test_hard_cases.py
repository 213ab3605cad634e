"""Surfaces and arguments that break contact solvers; each answer is verified."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.models.base import CompleteCurve, Sample, Status
from roughbench.models.halfspace import HalfSpace
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.models.halfspace.loops import gap

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi


def spike(*shape: int) -> FloatArray:
    heights = np.zeros(shape)
    heights[tuple(n // 3 for n in shape)] = 1.0
    return heights


def mesa(points: int) -> FloatArray:
    """Return a square plateau on a plain: flat, with steps, equal heights everywhere."""
    heights = np.zeros((points, points))
    heights[points // 4 : points // 2, points // 4 : points // 2] = 0.01
    return heights


def paraboloid(points: int) -> FloatArray:
    x = np.arange(points) / points - 0.5
    return -(x[:, None] ** 2 + x**2) / 2


SURFACES: dict[str, tuple[FloatArray, tuple[float, ...]]] = {
    "single asperity": (paraboloid(64), (1e-9, 1e-5, 1e-2, 0.3, 1.0)),
    "spike": (spike(65, 64), (1e-9, 1e-2, 1.0, 10.0, 60.0)),
    "spike on a line": (spike(101), (1e-9, 1e-2, 1.0, 10.0, 100.0)),
    "hole": (-spike(64, 65), (1e-9, 1e-3, 1.0, 30.0, 45.0, 60.0)),
    "hole in a line": (-spike(100), (1e-9, 1e-3, 1.0, 30.0, 80.0)),
    "mesa": (mesa(64), (1e-6, 1e-3, 0.02, 0.1, 1.0)),
    "upside-down mesa": (-mesa(64), (1e-6, 1e-3, 0.02, 0.1, 1.0)),
    "two equal spikes": (spike(24, 24) + np.roll(spike(24, 24), (12, 12), (0, 1)), (1e-6, 1.0)),
    "chess board": (
        (np.indices((16, 16)).sum(axis=0) % 2).astype(float),
        (1e-6, 1.0, 20.0, 40.0),
    ),
    "chess line": ((np.arange(64) % 2).astype(float), (1e-6, 1.0, 50.0, 110.0)),
    "two by two": (np.array([[0.0, 1.0], [0.3, -0.2]]), (1e-3, 0.1, 1.0, 3.0)),
    "two points": (np.array([0.0, 1.0]), (1e-3, 1.0, 1.5, 1.6)),
    "narrow": (np.cos(np.arange(2 * 151.0) ** 1.5).reshape(2, 151), (1e-3, 0.3, 3.0)),
    "tall": (np.cos(np.arange(2 * 151.0) ** 1.5).reshape(151, 2), (1e-3, 3.0, 300.0)),
}
CASES = [
    pytest.param(heights, pressure, id=f"{name}-{pressure:g}")
    for name, (heights, pressures) in SURFACES.items()
    for pressure in pressures
]


@pytest.mark.parametrize(("heights", "pressure"), CASES)
def test_extreme_shapes(
    heights: FloatArray, pressure: float, reference: type[Reference]
) -> None:
    own = reference(heights)
    for tolerance in (1e-6, 1e-10):
        state = solve_contact(heights, pressure, tolerance=tolerance, threads=1)
        own.verify(state, pressure, tolerance)
        full = pressure >= -float(own.full_contact_traction().min()) * (1 + 1e-12)
        assert math.isinf(state.stiffness()) == full == (state.area_fraction_raw == 1.0)
        assert full or state.stiffness() > 0.0


@pytest.mark.parametrize("points", [64, 81, 100, 127, 128])
@pytest.mark.parametrize("q_rolloff", [1.0, 8.0])
@pytest.mark.parametrize("line", [False, True], ids=["surface", "line"])
def test_shortest_wave_at_the_nyquist_wavevector(
    *, line: bool, q_rolloff: float, points: int, rough: Rough, reference: type[Reference]
) -> None:
    """Contacts of single points everywhere, from the first one to full contact."""
    heights = rough(points, per_wave=2.0, q_rolloff=q_rolloff, line=line, seed=points)
    own = reference(heights, length=CELL)
    full = -float(own.full_contact_traction().min())
    areas = []
    for pressure in (1e-7, 1e-4, 1e-2, 0.05, 0.5 * full, 0.8 * full, 0.97 * full, full * 1.01):
        state = solve_contact(heights, pressure, length=CELL, threads=1)
        own.verify(state, pressure)
        areas.append(state.area_fraction_raw)
    assert areas[-3] > 0.9
    assert areas[-2] < areas[-1] == 1.0
    assert state.mean_separation == 0.0


@pytest.mark.parametrize("points", [2**14, 8191], ids=str)
def test_fine_lines(points: int, rough: Rough, reference: type[Reference]) -> None:
    """Lines are where an earlier prototype's conjugate gradients diverged.

    Long ones take long to plan: see :func:`test_long_lines`.
    """
    heights = rough(points, per_wave=4.0, q_rolloff=8.0, line=True)
    own = reference(heights, length=CELL)
    for pressure in (1e-5, 1e-2):
        own.verify(solve_contact(heights, pressure, length=CELL), pressure)


@pytest.mark.parametrize("power", [-150, -30, -9, 0, 9, 30, 150])
def test_any_unit_of_length(power: int, rough: Rough) -> None:
    """Nanometres in metres or light years: the same contact, to rounding."""
    heights = rough(32)
    one = solve_contact(heights, 1e-2, length=CELL, threads=1)
    unit = 10.0**power
    other = solve_contact(heights * unit, 1e-2, length=CELL * unit, threads=1)
    assert other.status is Status.CONVERGED
    assert np.array_equal(one.pressure > 0, other.pressure > 0)
    assert other.mean_separation == pytest.approx(one.mean_separation * unit, rel=1e-6)
    assert other.stiffness() * unit == pytest.approx(one.stiffness(), rel=1e-4)
    assert other.energy == pytest.approx(one.energy * unit, rel=1e-6)


@pytest.mark.parametrize("offset", [1e3, -1e6, 1e9])
def test_heights_far_from_zero(offset: float, rough: Rough, reference: type[Reference]) -> None:
    heights = rough(48)
    shifted = heights + offset * float(heights.std())
    own = reference(shifted, length=CELL)
    pressure = 2e-2
    # The offset costs the heights, and their mean, their last digits.
    rounding = 1e-10 + 1e-15 * abs(offset)
    state = own.verify(
        solve_contact(shifted, pressure, length=CELL), pressure, rounding=rounding
    )
    plain = solve_contact(heights, pressure, length=CELL)
    slack = 1e-6 + 1e-15 * abs(offset)
    assert abs(state.mean_separation - plain.mean_separation) <= slack * heights.std()


@pytest.mark.parametrize("height", [0.0, 0.1, -1e9 / 3, 1e-300])
@pytest.mark.parametrize("shape", [(30, 31), (16, 16), (99,), (2, 2)], ids=str)
def test_a_flat_wall_is_in_full_contact(height: float, shape: tuple[int, ...]) -> None:
    """Whatever the rounding error of its mean."""
    heights = np.full(shape, height)
    state = solve_contact(heights, 1e-9)
    assert state.status is Status.CONVERGED
    assert (state.area_fraction, state.area_fraction_raw) == (1.0, 1.0)
    assert state.mean_separation == 0.0
    assert state.stiffness() == math.inf
    assert state.energy == pytest.approx(0.0, abs=1e-22 * height**2)
    np.testing.assert_allclose(state.pressure, 1e-9, rtol=1e-6)
    np.testing.assert_array_equal(state.gap, 0.0)
    curve = solve_curve(heights, [1e-9, 1.0])
    np.testing.assert_array_equal(curve.area, 1.0)
    np.testing.assert_array_equal(curve.stiffness, math.inf)


@pytest.mark.parametrize(
    ("tolerance", "pressure"),
    [(t, p) for t in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12) for p in (1e-4, 1e-2, 0.1)],
)
def test_tolerances(
    tolerance: float, pressure: float, rough: Rough, reference: type[Reference]
) -> None:
    heights = rough(96, per_wave=2.0, seed=2)
    state = solve_contact(heights, pressure, length=CELL, tolerance=tolerance, threads=1)
    reference(heights, length=CELL).verify(state, pressure, tolerance)


@pytest.mark.parametrize("pressure", [1e-4, 1e-2, 0.1])
@pytest.mark.parametrize("tolerance", [1e-16, 1e-18])
def test_a_tolerance_below_rounding_is_not_claimed(
    tolerance: float, pressure: float, rough: Rough, reference: type[Reference]
) -> None:
    heights = rough(64, seed=3)
    state = solve_contact(heights, pressure, length=CELL, tolerance=tolerance, threads=1)
    reference(heights, length=CELL).consistent(state, pressure)
    assert (state.status is Status.CONVERGED) == state.certificate.holds(tolerance)
    if state.status is not Status.CONVERGED:
        assert state.status in (Status.STAGNATED, Status.MAX_ITERATIONS)
    assert state.certificate.complementarity < 1e-12  # it still went as far as it could


@pytest.mark.parametrize("limit", [1, 2, 5])
@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_an_unfinished_state_says_so(
    limit: int, precision: Any, rough: Rough, reference: type[Reference]
) -> None:
    heights = rough(64, per_wave=2.0)
    options = {"length": CELL, "max_iterations": limit, "precision": precision, "threads": 1}
    state = solve_contact(heights, 1e-2, **options)
    assert state.status is Status.MAX_ITERATIONS
    assert not state.certificate.holds(1e-6)
    assert state.iterations <= limit
    reference(heights, length=CELL).consistent(state, 1e-2)
    curve = solve_curve(heights, [1e-2, 1.0, 1e-3], **options)
    # Full contact is a closed form, which no limit stops.
    assert curve.status.tolist() == [
        Status.MAX_ITERATIONS,
        Status.CONVERGED,
        Status.MAX_ITERATIONS,
    ]
    assert (curve.diagnostics["complementarity"][[0, 2]] > 1e-6).all()


def test_max_iterations_does_not_spoil_a_good_start() -> None:
    """A start that already is the state needs no iteration at all."""
    state = solve_contact(spike(64, 64), 1e-6, max_iterations=1)
    assert state.status is Status.CONVERGED
    assert state.iterations <= 1


INPUTS: dict[str, Callable[[FloatArray], Any]] = {
    "float32": lambda h: h.astype(np.float32),
    "float16": lambda h: h.astype(np.float16),
    "long double": lambda h: h.astype(np.longdouble),
    "int64": lambda h: h.astype(np.int64),
    "int16": lambda h: h.astype(np.int16),
    "uint8": lambda h: (h - h.min()).astype(np.uint8),
    "big endian": lambda h: h.astype(">f8"),
    "list": lambda h: h.tolist(),
    "transposed": lambda h: np.asfortranarray(h),
    "strided": lambda h: np.repeat(np.repeat(h, 2, 0), 3, 1)[::2, ::3],
    "reversed": lambda h: np.ascontiguousarray(h[::-1, ::-1])[::-1, ::-1],
    "read-only": lambda h: np.broadcast_to(h, h.shape),
}


@pytest.mark.parametrize("kind", INPUTS)
def test_kinds_of_input(kind: str, rough: Rough, reference: type[Reference]) -> None:
    """Every kind of number is solved as the float64 heights that it stands for."""
    heights = rough(32)
    given = INPUTS[kind](heights / np.abs(heights).max() * 100)
    before = np.array(given, dtype=np.float64)
    pressure = 1e2
    state = solve_contact(given, pressure, length=CELL)
    np.testing.assert_array_equal(np.array(given, dtype=np.float64), before)
    reference(before, length=CELL).verify(state, pressure)
    exact = solve_contact(before, pressure, length=CELL)
    assert state.mean_separation == pytest.approx(exact.mean_separation, rel=1e-9)
    assert np.array_equal(state.pressure > 0, exact.pressure > 0)
    if kind not in ("float32", "float16", "long double"):  # the same float64 numbers
        assert state.pressure.tobytes() == exact.pressure.tobytes()
        assert state.gap.tobytes() == exact.gap.tobytes()


def test_the_loops_are_compiled_for_heights_that_lie_as_usual(rough: Rough) -> None:
    """Others are copied: compiled for each way that arrays can lie, they took half a minute."""
    heights = rough(32)
    solve_contact(heights, 1e-2, length=CELL)
    known = len(gap.mark_tiles.signatures)
    for lying in ("transposed", "strided", "reversed", "read-only"):
        solve_contact(INPUTS[lying](heights), 1e-2, length=CELL)
    assert len(gap.mark_tiles.signatures) == known


@pytest.mark.parametrize("offset", [0.0, 100.0, 0.9])
def test_float32_heights_at_full_contact(offset: float, reference: type[Reference]) -> None:
    """The threshold of float32 heights is that of the numbers they hold, in float64."""
    noise = np.random.default_rng(0).standard_normal((64, 64))
    heights = (noise + offset).astype(np.float32)
    own = reference(heights)
    threshold = -float(own.full_contact_traction().min())
    assert solve_contact(heights, threshold * (1 + 1e-9)).area_fraction_raw == 1.0
    assert solve_contact(heights, threshold * (1 - 1e-9)).area_fraction_raw < 1.0


@pytest.mark.parametrize("power", [-170, 160])
def test_heights_whose_square_cannot_be_represented(power: int) -> None:
    """Not full contact at a tiny pressure, but a refusal."""
    heights = np.eye(8) * 10.0**power
    with np.errstate(all="ignore"), pytest.raises(SolverError, match="another unit of length"):
        solve_contact(heights, 1e-6 * 10.0**power)


@pytest.mark.parametrize("pressure", [1e-60, 1e-300])
def test_pressures_that_float32_cannot_represent(pressure: float) -> None:
    with pytest.raises(SolverError, match=f"pressures must be at least .*, got {pressure}"):
        solve_contact(spike(16, 16), pressure)


@pytest.mark.slow
@pytest.mark.parametrize("power", [16, 18, 20])
def test_long_lines(power: int, rough: Rough, reference: type[Reference]) -> None:
    """Lines of up to a million points, where contacts compete at all distances."""
    heights = rough(2**power, per_wave=4.0, q_rolloff=8.0, line=True)
    own = reference(heights, length=CELL)
    for pressure in (1e-4, 1e-2, 0.05):
        own.verify(solve_contact(heights, pressure, length=CELL), pressure)


def test_fields_belong_to_the_caller(rough: Rough) -> None:
    """Writing into one state's fields changes no other state, and not the heights."""
    heights = rough(32)
    kept = heights.copy()
    one = solve_contact(heights, 1e-2, length=CELL)
    reference_bytes = one.pressure.tobytes()
    other = solve_contact(heights, 1e-2, length=CELL)
    other.pressure[:] = -1.0
    other.gap[:] = -1.0
    assert one.pressure.tobytes() == reference_bytes
    np.testing.assert_array_equal(heights, kept)
    assert one.stiffness() > 0.0


def test_pressures_alone_are_no_problem(rough: Rough) -> None:
    heights = rough(32)
    curve = solve_curve(heights, [1e-2], length=CELL)
    assert curve.area.shape == (1,)
    full = solve_curve(heights, [10.0, 5.0], length=CELL)
    np.testing.assert_array_equal(full.stiffness, math.inf)
    np.testing.assert_array_equal(full.separation, 0.0)
    assert full.energy[0] == full.energy[1] > 0.0


def test_model_solves_the_sample(rough: Rough) -> None:
    """The contender is the curve with E* = 1, and passes its options on."""
    heights = rough(48)
    pressures = np.array([5e-2, 1e-3])
    model = HalfSpace(tolerance=1e-9, precision="double")
    states = model.states(Sample(heights, CELL), pressures, threads=1)
    curve = CompleteCurve.from_states(states, pressures)
    expected = solve_curve(
        heights, pressures, length=CELL, tolerance=1e-9, precision="double", threads=1
    )
    np.testing.assert_array_equal(curve.separation, expected.separation)
    np.testing.assert_array_equal(curve.pressure, pressures)
    assert (curve.diagnostics["complementarity"] <= 1e-9).all()
    assert curve.status.dtype == np.int32
