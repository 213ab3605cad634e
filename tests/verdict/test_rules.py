"""From a number and its error to an outcome."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughbench.fits import Estimate
from roughbench.verdict.rules import (
    Outcome,
    PowerLaw,
    Rule,
    about,
    at_least,
    at_most,
    near,
    together,
)

H, F, U, N = Outcome.HOLDS, Outcome.FAILS, Outcome.UNDECIDED, Outcome.NOT_TESTED
FOLLOWS, ANOTHER = at_most(1.5, fails_above=2.0), at_least(2.0, fails_below=1.5)
RATIO = at_least(2.0, of_ratio=True)


def value(
    x: float, down: float = math.nan, up: float | None = None, count: int = 0
) -> Estimate:
    up = down if up is None else up
    return Estimate(x, (down + up) / 2, x - down, x + up, 1.0, count=count)


def bounded(x: float, bound: str) -> Estimate:
    return Estimate(x, 0.1, x - 0.1, x + 0.1, 1.0, bound)


@pytest.mark.parametrize(
    ("rule", "x", "outcome"),
    [
        # ± 2 × 0.1 about the value decides.
        (at_least(2.0), 2.21, H),
        (at_least(2.0), 2.19, U),
        (at_least(2.0), 1.81, U),
        (at_least(2.0), 1.79, F),
        (at_most(2.0), 1.79, H),
        (at_most(2.0), 1.81, U),
        (at_most(2.0), 2.19, U),
        (at_most(2.0), 2.21, F),
        (near(2.0, 0.5), 2.29, H),
        (near(2.0, 0.5), 2.31, U),
        (near(2.0, 0.5), 2.69, U),
        (near(2.0, 0.5), 2.71, F),
        (near(2.0, 0.5), 1.71, H),
        (near(2.0, 0.5), 1.29, F),
        # Between "follows" and "another law" neither is shown.
        (FOLLOWS, 1.29, H),
        (FOLLOWS, 1.31, U),
        (FOLLOWS, 1.75, U),
        (FOLLOWS, 2.19, U),
        (FOLLOWS, 2.21, F),
        (ANOTHER, 2.21, H),
        (ANOTHER, 1.75, U),
        (ANOTHER, 1.29, F),
    ],
)
def test_two_errors_decide(rule: Rule, x: float, outcome: Outcome) -> None:
    assert rule.decide(value(x, 0.1)) == outcome


def test_each_side_has_its_own_error() -> None:
    """A factor of 10 that may as well be 500, but not less than 7, is more than 2."""
    assert at_least(2.0).decide(value(10.0, 3.0, 490.0)) == H
    assert at_least(2.0).decide(value(10.0, 4.5, 490.0)) == U
    assert at_most(20.0).decide(value(10.0, 3.0, 490.0)) == U


def test_a_ratio_may_have_to_be_about_one() -> None:
    rule = about(1.0, 1.5)
    assert [rule.decide(value(x)) for x in (0.6, 0.7, 1.4, 1.6)] == [F, H, H, F]
    assert rule.decide(value(1.4, 0.1)) == U


def test_ratios_have_their_errors_in_the_logarithm() -> None:
    """10 within a factor 2 is 10 within a factor 4: at least 2.5."""
    assert RATIO.decide(value(10.0, 5.0, 10.0)) == H
    assert at_least(2.0).decide(value(10.0, 5.0, 10.0)) == U
    assert RATIO.decide(value(10.0, 6.0, 10.0)) == U  # 4² / 10 = 1.6
    assert RATIO.decide(value(0.9, 0.3, 0.3)) == F  # 1.2² / 0.9 = 1.6
    assert RATIO.decide(value(0.9, 0.3, 0.5)) == U  # 1.4² / 0.9 = 2.2


def test_few_surfaces_need_more_than_two_errors() -> None:
    """Student's t: the 95 % interval of four values is 2.65 of the 68 % ones, not 2."""
    assert at_least(2.0).decide(value(2.25, 0.1)) == H
    assert at_least(2.0).decide(value(2.25, 0.1, count=1000)) == H
    assert at_least(2.0).decide(value(2.25, 0.1, count=4)) == U
    assert at_least(2.0).decide(value(2.28, 0.1, count=4)) == H


