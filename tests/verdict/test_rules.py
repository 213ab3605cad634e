"""From a number and its error to an outcome."""

from __future__ import annotations

import math

import pytest

from roughbench.fits import Estimate
from roughbench.verdict.rules import AtLeast, AtMost, Near, Outcome, Rule, decide, together

H, F, U, N = Outcome.HOLDS, Outcome.FAILS, Outcome.UNDECIDED, Outcome.NOT_TESTED


def value(x: float, error: float = math.nan) -> Estimate:
    return Estimate(x, error, x - error, x + error, 1.0)


@pytest.mark.parametrize(
    ("rule", "x", "outcome"),
    [
        # ± 2 × 0.1 about the value decides.
        (AtLeast(2.0), 2.21, H),
        (AtLeast(2.0), 2.19, U),
        (AtLeast(2.0), 1.81, U),
        (AtLeast(2.0), 1.79, F),
        (AtMost(2.0), 1.79, H),
        (AtMost(2.0), 1.81, U),
        (AtMost(2.0), 2.19, U),
        (AtMost(2.0), 2.21, F),
        (Near(2.0, 0.5), 2.29, H),
        (Near(2.0, 0.5), 2.31, U),
        (Near(2.0, 0.5), 2.69, U),
        (Near(2.0, 0.5), 2.71, F),
        (Near(2.0, 0.5), 1.71, H),
        (Near(2.0, 0.5), 1.29, F),
    ],
)
def test_two_errors_decide(rule: Rule, x: float, outcome: Outcome) -> None:
    assert decide(rule, value(x, 0.1)) == outcome


def test_a_theory_decides_without_an_error() -> None:
    assert decide(AtLeast(2.0), value(2.0), exact=True) == H
    assert decide(AtLeast(2.0), value(1.999), exact=True) == F
    # But where an error is expected, its absence leaves the question open.
    assert decide(AtLeast(2.0), value(5.0)) == U


def test_what_does_not_exist_is_not_tested() -> None:
    for rule in (AtLeast(2.0), AtMost(2.0), Near(2.0, 1.0)):
        assert decide(rule, value(math.nan)) == N


def test_infinity_is_beyond_every_threshold() -> None:
    assert decide(AtLeast(2.0), value(math.inf)) == H
    assert decide(AtMost(2.0), value(math.inf)) == F
    assert decide(Near(2.0, 1.0), value(math.inf)) == F


@pytest.mark.parametrize(
    ("rule", "bound", "above", "below"),
    [
        (AtLeast(2.0), "≥", H, U),
        (AtLeast(2.0), "≤", U, F),
        (AtMost(2.0), "≥", F, U),
        (AtMost(2.0), "≤", U, H),
        (Near(2.0, 0.5), "≥", U, U),
    ],
)
def test_a_bound_decides_on_its_own_side(
    rule: Rule, bound: str, above: Outcome, below: Outcome
) -> None:
    assert decide(rule, value(3.0, 0.1), bound) == above
    assert decide(rule, value(1.0, 0.1), bound) == below


def test_one_failure_is_enough_and_one_doubt_leaves_open() -> None:
    assert together([H, H, N]) == H
    assert together([H, U, N]) == U
    assert together([H, U, F]) == F
    assert together([N, N]) == N
    assert together([]) == N
