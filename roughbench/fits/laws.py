r"""The laws of the paper, fitted to averaged curves; for many resamples at once.

==========================  ========================================================
name                        criterion
==========================  ========================================================
``kappa``, ``kappa_from``,  κ = (A/A0) E*ξ/p, geometric mean over the widest range of
``kappa_to``,               pressure (in ln p) on which it stays within ±10 % of one
``kappa_decades``           value, this range, and its width in decades
``half_contact``            p/E* at which A/A0 first reaches one half
``log_from``, ``log_to``,   the widest range on which K/p stays within ±20 % of one
``log_decades``             value, and its width in decades: the region K ∼ p
``u0``, ``alpha``,          ū = u0 ln(p0/p), least squares in ln p over the pressures
``beta``,                   of that region; α = u0/h_rms, β = p0/E*; with the rms height
``alpha_realized``          of the spectrum and of the realized heights
``u0_from_stiffness``       geometric mean of p⟨1/K⟩ over the region K ∼ p: u0 by eq. (9)
``plateau_decades``         width in decades of the widest range on which the slope
                            d ln K/d ln p, over two steps of pressure, stays within
                            1 ± 0.15; a drift of 15 % per e-fold passes it
``drift_1``, ``drift_2``,   by which factor K/p changes over 1, 2 and 3 decades where it
``drift_3``                 changes least, see :mod:`roughbench.fits.drift`: 1 for K ∼ p
``exponent``,               n of K ∼ p^n, least squares in ln p over the finite-size
``exponent_expected``       region, and 1/(1 + H): the pressures below the region K ∼ p
                            at which K is at least 4 times as large as p would have it,
                            and a single contact of this stiffness, of the diameter
                            K L²/E*, at least as wide as the shortest wave
``theta``,                  θ of eq. (10), geometric mean over the same pressures, with
``theta_realized``          the rms height of the spectrum and of the realized heights
``exponent_above``          the largest d ln K/d ln p between neighbouring pressures above
                            the region K ∼ p
==========================  ========================================================

Ends of ranges are interpolated linearly in ln p. A range holds at least three pressures.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughbench.fits.drift import least_drift
from roughbench.fits.windows import straight_line, widest_between, widest_flat
from roughbench.results import Attribute

FloatArray = NDArray[np.float64]
Fitted = dict[str, tuple[FloatArray, NDArray[np.bool_] | None]]
"""Name → values over the resamples, and whether they are bounds."""

AREA_TOLERANCE = 0.1
STIFFNESS_TOLERANCE = 0.2
SLOPE_TOLERANCE = 0.15
DRIFT_DECADES = (1, 2, 3)
FINITE_SIZE_EXCESS = 4.0
"""Where two laws meet the slope is between theirs: 0.03 above the lower one from here on, if
their squares add up, and 0.1 at an excess of 2."""
FEWEST = 3
_SLACK = 1e-9


def needs(name: str) -> tuple[str, ...]:
    """Return the quantities that a number of the table above is taken from."""
    if name.startswith("kappa") or name == "half_contact":
        return ("area",)
    if name in ("u0", "alpha", "alpha_realized", "beta"):
        return ("separation", "stiffness")
    return ("stiffness",)


def fit_laws(
    pressure: FloatArray,
    means: dict[str, FloatArray],
    attributes: dict[str, Attribute],
    realized_height: FloatArray,
) -> Fitted:
    """Return the numbers of the table above, over the resamples.

    Parameters
    ----------
    pressure : ndarray of float64, shape (P,)
        p/E*, ascending.
    means : dict of str to ndarray of float64, shape (B, P)
        ``area``, ``separation`` (length), ``stiffness`` and its harmonic mean
        ``stiffness_harmonic`` (1/length).
    attributes : dict
        Of the model's results: ``rms_height``, ``rms_slope``, ``length``; ``hurst``,
        ``q_rolloff`` and ``q_max`` where they are known.
    realized_height : ndarray of float64, shape (B,)
        rms height of the realized heights, length.

    Returns
    -------
    dict of str to (ndarray of float64, ndarray of bool or None)
        Each of shape (B,); nan where the criterion is met nowhere.
    """
    x = np.log(pressure)
    height, slope = float(attributes["rms_height"]), float(attributes["rms_slope"])
    fitted: Fitted = {}
    rate = _log(means["area"] * slope / pressure)
    start, end = proportional(pressure, means["area"], AREA_TOLERANCE)
    fitted["kappa"] = (np.exp(_mean(rate, inside(x, start, end))), None)
    at_start, at_end = reaches(x, start, end)
    fitted["kappa_from"] = (np.exp(start), at_start)
    fitted["kappa_to"] = (np.exp(end), at_end)
    fitted["kappa_decades"] = ((end - start) / math.log(10.0), at_start | at_end)

    fitted["half_contact"] = (np.exp(_firstreaches(x, means["area"], 0.5)), None)

    rate = _log(means["stiffness"] / pressure)
    start, end = proportional(pressure, means["stiffness"], STIFFNESS_TOLERANCE)
    region = inside(x, start, end)
    at_start, at_end = reaches(x, start, end)
    fitted["log_from"] = (np.exp(start), at_start)
    fitted["log_to"] = (np.exp(end), at_end)
    fitted["log_decades"] = ((end - start) / math.log(10.0), at_start | at_end)
    fall, at_zero = straight_line(x, means["separation"], region)
    fitted["u0"] = (-fall, None)
    compliance = _log(pressure / means["stiffness_harmonic"])
    fitted["u0_from_stiffness"] = (np.exp(_mean(compliance, region)), None)
    fitted["plateau_decades"] = _plateau(x, rate)
    for decades in DRIFT_DECADES:
        fitted[f"drift_{decades}"] = (least_drift(x, rate, decades), None)
    fitted["alpha"] = (-fall / height, None)
    fitted["alpha_realized"] = (-fall / realized_height, None)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        fitted["beta"] = (np.exp(-at_zero / fall), None)

    fitted["exponent_above"] = (_steepest(x, rate, end) + 1.0, None)

    excess = rate - _mean(rate, region)[:, None]
    with np.errstate(invalid="ignore"):
        few = (x < start[:, None]) & (excess >= math.log(FINITE_SIZE_EXCESS))
    few &= np.isfinite(rate)
    side = float(attributes["length"])
    if "q_max" in attributes:
        narrowest = 2.0 * math.pi / float(attributes["q_max"]) / side**2
        few &= means["stiffness"] >= narrowest
    few &= (few.sum(axis=1) >= FEWEST)[:, None]
    fitted["exponent"] = (straight_line(x, rate, few)[0] + 1.0, None)
    if "hurst" in attributes and "q_rolloff" in attributes:
        share = 1.0 / (1.0 + float(attributes["hurst"]))
        base = height / (side**2 * float(attributes["q_rolloff"]))
        fitted["exponent_expected"] = (np.full(1, share), None)
        law = (1.0 - share) * math.log(base) + share * x - math.log(height)
        theta = np.exp(_mean(rate + x - law, few))
        fitted["theta"] = (theta, None)
        # K h^{1/(1+H)} is what eq. (10) fixes.
        fitted["theta_realized"] = (theta * (realized_height / height) ** share, None)
    return fitted


def proportional(
    pressure: FloatArray, values: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Return the widest range of ln p on which values/p stay within ± a part of one value.

    Parameters
    ----------
    pressure : ndarray of float64, shape (P,)
        Ascending.
    values : ndarray of float64, shape (B, P)
    tolerance : float

    Returns
    -------
    (ndarray of float64, ndarray of float64), shape (B,)
        Both ends, in ln p; nan where the range holds fewer than three pressures.
    """
    x = np.log(pressure)
    return _at_least(FEWEST, x, *widest_flat(x, _log(values / pressure), tolerance))


