"""Averaged curves of the study's runs, read at equal separation, with errors of a jackknife."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Number:
    """A number, its standard error (nan: none) and how many surfaces it rests on (0: none)."""

    value: float
    error: float = math.nan
    count: int = 0


@dataclass(frozen=True, slots=True)
class Curve:
    """Averages over some realizations.

    Attributes
    ----------
    pressure : ndarray, shape (P,)
        p/E*, ascending.
    separation : ndarray, shape (P,)
        ū/h_rms, each surface in its own unit; descending.
    slope : ndarray, shape (P,)
        p/(K h_rms), the local slope −d(ū/h_rms)/d ln p of the averaged separation.
    area : ndarray, shape (P,)
        A/A₀.
    n_open : int
        At so many pressures, from the lowest on, no realization is closed: there alone
        separations and slopes are read.
    """

    pressure: FloatArray
    separation: FloatArray
    slope: FloatArray
    area: FloatArray
    n_open: int

    def _open(self, name: str) -> FloatArray:
        """Return a quantity where no realization is closed."""
        return np.asarray(getattr(self, name)[: self.n_open])

    def _reaches(self, separation: float) -> bool:
        """Return whether the open states lie on both sides of a separation."""
        known = self._open("separation")
        return bool(known.size > 1 and known[-1] <= separation <= known[0])

    def pressure_at(self, separation: float) -> float:
        """Return p/E* at a separation; nan outside. The slopes are known, not differenced."""
        if not self._reaches(separation):
            return math.nan
        u, p, slope = (self._open(one)[::-1] for one in ("separation", "pressure", "slope"))
        return float(np.exp(CubicHermiteSpline(u, np.log(p), -1.0 / slope)(separation)))

    def at_separation(self, name: str, separation: float) -> float:
        """Return ``slope`` or ``area`` at a separation; nan outside."""
        if not self._reaches(separation):
            return math.nan
        u, values = (self._open(one)[::-1] for one in ("separation", name))
        return float(np.exp(PchipInterpolator(u, np.log(values))(separation)))

    def at_pressure(self, name: str, pressure: float) -> float:
        """Return ``separation``, ``slope``, ``area`` or ``stiffness`` at a pressure.

        It is nan outside. The stiffness is K h_rms/E* = p/(slope E*), with K the harmonic mean.
        """
        if name == "stiffness":
            return pressure / self.at_pressure("slope", pressure)
        states = slice(None) if name == "area" else slice(self.n_open)
        x, at = np.log(self.pressure[states]), math.log(pressure)
        if x.size < 2 or not x[0] - 1e-9 <= at <= x[-1] + 1e-9:
            return math.nan
        at = min(max(at, x[0]), x[-1])
        values = getattr(self, name)[states]
        if name == "separation":
            return float(CubicHermiteSpline(x, values, -self.slope[states])(at))
        return float(np.exp(PchipInterpolator(x, np.log(values))(at)))

    def exponent(self, start: float, end: float) -> float:
        """Return the mean of d ln K/d ln p between two pressures: 1 for K ∼ p."""
        a, b = (self.at_pressure("slope", p) for p in (start, end))
        return 1.0 - math.log(b / a) / math.log(end / start)


def curve_of(model: ModelResult, chosen: IntArray | None = None, scale: float = 1.0) -> Curve:
    """Average the curves of some realizations; default: of all.

    Parameters
    ----------
    model : ModelResult
    chosen : ndarray of int, optional
    scale : float
        E* of the results in units of E*: what a pressure is multiplied by.
    """
    rows = slice(None) if chosen is None else chosen
    height = np.asarray(model["rms_height"], float)[rows][:, None]
    pressure = np.asarray(model["pressure"], float)
    if np.any(np.asarray(model["status"])[rows] != 0):
        raise ValueError(f"{model.label}: states that did not converge")
    separation = np.asarray(model["separation"], float)[rows] / height
    with np.errstate(divide="ignore"):
        slope = pressure / (np.asarray(model["stiffness"], float)[rows] * height)
    is_open = (slope > 0.0).all(axis=0) & (separation > 0.0).all(axis=0)
    area = np.asarray(model["area"], float)[rows]
    means = (one.mean(axis=0) for one in (separation, slope, area))
    return Curve(pressure * scale, *means, int(np.logical_and.accumulate(is_open).sum()))


def jackknife(value: Callable[[IntArray], float], count: int) -> Number:
    """Return a number with the error that leaving out one surface after the other gives.

    Parameters
    ----------
    value : callable
        Takes the indices of the realizations that count.
    count : int
        Of the realizations. With fewer than two there is no error.
    """
    every = np.arange(count)
    whole = value(every)
    if count < 2:
        return Number(whole, math.nan, count)
    parts = np.array([value(np.delete(every, k)) for k in every])
    error = math.sqrt((count - 1) / count * float(np.sum((parts - parts.mean()) ** 2)))
    return Number(whole, error, count)


Reading = Callable[[Curve], float]


def at_pressure(name: str, pressure: float) -> Reading:
    """Return what reads a quantity of a curve at a pressure."""
    return lambda curve: curve.at_pressure(name, pressure)


def at_separation(name: str, separation: float) -> Reading:
    """Return what reads a quantity, or ``pressure``, of a curve at a separation ū/h_rms."""
    if name == "pressure":
        return lambda curve: curve.pressure_at(separation)
    return lambda curve: curve.at_separation(name, separation)


def number_of(model: ModelResult, value: Reading, scale: float = 1.0) -> Number:
    """Return what a function says of a model's averaged curve; of a theory without an error."""
    if model.n_realizations == 1:
        return Number(value(curve_of(model, scale=scale)))
    count = model.n_realizations
    return jackknife(lambda chosen: value(curve_of(model, chosen, scale)), count)


def ratio_of(
    model: ModelResult, exact: ModelResult, value: Reading, scale: float = 1.0
) -> Number:
    """Return the ratio of what a function says of a model and of the exact solution.

    Where both have equally many realizations they are on the same surfaces, and are left out
    together. Otherwise the errors of both add up as squares. ``scale`` is that of
    :func:`curve_of`, of the model.
    """
    if model.n_realizations in (1, exact.n_realizations):

        def both(chosen: IntArray) -> float:
            one = curve_of(model, chosen if model.n_realizations > 1 else None, scale)
            return value(one) / value(curve_of(exact, chosen))

        return jackknife(both, exact.n_realizations)
    one, other = number_of(model, value, scale), number_of(exact, value)
    ratio = one.value / other.value
    error = ratio * math.hypot(one.error / one.value, other.error / other.value)
    return Number(ratio, error, exact.n_realizations)
