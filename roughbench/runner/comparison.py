"""Two results of the same spec, state by state: how far they are apart, and whether they agree.

States of a model that iterates carry a certificate that allows an error of the order of the
root of its tolerance in its pressures (docs/solver.md): that is the deviation that passes for
agreement. All else is rounding.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from roughbench.ensemble import STATISTICS
from roughbench.models.base import FloatArray
from roughbench.models.registry import presses_lines
from roughbench.numbers import json_number
from roughbench.quantities import QUANTITIES
from roughbench.results import ModelResult, Results

ROUNDING = 1e-9
"""Relative deviation of what does not iterate; sums of 10⁶ numbers are off by 10⁻¹¹."""
GRID_POINTS = 2.0
"""By so many points of the grid may the area differ as well: a pressure near zero decides
whether its point counts, and with it the perimeter. Not where all states have as many points
in contact as before."""
OF_SAMPLES = ("rms_height", "rms_slope")


@dataclass(frozen=True, slots=True)
class Allowance:
    """What deviation passes for agreement.

    Attributes
    ----------
    relative : float
        Of the value.
    absolute : float
        Beside it, in the unit of the quantity.
    """

    relative: float
    absolute: float = 0.0


@dataclass(frozen=True, slots=True)
class QuantityDeviation:
    """How far a quantity of one model is from what it was before.

    Attributes
    ----------
    model : str
        Such as ``main/bem``.
    quantity : str
    states : int
        How many values were compared.
    deviation : float
        The largest |new − old| / |old|; infinite where only one of them is 0, infinite or
        not a number.
    realization, pressure : int
        Where that is, from 1; 0 for a value that has none.
    allowed : float
        Relative deviation that passes for agreement.
    excess : float
        The largest deviation over what is allowed of it; up to 1 they agree.
    of_error : float
        The largest deviation of the mean over its standard error; nan without one.
    """

    model: str
    quantity: str
    states: int
    deviation: float
    realization: int
    pressure: int
    allowed: float
    excess: float
    of_error: float

    @property
    def agrees(self) -> bool:
        """Whether all of it is within what is allowed."""
        return self.excess <= 1.0

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, for strict JSON."""
        return {
            name: json_number(value) if isinstance(value, float) else value
            for name, value in asdict(self).items()
        } | {"agrees": self.agrees}


def compare(
    old: Results,
    new: Results,
    *,
    quantities: Collection[str] | None = None,
    tolerance: float | None = None,
) -> tuple[list[QuantityDeviation], list[str]]:
    """Return how far results are from others of the same spec.

    Parameters
    ----------
    old, new : Results
        Models that the new ones lack are passed over.
    quantities : collection of str, optional
        Variables to compare; default: those of :data:`~roughbench.quantities.QUANTITIES`,
        the realized rms heights and slopes, and observables.
    tolerance : float, optional
        Relative deviation that is allowed; default: see :func:`allowance`.

    Returns
    -------
    (list of QuantityDeviation, list of str)
        A deviation for each quantity; and what cannot be compared, in words: other
        pressures, realizations or quantities.
    """
    rows: list[QuantityDeviation] = []
    faults: list[str] = []
    for experiment, models in new.items():
        for label, after in models.items():
            where = f"{experiment}/{label}"
            if label not in old.experiments.get(experiment, {}):
                faults.append(f"{where}: is not in the old results")
                continue
            before = old[experiment][label]
            if fault := _other_states(before, after):
                faults.append(f"{where}: {fault}")
                continue
            if lost := int(np.count_nonzero((before["status"] == 0) & (after["status"] != 0))):
                faults.append(f"{where}: {lost} states converged before, and do not any more")
            for name in _compared(before, quantities):
                if name in after and after[name].shape == before[name].shape:
                    allowed = allowance(before, name, tolerance)
                    if name == "area" and _same_points(before, after):
                        allowed = Allowance(allowed.relative)
                    rows.append(_deviation(where, name, before, after, allowed))
                else:
                    faults.append(f"{where}: {name} is not there, or of another shape")
    return rows, faults


