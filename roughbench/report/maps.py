"""Maps of the contact pressure in single states, as pictures that stand inside the page."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from roughbench.report.pictures import address, coarse, levels, picture
from roughbench.report.sources import ReportSource
from roughbench.report.text import RichText, Span, joined, pressure_words
from roughbench.results import ModelResult

MOST_MAPS = 12
COLOURS = ((0.0, "#ffffff"), (0.016, "#dce9c8"), (0.35, "#56b48a"), (1.0, "#1d2a5e"))
"""From no pressure to E*ξ and above it."""


@dataclass(frozen=True, slots=True)
class FieldMap:
    """The contact pressure of one state, as a PNG; of a line, a stripe.

    The label stands in place of the picture; by model and experiment, the page's script finds
    it.
    """

    title: RichText
    label: str
    image: bytes
    model: str
    experiment: str
    is_line: bool

    @property
    def address(self) -> str:
        """The picture as an address that holds all of it."""
        return address(self.image)


def _kept(source: ReportSource) -> Iterator[tuple[str, ModelResult, int]]:
    """Yield experiment, result and index of every field that is kept in the file."""
    for experiment, result in source.models():
        if "field_pressure" in result:
            yield from ((experiment, result, k) for k in range(len(result["field_pressure"])))


def n_fields(source: ReportSource) -> int:
    """Return how many fields are kept in the file."""
    return len(list(_kept(source)))


def field_maps(source: ReportSource) -> list[FieldMap]:
    """Return maps of the fields that are kept in the file, the first of them."""
    return [_map(source, *field) for field in itertools.islice(_kept(source), MOST_MAPS)]


def _map(source: ReportSource, experiment: str, result: ModelResult, k: int) -> FieldMap:
    pressure = np.asarray(result["field_pressure"][k], float)
    parts = [source.curve_name(experiment, result.label)]
    if "field_nominal_pressure" in result:
        parts.append([Span(pressure_words(result, float(result["field_nominal_pressure"][k])))])
    if "field_realization" in result:
        parts.append([Span(f"realization {int(result['field_realization'][k])}")])
    title = source.title(result.label)
    slope = float(result.attributes["rms_slope"]) * (result.modulus or 1.0)
    return FieldMap(
        joined(parts),
        f"Map of the contact pressure of {title}, {experiment}, {source.name}",
        picture(levels(coarse(np.atleast_2d(pressure / slope))), COLOURS),
        result.label,
        experiment,
        pressure.ndim == 1,
    )
