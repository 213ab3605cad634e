"""The experiments that claims are tested on, with their fits, and groups of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from roughbench.errors import StoreError
from roughbench.fits import Deviations, Estimate, fit_models, reference_of
from roughbench.models.registry import is_modified
from roughbench.results import ModelResult, Results

EXACT = ("exact",)
"""Instead of kinds of models: the model that is taken for exact, whatever its kind."""
_SPECTRUM = ("hurst", "q_min", "q_rolloff", "q_max", "below_rolloff", "rms_slope", "length")
_SAMPLE = ("amplitude", "seed")


@dataclass(frozen=True, slots=True)
class FittedExperiment:
    """An experiment with the fits of its models.

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
    deviations : mapping of str to mapping of str to Deviations
        From it, by label and quantity.
    modulus : float or None
        E*, Pa, of results with units, whose models stand here without.
    """

    source: str
    experiment: str
    place: str
    models: Mapping[str, ModelResult]
    fits: Mapping[str, Mapping[str, Estimate]]
    reference: str | None
    deviations: Mapping[str, Mapping[str, Deviations]] = field(default_factory=dict)
    modulus: float | None = None

    @property
    def exact(self) -> ModelResult | None:
        """The exact solution."""
        return None if self.reference is None else self.models[self.reference]

    @property
    def contenders(self) -> list[ModelResult]:
        """All models but the exact solution."""
        return [one for label, one in self.models.items() if label != self.reference]

    def of_kinds(self, kinds: Sequence[str]) -> list[ModelResult]:
        """Return the contenders of some kinds, or for :data:`EXACT` the exact solution.

        Without those whose options make another model of them: no claim is about these.
        """
        if kinds == EXACT:
            return [] if self.exact is None else [self.exact]
        return [
            model
            for model in self.contenders
            if model.kind in kinds and not is_modified(model.kind, model.attributes)
        ]

    def where(self, model: ModelResult) -> str:
        """Say which model of which experiment."""
        return f"{self.place}/{model.label}"


def fit_experiments(
    sources: Sequence[tuple[str, Results]], reference: str | None, resamples: int
) -> list[FittedExperiment]:
    """Fit every experiment of some results; those with units become p/E* first.

    Parameters
    ----------
    sources : sequence of (str, Results)
        Each with a name, such as that of its file.
    reference : str or None
        Label of the model that is taken for exact; default, and where there is none of
        this label: the first ``bem`` without ``screening``.
    resamples : int
        Of the bootstrap that the errors come from, at least 2.

    Raises
    ------
    StoreError
        If no results have a model of this label.
    """
    experiments = []
    for name, results in sources:
        for experiment, models in results.reduced().items():
            known = reference is None or reference in models
            label = reference_of(dict(models), reference if known else None)
            kept = dict(models)
            fitted = fit_models(kept, reference=label, resamples=resamples)
            experiments.append(
                FittedExperiment(
                    name,
                    experiment,
                    experiment if len(sources) == 1 else f"{name}: {experiment}",
                    kept,
                    {key: one.estimates for key, one in fitted.items()},
                    label,
                    {key: one.deviations for key, one in fitted.items()},
                    next((one.modulus for one in results[experiment].values()), None),
                )
            )
    labels = dict.fromkeys(label for one in experiments for label in one.models)
    if reference is not None and reference not in labels:
        raise StoreError(f"no model is named {reference!r}; choose one of {', '.join(labels)}")
    return experiments


def models_of(
    experiments: Sequence[FittedExperiment], kinds: Sequence[str]
) -> Iterator[tuple[FittedExperiment, ModelResult, Mapping[str, Estimate]]]:
    """Yield every model of some kinds, with its experiment and its fits."""
    for experiment in experiments:
        for model in experiment.of_kinds(kinds):
            yield experiment, model, experiment.fits[model.label]


def that_differ_in(
    name: str, experiments: Sequence[FittedExperiment]
) -> list[list[tuple[FittedExperiment, ModelResult]]]:
    """Return groups of experiments whose exact surfaces differ in one property alone.

    Parameters
    ----------
    name : str
        Attribute of the results: ``length``, ``q_rolloff`` or ``below_rolloff``.
    experiments : sequence of FittedExperiment

    Returns
    -------
    list of list of (FittedExperiment, ModelResult)
        With their exact solutions, in the order of rising values; each group holds at least
        two values. Pressures, seeds and points on the shortest wave are equal as well.
    """
    groups: dict[tuple[object, ...], dict[object, tuple[FittedExperiment, ModelResult]]] = {}
    for experiment in experiments:
        exact = experiment.exact
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
        group = groups.setdefault(key, {})
        group.setdefault(exact.attributes[name], (experiment, exact))
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
