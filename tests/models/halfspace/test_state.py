"""A solved state is a thing of its own: it travels, and holds nothing of the solver."""

from __future__ import annotations

import copy
import gc
import math
import multiprocessing
import pickle
import threading
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.models.halfspace import contact, problem
from roughbench.models.halfspace.contact import ContactState
from roughbench.models.halfspace.solver import Solver
from tests.models.halfspace.conftest import CELL, Rough

LOADS = [1e-6, 1e-4, 1e-2, 0.08]
CASES = [
    pytest.param(load, {"precision": precision, "threads": threads}, line, id=name)
    for load in LOADS
    for precision, threads, line, name in (
        ("mixed", 1, False, f"{load:g}"),
        ("double", 1, False, f"{load:g}-double"),
        ("mixed", 2, False, f"{load:g}-threads"),
        ("mixed", 1, True, f"{load:g}-line"),
    )
]


def same(one: ContactState, other: ContactState) -> None:
    assert one.stiffness() == other.stiffness()  # to the bit
    for name in ("pressure", "gap"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in (
        *("area_fraction", "area_fraction_raw", "mean_separation", "energy", "status"),
        *("certificate", "iterations", "transform_pairs"),
    ):
        assert getattr(one, name) == getattr(other, name)


@pytest.mark.parametrize(("load", "options", "line"), CASES)
@pytest.mark.parametrize("send", [lambda s: pickle.loads(pickle.dumps(s)), copy.deepcopy])  # noqa: S301 - its own
def test_copies_are_the_same_state(
    load: float,
    options: dict[str, Any],
    rough: Rough,
    send: Callable[[ContactState], ContactState],
    *,
    line: bool,
) -> None:
    heights = rough(128, line=line, q_rolloff=4.0)
    state = rb.solve_contact(heights, load, length=CELL, modulus=3.0, **options)
    fresh = send(state)
    value = state.stiffness()
    for other in (fresh, send(state), send(fresh)):
        same(other, state)
    curve = rb.solve_curve(heights, [load], length=CELL, modulus=3.0, **options)
    assert value == curve.stiffness[0]


def test_full_contact_travels_as_well(rough: Rough) -> None:
    state = rb.solve_contact(rough(32), 10.0, length=CELL)
    assert math.isinf(state.stiffness())
    same(copy.deepcopy(state), state)


def _solve(load: float) -> ContactState:
    wave = np.cos(2 * math.pi * np.arange(32) / 32)
    return rb.solve_contact(0.01 * np.outer(wave, wave), load, threads=1)


def test_a_pool_returns_states() -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        states = pool.map(_solve, LOADS)
    for load, state in zip(LOADS, states, strict=True):
        same(state, _solve(load))


@pytest.mark.parametrize("ask", [False, True])
def test_a_state_keeps_no_solver_threads_or_buffers(
    rough: Rough, monkeypatch: pytest.MonkeyPatch, *, ask: bool
) -> None:
    made: list[weakref.ref[object]] = []

    class Watched(Solver):
        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            made.extend(weakref.ref(part) for part in (self, self.team, self.exact))

    for module in contact, problem:
        monkeypatch.setattr(module, "Solver", Watched)
    before = threading.active_count()
    gc.disable()
    try:
        states = [rb.solve_contact(rough(400), load, threads=2) for load in LOADS]
        if ask:
            assert all(state.stiffness() > 0.0 for state in states)
        alive = [part for part in made if part() is not None]
    finally:
        gc.enable()
    assert made
    assert alive == []
    for thread in threading.enumerate()[before:]:
        thread.join(5.0)
    assert threading.active_count() <= before


def test_a_state_is_no_larger_than_what_it_shows(rough: Rough) -> None:
    state = rb.solve_contact(rough(256), 1e-3, length=CELL)
    assert len(pickle.dumps(state)) < 1.2 * (state.pressure.nbytes + state.gap.nbytes)


def test_the_stiffness_is_computed_once(rough: Rough, monkeypatch: pytest.MonkeyPatch) -> None:
    state = rb.solve_contact(rough(32), 1e-3, length=CELL)
    value = state.stiffness()
    monkeypatch.delattr(contact, "Solver")
    assert state.stiffness() == value
