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

from collections.abc import Mapping
from dataclasses import dataclass, field

from roughbench.errors import StoreError
from roughbench.fits.averages import Averages
from roughbench.fits.comparisons import (
    PERCENTS,
    Comparison,
    compare,
    compare_factors,
    comparisons,
)
from roughbench.fits.deviations import Deviations, deviations
from roughbench.fits.laws import fit_laws, needs
from roughbench.fits.resampling import MISSING, NOT_GIVEN, Estimate, estimate, n_random
from roughbench.models.registry import is_modified, is_reference
from roughbench.results import ModelResult, Results

__all__ = [
    "MISSING",
    "NOT_GIVEN",
    "PERCENTS",
    "RESAMPLES",
    "Comparison",
    "Deviations",
    "Estimate",
    "FittedModel",
    "comparisons",
    "factors",
    "fit",
    "fit_models",
    "is_exact",
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
        A label; default: the first exact solver; a screened one is none.

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
    return next((label for label, result in models.items() if is_exact(result)), None)


def is_exact(result: ModelResult) -> bool:
    """Return whether others are compared with a model, as the exact solution.

    Options that make another model of it, as ``screening`` of ``bem`` does, end that.
    """
    return is_reference(result.kind) and not is_modified(result.kind, result.attributes)


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
        each experiment without ``screening``.
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
        the pressures differ. ``area_at_separation_agrees_from_10``, …,
        ``area_at_separation_factor`` and the same of the stiffness compare at equal mean
        separation (see :mod:`roughbench.fits.comparisons`), whatever the pressures. What
        rests on a quantity that a model lacks is :data:`NOT_GIVEN`. Pressures are p/E*, also
        of results with units; their lengths are in m.

    Raises
    ------
    StoreError
        If no model has the label ``reference``.
    ValueError
        If there are fewer than two resamples.
    """
    return {
        experiment: {
            label: one.estimates
            for label, one in fit_models(
                models,
                reference=reference_of(dict(models), reference),
                resamples=resamples,
                seed=seed,
            ).items()
        }
        for experiment, models in results.items()
    }


@dataclass(frozen=True, slots=True)
class FittedModel:
    """What one model's curves say in numbers.

    Attributes
    ----------
    estimates : dict of str to Estimate
        By name, as :func:`fit` describes them.
    deviations : mapping of str to Deviations
        From the reference, by quantity; empty for the reference itself, and where the
        pressures differ.
    """

    estimates: dict[str, Estimate]
    deviations: Mapping[str, Deviations] = field(default_factory=dict)


def fit_models(
    models: Mapping[str, ModelResult],
    *,
    reference: str | None,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> dict[str, FittedModel]:
    """Fit the models of one experiment, and compare them with one of them.

    Parameters
    ----------
    models : mapping of str to ModelResult
    reference : str or None
        Label of the one that the others are held against; None: of none.
    resamples, seed : int
        As in :func:`fit`.

    Raises
    ------
    ValueError
        If there are fewer than two resamples.
    """
    if resamples < 2:
        raise ValueError(f"an error needs at least 2 resamples, got {resamples}")
    averages = {label: Averages(result, resamples, seed) for label, result in models.items()}
    chosen = averages[reference] if reference is not None else None
    return {label: _fit_model(one, chosen) for label, one in averages.items()}


def _fit_model(one: Averages, reference: Averages | None) -> FittedModel:
    laws = fit_laws(one.pressure, one.means, dict(one.result.attributes), one.height[:, 0])
    found = {
        name: estimate(*values, bound="≤" if "_from" in name else "≥", count=one.count)
        if one.given.issuperset(needs(name))
        else NOT_GIVEN
        for name, values in laws.items()
    }
    if reference is None or reference is one:
        return FittedModel(found)
    return FittedModel(found | compare(one, reference), deviations(one, reference))


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
    one, other = (Averages(model, resamples, seed) for model in (result, reference))
    return compare_factors(one, other)
