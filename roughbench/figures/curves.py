"""Curves over the pressure: area and separation as in Fig. 3, stiffness as in Fig. 4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.figures.axes import BARE, Axes, axes_of
from roughbench.figures.styles import style_of
from roughbench.results import ModelResult, Results

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DrawnCurve:
    """What is drawn of one contender in one experiment; pressures ascend.

    Attributes
    ----------
    pressure : ndarray of float64, shape (P,)
        As the axis shows it: p/E*, or in its unit.
    value : ndarray of float64, shape (P,)
        Mean, or median, likewise; inf at full contact (stiffness).
    lower, upper : ndarray of float64, shape (P,)
        Mean ± its standard error, or the 16 % and 84 % quantiles; nan for one realization.
    is_median : ndarray of bool, shape (P,)
        Whether these are median and quantiles.
    """

    pressure: FloatArray
    value: FloatArray
    lower: FloatArray
    upper: FloatArray
    is_median: NDArray[np.bool_]


def curve_of(result: ModelResult, name: str, shown: Axes = BARE) -> DrawnCurve:
    """Return a contender's curve, without units with lengths in the spectrum's h_rms.

    It is the mean with its standard error; where a realization in full contact makes
    the mean of the stiffness infinite, the median with the 16 % and 84 % quantiles. A
    contender drawn as a line is then the median at *all* pressures, because a change
    from one to the other would draw a step that is none of the contender's.

    Parameters
    ----------
    result : ModelResult
    name : str
        Of a quantity that the contender has.
    shown : Axes
        Those of its results, see :func:`roughbench.figures.axes.axes_of`.

    Returns
    -------
    DrawnCurve
        nan where the contender does not give the quantity.
    """
    unit = shown[name].divisor(result)
    order = np.argsort(result["pressure"], kind="stable")

    def column(statistic: str) -> FloatArray:
        if name not in result:
            return np.full(order.size, np.nan)
        return np.asarray(result[f"{name}_{statistic}"], float)[order] / unit

    mean, error = column("mean"), column("sem")
    is_median = np.isinf(mean) & (result.n_realizations > 1)
    if not style_of(result).markers:
        is_median[:] = is_median.any()
    error = np.where(np.isfinite(mean), error, np.nan)
    return DrawnCurve(
        np.asarray(result["pressure"], float)[order] / shown.pressure.divisor(result),
        np.where(is_median, column("median"), mean),
        np.where(is_median, column("q16"), mean - error),
        np.where(is_median, column("q84"), mean + error),
        is_median,
    )


def curves_of(
    results: Results, name: str, experiments: Iterable[str] | None = None
) -> Iterator[tuple[str, ModelResult, DrawnCurve]]:
    """Yield experiment, contender and curve of all that have a quantity."""
    shown = axes_of(results)
    for experiment in results if experiments is None else experiments:
        for result in results[experiment].values():
            if name in result:
                yield experiment, result, curve_of(result, name, shown)


def full_contact_pressure(curve: DrawnCurve) -> float | None:
    """Return the lowest pressure at which the curve is 0 or inf, if there is one."""
    full = (curve.value == 0.0) | np.isinf(curve.value)
    return float(curve.pressure[int(np.argmax(full))]) if full.any() else None


def has_medians(results: Results, name: str) -> bool:
    """Return whether a curve shows a median somewhere."""
    return any(curve.is_median.any() for _, _, curve in curves_of(results, name))
