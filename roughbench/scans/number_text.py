"""Lines of numbers as bytes: which they are, and their values, missing ones as nan."""

from __future__ import annotations

import codecs
import io
import re
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError

FloatArray = NDArray[np.float64]

_CHUNK = 1 << 22
UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)

_FEWEST_SIGNS = 3
"""Separators in a line without numbers that is yet a row of a matrix, all of it missing."""
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_MISSING = {
    *(b"bad", b"nan", b"inf", b"infinity", b"infinite", b"n/a", b"na", b"null", b"none"),
    *(b"nodata", b"masked"),
}
"""Words that stand for a missing point."""
_WORD = re.compile(
    rb"[A-DF-Za-df-z][A-Za-z/]*|(?:(?<=[\s;,])|^)[-*?]+(?=[\s;,]|$)", re.MULTILINE
)
_NUMERIC = b"0123456789+-.,;eE \t\n"


def spelled(text: bytes, *, thoroughly: bool = False) -> bytes:
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


def is_numeric(text: bytes) -> bool:
    """Whether there is nothing but numbers, separators and nan."""
    left = text.translate(None, _NUMERIC)
    return left == b"nan" * (len(left) // 3)


def is_data(line: bytes) -> bool:
    """Whether a line consists of numbers and nan, or of empty cells alone."""
    if not is_numeric(line):
        return False
    signs = line.translate(None, b" \n")
    if len(signs) >= _FEWEST_SIGNS and signs == signs[:1] * len(signs) and signs[:1] in b";,\t":
        return True
    tokens = re.split(rb"[\s;,]+", line[:2000].strip())
    if len(line) > 2000:
        tokens.pop()
    tokens = [token for token in tokens if token]
    return bool(tokens) and all(
        token.lstrip(b"+-") == b"nan" or NUMBER.fullmatch(token) for token in tokens
    )


def filled(text: bytes, sign: bytes) -> bytes:
    """Return the text with nan in empty cells."""
    if b" " in text:
        text = re.sub(rb" *(%b|\n) *" % re.escape(sign), rb"\1", text)
    for _ in range(2):  # the second time for every other one of several in a row
        text = text.replace(sign + sign, sign + b"nan" + sign)
    text = text.replace(sign + b"\n", sign + b"nan\n").replace(b"\n" + sign, b"\nnan" + sign)
    return b"nan" + text if text.startswith(sign) else text


def parsed(text: bytes) -> FloatArray:
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


def decoded(text: bytes) -> str:
    """Return text in UTF-8 or an older code."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("cp1252", "replace")


def pieces(file: BinaryIO, name: str) -> Iterator[bytes]:
    """Yield the file in UTF-8 or an older code, in pieces of whole lines that end in LF."""
    head = file.read(4)
    file.seek(0)
    if head.startswith(UTF16):
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
