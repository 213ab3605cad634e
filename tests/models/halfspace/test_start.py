"""A start from given pressures, and the history of an iteration."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.models.base import Status
from roughbench.models.halfspace.contact import solve_contact

FloatArray = NDArray[np.float64]


def rough(n: int, m: int, seed: int = 0) -> FloatArray:
    """Heights of all wavelengths with an rms of 0.01."""
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n)[:, None] * n, np.fft.rfftfreq(m) * n)
    amplitude = np.where((q > 0) & (q <= n / 4), np.maximum(q, 1.0) ** -1.7, 0.0)
    heights = np.fft.irfft2(amplitude * np.exp(2j * np.pi * rng.random(q.shape)), s=(n, m))
    return np.asarray(0.01 * heights / heights.std())


@pytest.mark.parametrize("hardness", [None, 0.5])
def test_its_own_pressure_is_solved_already(hardness: float | None) -> None:
    heights = rough(44, 53)
    state = solve_contact(heights, 0.05, hardness=hardness, threads=1)
    again = solve_contact(heights, 0.05, hardness=hardness, start=state.pressure, threads=1)
    assert state.iterations > 5
    assert again.iterations == 0
    assert again.transform_pairs == 1
    assert again.pressure == pytest.approx(state.pressure, abs=1e-6)


def test_any_start_leads_to_the_same_state() -> None:
    heights = rough(44, 53)
    reference = solve_contact(heights, 0.05, tolerance=1e-9, threads=1)
    lonely = np.zeros(heights.shape)
    lonely[3, 50] = 1.0
    for start in (lonely, np.ones(heights.shape), 1e3 * rough(44, 53, seed=1).clip(0)):
        gap = reference.mean_separation
        for state in (
            solve_contact(heights, 0.05, start=start, tolerance=1e-9, threads=1),
            solve_contact(heights, separation=gap, start=start, tolerance=1e-9, threads=1),
        ):
            assert state.status is Status.CONVERGED
            assert state.pressure == pytest.approx(reference.pressure, abs=1e-4)
            assert state.pressure.mean() == pytest.approx(0.05, rel=1e-6)


def test_a_start_that_cannot_carry_the_load_is_left() -> None:
    heights = rough(44, 53)
    lonely = np.zeros(heights.shape)
    lonely[3, 50] = 1.0
    state = solve_contact(heights, 0.05, hardness=0.5, start=lonely, threads=1)
    assert state.status is Status.CONVERGED
    assert state.pressure.mean() == pytest.approx(0.05, rel=1e-6)


def test_a_line_starts_from_pressures_too() -> None:
    line = rough(44, 53)[0]
    state = solve_contact(line, 0.02, threads=1)
    again = solve_contact(line, 0.02, start=state.pressure, threads=1)
    assert again.iterations == 0
    assert again.area_fraction == state.area_fraction


def test_the_history_leads_to_the_certificate() -> None:
    state = solve_contact(rough(44, 53), 0.05, history=True, threads=1)
    assert state.history is not None
    certified = [step for step in state.history if step.is_certified]
    # Each relaxation notes its state before the first iteration as well.
    assert len(state.history) == state.iterations + 2 * len(certified) - 1
    assert state.history[-1] == certified[-1]
    assert certified[-1].error == state.certificate.error
    assert certified[-1].transform_pairs == state.transform_pairs
    pairs = [step.transform_pairs for step in state.history]
    assert pairs == sorted(pairs)
    assert certified[0].error > 100 * certified[-1].error
    assert copy.deepcopy(state).history == state.history
    assert solve_contact(rough(44, 53), 0.05, threads=1).history is None


@pytest.mark.parametrize("bad", [-1.0, np.nan, 0.0, np.inf])
def test_a_start_is_made_of_pressures(bad: float) -> None:
    with pytest.raises(SolverError, match="start must be pressures"):
        solve_contact(rough(8, 8), 0.1, start=np.full((8, 8), bad))


def test_a_start_has_the_shape_of_the_heights() -> None:
    with pytest.raises(
        SolverError, match=r"start must have the shape of the heights, \(8, 8\)"
    ):
        solve_contact(rough(8, 8), 0.1, start=np.ones((8, 9)))
