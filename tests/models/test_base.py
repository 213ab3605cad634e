"""States and curves: what a contender yields, and what becomes of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

import roughbench as rb
from roughbench.models.base import (
    CompleteCurve,
    Curve,
    FloatArray,
    Model,
    Needs,
    Sample,
    State,
    Status,
)

PRESSURES = np.array([0.3, 0.1, 0.2])
NOWHERE = Sample(None, 1.0)


class Nothing(Model):
    needs: ClassVar[Needs] = "spectrum"
    title: ClassVar[str] = "Nothing"
    kind: str = "nothing"


class Linear(Nothing):
    def curve(self, sample: Sample, pressures: FloatArray) -> Curve:
        del sample
        return Curve(pressure=pressures, area=2 * pressures, diagnostics={"n": np.arange(3)})


class Stepwise(Linear):
    """Overrides ``states`` below a class that overrides ``curve``."""

    def states(self, *arguments: Any, **options: Any) -> Iterator[State]:
        for state in super().states(*arguments, **options):
            yield replace(state, energy=state.pressure)


class Both(Stepwise):
    def curve(self, sample: Sample, pressures: FloatArray) -> Curve:
        return super().curve(sample, pressures)


def test_pressure_and_area_are_enough() -> None:
    curve = rb.Curve(pressure=PRESSURES, area=2 * PRESSURES)
    assert curve.status.tolist() == [rb.Status.CONVERGED] * 3
    assert curve.status.dtype == np.int32
    assert curve.separation is curve.stiffness is curve.energy is curve.area_raw is None


def test_states_rise_and_the_curve_is_in_the_order_asked_for() -> None:
    states = list(Linear().states(NOWHERE, PRESSURES))
    assert [state.pressure for state in states] == [0.1, 0.2, 0.3]
    assert [state.given() for state in states] == [
        {"area": 0.2, "n": 1},
        {"area": 0.4, "n": 2},
        {"area": 0.6, "n": 0},
    ]
    curve = Curve.from_states(states, PRESSURES)
    assert curve.pressure.tolist() == PRESSURES.tolist()
    assert curve.area.tolist() == (2 * PRESSURES).tolist()
    assert curve.diagnostics["n"].tolist() == [0, 1, 2]
    assert curve.energy is None


def test_a_stepwise_model_has_a_curve_as_well() -> None:
    states = [State(p, 2 * p, p, p, p, Status.STAGNATED) for p in sorted(PRESSURES)]
    curve = CompleteCurve.from_states(iter(states), PRESSURES)
    assert curve.stiffness.tolist() == PRESSURES.tolist()
    assert curve.status.tolist() == [Status.STAGNATED] * 3
    with pytest.raises(TypeError, match="stiffness"):
        CompleteCurve.from_states([State(1.0, 1.0, 1.0, None, 1.0)], np.array([1.0]))


def test_the_nearest_override_says_how_a_model_computes() -> None:
    models = (Linear(), Stepwise(), Both(), Nothing())
    assert [model.is_vectorized for model in models] == [True, False, True, False]


def test_a_model_that_computes_nothing_says_so() -> None:
    with pytest.raises(NotImplementedError, match="Nothing has neither curve nor states"):
        Nothing().curve(NOWHERE, PRESSURES)
    with pytest.raises(NotImplementedError, match="hands out no snapshots"):
        next(Linear().states(NOWHERE, PRESSURES, finished={}))


def test_states_of_other_pressures_are_refused() -> None:
    rising = [State(p, p) for p in (0.1, 0.2, 0.3)]
    for states in (rising[:2], rising[::-1], [*rising, rising[0]]):
        with pytest.raises(
            rb.SolverError, match=r"states for 3 pressures, or not in the order"
        ):
            Curve.from_states(states, PRESSURES)


def test_a_quantity_is_given_at_all_pressures_or_at_none() -> None:
    states = [State(p, p, energy=None if p == 0.2 else p) for p in (0.1, 0.2, 0.3)]
    message = r"gives area at p/E\* = 0.2, but area, energy at 0.1; give the same at every"
    with pytest.raises(rb.SolverError, match=message):
        Curve.from_states(states, PRESSURES)
