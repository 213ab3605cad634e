"""Results of two runs in one figure: models that were computed apart, on the same surfaces."""

from __future__ import annotations

from dataclasses import replace

from roughbench.errors import StoreError
from roughbench.results import ModelResult, Results

_SURFACE = ("hurst", "q_min", "q_rolloff", "q_max", "below_rolloff", "rms_slope", "length")
"""Attributes that say which surfaces a model was computed for; seeds may differ."""


def join(results: Results, others: Results) -> Results:
    """Return results with the models of others that were computed for the same surfaces.

    Parameters
    ----------
    results : Results
    others : Results
        Its experiments may have other names, pressures, seeds and numbers of realizations.

    Raises
    ------
    StoreError
        If one has units and the other not, no surfaces are the same, or a model of the same
        label is there already.
    """
    if results.has_units != others.has_units:
        raise StoreError("one of the results has units and the other has none")
    experiments = {name: dict(models) for name, models in results.experiments.items()}
    found = False
    for name, models in experiments.items():
        surface = next((_surface(one) for one in models.values()), None)
        for _, other in others.models():
            if surface is None or _surface(other) != surface:
                continue
            if other.label in models:
                raise StoreError(
                    f"{name} has a model {other.label!r} already; give one of the two another "
                    "`label` in its spec"
                )
            models[other.label] = other
            found = True
    if not found:
        raise StoreError(
            f"the results of {others.name or 'the other run'} are of other surfaces: "
            f"none has the same {', '.join(_SURFACE)}"
        )
    return replace(results, experiments=experiments)


def _surface(result: ModelResult) -> tuple[object, ...] | None:
    """Return what surfaces a model was computed for, without rounding; None of heights."""
    if any(name not in result.attributes for name in _SURFACE):
        return None
    known = (result.attributes[name] for name in _SURFACE)
    return tuple(float(f"{one:.9g}") if isinstance(one, float) else one for one in known)
