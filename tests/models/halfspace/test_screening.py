"""Waves that do not couple: from the half-space to independent springs with one number."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.errors import SolverError
from roughbench.figures.labels import model_names
from roughbench.fits import reference_of
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.models.halfspace.kernel import Kernel
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.winkler import winkler_curve
from roughbench.observables import Field, energy_spectrum
from roughbench.results import Results
from roughbench.spec import load_spec
from roughbench.verdict import judge

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

CELL = 2 * math.pi
QUANTITIES = ("area", "separation", "stiffness", "energy")


@pytest.mark.parametrize("screening", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("shape", [(1, 9), (6, 8)], ids=str)
def test_the_operator_is_the_dense_matrix(
    shape: tuple[int, int],
    screening: float,
    rng: np.random.Generator,
    reference: type[Reference],
) -> None:
    operator = HalfSpaceOperator(shape, np.float64, ThreadTeam(1), Kernel(screening=screening))
    values = rng.standard_normal(shape)
    given = values[0] if shape[0] == 1 else values
    own = reference(given, length=float(given.shape[0]), screening=screening)
    for apply, power in ((operator.displace, -1.0), (operator.traction, 1.0)):
        operator.field[...] = values
        apply()
        expected = (own.matrix(power) @ values.ravel()).reshape(shape)
        np.testing.assert_allclose(operator.field, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("screening", [0.5, 4.0, 40.0])
@pytest.mark.parametrize("pressure", [1e-3, 2e-2])
def test_states_against_the_slow_way(
    pressure: float, screening: float, rough: Rough, reference: type[Reference]
) -> None:
    heights = rough(16, per_wave=2.0, seed=5)
    own = reference(heights, length=CELL, screening=screening)
    slow = own.solve(pressure)
    state = own.verify(
        solve_contact(heights, pressure, length=CELL, screening=screening), pressure
    )
    assert np.array_equal(state.pressure.ravel() > 0, slow.contact)
    assert state.mean_separation == pytest.approx(slow.separation, abs=1e-6 * own.rms)
    assert state.energy == pytest.approx(slow.energy, rel=1e-5)
    assert state.stiffness() == pytest.approx(slow.stiffness, rel=1e-4)


def test_without_it_the_states_are_those_of_the_half_space(rough: Rough) -> None:
    """The first end of the ladder, to the bits; and the way to it is continuous."""
    heights = rough(64)
    cases: list[dict[str, Any]] = [{}, {"screening": 0.0}, {"screening": 1e-3}]
    plain, none, little = (
        solve_contact(heights, 1e-2, length=CELL, threads=1, **options) for options in cases
    )
    assert none.pressure.tobytes() == plain.pressure.tobytes()
    assert none.area_fraction == plain.area_fraction
    assert little.mean_separation == pytest.approx(plain.mean_separation, rel=1e-5)


@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_its_other_end_is_springs(precision: Any, rough: Rough) -> None:
    """Winkler's with k_w = E* q_c/2, at all loads up to full contact."""
    heights, q_c, modulus = rough(64), 1e6, 3.0
    loads = np.array([1e-5, 1e-3, 0.03, 0.1, 0.3, 3.0]) * heights.std() * q_c
    springs = winkler_curve(heights, loads, q_c / 2)
    curve = solve_curve(
        heights,
        modulus * loads,
        length=CELL,
        modulus=modulus,
        screening=q_c,
        precision=precision,
    )
    assert (curve.status == 0).all()
    np.testing.assert_array_equal(curve.area_raw, springs.area)
    assert springs.area[0] < 0.01
    assert springs.area[-1] == 1.0
    np.testing.assert_allclose(curve.area, springs.area, rtol=1e-6)
    np.testing.assert_allclose(
        curve.separation, springs.separation, rtol=0, atol=1e-6 * heights.std()
    )
    np.testing.assert_allclose(curve.stiffness, modulus * springs.stiffness, rtol=1e-5)
    np.testing.assert_allclose(curve.energy, modulus * springs.energy, rtol=1e-5)


def test_springs_of_a_line() -> None:
    heights = 0.01 * np.cos(2 * np.pi * np.arange(200) / 200)
    curve = solve_curve(heights, [10.0, 40.0], screening=1e5)
    springs = winkler_curve(heights, [10.0, 40.0], 5e4)
    np.testing.assert_array_equal(curve.area_raw, springs.area)
    np.testing.assert_allclose(curve.area, springs.area, atol=2.1 / 200 / (2 * 1e5 / 200))
    np.testing.assert_allclose(curve.separation, springs.separation, rtol=1e-5)


