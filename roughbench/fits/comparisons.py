r"""How a model compares with the reference: where both agree, and by which factor they differ.

Both are compared at equal pressure and, for area and stiffness, at equal mean separation as
well. For the latter, ln A and ln(K h) of the model are interpolated linearly in ū/h, h the
realized rms height of each one's own surfaces, between its states, to the ū/h of each state of
the reference; nothing is extrapolated, so that states of the reference beyond the first and
the last ū of the model are not compared. The pressures that are given are the reference's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.fits.averages import Averages
from roughbench.fits.laws import FEWEST, inside, reaches
from roughbench.fits.resampling import NOT_GIVEN, Estimate, estimate
from roughbench.fits.windows import widest_between
from roughbench.quantities import QUANTITIES, compared

FloatArray = NDArray[np.float64]
Ends = tuple[tuple[FloatArray, NDArray[np.bool_]], tuple[FloatArray, NDArray[np.bool_]]]
Curves = tuple[FloatArray, FloatArray]
"""Of a model and of the reference, each of shape (B, P)."""

PERCENTS = (10, 50)
PRESSURE_FACTOR = "pressure_at_separation_factor"
"""Name of the factor between the pressures at equal mean separation."""
HEIGHTS = (1, 2, 3)
"""Mean separations, in own rms heights, at which these pressures are compared one by one."""
NEARLY_CLOSED = 0.9
"""A/A0 of the reference past which all areas agree, and tell nothing."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """One quantity that models are compared in.

    Attributes
    ----------
    quantity : str
        One that is compared, see :mod:`roughbench.quantities`.
    at_separation : bool
        Whether at equal mean separation, not at equal pressure.
    """

    quantity: str
    at_separation: bool = False

    @property
    def name(self) -> str:
        """What the names of its estimates begin with."""
        return f"{self.quantity}_at_separation" if self.at_separation else self.quantity

    @property
    def needs(self) -> set[str]:
        """The quantities that a model has to give."""
        return {self.quantity, "separation"} if self.at_separation else {self.quantity}

    @property
    def factor(self) -> str:
        """The name of its factor."""
        return f"{self.name}_factor"

    @property
    def closed(self) -> str:
        """The name of the number of pressures that its factor leaves out, closed in one."""
        return f"{self.name}_closed"

    @property
    def is_expected(self) -> bool:
        """Whether it is named of models that do not give its quantity."""
        return QUANTITIES[self.quantity].is_expected

    def ends(self, percent: int) -> tuple[str, str]:
        """Return the names of both ends of the range of agreement within a percentage."""
        return f"{self.name}_agrees_from_{percent}", f"{self.name}_agrees_to_{percent}"


def comparisons() -> list[Comparison]:
    """Return what models are compared in."""
    return [
        *(Comparison(quantity) for quantity in compared()),
        Comparison("area", at_separation=True),
        Comparison("stiffness", at_separation=True),
    ]


def compare(one: Averages, reference: Averages) -> dict[str, Estimate]:
    """Return where a model agrees with the reference, and the factor between them.

    Returns
    -------
    dict of str to Estimate
        By the names that :func:`roughbench.fits.fit` describes; those at equal pressure are
        missing where the pressures differ.
    """
    agreement: dict[str, Estimate] = {}
    factors: dict[str, Estimate] = {}
    for comparison in comparisons():
        quantity = comparison.quantity
        if not _concerns(comparison, one, reference):
            continue
        if not comparison.needs <= one.given:
            names = (name for percent in PERCENTS for name in comparison.ends(percent))
            agreement |= dict.fromkeys(names, NOT_GIVEN)
            factors[comparison.factor] = NOT_GIVEN
        elif comparison.at_separation:
            curves = _at_separation(quantity, one, reference)
            agreement |= _agreement(comparison, curves, one, reference)
            factors[comparison.factor] = _factor(
                quantity, curves, one, reference, fewest=FEWEST
            )
        elif np.array_equal(one.pressure, reference.pressure):
            curves = _paired(one.means[quantity], reference.means[quantity])
            agreement |= _agreement(comparison, curves, one, reference)
            factors[comparison.factor] = _factor_at_pressure(quantity, one, reference)
            if quantity != "area":
                factors[comparison.closed] = _closed(quantity, one, reference)
    return agreement | factors | _pressures_at_separation(one, reference)


def compare_factors(one: Averages, reference: Averages) -> dict[str, Estimate]:
    """Return the factors at equal pressure alone."""
    return {
        comparison.factor: _factor_at_pressure(comparison.quantity, one, reference)
        if comparison.quantity in one.given
        else NOT_GIVEN
        for comparison in comparisons()
        if not comparison.at_separation and _concerns(comparison, one, reference)
    }


def _concerns(comparison: Comparison, one: Averages, reference: Averages) -> bool:
    """Whether every model should give the quantity, or one of the two does."""
    return comparison.is_expected or comparison.quantity in one.given | reference.given


def _agreement(
    comparison: Comparison, curves: Curves, one: Averages, reference: Averages
) -> dict[str, Estimate]:
    ours, theirs = curves
    pressure, count = reference.pressure, _count(one, reference)
    chosen = np.ones(pressure.shape, bool)
    if comparison.quantity == "area":
        chosen = ~(theirs[0] > NEARLY_CLOSED)
    found = {}
    for percent in PERCENTS:
        start, end = comparison.ends(percent)
        lower, upper = fit_departures(
            pressure[chosen], ours[:, chosen], theirs[:, chosen], percent / 100.0
        )
        found[start] = estimate(*lower, bound="≤", count=count)
        found[end] = estimate(*upper, bound="≥", count=count)
    return found


def _factor_at_pressure(quantity: str, one: Averages, reference: Averages) -> Estimate:
    """Return a factor over the pressures at which neither is closed.

    At full contact ū is 0 and K infinite: no factor is, and one closed pressure would decide.
    """
    curves = _paired(one.in_own_units(quantity), reference.in_own_units(quantity))
    if quantity == "area":
        return _factor(quantity, curves, one, reference)
    ours, theirs = curves
    kept = np.where(_is_closed(ours) != _is_closed(theirs), math.nan, ours)
    lost = np.isnan(ours).any() or np.isnan(theirs).any()
    if lost:  # a state is missing, which is something else than closed
        return _factor(quantity, curves, one, reference)
    return _factor(quantity, (kept, theirs), one, reference, fewest=FEWEST)


def _is_closed(values: FloatArray) -> NDArray[np.bool_]:
    """Return where ū is 0 or K infinite."""
    return np.asarray((values == 0.0) | np.isinf(values))


def _closed(quantity: str, one: Averages, reference: Averages) -> Estimate:
    """Return at how many pressures of the region the model alone is closed."""
    ours, theirs = _paired(one.in_own_units(quantity), reference.in_own_units(quantity))
    start, end = (np.broadcast_to(x, len(theirs)) for x in reference.linear["stiffness"])
    chosen = inside(np.log(reference.pressure), start, end)
    number = (chosen & _is_closed(ours) & ~_is_closed(theirs)).sum(axis=1)
    counted = np.where(chosen.any(axis=1), number, math.nan).astype(float)
    return estimate(counted, count=_count(one, reference))


def _pressures_at_separation(one: Averages, reference: Averages) -> dict[str, Estimate]:
    """Return how the pressures at equal ū/h compare, each with its own realized h.

    ū is nearly logarithmic in p: models that are close in ū at equal pressure may need very
    different pressures for the same ū.

    Returns
    -------
    dict of str to Estimate
        ``pressure_at_separation_factor``, e to the rms of ln of the ratio over the region K ∼ p
        of the reference, and ``pressure_at_1h``, …, the ratio of model to reference at ū = h.
    """
    names = [PRESSURE_FACTOR, *(f"pressure_at_{h}h" for h in HEIGHTS)]
    if "separation" not in one.given & reference.given:
        return dict.fromkeys(names, NOT_GIVEN)
    count = _count(one, reference)
    at, x = reference.in_own_units("separation"), one.in_own_units("separation")
    rows = max(len(at), len(x))
    ours = np.empty((rows, at.shape[1]))
    ratios = np.empty((rows, len(HEIGHTS)))
    heights = np.asarray(HEIGHTS, float)
    for row in range(rows):
        own, other = x[min(row, len(x) - 1)], at[min(row, len(at) - 1)]
        ours[row] = interpolate_falling(own, one.pressure, other)
        ratios[row] = interpolate_falling(own, one.pressure, heights) / interpolate_falling(
            other, reference.pressure, heights
        )
    curves = _paired(ours, np.broadcast_to(reference.pressure, at.shape))
    found = {PRESSURE_FACTOR: _factor("separation", curves, one, reference, fewest=FEWEST)}
    for name, column in zip(names[1:], ratios.T, strict=True):
        found[name] = estimate(column, count=count)
    return found


def _factor(
    quantity: str,
    curves: Curves,
    one: Averages,
    reference: Averages,
    fewest: int | None = None,
) -> Estimate:
    ours, theirs = curves
    ends = reference.linear["area" if quantity == "area" else "stiffness"]
    start, end = (np.broadcast_to(x, len(theirs)) for x in ends)
    factor = fit_factor(reference.pressure, ours, theirs, (start, end), fewest=fewest)
    return estimate(factor, count=_count(one, reference))


def _count(*models: Averages) -> int:
    """Return the number of realizations of the scarcest random ensemble; 0 for none."""
    return min((model.count for model in models if model.count), default=0)


def _at_separation(quantity: str, one: Averages, reference: Averages) -> Curves:
    """Return a quantity of both models at the mean separations of the reference."""
    theirs, at = reference.in_own_units(quantity), reference.in_own_units("separation")
    ours, x = one.in_own_units(quantity), one.in_own_units("separation")
    count = max(len(ours), len(theirs))
    found = np.empty((count, at.shape[1]))
    for row in range(count):
        own, other = min(row, len(ours) - 1), min(row, len(theirs) - 1)
        found[row] = interpolate_falling(x[own], ours[own], at[other])
    return _paired(found, theirs)


def interpolate_falling(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Return y at some places, ln y linear in a falling x; nan beyond its ends.

    Parameters
    ----------
    x, y : ndarray of float64, shape (P,)
        Points where one is not finite, y is not positive, or x is not below all before are
        left out.
    at : ndarray of float64, shape (K,)

    Returns
    -------
    ndarray of float64, shape (K,)

    Examples
    --------
    >>> x, y = np.array([3.0, 2.0, 0.0]), np.array([1.0, 10.0, np.inf])
    >>> interpolate_falling(x, y, np.array([3.5, 2.5, 2.0, 1.0])).round(2).tolist()
    [nan, 3.16, 10.0, nan]
    """
    kept = np.isfinite(x) & np.isfinite(y) & (y > 0.0)
    x, y = x[kept], y[kept]
    falling = np.ones(x.shape, bool)
    falling[1:] = x[1:] < np.minimum.accumulate(x)[:-1]
    x, y = x[falling], y[falling]
    if not x.size:
        return np.full(at.shape, math.nan)
    return np.exp(np.interp(-at, -x, np.log(y), left=math.nan, right=math.nan))