def allowance(result: ModelResult, quantity: str, tolerance: float | None = None) -> Allowance:
    """Return what deviation of a quantity passes for agreement.

    Of a model with a ``tolerance``: its root; for the area two points of the grid beside it
    (:func:`compare` leaves them out where no state has other points in contact), for the
    separation ten tolerances of h_rms, which the solver allows points to penetrate.
    Of other models: :data:`ROUNDING`.
    """
    given = result.attributes.get("tolerance")
    if quantity in OF_SAMPLES or not isinstance(given, float):
        return Allowance(ROUNDING if tolerance is None else tolerance)
    absolute = 0.0
    if quantity in ("area", "area_raw"):
        rows = float(result.attributes["grid_points"])
        columns = float(result.attributes.get("grid_columns", rows))
        is_line = presses_lines(result.kind, result.attributes)
        absolute = GRID_POINTS / (rows if is_line else rows * columns)
    elif quantity == "separation":
        absolute = 10.0 * given * float(result.attributes["rms_height"])
    return Allowance(math.sqrt(given) if tolerance is None else tolerance, absolute)


def _same_points(before: ModelResult, after: ModelResult) -> bool:
    """Whether no state has more points in contact, or fewer, than it had.

    Then no pressure near zero has decided otherwise, and an area that is off has another
    correction.
    """
    raw = "area_raw"
    return raw in before and raw in after and np.array_equal(before[raw], after[raw])


def _other_states(before: ModelResult, after: ModelResult) -> str:
    """Say in which way the states are others; empty if they are the same."""
    if before["status"].shape != after["status"].shape:
        return (
            f"has {after['status'].shape} (realizations, pressures), the old results "
            f"{before['status'].shape}"
        )
    if not np.allclose(before["pressure"], after["pressure"], rtol=1e-12, atol=0.0):
        return "has other pressures than the old results"
    return ""


def _compared(result: ModelResult, wanted: Collection[str] | None) -> Iterator[str]:
    """Yield the variables that are compared: what came from the states, not their averages."""
    averages = tuple(f"_{statistic}" for statistic in (*STATISTICS, "harmonic"))
    for name in result.variables:
        known = name in QUANTITIES or name in OF_SAMPLES or f"{name}_mean" in result
        if not known or name.endswith(averages) or (wanted is not None and name not in wanted):
            continue
        if result[name].shape[:1] == (result.n_realizations,):
            yield name


def _deviation(
    where: str, name: str, before: ModelResult, after: ModelResult, allowed: Allowance
) -> QuantityDeviation:
    old, new = (np.asarray(one[name], float) for one in (before, after))
    same = (old == new) | (np.isnan(old) & np.isnan(new))
    if old.ndim > 1:  # a state that did not converge has no numbers to agree on
        lost = (before["status"] != 0) | (after["status"] != 0)
        same |= lost.reshape(lost.shape + (1,) * (old.ndim - 2))
    finite = np.isfinite(old) & np.isfinite(new)
    scale = np.abs(old)
    if old.ndim > 2:  # bins of an observable: of the largest, as most are next to nothing
        scale = np.broadcast_to(scale.max(axis=-1, keepdims=True), scale.shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        gap = np.abs(new - old)
        relative = np.where(same, 0.0, np.where(finite & (scale > 0.0), gap / scale, np.inf))
        excess = gap / (allowed.relative * scale + allowed.absolute)
        excess = np.where(same, 0.0, np.where(finite, excess, np.inf))
    worst = int(np.argmax(relative if not excess.any() else excess)) if old.size else 0
    place = np.unravel_index(worst, old.shape) if old.size else (0,)
    return QuantityDeviation(
        model=where,
        quantity=name,
        states=int(old.size),
        deviation=float(relative.max(initial=0.0)),
        realization=int(place[0]) + 1,
        pressure=int(place[1]) + 1 if len(place) > 1 else 0,
        allowed=allowed.relative,
        excess=float(excess.max(initial=0.0)),
        of_error=_of_error(name, before, after),
    )


def _of_error(name: str, before: ModelResult, after: ModelResult) -> float:
    """Return the largest deviation of the mean over its standard error."""
    if f"{name}_sem" not in before or f"{name}_mean" not in after:
        return math.nan
    old, error, new = (
        np.asarray(values, float)
        for values in (before[f"{name}_mean"], before[f"{name}_sem"], after[f"{name}_mean"])
    )
    usable = np.isfinite(old) & np.isfinite(new) & np.isfinite(error) & (error > 0.0)
    ratio: FloatArray = np.abs(new[usable] - old[usable]) / error[usable]
    return float(ratio.max()) if ratio.size else math.nan
