"""Where a stiffness starts to deviate from the theory, on curves whose answer is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughbench.results import ModelResult
from roughbench.verdict.onset import (
    DEVIATES,
    Theory,
    foundation_and_theory,
    onset,
    onset_of,
    theory_of,
)
from tests.fits.lawful import HEIGHT, LENGTH, P, make

P0 = np.logspace(-8, -1, 71)
FEW, BULK = 0.02 * P0**0.6, 2.0 * P0
THEORY = Theory(P0, BULK, FEW, 0.0)
CROSSING = (0.01) ** 2.5
"""Where 0.02 p^0.6 = 2 p."""


def crossing(theta: float) -> float:
    return (theta * 0.01) ** 2.5


@pytest.mark.parametrize("theta", [0.5, 1.0, 2.3])
@pytest.mark.parametrize("m", [math.inf, 2.0, 8.0])
def test_the_theory_itself_does_not_deviate(theta: float, m: float) -> None:
    """With m = 2 the bulk is still 3 % of K where eq. (10) counts, and θ as much larger."""
    found, deviates, linear = onset_of(THEORY, THEORY.stiffness(theta, m), m)
    assert found == pytest.approx(theta, rel=1e-12 if math.isinf(m) else 0.02)
    assert math.isnan(deviates)
    assert linear == pytest.approx(crossing(theta), rel=1e-9 if math.isinf(m) else 0.05)


@pytest.mark.parametrize("place", [5e-6, 1e-4, 3e-3])
@pytest.mark.parametrize("power", [1.0, -0.5])
def test_a_power_law_that_sets_in_deviates_where_it_is_a_fifth(
    place: float, power: float
) -> None:
    away = np.maximum(P0 / place, 1.0) ** power
    found = onset_of(THEORY, THEORY.stiffness(2.0) * away)
    expected = place * DEVIATES ** (1.0 / abs(power))
    assert found[0] == pytest.approx(2.0, rel=1e-9)
    assert found[1] == pytest.approx(expected, rel=0.05)


def test_a_closed_foundation_deviates() -> None:
    stiffness = THEORY.stiffness(1.0).copy()
    stiffness[50:] = np.inf
    assert onset_of(THEORY, stiffness)[1] == pytest.approx(P0[49])


def test_no_law_of_few_contacts_no_onset() -> None:
    late = Theory(P0[50:], BULK[50:], FEW[50:], 0.0)
    assert all(math.isnan(one) for one in onset_of(late, BULK[50:]))
    narrow = Theory(P0, BULK, FEW, 1.0)  # contacts of less than the shortest wave
    assert all(math.isnan(one) for one in onset_of(narrow, THEORY.stiffness(1.0)))


def _foundation(scatter: NDArray[np.float64]) -> tuple[ModelResult, Theory]:
    known: dict[str, Any] = {
        "q_min": 1.0,
        "below_rolloff": "rolloff",
        "q_max": 8192.0,
        "q_rolloff": 1.0,
    }
    bare = make({"area": np.ones((1, P.size))}, "foundation", **known)
    theory = theory_of(bare, 0.45)
    assert theory is not None
    stiffness = theory.stiffness(2.0) * np.maximum(P / 1e-3, 1.0)
    values = {"stiffness": stiffness * (1.0 + scatter[:, None])}
    return make(values, "foundation", **known), theory


def test_the_theory_is_that_of_the_surfaces() -> None:
    _, theory = _foundation(np.zeros(1))
    base = HEIGHT / LENGTH**2
    few = base ** (0.7 / 1.7) * P ** (1 / 1.7) / HEIGHT
    np.testing.assert_allclose(theory.few, few, rtol=1e-9)
    assert theory.narrowest == pytest.approx(2 * math.pi / 8192 / LENGTH**2)
    bare = make({"area": np.ones((1, P.size))}, "foundation")
    assert theory_of(bare, 0.45) is None  # no q0


def test_lines_give_an_error() -> None:
    result, theory = _foundation(np.array([-0.1, -0.05, 0.0, 0.05, 0.1]))
    found = onset(result, theory, resamples=50)
    assert found.theta.value == pytest.approx(2.0, rel=1e-6)
    assert 0.0 < found.theta.error < 0.2
    assert found.deviates.value == pytest.approx(1e-3 * DEVIATES, rel=0.05)
    assert found.ratio.value == pytest.approx(found.deviates.value / found.linear.value)


def test_the_first_of_a_kind_counts() -> None:
    models = {
        label: make({"area": np.ones((1, P.size))}, kind, label)
        for label, kind in (("a", "persson"), ("b", "foundation"), ("c", "persson"))
    }
    foundation, theory = foundation_and_theory(models)
    assert foundation is models["b"]
    assert theory is models["a"]
    assert foundation_and_theory({}) == (None, None)
