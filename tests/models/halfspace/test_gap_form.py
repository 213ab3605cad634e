"""The problem with the gap as unknown: the same states, its preconditioner, its tangent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.models.base import Status
from roughbench.models.halfspace import solver as outer
from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve
from roughbench.models.halfspace.gap_form import GapSpace
from roughbench.models.halfspace.loops import gap_form as loops
from roughbench.models.halfspace.loops import tiles
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.solver import Solver
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi


@pytest.fixture
def always(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the gap the unknown at all loads."""
    for name in "GAP_FORM_LOAD", "GAP_TANGENT_CONTACT", "GAP_FORM_CONTACT":
        monkeypatch.setattr(outer, name, 0.0)


def never(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in "GAP_FORM_LOAD", "GAP_TANGENT_CONTACT":
        monkeypatch.setattr(outer, name, math.inf)


def space(shape: tuple[int, int], threads: int = 1) -> GapSpace:
    operator = HalfSpaceOperator(shape, np.float64, ThreadTeam(threads))
    return GapSpace(operator, np.zeros((shape[0] + 2, shape[1] + 2)))


@pytest.mark.usefixtures("always")
@pytest.mark.parametrize("pressure", [2e-3, 2e-2, 5e-2, 0.1])
@pytest.mark.parametrize("shape", [(12, 12), (11, 14)], ids=["even", "odd"])
def test_states_are_those_of_dense_matrices(
    shape: tuple[int, int], pressure: float, reference: type[Reference]
) -> None:
    heights = 0.02 * np.random.default_rng(4).standard_normal(shape)
    own = reference(heights, length=CELL)
    slow = own.solve(pressure)
    state = solve_contact(heights, pressure, length=CELL, tolerance=1e-11, threads=1)
    assert state.status is Status.CONVERGED
    np.testing.assert_array_equal((state.pressure > 0).ravel(), slow.contact)
    np.testing.assert_allclose(state.pressure.ravel(), slow.pressure, atol=1e-8 * pressure)
    assert state.mean_separation == pytest.approx(slow.separation, rel=1e-7)
    assert state.energy == pytest.approx(slow.energy, rel=1e-9)
    assert state.stiffness() == pytest.approx(slow.stiffness, rel=3e-5)


@pytest.mark.parametrize("precision", ["mixed", "double"])
@pytest.mark.parametrize("pressure", [0.02, 0.05, 0.1, 0.15])
def test_both_unknowns_give_the_same_state(
    pressure: float, precision: str, rough: Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = rough(96, seed=3)

    def solve() -> ContactState:
        return solve_contact(
            heights,
            pressure,
            length=CELL,
            tolerance=1e-9 if precision == "double" else 1e-6,
            precision=precision,  # type: ignore[arg-type]
            threads=2,
        )

    with monkeypatch.context() as patch:
        never(patch)
        by_pressure = solve()
        stiffness = by_pressure.stiffness()
    by_gap = solve()
    with monkeypatch.context() as patch:
        for name in "GAP_FORM_LOAD", "GAP_TANGENT_CONTACT":
            patch.setattr(outer, name, 0.0)
        by_gap = solve()
        assert by_gap.stiffness() == pytest.approx(stiffness, rel=1e-3)
    assert by_gap.status is by_pressure.status is Status.CONVERGED
    rel = 1e-7 if precision == "double" else 1e-5
    assert by_gap.energy == pytest.approx(by_pressure.energy, rel=rel)
    assert by_gap.mean_separation == pytest.approx(by_pressure.mean_separation, rel=1e-3)
    points = round(by_pressure.area_fraction_raw * heights.size)
    assert round(by_gap.area_fraction_raw * heights.size) == pytest.approx(points, abs=3)
    assert not np.array_equal(by_gap.pressure, by_pressure.pressure), "one form was used twice"


@pytest.mark.usefixtures("always")
def test_a_curve_from_first_contact_to_the_last_gap(rough: Rough) -> None:
    """Also where few points touch, to which the form is not suited, and nearly all do."""
    heights = rough(64, seed=2)
    pressures = np.geomspace(1e-4, 0.5, 24)
    curve = solve_curve(heights, pressures, length=CELL, threads=1)
    assert (curve.status == Status.CONVERGED).all()
    assert (np.diff(np.asarray(curve.area_raw)) >= 0).all()
    assert (np.diff(curve.separation) <= 0).all()
    assert curve.area[-1] == 1.0


def test_dimples() -> None:
    """Dimples in a plane: nearly all is in contact, the gap on few islands."""
    x = np.arange(96) * CELL / 96
    wave = np.maximum(np.cos(3 * x)[:, None] * np.cos(4 * x), 0.6)
    curve = solve_curve(-0.05 * wave, [0.005, 0.02, 0.05, 0.1], length=CELL, threads=1)
    exact = solve_curve(
        -0.05 * wave, [0.005, 0.02, 0.05, 0.1], length=CELL, tolerance=1e-12, threads=1
    )
    assert (curve.status == Status.CONVERGED).all()
    for name in "area_raw", "separation", "energy":
        np.testing.assert_allclose(getattr(curve, name), getattr(exact, name), rtol=1e-3)


@pytest.mark.parametrize("shape", [(12, 12), (9, 14), (1, 41)])
def test_the_preconditioner_is_symmetric_and_positive(shape: tuple[int, int]) -> None:
    """And near the inverse of S on the open points, whatever these are."""
    made = space(shape)
    generator = np.random.default_rng(1)
    n = shape[0] * shape[1]
    for share in (0.05, 0.4, 0.95):
        open_points = generator.random(shape) < share
        made._preconditioner.open(1.0 - share)
        weight = np.ones(shape)

        def precondition(
            w: FloatArray,
            weight: FloatArray = weight,
            open_points: NDArray[np.bool_] = open_points,
        ) -> FloatArray:
            zero = np.zeros(shape)
            fields = zero.copy(), w, zero.copy(), zero.copy()
            made._advance_frozen(fields, ~open_points, weight, 0.0)
            y = np.zeros(shape)
            made._precondition(weight, y)
            return y

        precondition(np.ones(shape))
        tiles.wrap_halo(made._masked)
        made._weigh(weight)
        a, b = generator.standard_normal((2, *shape)) * open_points
        m_a, m_b = precondition(a), precondition(b)
        assert (m_a[~open_points] == 0).all()
        assert np.vdot(b, m_a) == pytest.approx(np.vdot(a, m_b), rel=1e-10, abs=1e-12 * n)
        matrix = np.array([precondition(unit.reshape(shape)).ravel() for unit in np.eye(n)])
        inside = open_points.ravel()
        block = matrix[np.ix_(inside, inside)]
        assert np.linalg.eigvalsh(0.5 * (block + block.T)).min() > 0.0


def test_weights_count_open_neighbours() -> None:
    made = space((9, 14))
    open_points = np.random.default_rng(5).random((9, 14)) < 0.5
    masked = made._masked
    masked[1:-1, 1:-1] = open_points
    tiles.wrap_halo(masked)
    weight = np.empty((9, 14))
    made._weigh(weight)
    count = sum(
        np.roll(open_points, (i, j), (0, 1)).astype(int) for i in (-1, 0, 1) for j in (-1, 0, 1)
    )
    np.testing.assert_allclose(weight, (np.maximum(count, 1) / 9) ** 0.2)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.8])
