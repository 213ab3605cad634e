"""What the curves of a results file say in numbers, each with an error.

The laws and their criteria stand in :mod:`roughbench.fits.laws`, and in the page on fits
of the documentation. Errors come from a bootstrap over the realizations: the whole fit,
ranges included, is repeated on averages over realizations drawn with replacement.

>>> import roughbench as rb
>>> from roughbench.fits import fit
>>> results = rb.run(
...     {
...         "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 64.0, "slope": 0.1},
...         "pressures": {"min": 1e-5, "max": 0.1, "points": 17},
...         "realizations": 10,
...         "models": [{"kind": "persson"}, {"kind": "foundation", "springs": 128}],
...     }
... )
>>> fitted = fit(results, reference="persson")["main"]
>>> round(fitted["persson"]["kappa"].value, 2), fitted["persson"]["kappa"].error
(1.57, nan)
>>> fitted["foundation"]["stiffness_agrees_to_50"].value < 1e-3
True
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.fits.laws import (
    AREA_TOLERANCE,
    NEARLY_CLOSED,
    STIFFNESS_TOLERANCE,
    fit_departures,
    fit_factor,
    fit_laws,
    proportional,
    quantity_of,
)
from roughbench.fits.resampling import (
    MISSING,
    NOT_GIVEN,
    Estimate,
    draw_counts,
    estimate,
    harmonic_means,
    resampled_means,
)
from roughbench.fits.tables import PERCENTS
from roughbench.models.registry import is_reference
from roughbench.quantities import Quantity, compared
from roughbench.results import ModelResult, Results

__all__ = [
    "MISSING",
    "NOT_GIVEN",
    "PERCENTS",
    "RESAMPLES",
    "Estimate",
    "factors",
    "fit",
    "n_random",
    "reference_of",
]

Fits = dict[str, dict[str, dict[str, Estimate]]]
"""Experiment → label → name → estimate."""

RESAMPLES = 1000


def reference_of(models: dict[str, ModelResult], reference: str | None = None) -> str | None:
    """Return the label of the model that the others are held against.

    Parameters
    ----------
    models : dict of str to ModelResult
        Of one experiment.
    reference : str, optional
        A label; default: the first exact solver.

    Returns
    -------
    str or None
        None if there is no exact solver and none is named.

    Raises
    ------
    StoreError
        If no model has this label.
    """
    if reference is not None:
        if reference not in models:
            raise StoreError(
                f"no model is named {reference!r}; choose one of {', '.join(models)}"
            )
        return reference
    return next((label for label, result in models.items() if is_reference(result.kind)), None)


def fit(
    results: Results,
    *,
    reference: str | None = None,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Fits:
    """Fit the laws of :mod:`roughbench.fits.laws` to every model, with bootstrap errors.

    Parameters
    ----------
    results : Results
    reference : str, optional
        Label of the model that the others are held against; default: the first ``bem`` of
        each experiment.
    resamples : int
        How often to draw the realizations anew, at least 2.
    seed : int
        Of these draws; the same results and seed give the same errors.

    Returns
    -------
    dict of str to dict of str to dict of str to Estimate
        By experiment, label and name. For every model but the reference there are also
        ``area_agrees_from_10``, ``area_agrees_to_10``, … for area, separation and
        stiffness, 10 % and 50 %: the ends of the widest range of pressure in which it
        differs from the reference by less; for the area up to A/A0 = 0.9 of the
        reference. And ``area_factor``, ``separation_factor``, ``stiffness_factor``: the
        factor between the two (e to the rms of ln of the ratio; of K the harmonic means),
        lengths in units of the realized rms heights, over the range in which the reference
        has A ∼ p (for the area) or K ∼ p. They are missing where there is no reference, or
        the pressures differ. What needs a quantity that the model does not give is
        ``NOT_GIVEN``.

    Raises
    ------
    StoreError
        If no model has the label ``reference``.
    ValueError
        If there are fewer than two resamples.
    """
    if resamples < 2:
        raise ValueError(f"an error needs at least 2 resamples, got {resamples}")
    fitted: Fits = {}
    for experiment, models in results.items():
        label = reference_of(dict(models), reference)
        drawn = {name: _Drawn(result, resamples, seed) for name, result in models.items()}
        chosen = drawn[label] if label is not None else None
        fitted[experiment] = {name: _fit_model(one, chosen) for name, one in drawn.items()}
    return fitted


def _fit_model(one: _Drawn, reference: _Drawn | None) -> dict[str, Estimate]:
    pressure = one.pressure
    laws = fit_laws(pressure, one.means, dict(one.result.attributes), one.height[:, 0])
    count = n_random(one.result)
    found = {name: estimate(*values, count=count) for name, values in laws.items()}
    found |= {name: NOT_GIVEN for name in laws if quantity_of(name) not in one.result}
    if reference is None or reference is one:
        return found
    if not np.array_equal(reference.pressure, pressure):
        return found
    count = n_random(one.result, reference.result)
    for name in _compared(one, reference):
        ends = [
            f"{name}_agrees_{end}_{percent}" for percent in PERCENTS for end in ("from", "to")
        ]
        if not one.gives(name, reference):
            found |= dict.fromkeys(ends, NOT_GIVEN)
            continue
        ours, theirs = _paired(one.means[name], reference.means[name])
        open_ = np.ones(pressure.shape, bool)
        if name == "area":
            open_ = ~(theirs[0] > NEARLY_CLOSED)
        for percent in PERCENTS:
            lower, upper = fit_departures(
                pressure[open_], ours[:, open_], theirs[:, open_], percent / 100.0
            )
            found[f"{name}_agrees_from_{percent}"] = estimate(*lower, count=count)
            found[f"{name}_agrees_to_{percent}"] = estimate(*upper, count=count)
    return found | _factors(one, reference)


def n_random(*results: ModelResult) -> int:
    """Return the number of realizations of the scarcest random ensemble; 0 for none.

    Theories and heights from a file have nothing random in them.
    """
    return min((one.n_realizations for one in results if one.is_random), default=0)


def factors(
    result: ModelResult, reference: ModelResult, resamples: int = RESAMPLES, seed: int = 0
) -> dict[str, Estimate]:
    """Return by which factor two curves differ where the reference is proportional to p.

    Parameters
    ----------
    result, reference : ModelResult
        With the same pressures.
    resamples, seed : int
        As in :func:`fit`.

    Returns
    -------
    dict of str to Estimate
        ``area_factor``, ``separation_factor`` and ``stiffness_factor``, each at least 1:
        e to the rms of ln of their ratio, at the pressures of the range in which the
        reference has A ∼ p (for the area) or K ∼ p. Of the stiffness the harmonic means are
        compared: a single closed line makes the mean of K infinite. Lengths are in units of
        the rms height of each one's realized surfaces.
    """
    return _factors(_Drawn(result, resamples, seed), _Drawn(reference, resamples, seed))


def _factors(one: _Drawn, reference: _Drawn) -> dict[str, Estimate]:
    found, count = {}, n_random(one.result, reference.result)
    for name, quantity in _compared(one, reference).items():
        if not one.gives(name, reference):
            found[f"{name}_factor"] = NOT_GIVEN
            continue
        ours, theirs = (
            x.means[quantity.averaged] / x.height**quantity.length for x in (one, reference)
        )
        ours, theirs = _paired(ours, theirs)
        ends = reference.linear["area" if name == "area" else "stiffness"]
        start, end = (np.broadcast_to(x, len(theirs)) for x in ends)
        found[f"{name}_factor"] = estimate(
            fit_factor(reference.pressure, ours, theirs, (start, end)), count=count
        )
    return found


def _compared(one: _Drawn, other: _Drawn) -> dict[str, Quantity]:
    """Return the quantities that every model should give, and what one of the two gives."""
    return {
        name: quantity
        for name, quantity in compared().items()
        if quantity.is_expected or name in one.result or name in other.result
    }


class _Drawn:
    """The averages of a model over its resamples.

    Attributes
    ----------
    result : ModelResult
    pressure : ndarray of float64, shape (P,)
    means : dict of str to ndarray of float64, shape (B, P)
        What :func:`~roughbench.fits.laws.fit_laws` takes.
    height : ndarray of float64, shape (B, 1)
        Realized rms height.
    """

    def __init__(self, result: ModelResult, resamples: int, seed: int) -> None:
        counts = draw_counts(result.n_realizations, resamples, seed)
        self.result = result
        self.pressure = np.asarray(result["pressure"], float)
        self.means = {name: resampled_means(result, name, counts) for name in compared()}
        for name, quantity in compared().items():
            if quantity.has_harmonic_mean:
                self.means[quantity.averaged] = harmonic_means(result, name, counts)
        heights = np.asarray(result["rms_height"], float)
        self.height = (counts @ heights / heights.size)[:, None]

    def gives(self, name: str, reference: _Drawn) -> bool:
        """Whether both have a quantity."""
        return name in self.result and name in reference.result

    @functools.cached_property
    def linear(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Where area and stiffness are proportional to the pressure: ends in ln p, (B,)."""
        return {
            name: proportional(self.pressure, self.means[name], tolerance)
            for name, tolerance in (
                ("area", AREA_TOLERANCE),
                ("stiffness", STIFFNESS_TOLERANCE),
            )
        }


def _paired(
    one: NDArray[np.float64], other: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Repeat the single row of a model without randomness for all resamples."""
    count = max(len(one), len(other))
    return (
        np.broadcast_to(one, (count, one.shape[1])),
        np.broadcast_to(other, (count, other.shape[1])),
    )
