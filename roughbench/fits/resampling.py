"""Averages over resampled realizations: what the errors of the fits come from."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted number and what the bootstrap says about it.

    Attributes
    ----------
    value : float
        From all realizations; nan where the criterion is met nowhere.
    error : float
        Half the distance of ``low`` and ``high``; nan where they are, or one is infinite.
    low, high : float
        16 % and 84 % quantiles over the resamples in which it exists, widened where these lie
        beside the value (:func:`estimate`); nan without resamples, or where it exists in less
        than half of them.
    share : float
        Share of the resamples in which it exists.
    bound : {"", "≤", "≥"}
        Whether the value is a bound only, since its range goes on to the first or last
        pressure of the results.
    count : int
        Realizations behind the error: those of the scarcer of two ensembles; 0 if nothing
        is random.
    is_given : bool
        Whether the model gives the quantities that the number is about.
    """

    value: float
    error: float
    low: float
    high: float
    share: float
    bound: str = ""
    count: int = 0
    is_given: bool = True

    @property
    def is_bound(self) -> bool:
        """Whether the value is a bound only."""
        return bool(self.bound)

    def times(self, factor: float) -> Estimate:
        """Return it in another unit.

        Examples
        --------
        >>> scaled = Estimate(2.0, 0.5, 1.5, 2.5, 1.0, "≥").times(10.0)
        >>> scaled.value, scaled.error, scaled.high, scaled.bound
        (20.0, 5.0, 25.0, '≥')
        """
        numbers = {
            name: getattr(self, name) * factor for name in ("value", "error", "low", "high")
        }
        return replace(self, **numbers)


MISSING = Estimate(math.nan, math.nan, math.nan, math.nan, 0.0)
"""There is no such number."""
NOT_GIVEN = Estimate(math.nan, math.nan, math.nan, math.nan, 0.0, is_given=False)
"""The model does not give the quantity."""


def draw_counts(n_realizations: int, resamples: int, seed: int) -> FloatArray:
    """Return how often each realization counts in each resample; in the first, once.

    Equal numbers of realizations get equal counts, so that models on the same surfaces
    are resampled together.

    Returns
    -------
    ndarray of float64, shape (1 + resamples, n_realizations)
        A single row for a single realization.
    """
    first = np.ones((1, n_realizations))
    if n_realizations == 1:
        return first
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(n_realizations,)))
    drawn = generator.multinomial(
        n_realizations, np.full(n_realizations, 1.0 / n_realizations), size=resamples
    )
    return np.concatenate([first, drawn.astype(float)])


