"""A prescribed mean gap: the load that leaves it."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.models.base import Status
from roughbench.models.halfspace.contact import solve_contact, solve_curve

FloatArray = NDArray[np.float64]


def rough(n: int, seed: int) -> FloatArray:
    """Heights with wavelengths from the cell down to four points."""
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n)[:, None] * n, np.fft.rfftfreq(n) * n)
    amplitude = np.where((q > 0) & (q <= n / 4), np.maximum(q, 1.0) ** -1.7, 0.0)
    heights = np.fft.irfft2(amplitude * np.exp(2j * np.pi * rng.random(q.shape)), s=(n, n))
    return np.asarray(0.01 * heights / heights.std())


def full_load(heights: FloatArray) -> float:
    """Pressure from which on contact is full."""
    return float(1e3 - solve_contact(heights, 1e3, threads=1).pressure.min())


@pytest.mark.parametrize("share", [1e-7, 1e-4, 1e-2, 0.3, 0.9, 0.999])
def test_the_gap_that_a_pressure_leaves_gives_the_pressure_back(share: float) -> None:
    heights = rough(48, seed=2) + 5.0
    pressure = share * full_load(heights)
    there = solve_contact(heights, pressure, threads=1)
    back = solve_contact(heights, separation=there.mean_separation, threads=1)
    assert back.status is Status.CONVERGED
    # Next to full contact a state knows ū to 1 % of itself, and the load as well as that says.
    gap = there.mean_separation
    allowed = 5e-6 if share < 0.5 else 2 * 0.01 * gap * there.stiffness() / pressure
    assert back.pressure.mean() == pytest.approx(pressure, rel=allowed)
    assert back.mean_separation == pytest.approx(there.mean_separation, rel=2e-2)
    assert back.mean_separation == pytest.approx(
        there.mean_separation, abs=1e-6 * heights.std()
    )
    assert back.area_fraction_raw == pytest.approx(there.area_fraction_raw, abs=2e-3)
    assert back.transform_pairs <= 130


def test_westergaard() -> None:
    # ū = h0 (1 − P + P ln P) at the share P of the load of full contact.
    wave = 0.01 * np.cos(2 * np.pi * np.arange(1024) / 1024)
    for share in (0.1, 0.5, 0.9):
        gap = 0.01 * (1 - share + share * math.log(share))
        state = solve_contact(wave, separation=gap, threads=1)
        assert state.status is Status.CONVERGED
        assert state.pressure.mean() == pytest.approx(share * np.pi * 0.01, rel=1e-4)


def test_with_a_hardness() -> None:
    heights = rough(32, seed=3)
    pressure = 0.2 * full_load(heights)
    there = solve_contact(heights, pressure, hardness=2 * pressure, threads=1)
    assert there.plastic_depth > 0
    back = solve_contact(
        heights, separation=there.mean_separation, hardness=2 * pressure, threads=1
    )
    assert back.status is Status.CONVERGED
    assert back.pressure.mean() == pytest.approx(pressure, rel=1e-4)


@pytest.mark.parametrize("above", [1.0, 1.5])
def test_from_first_contact_on_nothing_is_carried(above: float) -> None:
    heights = rough(32, seed=4) - 3.0
    separation = above * float(heights.max() - heights.mean())
    state = solve_contact(heights, separation=separation, threads=1)
    assert state.status is Status.CONVERGED
    assert not state.pressure.any()
    assert (state.area_fraction, state.area_fraction_raw, state.energy) == (0.0, 0.0, 0.0)
    assert state.stiffness() == 0.0
    assert state.mean_separation == pytest.approx(separation)
    assert state.gap.mean() == pytest.approx(separation)
    assert state.gap.min() == pytest.approx((above - 1.0) * separation / above, abs=1e-12)


@pytest.mark.parametrize("separation", [0.0, -1.0, math.nan])
def test_full_contact_has_no_load_of_its_own(separation: float) -> None:
    with pytest.raises(SolverError, match="separation"):
        solve_contact(rough(16, seed=5), separation=separation)


def test_less_than_rounding_errors_is_refused() -> None:
    with pytest.raises(SolverError, match=r"separation must be at least"):
        solve_contact(rough(16, seed=5), separation=1e-16)


def test_either_pressure_or_separation() -> None:
    with pytest.raises(SolverError, match="exactly one of pressure, separation and force"):
        solve_contact(rough(16, seed=5))
    with pytest.raises(SolverError, match="exactly one of pressure, separation and force"):
        solve_contact(rough(16, seed=5), 1.0, separation=0.1)


def test_flat_walls_touch_or_do_not() -> None:
    state = solve_contact(np.zeros((8, 8)), separation=0.5, threads=1)
    assert not state.pressure.any()
    assert state.gap.tolist() == np.full((8, 8), 0.5).tolist()


def test_a_curve_at_gaps_is_that_at_their_pressures() -> None:
    heights = rough(32, seed=6)
    pressures = full_load(heights) * np.array([0.3, 1e-4, 0.15, 0.08, 0.2])
    there = solve_curve(heights, pressures, threads=1)
    assert there.separation is not None
    assert there.area_raw is not None
    assert there.stiffness is not None
    above = 2.0 * float(heights.max() - heights.mean())
    back = solve_curve(heights, separations=[*there.separation, above], threads=1)
    assert back.area_raw is not None
    assert back.stiffness is not None
    assert (back.status == Status.CONVERGED).all()
    np.testing.assert_allclose(back.pressure, [*pressures, 0.0], rtol=5e-6)
    np.testing.assert_allclose(back.area_raw, [*there.area_raw, 0.0], atol=2e-3)
    np.testing.assert_allclose(back.stiffness, [*there.stiffness, 0.0], rtol=1e-3)
    alone = [solve_contact(heights, separation=u, threads=1) for u in there.separation]
    pairs = sum(state.transform_pairs for state in alone)
    assert back.diagnostics["transform_pairs"].sum() < pairs


def test_a_curve_at_approaches() -> None:
    x = np.linspace(-0.5, 0.5, 32)
    sphere = -(x[:, None] ** 2 + x**2) / 20.0
    curve = solve_curve(sphere, separations=[-0.01, -0.005], boundary="free", threads=1)
    states = [solve_contact(sphere, separation=s, boundary="free") for s in (-0.01, -0.005)]
    # Over the area of a cell of unit length.
    np.testing.assert_allclose(curve.pressure, [s.force for s in states], rtol=1e-5)


def test_quantities_at_approaches_are_those_at_their_forces() -> None:
    x = np.linspace(-1.0, 1.0, 32)
    sphere = -(x[:, None] ** 2 + x**2) / 20.0
    curve = partial(
        solve_curve, sphere, boundary="free", length=(2.0, 3.0), modulus=5.0, threads=1
    )
    there = curve(forces=[0.02, 0.05])
    back = curve(separations=there.separation)
    for name in ("pressure", "area", "stiffness", "energy"):
        np.testing.assert_allclose(getattr(back, name), getattr(there, name), rtol=1e-4)


def test_states_without_contact_keep_their_places() -> None:
    curve = solve_curve(rough(16, seed=5), separations=[50.0, 60.0], threads=1)
    assert curve.separation is not None
    np.testing.assert_allclose(curve.separation, [50.0, 60.0], rtol=1e-12)


def test_a_curve_is_at_one_kind_of_points() -> None:
    with pytest.raises(SolverError, match="exactly one of pressures, forces and separations"):
        solve_curve(rough(16, seed=5), [1.0], separations=[0.1])
    with pytest.raises(SolverError, match="separations must be a list of one or more"):
        solve_curve(rough(16, seed=5), separations=[])
