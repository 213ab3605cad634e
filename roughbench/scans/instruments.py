"""Formats of instruments, read by SurfaceTopography: the only module that imports it."""

from __future__ import annotations

import contextlib
import io
import logging
import math
import re
import warnings
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from roughbench import memory
from roughbench.errors import SurfaceError
from roughbench.scans.image import Channel, Image, choose, held
from roughbench.scans.lengths import in_metres
from roughbench.text import on_one_line

COMMAND = "pip install 'roughbench[scan]'"
"""What adds the readers."""

_BUILT_IN = {"npy": ".npy", "npz": ".npz", "h5": ".h5", "asc": ".txt", "xyz": ".xyz"}
"""Formats of SurfaceTopography that roughbench reads itself, and how to name such a file."""
_BY_NAME = frozenset({"hgt", "nms"})
"""Formats without any mark, which any file of a fitting length has: only by their suffix."""
_BYTES_PER_POINT = 40
"""While a file is read: its own numbers, a mask, scaled and turned as float64."""
_MOST_SAID = 300


@dataclass(slots=True)
class _Said:
    """What the library said, by warnings and log messages."""

    lines: list[str] = field(default_factory=list)

    def add(self, text: object) -> None:
        line = _one_line(text)
        if line and line not in self.lines:
            self.lines.append(line)


def read_instrument(path: Path, name: str, channel: str | None) -> Image:
    """Return the named channel of an instrument's file, or the first that holds heights.

    Raises
    ------
    SurfaceError
        Without SurfaceTopography: with the command that adds it. For files that it cannot
        read, with what it says about them.
    """
    said = _Said()
    # Files that a reader leaves open when it fails are closed here.
    with _listening(said), path.open("rb") as file:
        reader = _open(path, file, name)
        try:
            image = _image(reader, name, channel)
        except SurfaceError:
            raise
        except Exception as error:  # whatever a library raises at a damaged file
            raise SurfaceError(
                f"{name}: damaged, or of a kind that cannot be read: {_one_line(error)}"
            ) from error
        finally:
            reader.close()
    return Image(
        image.values,
        image.unit,
        image.size,
        image.channel,
        image.notes + tuple(f"SurfaceTopography: {line}" for line in said.lines),
    )


def _open(path: Path, file: BinaryIO, name: str) -> Any:
    """Return SurfaceTopography's reader of the file."""
    try:
        from SurfaceTopography import IO
    except ImportError as error:
        suffix = on_one_line(path.suffix.lower()) or "such"
        raise SurfaceError(
            f"{name}: to read {suffix} files of instruments, add their readers: {COMMAND}"
        ) from error
    _check_size(path, name)
    try:
        reader = IO.open_topography(file)
    except Exception as error:
        raise SurfaceError(f"{name}: {_why_not(IO, path, file, error)}") from error
    kind = str(reader.format())
    suffix = path.suffix.lower()
    if kind in _BUILT_IN:
        reader.close()
        raise SurfaceError(
            f"{name}: the file is no instrument's, but of the kind {_BUILT_IN[kind]}; rename it"
        )
    if kind in _BY_NAME and suffix != f".{kind}":
        reader.close()
        raise SurfaceError(
            f"{name}: a foreign or damaged file: no mark of a topography in it; a .{kind} "
            "file, which has none, must be named so"
        )
    return reader


