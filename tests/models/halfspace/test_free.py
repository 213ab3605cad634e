"""A half-space that is not periodic, against contacts solved on paper and the dense matrix."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

import roughbench as rb
from roughbench.errors import SolverError
from roughbench.models.base import Status
from roughbench.models.halfspace import memory
from roughbench.models.halfspace.contact import ContactState, solve_contact, solve_curve
from roughbench.models.halfspace.free import FreeOperator
from roughbench.models.halfspace.kernel import Kernel
from roughbench.models.halfspace.love import love_influence
from roughbench.models.halfspace.preconditioner import free_averaged_kernel
from roughbench.models.halfspace.threads import ThreadTeam

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

FloatArray = NDArray[np.float64]
CELL = 2 * math.pi
RADIUS = 0.3
"""Of the contact, on a patch of the side 1."""


def solve(heights: FloatArray, **options: Any) -> ContactState:
    state = solve_contact(
        heights, boundary="free", **({"tolerance": 1e-9, "threads": 1} | options)
    )
    assert state.status is Status.CONVERGED
    return state


def distance(points: int, *, on_a_point: bool = False) -> FloatArray:
    """From the middle of the patch, which is a point of the grid or between four."""
    middle = points // 2 if on_a_point else (points - 1) / 2
    x = (np.arange(points) - middle) / points
    return np.hypot(x[:, None], x)


# The displacement by one point -------------------------------------------------------------


def classical(y: FloatArray, x: FloatArray, b: float, a: float) -> FloatArray:
    """Love's formula as it is printed: half sides b, a; 1/π of the integral of 1/r."""

    def line(u: FloatArray, v: FloatArray, c: float, d: float) -> FloatArray:
        above = (v + d) + np.hypot(v + d, u + c)
        below = (v - d) + np.hypot(v - d, u + c)
        return (u + c) * np.log(above / below)

    total = line(x, y, a, b) + line(y, x, b, a) - line(x, -y, -a, b) - line(y, -x, -b, a)
    return total / math.pi


@pytest.mark.parametrize("aspect", [0.2, 1.0, 6.0])
def test_love_is_what_is_printed(aspect: float) -> None:
    y, x = np.arange(12.0)[:, None], aspect * np.arange(9.0)
    expected = classical(y, x, 0.5, 0.5 * aspect)
    np.testing.assert_allclose(love_influence((12, 9), aspect), expected, rtol=1e-11)


@pytest.mark.parametrize("aspect", [0.2, 1.0, 6.0])
def test_it_is_the_integral_far_away_as_well(aspect: float) -> None:
    """Both sides of the distance where Love's formula gives way to Gauss's rule."""
    influence = love_influence((220, 220), aspect)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    weight = np.outer(weights, weights) * aspect / 4
    for i, j in ((31, 31), (32, 31), (33, 2), (6, 33), (190, 210), (0, 200), (199, 0)):
        r = np.hypot(i + nodes[:, None] / 2, aspect * (j + nodes / 2))
        assert influence[i, j] == pytest.approx((weight / r).sum() / math.pi, rel=1e-11)


