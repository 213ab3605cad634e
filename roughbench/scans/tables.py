"""Matrices of heights, and lists of points, as text: whatever separates their numbers."""

from __future__ import annotations

import codecs
import contextlib
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from roughbench import memory
from roughbench.errors import SurfaceError, explained
from roughbench.heights_file import check_there
from roughbench.scans import headers, points
from roughbench.scans.image import Channel, Image, choose, held
from roughbench.scans.lengths import in_metres
from roughbench.text import on_one_line

FloatArray = NDArray[np.float64]

HEAD = 1 << 12
"""Bytes at the beginning of a file that tell text from other things."""
_CHUNK = 1 << 22
_FEWEST_SIGNS = 3
"""Separators in a line without numbers that is yet a row of a matrix, all of it missing."""
_SAMPLE = 1 << 16
"""Bytes that the separators are looked for in."""
_MOST_HEADER = 10_000
"""Lines."""
_TEXT = frozenset({".txt", ".csv", ".tsv", ".xyz", ".prn"})
_OFTEN_TEXT = frozenset({".asc", ".dat"})
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_FOREIGN = (b"aISO-", b"aBCR-", b"Wyko ASCII", b"X;Y;valid")
"""Beginnings of text files that are no matrices, and have readers of their own."""

_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_MISSING = {
    *(b"bad", b"nan", b"inf", b"infinity", b"infinite", b"n/a", b"na", b"null", b"none"),
    *(b"nodata", b"masked"),
}
"""Words that stand for a missing point."""
_WORD = re.compile(
    rb"[A-DF-Za-df-z][A-Za-z/]*|(?:(?<=[\s;,])|^)[-*?]+(?=[\s;,]|$)", re.MULTILINE
)
_NUMERIC = b"0123456789+-.,;eE \t\n"


def is_table(suffix: str, head: bytes) -> bool:
    """Tell whether a file of this suffix that begins like this is meant as a table."""
    if head.removeprefix(codecs.BOM_UTF8).startswith(_FOREIGN):
        return False
    is_text = not re.search(rb"[\x00-\x08\x0e-\x1f\x7f]", head) or head.startswith(_UTF16)
    return suffix in _TEXT or (suffix in _OFTEN_TEXT and is_text)


@dataclass(slots=True)
class _Block:
    """Numbers that follow each other, and what stands above them."""

    header: list[str]
    parts: list[FloatArray] = field(default_factory=list)
    n_columns: int = 0


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
            blocks = _Reader(name, path.stat().st_size).read(file)
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


def _values(block: _Block) -> FloatArray:
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


