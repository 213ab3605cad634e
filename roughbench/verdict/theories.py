"""The theory's own K ∼ p: each theory once, however many experiments and labels have it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from roughbench.fits import MISSING, Estimate
from roughbench.results import ModelResult
from roughbench.verdict.experiments import models_of
from roughbench.verdict.measures import (
    Experiments,
    Kinds,
    Measure,
    Reading,
    has_the_papers_size,
    has_the_rolloff,
    is_as_published,
    reading,
)

_OF_SAMPLES = ("seed", "amplitude")
"""Attributes of surfaces that a theory, which knows their spectrum, does not depend on."""
_MOST = 3


def theory_fitted(name: str, what: str, *, except_of: str, remedy: str) -> Measure:
    """Return the measure of a fitted number of theories as published, with the roll-off.

    A theory with the same spectrum, options and pressures in several experiments, or under
    several labels, is one: its number is said of the first, and the note names the others.
    The note also names what is left out, those with other options than the paper's.

    Parameters
    ----------
    name, what : str
        Of the fit, and in words.
    except_of : str
        Why those of another cut-off than the paper's do not count.
    remedy : str
    """

    def measure(experiments: Experiments, kinds: Kinds, _resamples: int) -> Iterator[Reading]:
        places: dict[tuple[object, ...], list[str]] = {}
        first: dict[tuple[object, ...], Reading] = {}
        other: list[str] = []
        for experiment, model, fits in models_of(experiments, kinds):
            if name not in fits or not has_the_rolloff(model):
                continue
            if not is_as_published(model):
                other.append(experiment.where(model))
                continue
            known = has_the_papers_size(model)
            estimate: Estimate = fits[name] if known else MISSING
            more = {} if known else {"missing": except_of}
            key = _identity(model)
            first.setdefault(
                key, reading(experiment, model, what, estimate, remedy=remedy, **more)
            )
            places.setdefault(key, []).append(experiment.where(model))
        for key, found in first.items():
            yield replace(found, note=_note(places[key][1:], other))

    return measure


def _identity(model: ModelResult) -> tuple[object, ...]:
    """Return all that the curves of a theory depend on."""
    options = (
        (name, str(value))
        for name, value in model.attributes.items()
        if name not in _OF_SAMPLES
    )
    return (model.kind, *sorted(options), model["pressure"].tobytes())


def _note(same: Sequence[str], other: Sequence[str]) -> str:
    parts = []
    if same:
        parts.append(f"the same theory as {_names(same)}, counted once")
    if other:
        parts.append(f"not counted, with other options than the paper's: {_names(other)}")
    return "; ".join(parts)


def _names(places: Sequence[str]) -> str:
    shown = ", ".join(places[:_MOST])
    return shown if len(places) <= _MOST else f"{shown} and {len(places) - _MOST} more"
