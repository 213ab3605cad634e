"""Maps of the contact pressure in single states, as pictures that stand inside the page."""

from __future__ import annotations

import base64
import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.report.markup import escape, number
from roughbench.report.sources import Source
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
class Map:
    """The contact pressure of one state.

    Attributes
    ----------
    title : str
        HTML.
    label : str
        Plain text in place of the picture.
    image : bytes
        PNG.
    model, experiment : str
        By which the page's script finds it.
    is_line : bool
        Whether it is a stripe.
    """

    title: str
    label: str
    image: bytes
    model: str
    experiment: str
    is_line: bool

    @property
    def address(self) -> str:
        """The picture as an address that holds all of it."""
        return f"data:image/png;base64,{base64.b64encode(self.image).decode('ascii')}"


def field_maps(source: Source) -> list[Map]:
    """Return maps of the fields that are kept in the file, the first of them."""
    maps: list[Map] = []
    for experiment, result in source.models():
        if "field_pressure" not in result:
            continue
        slope = float(result.attributes["rms_slope"])
        for k, field in enumerate(np.asarray(result["field_pressure"], float)):
            if len(maps) < MOST_MAPS:
                maps.append(_map(source, experiment, result, k, field / slope))
    return maps


def n_fields(source: Source) -> int:
    """Return how many fields are kept in the file."""
    return sum(
        len(result["field_pressure"])
        for _, result in source.models()
        if "field_pressure" in result
    )


def _map(
    source: Source, experiment: str, result: ModelResult, k: int, pressure: FloatArray
) -> Map:
    name = source.title(result.label)
    parts = [escape(name)]
    if len(source.results) > 1:
        parts.append(source.experiment(experiment))
    if "field_nominal_pressure" in result:
        parts.append(f"p/E* = {number(float(result['field_nominal_pressure'][k]))}")
    if "field_realization" in result:
        parts.append(f"realization {int(result['field_realization'][k])}")
    return Map(
        ", ".join(parts),
        f"Map of the contact pressure of {name}, {experiment}, {source.name}",
        picture(levels(coarse(np.atleast_2d(pressure)))),
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
    """Return a PNG of levels, in the colours of :data:`COLOURS`; the first row is below.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (n, m)

    Returns
    -------
    bytes
    """
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
