"""The surfaces behind the results, from the spec that the results carry."""

from __future__ import annotations

from roughbench.errors import SpecError
from roughbench.results import Results
from roughbench.spec import SelfAffineSurface, Spec, parse_spec

Experiment = tuple[str, SelfAffineSurface, Spec]


def spec_fault(results: Results) -> str | None:
    """Return what is wrong with the spec in the results, in words of what is needed."""
    try:
        parse_spec(results.spec_text, outside=results.outside_kinds)
    except SpecError as error:
        return f"the results' spec, which cannot be read: {error.faults[0]}"
    return None


def self_affine_experiments(results: Results) -> list[Experiment]:
    """Return name, surface and spec of the experiments whose surface has a spectrum.

    Raises
    ------
    SpecError
        If the spec cannot be read (see :func:`spec_fault`).
    """
    return [
        (name, spec.surface, spec)
        for name, spec in parse_spec(
            results.spec_text, outside=results.outside_kinds
        ).experiments()
        if isinstance(spec.surface, SelfAffineSurface) and name in results
    ]
