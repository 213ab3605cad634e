"""Maps of the contact pressure in single states, as pictures that stand inside the page."""

from __future__ import annotations

import base64
import itertools
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.report.numbers import number
from roughbench.report.sources import ReportSource
from roughbench.report.text import RichText, Span, joined
from roughbench.results import ModelResult

FloatArray = NDArray[np.float64]

MOST_MAPS = 12
MOST_POINTS = 256
"""Points of a map per side; finer fields are averaged over squares."""
COLOURS = ((0.0, "#ffffff"), (0.016, "#dce9c8"), (0.35, "#56b48a"), (1.0, "#1d2a5e"))
"""From no pressure to E*ξ and above it."""
STEPS = 63
"""Steps of colour: as many as an eye tells apart, and half of the bytes of 255."""


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
        return f"data:image/png;base64,{base64.b64encode(self.image).decode('ascii')}"


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
        parts.append([Span(f"p/E* = {number(float(result['field_nominal_pressure'][k]))}")])
    if "field_realization" in result:
        parts.append([Span(f"realization {int(result['field_realization'][k])}")])
    title = source.title(result.label)
    slope = float(result.attributes["rms_slope"])
    return FieldMap(
        joined(parts),
        f"Map of the contact pressure of {title}, {experiment}, {source.name}",
        picture(levels(coarse(np.atleast_2d(pressure / slope)))),
        result.label,
        experiment,
        pressure.ndim == 1,
    )


def coarse(field: FloatArray) -> FloatArray:
    """Return the field with at most MOST_POINTS points per side, averaged over squares."""
    for axis in (0, 1):
        factor = -(-field.shape[axis] // MOST_POINTS)
        if factor > 1:
            cut = field.shape[axis] // factor * factor
            parts = np.moveaxis(field, axis, 0)[:cut]
            field = np.moveaxis(parts.reshape(-1, factor, parts.shape[1]).mean(axis=1), 0, axis)
    return field


def levels(field: FloatArray) -> NDArray[np.uint8]:
    """Return values from 0 to 1 as whole numbers up to STEPS; whatever touches is not 0."""
    steps = np.ceil(STEPS * np.clip(np.nan_to_num(field), 0.0, 1.0))
    return steps.astype(np.uint8)


def picture(pixels: NDArray[np.uint8]) -> bytes:
    """Return a PNG of levels, in the colours of :data:`COLOURS`; the first row is below."""
    rows, columns = pixels.shape
    head = struct.pack(">IIBBBBB", columns, rows, 8, 3, 0, 0, 0)  # 8 bits, with a palette
    lines = np.concatenate([np.zeros((rows, 1), np.uint8), pixels[::-1]], axis=1)  # no filter
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in (
            (b"IHDR", head),
            (b"PLTE", _palette().tobytes()),
            (b"IDAT", zlib.compress(lines.tobytes(), 9)),
            (b"IEND", b""),
        )
    )


def _palette() -> NDArray[np.uint8]:
    places = [place for place, _ in COLOURS]
    steps = np.linspace(0.0, 1.0, STEPS + 1)
    channels = [
        np.interp(steps, places, [int(colour[i : i + 2], 16) for _, colour in COLOURS])
        for i in (1, 3, 5)
    ]
    return np.stack(channels, axis=1).round().astype(np.uint8)