def test_one_wave_is_as_stiff_as_its_kernel_says() -> None:
    """Full contact of h0 cos(qx): p* = E*√(q² + q_c²)h0/2, U = h0 p*/4."""
    height, q_c = 0.01, 5.0
    line = height * np.cos(2 * np.pi * np.arange(64) / 64)
    full = 0.5 * math.hypot(2 * math.pi, q_c) * height
    state = solve_contact(line, 1.0001 * full, screening=q_c)
    assert state.area_fraction == 1.0
    assert state.energy == pytest.approx(height * full / 4, rel=1e-12)
    assert solve_contact(line, 0.9999 * full, screening=q_c).area_fraction < 1.0


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1.0, "screening must be a wavevector of at least 0, got -1.0"),
        (math.nan, "at least 0, got nan"),
        (math.inf, "at least 0, got inf"),
        ("1", "screening must be a number, got '1'"),
        (1e11, r"screening must be at most 4.0e\+09 on this grid .1e\+09/Δ., got 1e\+11"),
    ],
)
def test_screening_out_of_range(value: Any, message: str) -> None:
    for solve in (
        lambda: solve_contact(np.eye(4), 0.1, screening=value),
        lambda: solve_curve(np.eye(4), [0.1], screening=value),
    ):
        with pytest.raises(SolverError, match=message):
            solve()


def spec(**options: Any) -> dict[str, Any]:
    return {
        "name": "ladder",
        "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
        "pressures": [0.003, 0.03],
        "models": [{"kind": "bem", **options}, {"kind": "winkler", "modulus": 0.5e5}],
    }


def test_a_spec_climbs_the_ladder() -> None:
    """With the option the model of a spec is the springs; without, the spec it was."""
    assert load_spec(spec(screening=0)).sha256 == load_spec(spec()).sha256
    results = rb.run(spec(screening=1e5) | {"pressures": [30.0, 300.0]})["main"]
    assert results["bem"].attributes["screening"] == 1e5
    for name in QUANTITIES:
        np.testing.assert_allclose(results["bem"][name], results["winkler"][name], rtol=1e-5)


@pytest.fixture(scope="module")
def ladder() -> Results:
    """Three rungs and the springs at its end; the half-space is listed last."""
    tree = spec() | {
        "pressures": [1e-4, 1e-3, 1e-2, 0.1, 1.0],
        "realizations": 3,
        "observables": ["energy"],
    }
    rungs = {"q1": 1.0, "q4": 4.0, "q1e5": 1e5}
    tree["models"] = [
        *({"kind": "bem", "label": label, "screening": q} for label, q in rungs.items()),
        {"kind": "winkler", "modulus": 0.5e5},
        {"kind": "bem"},
    ]
    return rb.run(tree)


def test_a_screened_half_space_is_not_the_exact_solution(ladder: Results) -> None:
    models = ladder["main"]
    assert reference_of(dict(models)) == "bem"
    assert reference_of({"q1": models["q1"]}) is None
    verdicts = {one.key: one for one in judge([("ladder", ladder)], resamples=20)}
    names = {one.where for one in verdicts["area-linear"].measurements}
    assert names == {"main/bem"}
    assert verdicts["coupling-area"].measurements == ()  # winkler with a modulus of its own
    assert verdicts["contender-bem-q4"].claim == (
        "Screened half-space (BEM) follows the exact solution."
    )
    alone = Results({"main": {"q1": models["q1"]}}, "no spec", "")
    found = {one.key: one for one in judge([("one", alone)], resamples=20)}
    assert found["area-linear"].measurements == ()


def test_legends_tell_the_rungs_apart(ladder: Results) -> None:
    names = model_names(ladder, ["main"], "area")
    assert names["bem"] == "Exact (BEM), $n = 3$"
    assert names["q4"] == "Screened half-space (BEM), q4, $q_c/q_0 = 4$, $n = 3$"


def test_the_energy_of_the_waves_is_that_of_the_screened_kernel(ladder: Results) -> None:
    for label in ("bem", "q1", "q4", "q1e5", "winkler"):
        one = ladder["main"][label]
        np.testing.assert_allclose(one["energy_spectrum_total"], one["energy"], rtol=1e-5)
    # Without the screening the springs would hold far too much.
    stiff = ladder["main"]["q1e5"]
    single = Field(np.array([0.0, 1.0]), np.zeros(2), 2 * math.pi, 1.0, 1.0)
    plain, screened = (
        energy_spectrum(replace(single, screening=q)) for q in (0.0, math.sqrt(3.0))
    )
    assert plain.scalars["total"] == pytest.approx(0.25)
    assert screened.scalars["total"] == pytest.approx(0.125)
    assert stiff.attributes["screening"] == 1e5
    with pytest.raises(SolverError, match="screening must be at least 0"):
        replace(single, screening=-1.0)


def test_a_spec_with_units_takes_a_wavevector() -> None:
    tree = spec(screening="2 /um") | {
        "surface": {"H": 0.7, "q0": "1 /um", "q1": "8 /um", "slope": 0.1},
        "modulus": {"E*": "1 GPa"},
        "pressures": ["1 MPa"],
    }
    tree["models"] = tree["models"][:1]
    assert load_spec(tree).models[0].screening == pytest.approx(2e6)  # type: ignore[attr-defined]