def reaches(
    x: FloatArray, start: FloatArray, end: FloatArray, known: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which ranges reach the first and the last pressure, rounding forgiven.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        ln p, ascending.
    start, end : ndarray of float64, shape (B,)
        Ends of the ranges.
    known : ndarray of bool, shape (B, P), optional
        Pressures at which the curves have a value; default: all.
    """
    if not x.size:
        return np.zeros(start.shape, np.bool_), np.zeros(end.shape, np.bool_)
    first, last = x[0], x[-1]
    if known is not None:
        first, last = x[known.argmax(axis=1)], x[::-1][known[:, ::-1].argmax(axis=1)]
    with np.errstate(invalid="ignore"):
        return start <= first + _SLACK, end >= last - _SLACK


def _firstreaches(x: FloatArray, y: FloatArray, level: float) -> FloatArray:
    """Return where each curve first rises through a level, linear in ln y; nan if nowhere."""
    above = y >= level
    after = above.argmax(axis=1)
    before = np.maximum(after - 1, 0)
    rows, known = np.arange(len(y)), after > 0  # 0: reached nowhere, or from the start
    low, high = _log(y[rows, before]), _log(y[rows, after])
    part = (math.log(level) - low) / np.where(known, high - low, 1.0)
    return np.asarray(np.where(known, x[before] + part * (x[after] - x[before]), math.nan))


def _steepest(x: FloatArray, y: FloatArray, start: FloatArray) -> FloatArray:
    """Return the largest slope between neighbouring points that ends past a place; else nan."""
    slopes = np.diff(y, axis=1) / np.diff(x)
    with np.errstate(invalid="ignore"):
        known = np.isfinite(slopes) & (x[1:] > start[:, None] + _SLACK)
    largest = np.where(known, slopes, -math.inf).max(axis=1, initial=-math.inf)
    return np.asarray(np.where(known.any(axis=1), largest, math.nan))


def _plateau(x: FloatArray, rate: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the decades on which the slope of ln K is about 1, and whether they go on.

    The slope over two steps stands at the pressure between them.
    """
    count = len(rate)
    if x.size < FEWEST + 1:
        return np.full(count, math.nan), np.zeros(count, np.bool_)
    slopes = (rate[:, 2:] - rate[:, :-2]) / (x[2:] - x[:-2])
    band = np.full(count, SLOPE_TOLERANCE)
    start, end = widest_between(x[1:-1], slopes, -band, band)
    known = np.isfinite(slopes).any(axis=1)
    width = np.where(np.isnan(end - start), 0.0, end - start) / math.log(10.0)
    at_start, at_end = reaches(x[1:-1], start, end)
    return np.where(known, width, math.nan), at_start | at_end


def _log(values: FloatArray) -> FloatArray:
    """Return the logarithm, nan where it is not finite."""
    known = np.isfinite(values) & (values > 0.0)
    return np.where(known, np.log(np.where(known, values, 1.0)), math.nan)


def inside(x: FloatArray, start: FloatArray, end: FloatArray) -> NDArray[np.bool_]:
    """Return which places lie in which ranges, rounding forgiven: (B, P)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((x >= start[:, None] - _SLACK) & (x <= end[:, None] + _SLACK))


def _at_least(
    number: int, x: FloatArray, start: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the ranges that hold so many points, nan for the others."""
    enough = inside(x, start, end).sum(axis=1) >= number
    return np.where(enough, start, math.nan), np.where(enough, end, math.nan)


def _mean(values: FloatArray, chosen: NDArray[np.bool_]) -> FloatArray:
    """Return the mean over the chosen points, nan where there is none."""
    number = chosen.sum(axis=1)
    total = np.where(chosen, values, 0.0).sum(axis=1)
    return np.asarray(np.where(number > 0, total / np.maximum(number, 1), math.nan))