def resampled_means(result: ModelResult, name: str, counts: FloatArray) -> FloatArray:
    """Return the mean over the converged realizations, for each resample.

    Parameters
    ----------
    result : ModelResult
    name : str
        A variable over (realization, pressure).
    counts : ndarray of float64, shape (B, R)

    Returns
    -------
    ndarray of float64, shape (B, P)
        inf as soon as one value is; nan where no realization of a resample converged, and
        where the model does not give the variable.
    """
    values = _values(result, name)
    held = np.asarray(result["status"]) == 0
    finite = held & np.isfinite(values)
    number = counts @ held
    total = counts @ np.where(finite, values, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total / np.where(number > 0.0, number, math.nan)
    infinite = counts @ (held & np.isposinf(values)) > 0.0
    lost = counts @ (held & np.isnan(values)) > 0.0
    return np.where(lost, math.nan, np.where(infinite, math.inf, mean))


def harmonic_means(result: ModelResult, name: str, counts: FloatArray) -> FloatArray:
    """Return 1/⟨1/x⟩ over the converged realizations, for each resample.

    Parameters
    ----------
    result : ModelResult
    name : str
        A positive variable over (realization, pressure), which may be infinite.
    counts : ndarray of float64, shape (B, R)

    Returns
    -------
    ndarray of float64, shape (B, P)
        inf where all values are; nan as for :func:`resampled_means`.
    """
    values = _values(result, name)
    held = np.asarray(result["status"]) == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        number = counts @ held
        total = counts @ np.where(held, 1.0 / values, 0.0)
        return np.asarray(np.where(number > 0.0, number, math.nan) / total)


def _values(result: ModelResult, name: str) -> FloatArray:
    if name in result:
        return np.asarray(result[name], float)
    return np.full(result["status"].shape, math.nan)


def estimate(
    values: FloatArray,
    bounds: NDArray[np.bool_] | None = None,
    *,
    bound: str = "≥",
    count: int = 0,
) -> Estimate:
    """Return the estimate from its values over the resamples, the first from all.

    A bootstrap knows nothing of the scatter of its own estimate of the scatter: both sides
    of the interval are widened as Student's t and n/(n − 1) ask for. No interval of what is
    positive reaches zero by that.

    A number that is an optimum, as the widest range on which a curve keeps to a law, is pulled
    to one side by scatter, and resamples scatter more than what they are drawn from: the
    interval of their quantiles may lie beside the value, on the side on which the truth is
    not. It then reaches from there to as far beyond the value as their median is short of it.

    Parameters
    ----------
    values : ndarray of float64, shape (B,)
    bounds : ndarray of bool, shape (B,), optional
        Whether the value is a bound.
    bound : {"≤", "≥"}
        Which it is then.
    count : int
        Number n of realizations that were drawn from; 0 widens nothing.
    """
    value = float(values[0])
    bound = bound if bounds is not None and math.isfinite(value) and bounds[0] else ""
    drawn = values[1:]
    found = drawn[~np.isnan(drawn)]
    share = found.size / drawn.size if drawn.size else float(not math.isnan(value))
    if found.size < 2 or share < 0.5 or math.isnan(value):
        return Estimate(value, math.nan, math.nan, math.nan, share, bound, count)
    if np.isfinite(found).all():
        low, high = np.quantile(found, [0.16, 0.84])
    else:  # nothing lies between a number and infinity
        low = np.quantile(found, 0.16, method="lower")
        high = np.quantile(found, 0.84, method="higher")
    if math.isfinite(value):
        if not low <= value <= high:
            low, high = _around(value, low, high, float(np.median(found)))
        wider, quantile = _widening(count), low
        low, high = value - wider * (value - low), value + wider * (high - value)
        if low <= 0.0 < quantile:  # what is positive in the draws is widened as its logarithm
            low = value * (quantile / value) ** wider
    finite = math.isfinite(value) and math.isfinite(high)
    error = float(high - low) / 2.0 if finite else math.nan
    return Estimate(value, error, float(low), float(high), share, bound, count)


def _around(value: float, low: float, high: float, median: float) -> tuple[float, float]:
    """Return an interval of resamples together with itself, freed of their bias twice.

    Examples
    --------
    >>> _around(2.0, 1.25, 1.75, 1.5), _around(2.0, 3.0, math.inf, math.inf)
    ((1.25, 2.75), (2.0, inf))
    """
    if not math.isfinite(median):
        return min(low, value), max(high, value)
    bias = median - value
    return min(low, low - 2.0 * bias), max(high, high - 2.0 * bias)


def _widening(count: int) -> float:
    """Return by how much the interval of so few realizations must be wider."""
    if count < 2:
        return 1.0
    return math.sqrt(count / (count - 1)) * student(0.84, count) / student(0.84, 10**9)


def student(probability: float, count: int) -> float:
    """Return the quantile of Student's t for the mean of ``count`` values."""
    from scipy.special import stdtrit

    return float(stdtrit(count - 1, probability))


def n_random(*results: ModelResult) -> int:
    """Return the number of realizations of the scarcest random ensemble; 0 for none.

    Theories and heights from a file have nothing random in them.
    """
    return min((result.n_realizations for result in results if result.is_random), default=0)
