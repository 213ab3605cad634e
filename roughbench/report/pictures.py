"""Pictures that stand inside the page: PNG of levels, in a palette of colours."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Palette = Sequence[tuple[float, str]]
"""Places from 0 to 1 and their colours, ``#RRGGBB``; in between they are mixed."""

MOST_POINTS = 256
"""Points of a map per side; finer fields are averaged over squares."""
STEPS = 63
"""Steps of colour: as many as an eye tells apart, and half of the bytes of 255."""


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


def picture(pixels: NDArray[np.uint8], palette: Palette) -> bytes:
    """Return a PNG of levels, in the colours of a palette; the first row is below."""
    rows, columns = pixels.shape
    head = struct.pack(">IIBBBBB", columns, rows, 8, 3, 0, 0, 0)  # 8 bits, with a palette
    lines = np.concatenate([np.zeros((rows, 1), np.uint8), pixels[::-1]], axis=1)  # no filter
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in (
            (b"IHDR", head),
            (b"PLTE", _colours(palette).tobytes()),
            (b"IDAT", zlib.compress(lines.tobytes(), 9)),
            (b"IEND", b""),
        )
    )


def address(image: bytes) -> str:
    """Return a PNG as an address that holds all of it."""
    return f"data:image/png;base64,{base64.b64encode(image).decode('ascii')}"


def _colours(palette: Palette) -> NDArray[np.uint8]:
    places = [place for place, _ in palette]
    steps = np.linspace(0.0, 1.0, STEPS + 1)
    channels = [
        np.interp(steps, places, [int(colour[i : i + 2], 16) for _, colour in palette])
        for i in (1, 3, 5)
    ]
    return np.stack(channels, axis=1).round().astype(np.uint8)
