"""The exact solver against contacts solved on paper, with their orders of convergence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import sici

from roughbench.models.base import Status
from roughbench.models.halfspace.contact import ContactState, solve_contact
from roughbench.models.halfspace.perimeter import edge_excess

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

FloatArray = NDArray[np.float64]
HEIGHT = 0.01
TIGHT = 1e-11


def solve(
    heights: FloatArray, pressure: float, length: float = 1.0, screening: float = 0.0
) -> ContactState:
    """Solve far below the error of the grid."""
    state = solve_contact(
        heights,
        pressure,
        length=length,
        tolerance=TIGHT,
        precision="double",
        threads=1,
        screening=screening,
    )
    assert state.status is Status.CONVERGED
    return state


def order(errors: list[float], points: list[int]) -> float:
    """Slope of the logarithm of the error against that of the grid spacing."""
    return -float(np.polyfit(np.log(points), np.log(np.abs(errors)), 1)[0])


# Westergaard: h = h0 cos(2πx/λ) ------------------------------------------------------------


@dataclass(frozen=True)
class Westergaard:
    """The wavy line in contact at p̄ = P p*, λ = E* = 1."""

    ratio: float
    full: float = math.pi * HEIGHT

    @property
    def area(self) -> float:
        return 2 / math.pi * math.asin(math.sqrt(self.ratio))

    @property
    def separation(self) -> float:
        return HEIGHT * (1 - self.ratio + self.ratio * math.log(self.ratio))

    @property
    def energy(self) -> float:
        return HEIGHT * self.full * self.ratio**2 * (0.25 - 0.5 * math.log(self.ratio))

    @property
    def stiffness(self) -> float:
        return self.full / (HEIGHT * math.log(1 / self.ratio))

    def pressure(self, x: FloatArray) -> FloatArray:
        sine = np.sin(math.pi * x) ** 2
        root = np.sqrt(np.maximum(self.ratio - sine, 0.0))
        return 2 * self.full * np.abs(np.cos(math.pi * x)) * root


def wave(points: int) -> FloatArray:
    return HEIGHT * np.cos(2 * math.pi * np.arange(points) / points)


WESTERGAARD_ERRORS: dict[
    str, tuple[float, float, Callable[[ContactState, Westergaard, FloatArray], float]]
] = {
    # name: (order, error at 1024 points, error of a state)
    "area": (1.0, 1.1e-3, lambda s, w, _: s.area_fraction - w.area),
    "separation": (2.0, 1.5e-7, lambda s, w, _: (s.mean_separation - w.separation) / HEIGHT),
    "energy": (2.0, 5e-7, lambda s, w, _: s.energy / w.energy - 1),
    "stiffness": (1.0, 3e-3, lambda s, w, _: s.stiffness() / w.stiffness - 1),
    # Its square root at the edge of the contact: 1/2 in the maximum, 1 in the mean square.
    "pressure, worst": (
        0.5,
        1.5e-2,
        lambda s, w, x: float(np.abs(s.pressure - w.pressure(x)).max()) / w.full,
    ),
    "pressure, rms": (
        1.0,
        7e-4,
        lambda s, w, x: float(np.sqrt(((s.pressure - w.pressure(x)) ** 2).mean())) / w.full,
    ),
}


@pytest.fixture(scope="module")
def westergaard_states() -> dict[int, ContactState]:
    """At P = 1/2 the edge of the contact, x = λ/4, falls on a point of every grid."""
    return {n: solve(wave(n), 0.5 * math.pi * HEIGHT) for n in (128, 256, 512, 1024)}


@pytest.mark.parametrize("name", WESTERGAARD_ERRORS)
def test_westergaard_converges_with_its_order(
    name: str, westergaard_states: dict[int, ContactState]
) -> None:
    expected, largest, error = WESTERGAARD_ERRORS[name]
    exact = Westergaard(0.5)
    points = list(westergaard_states)
    errors = [error(state, exact, np.arange(n) / n) for n, state in westergaard_states.items()]
    assert order(errors, points) == pytest.approx(expected, abs=0.05)
    assert abs(errors[-1]) <= largest


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.3, 0.7, 0.9, 0.99])
def test_westergaard_at_other_pressures(ratio: float) -> None:
    """Where the edges fall between two points, A is off by a point at most."""
    n = 2048
    exact = Westergaard(ratio)
    state = solve(wave(n), ratio * exact.full)
    assert abs(state.area_fraction_raw - exact.area) <= 1.5 / n
    assert abs(state.area_fraction - exact.area) <= 1.0 / n + 1e-9
    excess = (state.area_fraction_raw - state.area_fraction) * n
    assert excess == pytest.approx(2 * edge_excess(), rel=1e-9)
    assert state.mean_separation == pytest.approx(exact.separation, abs=3e-6 * HEIGHT)
    assert state.energy == pytest.approx(exact.energy, rel=2e-5)
    # K follows the contact set: dK/K = dA/A · O(1) below, and · 1/(1 − A) near full contact.
    node = 1.5 / n / exact.area / (1 - exact.area)
    assert state.stiffness() == pytest.approx(exact.stiffness, rel=2 * node)


def shifted(n: int, pressure: float, screening: float, count: int) -> FloatArray:
    """A/A0 of a wave in points, and corrected, at positions between two points, (count, 2)."""
    found = []
    for offset in (np.arange(count) + 0.5) / count / n:
        line = HEIGHT * np.cos(2 * math.pi * (np.arange(n) / n - offset))
        state = solve(line, pressure, screening=screening)
        found.append((state.area_fraction_raw, state.area_fraction))
    return np.array(found)


@pytest.mark.parametrize(
    ("screening", "pressure", "expected"), [(0.0, 0.3 * math.pi, 0.190), (64.0, 9.0, 0.152)]
)
def test_the_edges_of_a_line_count_as_many_points_too_many_as_theory_says(
    screening: float, pressure: float, expected: float
) -> None:
    """The mean over 40 positions of the crest, known to half of 1/40 points an edge.

    With screening against a line of 32 times as many points, where an edge counts 0.189.
    """
    n, area = 64, Westergaard(0.3).area
    if screening:
        area = float(shifted(2048, pressure * HEIGHT, screening, 2)[:, 1].mean())
    raw, corrected = shifted(n, pressure * HEIGHT, screening, 40).T
    assert edge_excess(screening / n) == pytest.approx(expected, abs=1e-3)
    assert (raw.mean() - area) * n / 2 == pytest.approx(expected, abs=0.0125)
    assert (corrected.mean() - area) * n / 2 == pytest.approx(0.0, abs=0.0125)


def test_the_excess_of_an_edge_is_its_integral() -> None:
    """Against the coefficients of ln S+ and Si, summed with the tail of an alternating series:
    μ = 1/4 - (1/π) Σ [Si(nπ) - π/2]."""  # noqa: D209, D205
    n = np.arange(1, 4001)
    terms = sici(n * math.pi)[0] - math.pi / 2
    sums = np.cumsum(terms)
    assert edge_excess() == pytest.approx(0.25 - (sums[-2] + sums[-1]) / 2 / math.pi, abs=1e-7)
    assert edge_excess(1e-9) == pytest.approx(edge_excess(), abs=1e-7)
    assert edge_excess(1e4) == pytest.approx(0.5e-4, rel=1e-3)  # springs: nearly none


def test_a_wavy_surface_is_the_wavy_line(rng: np.random.Generator) -> None:
    """The 2D operator on h(x) alone is the 1D one, along either axis."""
    line = solve(wave(64), 0.4 * math.pi * HEIGHT)
    rows = int(rng.integers(5, 12))
    across = solve(np.tile(wave(64)[:, None], (1, rows)), 0.4 * math.pi * HEIGHT)
    along = solve(np.tile(wave(64), (rows, 1)), 0.4 * math.pi * HEIGHT, length=rows / 64)
    for surface in (across, along):
        assert surface.area_fraction_raw == line.area_fraction_raw
        assert surface.mean_separation == pytest.approx(line.mean_separation, rel=1e-9)
        assert surface.energy == pytest.approx(line.energy, rel=1e-9)
        assert surface.stiffness() == pytest.approx(line.stiffness(), rel=1e-4)


# Johnson, Greenwood and Higginson: h = h0 cos(2πx/λ) cos(2πy/λ) -----------------------------

FULL_2D = math.sqrt(2) * math.pi * HEIGHT


def egg_box(points: int) -> FloatArray:
    cosine = np.cos(2 * math.pi * np.arange(points) / points)
    return HEIGHT * np.outer(cosine, cosine)


def test_egg_box_at_low_pressure() -> None:
    """A → π(3P/8π)^(2/3) from above, as the neighbouring contacts lose their influence."""
    ratios = (0.03, 0.01, 0.003)
    excess = [
        solve(egg_box(512), P * FULL_2D).area_fraction
        / (math.pi * (3 * P / 8 / math.pi) ** (2 / 3))
        - 1
        for P in ratios
    ]
    assert excess[0] > excess[1] > excess[2]
    # 2 contacts of about 26 points radius: their area is off by some 1 %.
    assert abs(excess[2]) < 0.01


@pytest.mark.parametrize("ratio", [0.98, 0.99])
def test_egg_box_near_full_contact(ratio: float) -> None:
    """1 − A → (3/2π)(1 − P)."""
    state = solve(egg_box(512), ratio * FULL_2D)
    left = (1 - state.area_fraction) / (1 - ratio)
    assert left == pytest.approx(3 / 2 / math.pi, rel=0.01)
    assert 0.0 < state.mean_separation < 1e-3 * HEIGHT


def test_egg_box_in_full_contact() -> None:
    """U = h0 p*/8 from p* on, and not before."""
    state = solve(egg_box(32), FULL_2D * (1 + 1e-12))
    assert state.energy == pytest.approx(HEIGHT * FULL_2D / 8, rel=1e-12)
    assert state.area_fraction == state.area_fraction_raw == 1.0
    assert solve(egg_box(32), FULL_2D * (1 - 1e-9)).area_fraction_raw < 1.0


# Periodic Hertz: h = −r²/2R -------------------------------------------------------------

M1, M3 = -3.90026492, 9.03362168
"""4 ζ(½) β(½) and 4 ζ(3/2) β(3/2): the sums of 1/r and 1/r³ over a square lattice."""


@dataclass(frozen=True)
class Hertz:
    """A sphere of radius 1 in each cell of side 1, E* = 1, under the force F."""

    force: float

    @property
    def curvature(self) -> float:
        return 1 + M3 * self.force / (2 * math.pi)

    @property
    def radius(self) -> float:
        return (0.75 * self.force / self.curvature) ** (1 / 3)

    @property
    def approach(self) -> float:
        """δ: crest of the sphere below the mean of the deformed plane."""
        a, f = self.radius, self.force
        return a * a * self.curvature + M1 * f / math.pi + M3 * f * a * a / (10 * math.pi)

    @property
    def stiffness(self) -> float:
        return 1 / (1 / (2 * self.radius) + M1 / math.pi)

    @property
    def highest_pressure(self) -> float:
        return 1.5 * self.force / (math.pi * self.radius**2)


def sphere(points: int) -> FloatArray:
    x = np.arange(points) / points - 0.5
    return -(x[:, None] ** 2 + x**2) / 2


@pytest.mark.parametrize(
    ("force", "approach", "stiffness"),
    # a = 21.6 and 46.6 points; K by its leading terms, up to O((a/L)³)
    [(1e-4, 1e-4, 3e-3), (1e-3, 1e-4, 5e-3)],
)
def test_periodic_hertz(force: float, approach: float, stiffness: float) -> None:
    n, exact = 512, Hertz(force)
    heights = sphere(n)
    state = solve(heights, force)
    delta = -float(heights.mean()) - state.mean_separation
    assert delta == pytest.approx(exact.approach, rel=approach)
    assert state.stiffness() == pytest.approx(exact.stiffness, rel=stiffness)
    assert float(state.pressure.max()) == pytest.approx(exact.highest_pressure, rel=1e-3)
    x = np.arange(n) / n - 0.5
    inside = 1 - (x[:, None] ** 2 + x**2) / exact.radius**2
    profile = exact.highest_pressure * np.sqrt(np.maximum(inside, 0.0))
    # The worst point stands at the edge, where the slope of the profile is infinite.
    deviation = np.abs(state.pressure - profile) / exact.highest_pressure
    assert deviation[inside > 0.1].max() < 0.01


def test_perimeter_correction_on_hertz(rng: np.random.Generator) -> None:
    """Grid points overcount the contact along its edge: by 2.2 % at a radius of 11 points.

    The mean over centres of the sphere between the points, one centre scattering by 0.7 %.
    The correction leaves (-0.5 ± 0.1) %, found with 40 centres.
    """
    n, exact = 128, Hertz(1e-3)
    area = math.pi * exact.radius**2
    raw, corrected = [], []
    for centre in rng.random((16, 2)):
        x, y = ((np.arange(n) + shift) / n - 0.5 for shift in centre)
        state = solve(-(x[:, None] ** 2 + y**2) / 2, 1e-3)
        raw.append(state.area_fraction_raw / area - 1)
        corrected.append(state.area_fraction / area - 1)
    assert np.mean(raw) == pytest.approx(0.022, abs=0.006)
    assert np.mean(corrected) == pytest.approx(-0.005, abs=0.006)


# Full contact ------------------------------------------------------------------------------


@pytest.mark.parametrize("line", [False, True], ids=["surface", "line"])
@pytest.mark.parametrize("points", [31, 32])
def test_full_contact_begins_exactly_at_its_threshold(
    points: int, *, line: bool, rng: np.random.Generator, reference: type[Reference]
) -> None:
    heights = rng.standard_normal(points if line else (points, points))
    own = reference(heights, length=2.0, modulus=3.0)
    sigma = own.full_contact_traction()
    threshold = -float(sigma.min())

    def at(pressure: float) -> ContactState:
        return solve_contact(heights, pressure, length=2.0, modulus=3.0, tolerance=1e-11)

    for pressure in (threshold * (1 + 1e-13), threshold * 1.5):
        state = own.verify(at(pressure), pressure, 1e-11)
        assert (state.area_fraction, state.area_fraction_raw) == (1.0, 1.0)
        assert state.mean_separation == 0.0
        assert state.stiffness() == math.inf
        assert state.energy == pytest.approx(0.5 * (own.heights * sigma).mean(), rel=1e-12)
        np.testing.assert_allclose(
            state.pressure, sigma + pressure, rtol=0, atol=1e-12 * threshold
        )
    # Just below it one point is open.
    state = own.verify(at(threshold * (1 - 1e-7)), threshold * (1 - 1e-7), 1e-11)
    assert state.area_fraction_raw == 1 - 1 / heights.size
    assert 0.0 < state.mean_separation < 1e-6
    assert math.isfinite(state.stiffness())


def test_energy_of_full_contact_is_a_lattice_sum(
    rough: Rough, reference: type[Reference]
) -> None:
    """U = E* Σ|q| |h_q|²/4 over the modes of the cell."""
    heights = rough(32, per_wave=2.0)
    own = reference(heights, length=2 * math.pi)
    modes = np.abs(np.fft.fft2(own.heights) / heights.size) ** 2
    state = solve(heights, 1.0, length=2 * math.pi)
    assert state.energy == pytest.approx(float((own.q * modes).sum()) / 4, rel=1e-12)