def fit_factor(
    pressure: FloatArray,
    values: FloatArray,
    reference: FloatArray,
    region: tuple[FloatArray, FloatArray],
    *,
    fewest: int | None = None,
) -> FloatArray:
    """Return the factor, up or down, between two curves: e to the rms of ln of their ratio.

    Parameters
    ----------
    pressure : ndarray of float64, shape (P,)
    values, reference : ndarray of float64, shape (B, P)
        Non-negative; inf where one is zero or infinite and the other is not.
    region : (ndarray of float64, ndarray of float64), shape (B,)
        Ends in ln p. The mean is over the pressures between them.
    fewest : int, optional
        Number of these that must have a value; default: all.

    Returns
    -------
    ndarray of float64, shape (B,)
        At least 1; nan where the region does not exist or values are missing in it.
    """
    chosen = inside(np.log(pressure), *region)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.abs(np.log(values) - np.log(reference))
    distance = np.where(values == reference, 0.0, distance)
    if fewest is not None:
        chosen &= ~np.isnan(distance)
    number = chosen.sum(axis=1)
    total = np.where(chosen, distance, 0.0)
    enough = number >= (fewest or 1)
    with np.errstate(invalid="ignore"):
        square = (total * total).sum(axis=1) / np.where(enough, number, math.nan)
    return np.asarray(np.exp(np.sqrt(square)))