class _Reader:
    """Reads a file piece by piece into blocks of numbers."""

    def __init__(self, name: str, size: int) -> None:
        self._name, self._size = name, size
        self._line = 0
        """Lines before the present piece."""
        self._separator = b" "
        self._has_decimal_comma = False
        self._has_trailing = False
        """Whether a separator stands at the end of every line."""
        self._header: list[str] = []
        self._blocks: list[_Block] = []

    def read(self, file: BinaryIO) -> list[_Block]:
        for piece in _pieces(file, self._name):
            self._take(piece)
        if self._blocks:  # what is said below the numbers is on them, too
            self._blocks[-1].header.extend(self._header)
        return self._blocks

    def _take(self, piece: bytes) -> None:
        """Take apart lines of headers and lines of numbers."""
        if not self._blocks or self._header:  # headers stand first: look where they end
            start = 0
            while start < len(piece):
                end = piece.find(b"\n", start) + 1
                if _is_data(_spelled(piece[start:end], thoroughly=True)):
                    break
                self._take_header(piece[start:end])
                start = end
            piece = piece[start:]
        words = _spelled(piece)
        if _is_numeric(words):
            self._take_numbers(words)
            return
        run: list[bytes] = []
        for line in words.splitlines(keepends=True):
            if _is_data(_spelled(line, thoroughly=True)):
                run.append(line)
                continue
            self._take_numbers(b"".join(run))
            run.clear()
            self._take_header(line)
        self._take_numbers(b"".join(run))

    def _take_header(self, line: bytes) -> None:
        self._line += 1
        text = _decoded(line).strip()
        if not text:
            return
        tokens = re.split(rb"[\s;,]+", line.strip())
        if self._blocks and not text.startswith(("#", "%", '"', "//")):
            n_numbers = sum(_NUMBER.fullmatch(token) is not None for token in tokens)
            if 2 * n_numbers >= len(tokens):
                wrong = next(t for t in tokens if not _NUMBER.fullmatch(t))
                raise self._fault(f"{_decoded(wrong)[:40]!r} is no number", self._line)
        if len(self._header) >= _MOST_HEADER:
            raise self._fault("too many lines that are no numbers", self._line)
        self._header.append(text)

    def _take_numbers(self, text: bytes) -> None:
        if text.strip():
            if not self._blocks or self._header:
                self._settle_format(text[: text.find(b"\n", _SAMPLE) + 1 or len(text)])
                self._blocks.append(_Block(self._header))
                self._header = []
            self._add(self._blocks[-1], text)
        self._line += text.count(b"\n")

    def _add(self, block: _Block, text: bytes) -> None:
        """Read lines of numbers as rows of a block."""
        text = self._with_points(text)
        try:
            values = self._values(text)
        except ValueError:
            text = _spelled(text, thoroughly=True)
            try:
                values = self._values(text)
            except ValueError:
                raise self._bad_line(block, text) from None
        if not block.parts:
            block.n_columns = values.shape[1]
            self._check_memory(values.size / len(text))
        if values.shape[1] != block.n_columns:
            raise self._bad_line(block, text)
        block.parts.append(values)

    def _values(self, text: bytes) -> FloatArray:
        """Return the numbers of lines; nan in empty cells."""
        sign = self._separator
        if sign == b" ":
            return _parsed(text)
        n_signs = text.count(sign)
        with contextlib.suppress(ValueError):
            values = _parsed(text.replace(sign, b" "))
            if values.size == n_signs + values.shape[0]:  # no cell is empty
                return values
        text = _filled(text, sign)
        n_signs = text.count(sign)
        values = _parsed(text.replace(sign, b" "))
        if values.size != n_signs + values.shape[0]:
            raise ValueError
        return values

    def _with_points(self, text: bytes) -> bytes:
        """Return the text with decimal points, and without a separator after each line."""
        if self._has_decimal_comma:
            text = text.replace(b",", b".")
        if self._has_trailing:
            text = re.sub(rb" +\n", b"\n", text) if b" \n" in text else text
            text = text.replace(self._separator + b"\n", b"\n")
        return text

    def _settle_format(self, sample: bytes) -> None:
        """Find what separates the numbers, and whether commas are decimal signs."""
        self._settle_signs(sample)
        lines = [line.rstrip(b" ") for line in sample.split(b"\n")[:-1]]
        sign = self._separator
        self._has_trailing = sign != b" " and all(line.endswith(sign) for line in lines if line)

    def _settle_signs(self, sample: bytes) -> None:
        self._has_decimal_comma = False
        for separator in (b";", b"\t"):
            if separator in sample:
                self._separator, self._has_decimal_comma = separator, b"," in sample
                return
        if b"," not in sample:
            self._separator = b" "
            return
        tokens = sample.split()
        most = max(token.count(b",") for token in tokens)
        lines = [line for line in sample.splitlines() if line.strip()]
        if b"." in sample or most > 1 or tokens[0].endswith(b","):
            self._separator = b","
        elif len(tokens) > len(lines):  # white space separates, and each has one comma at most
            self._separator, self._has_decimal_comma = b" ", True
        else:
            raise SurfaceError(
                f"{self._name}: is {_decoded(tokens[0])[:40]} one number or two? Write decimal "
                "points, or separate the numbers by semicolons"
            )

    def _check_memory(self, per_byte: float) -> None:
        n_numbers = int(per_byte * self._size)
        memory.check(
            16 * n_numbers,
            f"{self._name}: to read {n_numbers} numbers takes "
            f"{memory.gigabytes(16 * n_numbers)}",
            lambda room: f"{room // 16} would fit: take a coarser or smaller part",
            SurfaceError,
        )

    def _bad_line(self, block: _Block, text: bytes) -> SurfaceError:
        """Find the line that is no row of numbers, or none like the others."""
        sign = self._separator
        if sign != b" ":
            text = _filled(text, sign)
            if re.search(rb"[^\s,;]+ +[^\s,;]", text):
                what = {b"\t": "tabs", b";": "semicolons", b",": "commas"}[sign]
                return SurfaceError(
                    f"{self._name}: numbers are separated by {what} and by blanks, too: are "
                    "there cells missing? Separate them in one way"
                )
            text = text.replace(sign, b" ")
        n_columns = block.n_columns
        for count, line in enumerate(text.splitlines()):
            tokens = line.split()
            place = self._line + count + 1
            for token in tokens:
                if not _NUMBER.fullmatch(token) and token.lower().lstrip(b"+-") != b"nan":
                    return self._fault(f"{_decoded(token)[:40]!r} is no number", place)
            n_columns = n_columns or len(tokens)
            if tokens and len(tokens) != n_columns:
                return self._fault(
                    f"{len(tokens)} numbers, where the lines before have {n_columns}; mark "
                    "header lines with #, complete the line, or delete it",
                    place,
                )
        return self._fault("numbers that cannot be read", self._line + 1)

    def _fault(self, text: str, line: int) -> SurfaceError:
        return SurfaceError(f"{self._name}: line {line}: {on_one_line(text)}")