def dense(shape: tuple[int, int], aspect: float) -> FloatArray:
    influence = love_influence(shape, aspect)
    i, j = (index.ravel() for index in np.indices(shape))
    return influence[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize(("dtype", "error"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("shape", [(2, 2), (5, 7), (16, 16), (31, 50), (13, 8)], ids=str)
def test_the_operator_is_the_dense_matrix(
    shape: tuple[int, int],
    dtype: type,
    error: float,
    threads: int,
    rng: np.random.Generator,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("roughbench.transform.padded.FEWEST_POINTS", 1)
    monkeypatch.setattr("roughbench.transform.padded.WORK", 1)  # many blocks of columns
    operator = FreeOperator(shape, dtype, ThreadTeam(threads), Kernel(1.7, free=True))
    for _ in range(2):  # nothing of the first is left in the padding
        pressure = rng.random(shape)
        operator.field[...] = pressure
        operator.displace()
        expected = (dense(shape, 1.7) @ pressure.ravel()).reshape(shape)
        scale = float(expected.max())
        np.testing.assert_allclose(operator.field, expected, rtol=0, atol=error * scale)
    assert operator.pairs == 2


def test_the_kernel_between_cells_is_the_mean_over_their_points() -> None:
    spectrum = free_averaged_kernel((5, 4), (8, 8), Kernel(0.5, free=True))
    between = np.fft.irfft2(spectrum, s=(10, 8))
    matrix = dense((40, 32), 0.5).reshape(5, 8, 4, 8, 5, 8, 4, 8)
    mean = matrix.mean(axis=(1, 3, 5, 7))[0, 0]
    np.testing.assert_allclose(between[:3, :3], mean[:3, :3], rtol=1e-10)
    np.testing.assert_allclose(between[:5, :4], mean, rtol=0.05)


# States, against an active set on the dense matrix -----------------------------------------


@pytest.fixture
def slow_way(reference: type[Reference]) -> type[Reference]:
    class FreeReference(reference):  # type: ignore[misc, valid-type]
        def matrix(self, power: float = -1.0) -> FloatArray:
            assert power < 0
            y, x = self.spacing
            return dense(self.heights.shape, x / y) * y / self.modulus

    return FreeReference


@pytest.mark.parametrize("precision", ["mixed", "double"])
@pytest.mark.parametrize("sides", [(CELL, CELL * 0.75), (CELL, CELL * 2.0)], ids=str)
@pytest.mark.parametrize("pressure", [1e-3, 1e-2, 1e-1, 1.0])
def test_states_against_the_slow_way(
    pressure: float,
    sides: tuple[float, float],
    precision: Any,
    rough: Rough,
    slow_way: type[Reference],
) -> None:
    """Fields, certificate, K and U; also with the contact along the border, and full."""
    heights = rough(16, per_wave=2.0, seed=3)[:, :12]
    own = slow_way(heights, length=sides, modulus=2.0)
    slow = own.solve(pressure)
    area = sides[0] * sides[1]
    state = solve_contact(
        heights,
        force=pressure * area,
        length=sides,
        modulus=2.0,
        precision=precision,
        boundary="free",
    )
    assert state.status is Status.CONVERGED
    assert state.force == pytest.approx(pressure * area, rel=1e-12)
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    top = own.heights.max()
    assert state.mean_separation == pytest.approx(slow.separation - top, rel=1e-5)
    assert state.energy == pytest.approx(slow.energy, rel=1e-5)
    assert state.stiffness() == pytest.approx(slow.stiffness * area, rel=1e-4)
    assert slow.contact.all() == (pressure == 1.0)
    # From the fields alone.
    u = (own.matrix() @ state.pressure.ravel()).reshape(heights.shape)
    gap = u - own.heights + state.mean_separation + top
    np.testing.assert_allclose(state.gap, gap, rtol=0, atol=1e-9 * own.rms)
    load = state.pressure.sum()
    wrong = float(np.abs(state.pressure * gap).sum() / (load * own.rms))
    told = state.certificate
    assert told.complementarity == pytest.approx(wrong, rel=1e-3, abs=1e-11)
    assert told.penetration == pytest.approx(max(-gap.min(), 0.0) / own.rms, rel=1e-3, abs=1e-9)
    assert told.holds(1e-6)


def test_the_area_is_not_corrected_where_the_heights_end() -> None:
    """A wall that touches along its border has an edge there which the heights prescribe."""
    state = solve(np.zeros((16, 20)), force=1.0)
    assert state.area_fraction == state.area_fraction_raw == 1.0
    ridge = np.zeros((16, 20)) - 5e-4 * np.abs(np.arange(20) - 9.5) ** 2
    state = solve(ridge, force=1e-2)
    contact = state.pressure > 0
    assert contact.any(axis=1).all()
    inside = sum(int(np.diff(contact, axis=axis).sum()) for axis in (0, 1))
    assert inside >= 2 * 16  # both flanks of the ridge, and none at its ends
    factor = (math.pi - 1 + math.log(2)) / 24
    assert state.area_fraction == pytest.approx((contact.sum() - factor * inside) / 320)


# Closed forms, with their orders -----------------------------------------------------------

SLOPE = 0.1


def sphere(points: int) -> FloatArray:
    return -(distance(points) ** 2) / 2


def cone(points: int) -> FloatArray:
    """With its tip on a point: else the highest point lies Δ/√2 beside it."""
    return -SLOPE * distance(points, on_a_point=True)


def punch(points: int) -> FloatArray:
    return np.where(distance(points) <= RADIUS, 0.0, -1.0)


def plate(points: int) -> FloatArray:
    return np.zeros((points, points))


CLOSED_FORMS: dict[str, tuple[Callable[[int], FloatArray], float, float, float]] = {
    # name: (heights, force, approach, order of the error of the approach)
    # Hertz (1882), R = 1: F = 4a³/3R, δ = a²/R.
    "sphere": (sphere, 4 / 3 * RADIUS**3, RADIUS**2, 2.0),
    # Sneddon (1948): F = πa²tan/2, δ = πa tan/2.
    "cone": (cone, math.pi / 2 * RADIUS**2 * SLOPE, math.pi / 2 * RADIUS * SLOPE, 2.0),
    # Boussinesq (1885): F = 2aδ, with a pressure like 1/√s at the edge.
    "punch": (punch, 1e-3, 1e-3 / (2 * RADIUS), 1.0),
    # All points of a square: F = πCδ, with the capacity C = 0.36679 of the unit square.
    "square punch": (plate, 1e-3, 1e-3 / (math.pi * 0.3667874), 1.0),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_indenters_converge_with_their_order(name: str) -> None:
    shape, force, approach, order = CLOSED_FORMS[name]
    points = [16, 32, 64, 128]
    states = [solve(shape(n), force=force) for n in points]
    found = np.array([-state.mean_separation for state in states])
    stiffness = np.array([state.stiffness() for state in states])
    if name == "punch":  # a disc of points has the radius that its area says
        radius = np.sqrt([state.area_fraction_raw / math.pi for state in states])
        found *= radius / RADIUS
        stiffness *= RADIUS / radius
    error = np.abs(found / approach - 1)
    slope = -np.polyfit(np.log(points), np.log(error), 1)[0]
    assert slope == pytest.approx(order, abs=0.25), error
    assert error[-1] <= {1.0: 4e-3, 2.0: 3e-4}[order]
    # K follows the points in contact, which come and go one by one.
    wanted = math.pi * 0.3667874 if name == "square punch" else 2 * RADIUS
    assert stiffness[-1] == pytest.approx(wanted, rel=4e-3)


def test_the_pressure_under_a_sphere() -> None:
    force = 4 / 3 * RADIUS**3
    state = solve(sphere(128), force=force)
    peak = 1.5 * force / (math.pi * RADIUS**2)
    r = distance(128)
    hertz = peak * np.sqrt(np.maximum(1 - (r / RADIUS) ** 2, 0.0))
    assert state.pressure.max() == pytest.approx(peak, rel=3e-4)
    assert np.sqrt(((state.pressure - hertz) ** 2).mean()) < 3e-3 * peak
    assert state.area_fraction == pytest.approx(math.pi * RADIUS**2, rel=4e-3)
    # U = (2/5)Fδ, over the area of the patch.
    assert state.energy == pytest.approx(0.4 * force * RADIUS**2, rel=1e-4)
    # And the gap outside: that of the undeformed sphere less what the surface sinks.
    outside = r[r > RADIUS]
    x = outside / RADIUS
    u = ((2 - x**2) * np.arcsin(1 / x) + np.sqrt(x**2 - 1)) * RADIUS**2 / math.pi
    wanted = u + outside**2 / 2 - RADIUS**2
    np.testing.assert_allclose(state.gap[r > RADIUS], wanted, rtol=0, atol=3e-4 * RADIUS**2)


def test_a_large_periodic_cell_tends_to_it() -> None:
    """The images of the neighbours lift the surface by M1 F/(πE*L), M1 = −3.90026."""
    n, force = 32, 2e-3
    patch = sphere(n)
    free = solve(patch, force=force)
    found = []
    for cells in (2, 4, 8):
        wide = np.full((cells * n, cells * n), -10.0)
        wide[:n, :n] = patch
        periodic = solve_contact(wide, force=force, length=float(cells), threads=1)
        approach = wide.max() - wide.mean() - periodic.mean_separation
        lifted = approach + 3.90026492 * force / (math.pi * cells)
        found.append(lifted / -free.mean_separation)
        assert periodic.force == pytest.approx(force, rel=1e-12)
    # What is left is the two kernels' difference on this grid: 2 % with 5 points to the edge.
    assert abs(found[0] / found[2] - 1) < 1e-3
    assert abs(found[1] / found[2] - 1) < 1e-4
    assert found[2] == pytest.approx(1.0, abs=0.03)


# Force, approach, curves -------------------------------------------------------------------


@pytest.mark.parametrize("shape", [sphere, cone, punch])
def test_an_approach_is_reached(shape: Callable[[int], FloatArray]) -> None:
    for approach in (1e-5, 1e-3, 0.05):
        state = solve(shape(48), separation=-approach, tolerance=1e-8)
        assert -state.mean_separation == pytest.approx(approach, rel=1e-6)
        again = solve(shape(48), force=state.force, tolerance=1e-8)
        assert again.mean_separation == pytest.approx(state.mean_separation, rel=1e-6)


def test_force_and_work_are_derivatives(rough: Rough) -> None:
    """F = dU/dδ and K = dF/dδ, with the same points in contact."""
    heights, area = rough(32, seed=2), CELL**2
    options: dict[str, Any] = {"length": CELL, "tolerance": 1e-12, "precision": "double"}
    force, step = 0.3, 1e-6
    low, middle, high = (
        solve(heights, force=force * (1 + k * step), **options) for k in (-1, 0, 1)
    )
    assert np.array_equal(low.pressure > 0, high.pressure > 0)
    change = low.mean_separation - high.mean_separation
    assert 2 * step * force / change == pytest.approx(middle.stiffness(), rel=1e-4)
    assert (high.energy - low.energy) * area / change == pytest.approx(force, rel=1e-5)


def test_a_curve_is_its_states(rough: Rough) -> None:
    heights = rough(48, q_rolloff=2.0)
    forces = np.array([0.5, 0.01, 0.1])
    curve = solve_curve(heights, forces=forces, length=CELL, boundary="free")
    assert (curve.status == 0).all()
    np.testing.assert_allclose(curve.pressure, forces / CELL**2, rtol=1e-14)
    for k, force in enumerate(forces):
        state = solve_contact(heights, force=force, length=CELL, boundary="free")
        assert curve.area_raw is not None
        assert curve.area_raw[k] == pytest.approx(state.area_fraction_raw, abs=2 / 48**2)
        assert curve.separation[k] == pytest.approx(state.mean_separation, rel=1e-5)
        assert curve.stiffness[k] * CELL**2 == pytest.approx(state.stiffness(), rel=2e-2)
    by_pressure = solve_curve(
        heights, forces / CELL**2, length=CELL, boundary="free", tolerance=1e-6
    )
    np.testing.assert_array_equal(by_pressure.separation, curve.separation)


def test_units_do_not_matter(rough: Rough) -> None:
    """F scales with E*·length², δ with the heights."""
    heights = rough(32)
    plain = solve(heights, force=0.1, length=CELL)
    scaled = solve(1e-9 * heights, force=0.1e-18 * 5e9, length=1e-9 * CELL, modulus=5e9)
    assert scaled.mean_separation == pytest.approx(1e-9 * plain.mean_separation, rel=1e-9)
    assert scaled.stiffness() == pytest.approx(5.0 * plain.stiffness(), rel=1e-5)


@pytest.mark.parametrize("depth", [1e-3, 1.0, 1e6])
def test_how_deep_the_rest_lies_does_not_matter(depth: float) -> None:
    heights = np.where(distance(32) <= RADIUS, 0.0, -depth)
    state = solve(heights, force=1e-4)
    assert state.mean_separation == pytest.approx(-1e-4 / (2 * RADIUS), rel=0.03)


@pytest.mark.parametrize("threads", [1, 2])
def test_deterministic(threads: int, rough: Rough) -> None:
    states = [
        solve_contact(rough(64), force=0.2, length=CELL, boundary="free", threads=threads)
        for _ in range(2)
    ]
    assert states[0].pressure.tobytes() == states[1].pressure.tobytes()


def test_it_takes_as_few_iterations_as_the_periodic_one(rough: Rough) -> None:
    """Both levels of the preconditioner are those of the free half-space."""
    heights = rough(128, per_wave=2.0)
    for pressure in (1e-3, 1e-2):
        free = solve_contact(heights, pressure, length=CELL, boundary="free")
        periodic = solve_contact(heights, pressure, length=CELL)
        assert free.iterations <= 1.5 * periodic.iterations


# In specs, and what is refused -------------------------------------------------------------


def test_a_spec_may_ask_for_it(tmp_path: Any, rough: Rough) -> None:
    heights = rough(24)
    np.save(tmp_path / "h.npy", heights)
    spec = {
        "surface": {"kind": "file", "path": str(tmp_path / "h.npy"), "length": CELL},
        "pressures": [1e-3, 1e-2],
        "models": [{"kind": "bem", "boundary": "free"}],
    }
    found = rb.run(spec)["main"]["bem"]
    assert found.attributes["boundary"] == "free"
    curve = solve_curve(heights, [1e-3, 1e-2], length=CELL, boundary="free")
    np.testing.assert_allclose(found["separation"][0], curve.separation, rtol=1e-6)
    assert (found["separation"] < 0).all()


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({}, "exactly one of pressure, separation and force, got none of them"),
    ({"pressure": 1.0, "force": 1.0}, "got pressure and force"),
    ({"force": -1.0, "boundary": "free"}, "positive and finite"),
    ({"force": "1", "boundary": "free"}, "force must be a number, got '1'"),
    (
        {"separation": 0.0, "boundary": "free"},
        "separation must be negative with boundary: free",
    ),
    ({"separation": math.nan, "boundary": "free"}, "must be negative"),
    ({"force": 1.0, "boundary": "open"}, "boundary must be 'periodic' or 'free', got 'open'"),
    (
        {"force": 1.0, "boundary": "free", "screening": 2.0},
        "screening needs boundary: periodic",
    ),
]


@pytest.mark.parametrize(("options", "message"), REFUSED)
def test_what_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(SolverError, match=message):
        solve_contact(np.eye(4), **options)


def test_lines_are_refused_with_the_reason() -> None:
    with pytest.raises(SolverError, match="grows like the logarithm of the distance"):
        solve_contact(np.arange(8.0), force=1.0, boundary="free")


def test_curves_take_one_of_both() -> None:
    cases: list[dict[str, Any]] = [{}, {"pressures": [1.0], "forces": [1.0]}]
    for options in cases:
        with pytest.raises(
            SolverError, match="exactly one of pressures, forces and separations"
        ):
            solve_curve(np.eye(4), **options)


def test_its_memory_is_counted() -> None:
    for double in (False, True):
        more = memory.needed(1000, double=double, free=True)
        assert more > memory.needed(1000, double=double)


def test_a_start_needs_a_load() -> None:
    heights = np.zeros((8, 8))
    heights[4, 4] = 1.0
    with pytest.raises(SolverError, match="start needs a pressure or a force with boundary"):
        rb.solve_contact(heights, separation=-0.1, boundary="free", start=np.ones((8, 8)))
    started = rb.solve_contact(heights, force=0.01, boundary="free", start=np.ones((8, 8)))
    alone = rb.solve_contact(heights, force=0.01, boundary="free")
    assert started.mean_separation == pytest.approx(alone.mean_separation, rel=1e-5)