def fit_departures(
    pressure: FloatArray, values: FloatArray, reference: FloatArray, part: float
) -> Ends:
    """Return the ends of the widest range on which two curves differ by less than a part.

    Between the pressures (r − 1)/(r + 1) of their ratio r is taken as linear in ln p,
    which knows 0 and infinity; where both are 0 or both infinite they agree.

    Parameters
    ----------
    pressure : ndarray of float64, shape (P,)
        p/E*, ascending.
    values, reference : ndarray of float64, shape (B, P)
        Non-negative; may be inf.
    part : float
        0.1 for 10 % of the reference.

    Returns
    -------
    ((ndarray of float64, ndarray of bool), (ndarray of float64, ndarray of bool))
        Lower and upper end, p/E*, and whether each is a bound, the first or last pressure
        with a value of both, of shape (B,); nan where the curves agree nowhere.
    """
    x = np.log(pressure)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        s = np.where(
            np.isinf(values) | np.isinf(reference),
            np.isinf(values).astype(float) - np.isinf(reference),
            (values - reference) / (values + reference),
        )
    s = np.where((values == 0.0) & (reference == 0.0), 0.0, s)
    s = np.where(np.isnan(values) | np.isnan(reference), math.nan, s)
    count = s.shape[0]
    low, high = np.full(count, -part / (2.0 - part)), np.full(count, part / (2.0 + part))
    start, end = widest_between(x, s, low, high)
    at_start, at_end = reaches(x, start, end, ~np.isnan(s))
    return (np.exp(start), at_start), (np.exp(end), at_end)


def _paired(one: FloatArray, other: FloatArray) -> Curves:
    """Repeat the single row of a model without randomness for all resamples."""
    count = max(len(one), len(other))
    return (
        np.broadcast_to(one, (count, one.shape[1])),
        np.broadcast_to(other, (count, other.shape[1])),
    )
