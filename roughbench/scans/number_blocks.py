"""A text file, piece by piece, as blocks of numbers and the lines above them."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass, field
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from roughbench import memory
from roughbench.errors import SurfaceError
from roughbench.scans.number_text import (
    NUMBER,
    decoded,
    filled,
    is_data,
    is_numeric,
    parsed,
    pieces,
    spelled,
)
from roughbench.text import on_one_line

FloatArray = NDArray[np.float64]

_SAMPLE = 1 << 16
"""Bytes that the separators are looked for in."""
_MOST_HEADER = 10_000
"""Lines."""


@dataclass(slots=True)
class NumberBlock:
    """Numbers that follow each other, and what stands above them."""

    header: list[str]
    parts: list[FloatArray] = field(default_factory=list)
    n_columns: int = 0


class NumberReader:
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
        self._blocks: list[NumberBlock] = []

    def read(self, file: BinaryIO) -> list[NumberBlock]:
        """Return the blocks, in the order of the file."""
        for piece in pieces(file, self._name):
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
                if is_data(spelled(piece[start:end], thoroughly=True)):
                    break
                self._take_header(piece[start:end])
                start = end
            piece = piece[start:]
        words = spelled(piece)
        if is_numeric(words):
            self._take_numbers(words)
            return
        run: list[bytes] = []
        for line in words.splitlines(keepends=True):
            if is_data(spelled(line, thoroughly=True)):
                run.append(line)
                continue
            self._take_numbers(b"".join(run))
            run.clear()
            self._take_header(line)
        self._take_numbers(b"".join(run))

    def _take_header(self, line: bytes) -> None:
        self._line += 1
        text = decoded(line).strip()
        if not text:
            return
        tokens = re.split(rb"[\s;,]+", line.strip())
        if self._blocks and not text.startswith(("#", "%", '"', "//")):
            n_numbers = sum(NUMBER.fullmatch(token) is not None for token in tokens)
            if 2 * n_numbers >= len(tokens):
                wrong = next(t for t in tokens if not NUMBER.fullmatch(t))
                raise self._fault(f"{decoded(wrong)[:40]!r} is no number", self._line)
        if len(self._header) >= _MOST_HEADER:
            raise self._fault("too many lines that are no numbers", self._line)
        self._header.append(text)

    def _take_numbers(self, text: bytes) -> None:
        if text.strip():
            if not self._blocks or self._header:
                self._settle_format(text[: text.find(b"\n", _SAMPLE) + 1 or len(text)])
                self._blocks.append(NumberBlock(self._header))
                self._header = []
            self._add(self._blocks[-1], text)
        self._line += text.count(b"\n")

    def _add(self, block: NumberBlock, text: bytes) -> None:
        """Read lines of numbers as rows of a block."""
        text = self._with_points(text)
        try:
            values = self._values(text)
        except ValueError:
            text = spelled(text, thoroughly=True)
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
            return parsed(text)
        n_signs = text.count(sign)
        with contextlib.suppress(ValueError):
            values = parsed(text.replace(sign, b" "))
            if values.size == n_signs + values.shape[0]:  # no cell is empty
                return values
        text = filled(text, sign)
        n_signs = text.count(sign)
        values = parsed(text.replace(sign, b" "))
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
                f"{self._name}: is {decoded(tokens[0])[:40]} one number or two? Write decimal "
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

    def _bad_line(self, block: NumberBlock, text: bytes) -> SurfaceError:
        """Find the line that is no row of numbers, or none like the others."""
        sign = self._separator
        if sign != b" ":
            text = filled(text, sign)
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
                if not NUMBER.fullmatch(token) and token.lower().lstrip(b"+-") != b"nan":
                    return self._fault(f"{decoded(token)[:40]!r} is no number", place)
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
