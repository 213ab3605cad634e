"""Statistics over realizations against NumPy's, with infinities, gaps and permutations."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.ensemble import STATISTICS, harmonic_mean, summarize

FloatArray = NDArray[np.float64]


def every(values: FloatArray) -> NDArray[np.bool_]:
    return np.ones(values.shape, bool)


@pytest.mark.parametrize("n", [1, 2, 3, 10, 51, 100])
def test_agrees_with_numpy(n: int, rng: np.random.Generator) -> None:
    values = rng.normal(size=(n, 4))
    summary = summarize(values, every(values))
    np.testing.assert_allclose(summary.mean, values.mean(axis=0), rtol=1e-13)
    np.testing.assert_allclose(summary.median, np.median(values, axis=0), rtol=1e-13)
    for name, fraction in (("q16", 0.16), ("q84", 0.84)):
        expected = np.quantile(values, fraction, axis=0)
        np.testing.assert_allclose(getattr(summary, name), expected, rtol=1e-12, atol=1e-15)
    if n > 1:
        sem = values.std(axis=0, ddof=1) / math.sqrt(n)
        np.testing.assert_allclose(summary.sem, sem, rtol=1e-13)
    assert summary.count.tolist() == [n] * 4


def test_one_realization_has_no_standard_error() -> None:
    summary = summarize(np.array([[3.0]]), np.array([[True]]))
    assert math.isnan(summary.sem[0])
    assert summary.mean[0] == summary.median[0] == summary.q16[0] == summary.q84[0] == 3.0


def test_states_that_did_not_converge_do_not_count() -> None:
    values = np.array([[1.0, 5.0], [np.nan, 6.0], [3.0, 1e9]])
    converged = np.array([[True, True], [False, True], [True, False]])
    summary = summarize(values, converged)
    assert summary.mean.tolist() == [2.0, 5.5]
    assert summary.count.tolist() == [2, 2]
    # The negative control: counted in, they would show.
    assert summarize(values[:, 1:], every(values[:, 1:])).mean[0] > 1e8


def test_without_a_converged_state_nothing_is_known() -> None:
    values, none = np.array([[1.0], [2.0]]), np.zeros((2, 1), bool)
    summary = summarize(values, none)
    assert summary.count.tolist() == [0]
    assert all(math.isnan(getattr(summary, name)[0]) for name in STATISTICS)
    assert math.isnan(harmonic_mean(values, none)[0])


@pytest.mark.parametrize(
    ("column", "mean", "median", "q84", "harmonic"),
    [
        (
            [1.0, 2.0, 3.0, 4.0, math.inf],
            math.inf,
            3.0,
            math.inf,
            5 / (1 + 1 / 2 + 1 / 3 + 1 / 4),
        ),
        ([1.0, math.inf], math.inf, math.inf, math.inf, 2.0),
        ([math.inf, math.inf, math.inf], math.inf, math.inf, math.inf, math.inf),
        ([0.0, 1.0, 5.0], 2.0, 1.0, 3.72, 0.0),
        ([1.0, math.nan, 3.0], math.nan, math.nan, math.nan, math.nan),
    ],
)
def test_infinite_stiffness(
    column: list[float], mean: float, median: float, q84: float, harmonic: float
) -> None:
    values = np.array(column)[:, None]
    summary = summarize(values, every(values))
    found = [summary.mean[0], summary.median[0], summary.q84[0]]
    np.testing.assert_allclose(found, [mean, median, q84], rtol=1e-14)
    np.testing.assert_allclose(harmonic_mean(values, every(values)), [harmonic], rtol=1e-14)
    assert math.isfinite(mean) or math.isnan(summary.sem[0])


@pytest.mark.parametrize("n", [26, 51, 76, 101])
def test_quantile_on_an_order_statistic_is_not_spoiled_by_the_next(n: int) -> None:
    # 0.84 (n - 1) is a whole number; the values above it are infinite.
    place = round(0.84 * (n - 1))
    column = np.arange(n, dtype=float)
    column[place + 1 :] = math.inf
    assert summarize(column[:, None], every(column[:, None])).q84[0] == place


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=12), st.randoms())
def test_order_of_the_realizations_does_not_matter(
    column: list[float], shuffler: random.Random
) -> None:
    shuffled = column.copy()
    shuffler.shuffle(shuffled)
    one, other = (
        summarize(values, every(values))
        for values in (np.array(column)[:, None], np.array(shuffled)[:, None])
    )
    scale = max(abs(x) for x in column)
    for name in STATISTICS:
        found = [float(getattr(summary, name)[0]) for summary in (one, other)]
        assert found[0] == pytest.approx(found[1], rel=1e-12, abs=1e-12 * scale)
    assert one.q16[0] <= one.median[0] <= one.q84[0]
    assert min(column) - 1e-12 * scale <= one.mean[0] <= max(column) + 1e-12 * scale


def test_standard_error_covers_the_true_mean() -> None:
    """Of 2000 ensembles of 25 normal numbers 67.3 % lie within one standard error.

    Student's t with 24 degrees of freedom: P(|t| < 1) = 0.6727; the observed share has
    the standard deviation √(0.67·0.33/2000) = 0.0105, so 4σ = 0.042.
    """
    values = np.random.default_rng(1).normal(size=(25, 2000))
    summary = summarize(values, every(values))
    share = float(np.mean(np.abs(summary.mean) < summary.sem))
    assert abs(share - 0.6727) < 0.042
    # The negative control: a standard error without √n is far outside.
    assert abs(float(np.mean(np.abs(summary.mean) < summary.sem / 5)) - 0.6727) > 0.042


@pytest.mark.parametrize("shape", [(3,), (3, 3), (2, 2, 1)])
def test_refuses_shapes_that_do_not_fit(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"shape \(realizations, pressures\)"):
        summarize(np.ones(shape), np.ones((2, 3), bool))
    with pytest.raises(ValueError, match=r"shape \(realizations, pressures\)"):
        harmonic_mean(np.ones(shape), np.ones((2, 3), bool))