def _pieces(file: BinaryIO, name: str) -> Iterator[bytes]:
    """Yield the file in UTF-8 or an older code, in pieces of whole lines that end in LF."""
    head = file.read(4)
    file.seek(0)
    if head.startswith(_UTF16):
        try:
            file = io.BytesIO(file.read().decode("utf-16").encode())
        except UnicodeDecodeError as error:
            raise SurfaceError(f"{name}: damaged: it begins as UTF-16 and is none") from error
    elif head.startswith(codecs.BOM_UTF8):
        file.seek(len(codecs.BOM_UTF8))
    while piece := file.read(_CHUNK):
        piece += file.readline()
        if b"\0" in piece:
            raise SurfaceError(
                f"{name}: no text: bytes of zero in it; it is damaged or foreign"
            )
        if b"\r" in piece:
            piece = piece.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        yield piece if piece.endswith(b"\n") else piece + b"\n"


def _spelled(text: bytes, *, thoroughly: bool = False) -> bytes:
    """Return the text with nan for every word that stands for a missing point.

    Signs that stand alone, as in ``1;-;2``, are looked for only ``thoroughly``: it is slow.
    """
    left = text.translate(None, _NUMERIC)
    if not left and not thoroughly:
        return text
    for length in range(2, 6):  # mostly it is one and the same word
        word = left[:length]
        if word.lower() in _MISSING and left == word * (len(left) // length):
            text = text.replace(word, b"nan")
            if not thoroughly:
                return text
            break
    text = re.sub(rb"no data", b"nan", text, flags=re.IGNORECASE) if b"ata" in text else text
    return _WORD.sub(_missing_as_nan, text)


def _missing_as_nan(match: re.Match[bytes]) -> bytes:
    word = match[0]
    is_missing = word[:1] in b"-*?" or word.lower() in _MISSING
    return b"nan" if is_missing else word


def _is_numeric(text: bytes) -> bool:
    """Whether there is nothing but numbers, separators and nan."""
    left = text.translate(None, _NUMERIC)
    return left == b"nan" * (len(left) // 3)


def _is_data(line: bytes) -> bool:
    """Whether a line consists of numbers and nan, or of empty cells alone."""
    if not _is_numeric(line):
        return False
    signs = line.translate(None, b" \n")
    if len(signs) >= _FEWEST_SIGNS and signs == signs[:1] * len(signs) and signs[:1] in b";,\t":
        return True
    tokens = re.split(rb"[\s;,]+", line[:2000].strip())
    if len(line) > 2000:
        tokens.pop()
    tokens = [token for token in tokens if token]
    return bool(tokens) and all(
        token.lstrip(b"+-") == b"nan" or _NUMBER.fullmatch(token) for token in tokens
    )


def _filled(text: bytes, sign: bytes) -> bytes:
    """Return the text with nan in empty cells."""
    if b" " in text:
        text = re.sub(rb" *(%b|\n) *" % re.escape(sign), rb"\1", text)
    for _ in range(2):  # the second time for every other one of several in a row
        text = text.replace(sign + sign, sign + b"nan" + sign)
    text = text.replace(sign + b"\n", sign + b"nan\n").replace(b"\n" + sign, b"\nnan" + sign)
    return b"nan" + text if text.startswith(sign) else text


def _parsed(text: bytes) -> FloatArray:
    """Return the numbers of lines that white space separates, rows by columns.

    np.loadtxt with whole lines is faster here than np.fromstring was, 0.8 s for 2048²
    numbers of eight digits.

    Raises
    ------
    ValueError
        If a word is no number.
    """
    lines = text.decode("ascii", "replace").split("\n")
    with np.errstate(all="ignore"):
        return np.loadtxt(lines, np.float64, comments=None, ndmin=2)


def _decoded(text: bytes) -> str:
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("cp1252", "replace")
