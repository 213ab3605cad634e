"""Matrices of heights, and lists of points, as text: whatever separates their numbers."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError, explained
from roughbench.heights_file import check_there
from roughbench.scans import headers, points
from roughbench.scans.image import Channel, Image, choose, held
from roughbench.scans.lengths import in_metres
from roughbench.scans.number_blocks import NumberBlock, NumberReader
from roughbench.scans.number_text import UTF16

FloatArray = NDArray[np.float64]
HEAD = 1 << 12
"""Bytes at the beginning of a file that tell text from other things."""
_TEXT = frozenset({".txt", ".csv", ".tsv", ".xyz", ".prn"})
_OFTEN_TEXT = frozenset({".asc", ".dat"})
_FOREIGN = (b"aISO-", b"aBCR-", b"Wyko ASCII", b"X;Y;valid")
"""Beginnings of text files that are no matrices, and have readers of their own."""


def is_table(suffix: str, head: bytes) -> bool:
    """Tell whether a file of this suffix that begins like this is meant as a table."""
    if head.removeprefix(codecs.BOM_UTF8).startswith(_FOREIGN):
        return False
    is_text = not re.search(rb"[\x00-\x08\x0e-\x1f\x7f]", head) or head.startswith(UTF16)
    return suffix in _TEXT or (suffix in _OFTEN_TEXT and is_text)


def read_table(path: Path, name: str, channel: str | None) -> Image:
    """Return the matrix of a text file, or its list of points put on their grid.

    Separated by white space, tabs, semicolons or commas, with points or commas as decimal
    signs; missing points are empty cells or words such as ``nan`` and ``BAD``. Lines that
    are no numbers, and what follows ``#``, are header lines; they may say size and units as
    Gwyddion, SPIP and others write them. Several matrices, each under its own header lines,
    are channels. Three columns are a list of points x, y, height.

    Raises
    ------
    SurfaceError
        With the number of the line that is wrong.
    """
    check_there(path, name)
    try:
        with path.open("rb") as file:
            blocks = NumberReader(name, path.stat().st_size).read(file)
    except OSError as error:
        raise SurfaceError(f"{name}: cannot be read: {explained(error)}") from error
    if not blocks:
        raise SurfaceError(
            f"{name}: no lines of numbers in it; a matrix has one row per line, separated by "
            "white space, tabs, semicolons or commas"
        )
    found = [headers.parse(block.header) for block in blocks]
    channels = [_channel(header, place) for place, header in enumerate(found)]
    if len({entry.name for entry in channels}) < len(channels):
        raise SurfaceError(
            f"{name}: several matrices of one name; {held(channels)}; name them apart, with "
            "lines such as # Channel: height above them"
        )
    place = choose(channels, channel, name)
    header, values = found[place], _values(blocks[place])
    unit = in_metres(header.unit)
    if unit is not None:
        unit *= header.factor
    if path.suffix.lower() == ".xyz" or values.shape[1] == 3:
        return points.on_grid(values, header, unit, name)
    values = _shaped(values, header, name)
    _refuse_coordinates(values, name)
    size = None
    if header.width is not None and header.height is not None:
        size = (header.height, header.width)
    elif header.pixel is not None:
        size = (header.pixel[0] * values.shape[0], header.pixel[1] * values.shape[1])
    return Image(values, unit, size, header.channel)


def _channel(header: headers.Header, place: int) -> Channel:
    is_height = header.unit in ("", "1") or in_metres(header.unit) is not None
    return Channel(header.channel or f"matrix {place + 1}", header.unit, is_height)


def _values(block: NumberBlock) -> FloatArray:
    """Return the numbers of a block, rows by columns."""
    values = block.parts[0] if len(block.parts) == 1 else np.concatenate(block.parts)
    block.parts.clear()
    return values


def _shaped(values: FloatArray, header: headers.Header, name: str) -> FloatArray:
    """Return the matrix in the shape that its header says, if it says one."""
    rows, columns = header.rows or values.shape[0], header.columns or values.shape[1]
    if header.rows and header.columns and rows * columns == values.size:
        return values.reshape(rows, columns)
    if (rows, columns) != values.shape:
        raise SurfaceError(
            f"{name}: its header says {rows} rows and {columns} columns, it has "
            f"{values.shape[0]} and {values.shape[1]}; it is cut short or damaged"
        )
    if columns == 1:
        raise SurfaceError(
            f"{name}: {rows} lines with one number each are no matrix; write one row per line"
        )
    return values


def _refuse_coordinates(values: FloatArray, name: str) -> None:
    """Refuse matrices with coordinates along the top and the left, and an empty corner."""
    if not np.isnan(values[0, 0]) or min(values.shape) < 4:
        return
    steps = [np.diff(edge) for edge in (values[0, 1:], values[1:, 0])]
    if all(
        np.isfinite(s).all() and np.ptp(s) <= 1e-2 * abs(s.mean()) and s.all() for s in steps
    ):
        raise SurfaceError(
            f"{name}: the first row and column look like coordinates (even steps of "
            f"{steps[0].mean():g} and {steps[1].mean():g}, an empty corner); leave them out, "
            "and say the size with size:"
        )