def _check_size(path: Path, name: str) -> None:
    """Refuse archives that grow beyond the memory when they are unpacked."""
    size = path.stat().st_size
    with contextlib.suppress(zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as archive:
                size = max(size, sum(entry.file_size for entry in archive.infolist()))
    memory.check(
        2 * size,
        f"{name}: to read {memory.gigabytes(size)} takes {memory.gigabytes(2 * size)}",
        lambda room: f"{memory.gigabytes(room / 2)} would fit: take a smaller part",
        SurfaceError,
    )


def _why_not(library: Any, path: Path, file: BinaryIO, error: Exception) -> str:
    """Say what the reader of this suffix says; of all readers otherwise, that none fits."""
    suffix = path.suffix.lower().lstrip(".")
    fitting = [kind for kind in library.readers if suffix in (kind.file_extensions() or ())]
    for kind in fitting:
        file.seek(0)
        try:
            kind(file).close()
        except Exception as its_error:
            return (
                f"damaged, or no {kind.name()} file as its suffix says: {_one_line(its_error)}"
            )
    if isinstance(error, library.CannotDetectFileFormat):
        return "of no kind that can be read: SurfaceTopography knows no such file"
    return f"cannot be read: {_one_line(error)}"


def _image(reader: Any, name: str, wanted: str | None) -> Image:
    """Read the channel that is wanted, in the file's unit, rows along y."""
    infos = list(reader.channels)
    channels = [_channel(info) for info in infos]
    place = choose(channels, wanted, name)
    info = infos[place]
    if info.dim != 2 or info.nb_grid_pts is None or len(info.nb_grid_pts) != 2:
        raise SurfaceError(
            f"{name}: channel {channels[place]} is a line scan, no map; {held(channels)}"
        )
    n_points = math.prod(info.nb_grid_pts)
    memory.check(
        _BYTES_PER_POINT * n_points,
        f"{name}: to read {n_points} points takes "
        f"{memory.gigabytes(_BYTES_PER_POINT * n_points)}",
        lambda room: f"{room // _BYTES_PER_POINT} would fit: take a coarser or smaller part",
        SurfaceError,
    )
    given: dict[str, Any] = {}
    if info.physical_sizes is None:
        given["physical_sizes"] = tuple(map(float, info.nb_grid_pts))
    topography = reader.topography(channel_index=info.index, **given)
    heights = topography.heights()  # (nx, ny), the first row of the image at y = 0
    missing = np.ma.getmaskarray(heights).T if np.ma.isMaskedArray(heights) else None
    values = np.array(np.ma.getdata(heights).T, np.float64, order="C")
    if missing is not None:
        values[missing] = np.nan
    if values.shape != (info.nb_grid_pts[1], info.nb_grid_pts[0]):
        raise SurfaceError(
            f"{name}: {values.shape} rows and columns were read, the file says "
            f"{info.nb_grid_pts[::-1]}; it is damaged"
        )
    unit = in_metres(str(topography.unit)) if topography.unit is not None else None
    notes: tuple[str, ...] = ()
    size = None
    if info.physical_sizes is not None:
        width, height = (float(side) for side in topography.physical_sizes)
        if unit is not None:
            size = (height * unit, width * unit)
        else:
            notes = (f"the file says {width:g} by {height:g} without a unit",)
    return Image(values, unit, size, channels[place].name, notes)


def _channel(info: Any) -> Channel:
    """Describe a channel; one with two units, or one that is no length, is no heights."""
    unit = info.data_unit
    if not isinstance(unit, str | None) or not isinstance(info.unit, str | None):
        return Channel(str(info.channel_id), "unknown unit", is_height=False)
    is_length = unit is None or in_metres(unit) is not None
    is_height = bool(info.is_height_channel) and info.dim == 2 and is_length
    return Channel(str(info.channel_id), unit or "", is_height)


class _Handler(logging.Handler):
    def __init__(self, said: _Said) -> None:
        super().__init__(logging.WARNING)
        self._said = said

    def emit(self, record: logging.LogRecord) -> None:
        self._said.add(record.getMessage())


@contextlib.contextmanager
def _listening(said: _Said) -> Iterator[None]:
    """Keep what the library says off the terminal; its doubts about the file are kept."""
    handler, loggers = _Handler(said), [logging.getLogger(n) for n in _LOGGERS]
    before = [logger.propagate for logger in loggers]
    with warnings.catch_warnings(record=True) as caught, np.errstate(all="ignore"):
        warnings.simplefilter("always")
        for logger in loggers:
            logger.addHandler(handler)
            logger.propagate = False
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                yield
        finally:
            for logger, propagate in zip(loggers, before, strict=True):
                logger.removeHandler(handler)
                logger.propagate = propagate
            for warning in caught:
                if not issubclass(warning.category, _OF_THE_CODE):
                    said.add(warning.message)


_LOGGERS = ("SurfaceTopography", "tifffile", "igor2", "NuMPI")
_OF_THE_CODE = (
    *(DeprecationWarning, PendingDeprecationWarning, FutureWarning),
    *(ImportWarning, ResourceWarning),
)
"""Warnings about programs, not about a file."""


def _one_line(text: object) -> str:
    """Return what a library says as one short line, without names of its own code."""
    line = re.sub(r"\s+", " ", str(text)).strip()
    if isinstance(text, KeyError):
        line = f"no {line} in it"
    if not line and isinstance(text, BaseException):
        line = type(text).__name__
    if len(line) > _MOST_SAID:
        line = line[: _MOST_SAID - 1] + "…"
    return on_one_line(line)