def test_the_tangent_is_that_of_dense_matrices(
    share: float, reference: type[Reference]
) -> None:
    """S v = −1 on the open points; compliance −⟨v⟩, and the pressure 1 + S v elsewhere."""
    heights = np.random.default_rng(2).standard_normal((14, 20))
    own = reference(heights, length=14.0)  # spacing 1
    open_points = np.random.default_rng(3).random(heights.size) < share
    stiffness = own.matrix(1.0)
    v = np.zeros(heights.size)
    v[open_points] = np.linalg.solve(
        stiffness[np.ix_(open_points, open_points)], -np.ones(open_points.sum())
    )
    solver = Solver(heights, 1e-6, double=True)
    marked = np.ones((2, 3), np.uint8)
    points = WorkingSet.on(heights.shape, marked, np.float64)
    dense = np.where(open_points, 0.0, 1.0).reshape(heights.shape)
    loops.gather(0, 2, points.tiling, dense, points.p)
    workspace = solver._workspace(double=True)
    compliance, rate, _ = solver._gap_space(workspace).tangent(points, 1e-12)
    assert compliance == pytest.approx(-v.mean(), rel=1e-9)
    expected = np.zeros(points.p.size)
    rates = np.where(open_points, 0.0, 1.0 + stiffness @ v).reshape(heights.shape)
    loops.gather(0, 2, points.tiling, rates, expected)
    np.testing.assert_allclose(rate, expected, atol=1e-4)
    assert rate.sum() == pytest.approx(heights.size, rel=1e-4)


def test_scratch_is_left_zero(rough: Rough) -> None:
    solver = Solver(rough(64), 1e-6)
    load = 0.5 * solver.full_load
    solution = solver.solve(load, solver.cold_start(load))
    assert solution.status is Status.CONVERGED
    solver.tangent(solution.points)
    assert solver._gap_spaces, "the gap was not the unknown"
    for made in solver._gap_spaces.values():
        assert not made._masked.any()


@pytest.mark.usefixtures("always")
def test_threads_change_no_contact(rough: Rough) -> None:
    heights = rough(128, seed=8)
    one, two = (
        solve_contact(heights, 0.06, length=CELL, threads=threads) for threads in (1, 2)
    )
    assert one.energy == pytest.approx(two.energy, rel=1e-6)
    again = solve_contact(heights, 0.06, length=CELL, threads=2)
    np.testing.assert_array_equal(again.pressure, two.pressure)
