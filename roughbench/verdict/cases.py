"""The experiments that claims are tested on, with their fits, and pairs of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from roughbench.errors import StoreError
from roughbench.fits import Estimate, fit, reference_of
from roughbench.results import ModelResult, Results

Source = tuple[str, Results]
"""A name, such as that of the file, and its results."""

_SPECTRUM = ("hurst", "q_min", "q_rolloff", "q_max", "below_rolloff", "rms_slope", "length")
_SAMPLE = ("amplitude", "seed")


@dataclass(frozen=True, slots=True)
class Case:
    """One experiment.

    Attributes
    ----------
    source, experiment : str
        Where it comes from.
    place : str
        Experiment, after its source where there are several.
    models : mapping of str to ModelResult
    fits : mapping of str to mapping of str to Estimate
        By label and name.
    reference : str or None
        Label of the exact solution.
    """

    source: str
    experiment: str
    place: str
    models: Mapping[str, ModelResult]
    fits: Mapping[str, Mapping[str, Estimate]]
    reference: str | None

    @property
    def exact(self) -> ModelResult | None:
        """The exact solution."""
        return None if self.reference is None else self.models[self.reference]

    def of_kind(self, *kinds: str) -> Iterator[ModelResult]:
        """Yield the models of some kinds but the reference; ``reference`` is it alone."""
        for label, model in self.models.items():
            if ("reference" in kinds) if label == self.reference else (model.kind in kinds):
                yield model

    def where(self, model: ModelResult) -> str:
        """Say which model of which experiment."""
        return f"{self.place}/{model.label}"


def cases_of(sources: Sequence[Source], reference: str | None, resamples: int) -> list[Case]:
    """Fit every experiment of some results.

    Parameters
    ----------
    sources : sequence of (str, Results)
    reference : str or None
        Label of the model that is taken for exact; default, and where there is none of
        this label: the first ``bem``.
    resamples : int

    Returns
    -------
    list of Case

    Raises
    ------
    StoreError
        If no results have a model of this label.
    """
    cases = []
    for name, results in sources:
        for experiment, models in results.items():
            known = reference is None or reference in models
            label = reference_of(dict(models), reference if known else None)
            alone = Results({experiment: models}, results.spec_text, results.spec_sha256)
            fits = fit(alone, reference=label, resamples=resamples)[experiment]
            place = experiment if len(sources) == 1 else f"{name}: {experiment}"
            cases.append(Case(name, experiment, place, dict(models), fits, label))
    labels = dict.fromkeys(label for case in cases for label in case.models)
    if reference is not None and reference not in labels:
        raise StoreError(f"no model is named {reference!r}; choose one of {', '.join(labels)}")
    return cases


def alike_but(cases: Sequence[Case], name: str) -> list[list[Case]]:
    """Return groups of cases whose exact surfaces differ in one property alone.

    Parameters
    ----------
    cases : sequence of Case
    name : str
        Attribute of the results: ``length``, ``q_rolloff`` or ``below_rolloff``.

    Returns
    -------
    list of list of Case
        In the order of rising values; each group holds at least two values. Equal
        pressures, seeds and points on the shortest wave go without saying.
    """
    groups: dict[tuple[object, ...], dict[object, Case]] = {}
    for case in cases:
        exact = case.exact
        if exact is None or any(key not in exact.attributes for key in _SPECTRUM):
            continue
        key = (
            *(_same(exact.attributes[other]) for other in _SPECTRUM if other != name),
            *(exact.attributes.get(other) for other in _SAMPLE),
            exact["pressure"].tobytes(),
            _same(
                float(exact.attributes.get("grid_points", 0))
                / float(exact.attributes["length"])
            ),
        )
        groups.setdefault(key, {}).setdefault(exact.attributes[name], case)
    return [
        [group[value] for value in sorted(group, key=_order)]
        for group in groups.values()
        if len(group) > 1
    ]


def _same(value: object) -> object:
    """Return a property without the rounding errors that it came with."""
    return float(f"{value:.9g}") if isinstance(value, float) else value


def _order(value: object) -> tuple[float, str]:
    return (float(value), "") if isinstance(value, int | float) else (0.0, str(value))
