r"""From the values of many realizations to their mean, standard error and quantiles.

Every realization is evaluated at the same pressures first; here its values are only
averaged, in the order of the realizations, so that the last bit does not depend on
which of them was computed first. States that did not converge are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

STATISTICS = {
    "mean": "mean",
    "sem": "standard error of the mean",
    "median": "median",
    "q16": "16 % quantile",
    "q84": "84 % quantile",
}
"""What :class:`Summary` holds, the suffixes of the summaries in a results file, in words."""


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics over the converged realizations; every array has shape (pressures,).

    Attributes
    ----------
    mean : ndarray of float64
        Arithmetic mean; inf as soon as one value is.
    sem : ndarray of float64
        Standard error of the mean, √(Σ(x − mean)² / (n (n − 1))); nan for fewer than two
        values, and where the mean is infinite.
    median, q16, q84 : ndarray of float64
        Quantiles 0.5, 0.16 and 0.84, linear between the order statistics.
    count : ndarray of int64
        Number n of converged realizations; where it is zero all others are nan.
    """

    mean: FloatArray
    sem: FloatArray
    median: FloatArray
    q16: FloatArray
    q84: FloatArray
    count: NDArray[np.int64]


def summarize(values: FloatArray, converged: NDArray[np.bool_]) -> Summary:
    """Return mean, standard error, median, 16 % and 84 % quantile at each pressure.

    Parameters
    ----------
    values : ndarray of float64, shape (realizations, pressures)
        Any unit; may hold inf (the stiffness at full contact).
    converged : ndarray of bool, shape (realizations, pressures)
        Which states count.

    Returns
    -------
    Summary
        In the unit of ``values``.

    Raises
    ------
    ValueError
        If the shapes differ or are not two-dimensional.

    Notes
    -----
    One infinite value makes the mean infinite and its standard error meaningless (nan);
    the quantiles stay finite as long as only finite order statistics enter them. A nan
    among the converged values makes all statistics of that pressure nan.

    Examples
    --------
    >>> stiffness = np.array([[1.0, 2.0], [3.0, np.inf], [2.0, 4.0], [9.0, 5.0]])
    >>> converged = np.array([[True, True], [True, True], [True, True], [False, True]])
    >>> summary = summarize(stiffness, converged)
    >>> summary.mean.tolist(), summary.median.tolist(), summary.count.tolist()
    ([2.0, inf], [2.0, 4.5], [3, 4])
    """
    _check_shapes(values, converged)
    columns = [
        _summarize_column(x[keep]) for x, keep in zip(values.T, converged.T, strict=True)
    ]
    table = np.array(columns, dtype=np.float64).reshape(-1, len(STATISTICS))
    mean, sem, median, q16, q84 = table.T.copy()
    return Summary(mean, sem, median, q16, q84, converged.sum(axis=0, dtype=np.int64))


def mean_and_error(values: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return mean and standard error over the first axis; one row has an error of nan."""
    rows = np.asarray(values, float)
    count = len(rows)
    mean = rows.mean(axis=0)
    if count == 1:
        return mean, np.full(mean.shape, math.nan)
    return mean, np.sqrt(((rows - mean) ** 2).sum(axis=0) / (count * (count - 1)))


def means_and_errors(
    values: FloatArray, converged: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return mean and standard error of finite values at each pressure.

    Parameters
    ----------
    values : ndarray of float64, shape (realizations, pressures, …)
    converged : ndarray of bool, shape (realizations, pressures)

    Returns
    -------
    (ndarray, ndarray) of float64, shape (pressures, …)
        nan where no state converged.
    """
    mean, sem = np.full((2, *values.shape[1:]), math.nan)
    for k, counts in enumerate(converged.T):
        if counts.any():
            mean[k], sem[k] = mean_and_error(values[counts, k])
    return mean, sem


def harmonic_mean(values: FloatArray, converged: NDArray[np.bool_]) -> FloatArray:
    """Return 1/⟨1/x⟩ at each pressure: the mean stiffness of springs in series.

    Unlike the mean it stays finite until every realization is in full contact.

    Parameters
    ----------
    values : ndarray of float64, shape (realizations, pressures)
        Non-negative; may hold inf.
    converged : ndarray of bool, shape (realizations, pressures)

    Returns
    -------
    ndarray of float64, shape (pressures,)
        nan where no state converged.

    Examples
    --------
    >>> harmonic_mean(np.array([[1.0], [np.inf]]), np.array([[True], [True]])).tolist()
    [2.0]
    """
    _check_shapes(values, converged)
    columns = [_harmonic(x[keep]) for x, keep in zip(values.T, converged.T, strict=True)]
    return np.array(columns, dtype=np.float64)


def _check_shapes(values: FloatArray, converged: NDArray[np.bool_]) -> None:
    if values.ndim != 2 or values.shape != converged.shape:
        raise ValueError(
            "values and converged must both have shape (realizations, pressures), "
            f"got {values.shape} and {converged.shape}"
        )


def _summarize_column(x: FloatArray) -> tuple[float, float, float, float, float]:
    n = len(x)
    if n == 0 or np.isnan(x).any():
        return (math.nan,) * 5
    order = np.sort(x)
    quantiles = (_quantile(order, 0.5), _quantile(order, 0.16), _quantile(order, 0.84))
    if not np.isfinite(x).all():
        return (float(order[0] + order[-1]), math.nan, *quantiles)
    mean, sem = mean_and_error(x)
    return (float(mean), float(sem), *quantiles)


def _quantile(order: FloatArray, fraction: float) -> float:
    """Quantile of sorted values, linear in between; any weight on inf gives inf."""
    place = (len(order) - 1) * fraction
    lower = math.floor(place + 1e-9)  # 0.16 (n − 1) may miss a whole number by rounding
    weight = place - lower
    left = float(order[lower])
    if weight <= 1e-9:
        return left
    right = float(order[lower + 1])
    return right if math.isinf(right) else left + weight * (right - left)


def _harmonic(x: FloatArray) -> float:
    if len(x) == 0 or np.isnan(x).any():
        return math.nan
    if (x == 0.0).any():
        return 0.0
    mean = float((1.0 / x).sum()) / len(x)
    return 1.0 / mean if mean > 0.0 else math.inf
