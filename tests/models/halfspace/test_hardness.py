"""An upper bound on the pressure: optimality, dense references, closed forms, tangents."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

import roughbench as rb
from roughbench.errors import SolverError, SpecError
from roughbench.models.base import Status
from roughbench.models.halfspace import HalfSpace
from roughbench.models.halfspace import contact as exact
from roughbench.models.halfspace.options import Precision
from roughbench.models.halfspace.plastic import fit_load, rounded_down, scaled_within

FloatArray = NDArray[np.float64]

N = 24


def rough(
    n: int = N, m: int | None = None, seed: int = 0, roughness: float = 0.01
) -> FloatArray:
    """Heights of all wavelengths down to four points, with this rms."""
    m = m or n
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n)[:, None] * n, np.fft.rfftfreq(m) * n)
    amplitude = np.where((q > 0) & (q <= n / 4), np.maximum(q, 1.0) ** -1.7, 0.0)
    phases = np.exp(2j * np.pi * rng.random(q.shape))
    heights = np.fft.irfft2(amplitude * phases, s=(n, m))
    return np.asarray(heights * roughness / heights.std())


def green(shape: tuple[int, int]) -> FloatArray:
    """G as a dense matrix, of a cell of side 1 along the first axis and E* = 1."""
    n, m = shape
    q = 2 * math.pi * n * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(m))
    q[0, 0] = math.inf
    response = np.fft.ifft2(2.0 / q).real
    rows, columns = np.divmod(np.arange(n * m), m)
    return np.asarray(response[(rows[:, None] - rows) % n, (columns[:, None] - columns) % m])


def projected_gradients(
    heights: FloatArray, load: float, hardness: float
) -> tuple[FloatArray, float]:
    """Pressure and α by projected gradients on dense matrices, then solved on their sets."""
    G, h = green(heights.shape), heights.ravel() - heights.mean()
    n = h.size
    step = 1.0 / np.linalg.eigvalsh(G)[-1]

    def onto_the_loads(trial: FloatArray) -> FloatArray:
        def surplus(shift: float) -> float:
            return float(np.clip(trial + shift, 0.0, hardness).mean()) - load

        shift = brentq(surplus, -trial.max(), hardness - trial.min(), xtol=1e-17)
        return np.asarray(np.clip(trial + shift, 0.0, hardness))

    p = y = np.full(n, load)
    for k in range(3000):
        before, p = p, onto_the_loads(y - step * (G @ y - h))
        y = p + k / (k + 3) * (p - before)
    plastic, elastic = p >= hardness, (p > 0.0) & (p < hardness)
    k = int(elastic.sum())
    system = np.zeros((k + 1, k + 1))
    system[:k, :k] = G[np.ix_(elastic, elastic)]
    system[:k, k], system[k, :k] = -1.0, 1.0
    p = np.where(plastic, hardness, 0.0)
    right = np.append((h - G @ p)[elastic], load * n - p.sum())
    solved = np.linalg.solve(system, right)
    p[elastic], alpha = solved[:k], float(solved[k])
    gap = G @ p - h - alpha
    rounding = 1e-12 * heights.std()
    assert p.min() >= 0.0
    assert p.max() <= hardness
    assert gap[~plastic].min() > -rounding
    assert gap[plastic].max(initial=-1.0) < rounding
    return p.reshape(heights.shape), alpha


def highest_traction(heights: FloatArray) -> float:
    """Maximum of the pressure that flattens the heights, beyond its mean."""
    return float(exact.solve_contact(heights, 1e6 * heights.std()).pressure.max()) - float(
        1e6 * heights.std()
    )


@pytest.mark.parametrize("share", [0.05, 0.3, 0.7, 0.95])
@pytest.mark.parametrize("part", [0.1, 0.4])
def test_the_pressure_is_that_of_projected_gradients_on_dense_matrices(
    part: float, share: float
) -> None:
    heights = rough(16, seed=3)
    hardness = part * highest_traction(heights)
    load = share * hardness
    wanted, alpha = projected_gradients(heights, load, hardness)
    state = exact.solve_contact(heights, load, hardness=hardness, tolerance=1e-11, threads=1)
    assert state.status is Status.CONVERGED
    assert np.abs(state.pressure - wanted).max() < 1e-7 * hardness
    assert np.array_equal(state.pressure == hardness, wanted == hardness)
    assert state.mean_separation == pytest.approx(-alpha, abs=1e-9 * heights.std())
    assert state.area_fraction_raw == np.mean(wanted > 0)


@given(
    seed=st.integers(0, 50),
    part=st.floats(0.01, 2.0),
    share=st.floats(1e-3, 1.0),
    m=st.sampled_from([13, 24]),
)
def test_states_obey_the_conditions_of_optimality(
    seed: int, part: float, share: float, m: int
) -> None:
    heights = rough(N, m, seed)
    hardness = part * highest_traction(heights)
    state = exact.solve_contact(heights, share * hardness, hardness=hardness, threads=1)
    p, gap, rms = state.pressure, state.gap, heights.std()
    assert state.status is Status.CONVERGED
    assert p.mean() == pytest.approx(share * hardness, rel=2e-6)
    assert p.min() >= 0.0
    assert p.max() <= hardness
    plastic = p == hardness
    assert gap[~plastic].min(initial=0.0) >= -1e-5 * rms
    # Σ p|g| of elastic points, and of plastic ones where they lift off.
    wrong = np.where(plastic, np.maximum(gap, 0.0), np.abs(gap)) * p
    assert wrong.sum() <= 1.001e-6 * p.sum() * rms
    assert gap.mean() == pytest.approx(state.mean_separation, abs=1e-6 * rms)
    depth = np.where(plastic, np.maximum(-gap, 0.0), 0.0).mean()
    assert state.plastic_depth == pytest.approx(depth, abs=1e-6 * rms)


@pytest.mark.parametrize("share", [0.9, 0.999, 1.0 - 1e-6, 1.0])
@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_contact_converges_up_to_the_hardness(precision: Precision, share: float) -> None:
    heights = rough(48, seed=1)
    for part in (0.03, 0.3, 1.0, 3.0):
        hardness = part * highest_traction(heights)
        state = exact.solve_contact(
            heights, share * hardness, hardness=hardness, precision=precision, threads=1
        )
        assert state.status is Status.CONVERGED
        assert state.transform_pairs < 80
        assert state.area_fraction_raw > 0.85
        if share == 1.0:
            assert np.array_equal(state.pressure, np.full(heights.shape, hardness))
            assert state.stiffness() == 0.0 or part == 3.0


def test_a_hardness_that_is_never_reached_changes_nothing() -> None:
    x = np.arange(256) / 256
    wave = 0.01 * np.cos(2 * np.pi * x)
    full = np.pi * 0.01
    loads = np.array([0.1, 0.5, 0.9, 2.0]) * full
    # At 1e-6 both are free to differ by more than is asked for: ū is 0.007 h_rms at 0.9.
    elastic = exact.solve_curve(wave, loads, tolerance=1e-10, threads=1)
    bounded = exact.solve_curve(wave, loads, tolerance=1e-10, hardness=10 * full, threads=1)
    for name in ("area", "separation", "stiffness", "energy"):
        expected = getattr(elastic, name)
        assert getattr(bounded, name) == pytest.approx(expected, rel=1e-5, abs=1e-9), name
    assert bounded.diagnostics["plastic_depth"].tolist() == [0.0] * 4
    assert "plastic_depth" not in elastic.diagnostics


def test_a_soft_asperity_carries_its_hardness_on_the_cut_through_it() -> None:
    # As H → 0 the wall is pressed in like into putty: A/A0 = p/H, a disc of the cap.
    n, radius, load = 128, 1.0, 0.05
    x = (np.arange(n) - n / 2) / n
    cap = -(x[:, None] ** 2 + x**2) / (2 * radius)
    hardness = 1e-4
    state = exact.solve_contact(cap, load * hardness, hardness=hardness, threads=1)
    plastic = np.mean(state.pressure == hardness)
    assert plastic <= load <= state.area_fraction_raw  # all but its rim of one point in width
    assert state.area_fraction_raw == pytest.approx(load, rel=5e-3)
    assert state.area_fraction == state.area_fraction_raw  # no edge is free
    depth = load / math.pi / (2 * radius)  # of the cut through the cap: πa² = A
    expected = depth * load / 2  # volume of the cap
    assert state.plastic_depth == pytest.approx(expected, rel=0.02)
    assert state.mean_separation == pytest.approx(-cap.mean() - depth, rel=1e-2)


def test_the_stiffness_is_the_slope_of_the_load() -> None:
    heights = rough(N, seed=5)
    hardness = 0.4 * highest_traction(heights)
    options = {"hardness": hardness, "tolerance": 1e-11, "threads": 1}
    for share in (0.1, 0.5, 0.9):
        load = share * hardness
        states = [exact.solve_contact(heights, load * f, **options) for f in (1.0, 1.0 + 1e-7)]  # type: ignore[arg-type]
        slope = -1e-7 * load / (states[1].mean_separation - states[0].mean_separation)
        assert states[0].stiffness() == pytest.approx(slope, rel=1e-3)


def test_the_work_of_the_load_is_elastic_energy_and_plastic_work() -> None:
    heights = rough(N, seed=6)
    hardness = 0.3 * highest_traction(heights)
    loads = 0.6 * hardness * np.array([1.0, 1.001])
    curve = exact.solve_curve(heights, loads, hardness=hardness, tolerance=1e-10, threads=1)
    work = curve.energy + hardness * curve.diagnostics["plastic_depth"]
    assert curve.diagnostics["plastic_depth"][0] > 0.1 * curve.energy[0] / hardness
    slope = -(work[1] - work[0]) / (curve.separation[1] - curve.separation[0])
    assert slope == pytest.approx(loads.mean(), rel=1e-6)


def test_curves_are_single_states() -> None:
    heights = rough(N, seed=7)
    hardness = 0.3 * highest_traction(heights)
    loads = hardness * np.array([0.01, 0.03, 0.3, 0.6, 0.99, 1.0])
    curve = exact.solve_curve(heights, loads, hardness=hardness, threads=1)
    states = [exact.solve_contact(heights, p, hardness=hardness, threads=1) for p in loads]
    assert curve.status.tolist() == [0] * 6
    assert curve.area_raw == pytest.approx([s.area_fraction_raw for s in states], abs=4e-3)
    assert curve.separation == pytest.approx(
        [s.mean_separation for s in states], abs=1e-6 * heights.std()
    )
    assert np.diff(curve.area).min() > 0


def test_flat_walls_carry_the_load_evenly() -> None:
    state = exact.solve_contact(np.zeros((8, 8)), 0.5, hardness=1.0, threads=1)
    assert np.array_equal(state.pressure, np.full((8, 8), 0.5))


@pytest.mark.parametrize("hardness", [0.0, -1.0, math.nan, math.inf, "hard"])
def test_a_hardness_is_a_positive_number(hardness: float) -> None:
    with pytest.raises(SolverError, match="hardness"):
        exact.solve_contact(rough(), 1e-3, hardness=hardness)


def test_no_load_is_above_the_hardness() -> None:
    with pytest.raises(SolverError, match=r"hardness of 0\.1 bears no mean pressure above it"):
        exact.solve_curve(rough(), [0.01, 0.11], hardness=0.1)


def test_loads_are_scaled_within_capacities() -> None:
    loads, capacities = np.array([0.0, 1.0, 4.0, 2.0]), np.array([5.0, 5.0, 5.0, 5.0])
    assert scaled_within(loads, capacities, 14.0).tolist() == pytest.approx([0, 4, 5, 5])
    assert scaled_within(loads, capacities, 3.5).tolist() == [0.0, 0.5, 2.0, 1.0]
    assert scaled_within(loads, capacities, 99.0).tolist() == [0.0, 5.0, 5.0, 5.0]
    p = np.array([-1.0, 0.5, 2.0])
    fit_load(p, 1.0, 1.75)
    assert p.tolist() == [0.0, 0.75, 1.0]
    fit_load(p, 1.0, 0.875)
    assert p.tolist() == [0.0, 0.375, 0.5]


def test_the_hardness_is_rounded_down() -> None:
    for value in (0.1, 1.0 / 3.0, 2.0, 1e-9):
        single = rounded_down(value, np.float32)
        assert single == float(np.float32(single))
        assert value * (1 - 2e-7) < single <= value
        assert rounded_down(value, np.float64) == value


SPEC = {
    "surface": {"H": 0.7, "q0": 1.0, "q1": 4.0, "slope": 0.1},
    "pressures": [1e-3, 0.02],
    "models": [
        {"kind": "bem", "grid": 16, "hardness": 0.03},
        {"kind": "bem", "label": "elastic"},
    ],
}


def test_a_spec_has_a_hardness() -> None:
    results = rb.run(SPEC)["main"]
    assert set(results["bem"]["plastic_depth"].shape) == {1, 2}
    assert results["bem"]["plastic_depth"][0, 1] > 0
    assert "plastic_depth" not in results["elastic"]
    in_pascal: dict[str, Any] = {
        "surface": {"H": 0.7, "longest": f"{2 * math.pi} m", "q1": "4 1/m", "slope": 0.1},
        "pressures": ["2 MPa", "40 MPa"],
        "modulus": {"E*": "2 GPa"},
        "models": [{"kind": "bem", "grid": 16, "hardness": "60 MPa"}],
    }
    other = rb.run(in_pascal)["main"]["bem"]
    for name in ("area", "plastic_depth"):
        assert other[name] == pytest.approx(results["bem"][name], rel=1e-4), name


def test_a_spec_refuses_loads_above_the_hardness() -> None:
    spec = {**SPEC, "pressures": [1e-3, 0.04]}
    with pytest.raises(SpecError, match=r"models\[0\]\.hardness.*the highest is 0\.04"):
        rb.run(spec)


def test_a_spec_without_hardness_is_the_spec_that_it_was() -> None:
    assert "hardness" not in HalfSpace().model_dump()
    assert HalfSpace(hardness=0.1).model_dump()["hardness"] == 0.1
    assert HalfSpace(hardness=3.0).reduced(2.0).hardness == 1.5
    assert HalfSpace().memory(1000) < HalfSpace(hardness=3.0).memory(1000)


@pytest.mark.parametrize(
    "options", [{"boundary": "free"}, {"screening": 1.0}, {"length": (1.0, 2.0)}], ids=str
)
def test_what_is_not_computed_together_is_refused(options: dict[str, Any]) -> None:
    heights = np.random.default_rng(1).standard_normal((8, 8))
    with pytest.raises(SolverError, match="hardness needs boundary: periodic, square points"):
        rb.solve_contact(heights, 0.1, hardness=1.0, **options)
    options.pop("length", None)
    if options:
        with pytest.raises(ValueError, match="hardness needs boundary: periodic, and no"):
            HalfSpace(hardness=1.0, **options)