def test_a_theory_decides_without_an_error_and_a_single_surface_not_at_all() -> None:
    assert at_least(2.0).decide(value(2.0)) == H
    assert at_least(2.0).decide(value(1.999)) == F
    assert at_least(2.0).decide(value(5.0, count=1)) == U
    assert at_least(2.0).decide(value(5.0, count=7)) == U  # it rarely exists


def test_what_does_not_exist_is_not_tested() -> None:
    for rule in (at_least(2.0), at_most(2.0), near(2.0, 1.0)):
        assert rule.decide(value(math.nan)) == N


def test_infinity_counts_with_the_scatter_around_it() -> None:
    always = Estimate(math.inf, math.nan, math.inf, math.inf, 1.0)
    often = Estimate(math.inf, math.nan, 12.0, math.inf, 1.0)
    for infinite in (always, often):
        assert at_least(2.0).decide(infinite) == H
        assert at_most(2.0).decide(infinite) == F
    assert at_least(20.0).decide(often) == U
    alone = Estimate(math.inf, math.nan, math.nan, math.nan, 1.0)
    assert at_least(2.0).decide(alone) == H


@pytest.mark.parametrize(
    ("rule", "bound", "above", "below"),
    [
        (at_least(2.0), "≥", H, U),
        (at_least(2.0), "≤", U, F),
        (at_most(2.0), "≥", F, U),
        (at_most(2.0), "≤", U, H),
        (near(2.0, 0.5), "≥", F, U),
        (near(2.0, 0.5), "≤", U, F),
    ],
)
def test_a_bound_decides_on_its_own_side(
    rule: Rule, bound: str, above: Outcome, below: Outcome
) -> None:
    assert rule.decide(bounded(3.0, bound)) == above
    assert rule.decide(bounded(1.0, bound)) == below


def test_one_failure_is_enough_and_one_doubt_leaves_open() -> None:
    assert together([H, H, N]) == H
    assert together([H, U, N]) == U
    assert together([H, U, F]) == F
    assert together([N, N]) == N
    assert together([]) == N


HALF = PowerLaw("1/(1+H)", lambda h: 1.0 / (1.0 + h))


@pytest.mark.parametrize(
    ("rule", "text"),
    [
        (at_least(2.0, "decade"), "at least 2 decades"),
        (at_least(1.0, "decade"), "at least 1 decade"),
        (at_most(1.2, of_ratio=True), "at most 1.2"),
        (FOLLOWS, "at most 1.5 (fails from 2 on)"),
        (ANOTHER, "at least 2 (fails up to 1.5)"),
        (near(3.0, 0.5, "decade"), "3 ± 0.5 decades"),
        (near(-1.0, 0.2), "−1 ± 0.2"),
        (near(0.0, 0.2), "0 ± 0.2"),
        (about(1.0, 1.5), "1 within a factor 1.5"),
        (about(2.0, 3.0), "2 within a factor 3"),
        (near(HALF, 0.05), "1/(1+H) ± 0.05"),
    ],
)
def test_a_rule_says_what_it_decides_by(rule: Rule, text: str) -> None:
    assert rule.text == text


@given(st.floats(0.01, 100), st.floats(0.01, 10), st.sampled_from([at_least, at_most, near]))
def test_the_numbers_in_the_text_are_those_that_decide(
    target: float, tolerance: float, make: Callable[..., Rule]
) -> None:
    """Read the thresholds back from the text: just inside it holds, just outside it fails."""
    target, tolerance = (float(f"{number:.3g}") for number in (target, tolerance))
    rule = make(target, tolerance) if make is near else make(target)
    numbers = [float(number) for number in re.findall(r"[\d.]+(?:e[−+]\d+)?", rule.text)]
    assert numbers[0] == pytest.approx(target, rel=1e-5)
    reach = numbers[1] if make is near else 0.0
    ends = {at_least: [(-1, 0)], at_most: [(1, 0)], near: [(-1, -1), (1, 1)]}[make]
    for outwards, side in ends:
        end = numbers[0] + side * reach
        step = outwards * 0.01 * tolerance
        assert rule.decide(value(end - step)) == H
        assert rule.decide(value(end + step)) == F


def test_a_law_is_counted_from_the_surfaces_exponent() -> None:
    rule = near(HALF, 0.05)
    assert rule.decide(value(0.6), hurst=0.7) == H  # 1/1.7 = 0.588
    assert rule.decide(value(0.6), hurst=0.5) == F  # 1/1.5 = 0.667
