"""Header lines of topographies that were exported as text: size, units, name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from roughbench.scans.lengths import in_metres


@dataclass(frozen=True, slots=True)
class Header:
    """What the lines above a matrix or list of points say; None where they do not.

    Parameters
    ----------
    width, height : float or None
        Of the image along x and y, in m.
    pixel : (float, float) or None
        Distance of neighbouring points along (y, x), in m.
    unit : str
        Of the heights, in the file's words.
    factor : float
        Heights in that unit per number in the file.
    lateral : (str, str)
        Units of x and y.
    columns, rows : int or None
        Points along x and y.
    channel : str
    """

    width: float | None = None
    height: float | None = None
    pixel: tuple[float, float] | None = None
    unit: str = ""
    factor: float = 1.0
    lateral: tuple[str, str] = ("", "")
    columns: int | None = None
    rows: int | None = None
    channel: str = ""


_NUMBER = r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)"
_LENGTH = rf"{_NUMBER}\s*([^\s\d,;()\[\]]*)"
_IS = r"[\"']?\s*(?:[:=：,;\t]|\s)\s*[\"']?"


def _pattern(names: str, value: str) -> re.Pattern[str]:
    """Match a line that gives one of these names a value, after a comment sign or none."""
    return re.compile(rf"^[\s#%\"'*\\]*(?:{names}){_IS}{value}", re.IGNORECASE)


# The labels of Gwyddion's ASCII matrix in several languages, of SPIP, Nova and others.
_WIDTH = _pattern(
    r"width|breite|largeur|anchura|larghezza|x[- ]length|x[- ]size|size[- ]x|x[- ]range"
    r"|x scan size|scan size x",
    _LENGTH,
)
_HEIGHT = _pattern(
    r"height|höhe|hauteur|altura|altezza|y[- ]length|y[- ]size|size[- ]y|y[- ]range"
    r"|y scan size|scan size y",
    _LENGTH,
)
_SQUARE = _pattern(r"scan[- ]size|image size", _LENGTH + r"[\"'\s]*$")
_PIXEL = _pattern(r"pixel[- ]size|pixel spacing|spacing", _LENGTH + r"[\"'\s]*$")
_PIXEL_X = _pattern(r"scale x|dx|x[- ]spacing|pixel[- ](?:size x|width)|xpixel", _LENGTH)
_PIXEL_Y = _pattern(r"scale y|dy|y[- ]spacing|pixel[- ](?:size y|height)|ypixel", _LENGTH)
_UNIT = _pattern(
    r"value units?|z[- ]units?|height units?|data units?|unit data|unit of heights?|einheiten"
    r"|unités|unità valore|unidades de valor",
    r"([^\s\"',;]*)",
)
_UNIT_X = _pattern(r"x[- ]units?|unit x|lateral units?|xy[- ]units?", r"([^\s\"',;]*)")
_UNIT_Y = _pattern(r"y[- ]units?|unit y|lateral units?|xy[- ]units?", r"([^\s\"',;]*)")
_COLUMNS = _pattern(r"x[- ]pixels|nx|columns|ncols|samples/line", r"(\d+)[\"'\s]*$")
_ROWS = _pattern(r"y[- ]pixels|ny|rows|nrows|lines", r"(\d+)[\"'\s]*$")
_CHANNEL = _pattern(r"channel|kanal|canal|canale|data field", r"(.*?)[\"'\s]*$")
_SPIP = re.compile(r"^#\s*File Format\s*=\s*ASCII\s*$", re.IGNORECASE)
_BIT_TO_NM = _pattern(r"bit2nm", _NUMBER)
_HEADED = re.compile(r"([xyz])\b[^\[\](xyz]*[\[(]([^\])]+)[\])]", re.IGNORECASE)


def parse(lines: Iterable[str], before: Header | None = None) -> Header:
    r"""Return what header lines say, on top of what lines before them said.

    Examples
    --------
    >>> header = parse(["# Channel: ZSensor", "# Width: 2.00 µm", "# Value units: nm"])
    >>> header.channel, header.width, header.unit
    ('ZSensor', 2e-06, 'nm')
    >>> parse(["X [µm];Y [µm];Z [nm]"]).lateral
    ('µm', 'µm')
    """
    found = _HeaderNumbers(before or Header())
    for line in lines:
        found.read(line.rstrip("\r\n"))
    return found.header()


class _HeaderNumbers:
    """Numbers and units as they stand, until all lines are known."""

    def __init__(self, start: Header) -> None:
        self._start = start
        self._lengths: dict[str, tuple[float, str]] = {}
        self._texts: dict[str, str] = {}
        self._counts: dict[str, int] = {}
        self._spip = False
        self._factor: float | None = None

    def read(self, line: str) -> None:
        for key, pattern in (
            *(("width", _WIDTH), ("height", _HEIGHT), ("square", _SQUARE)),
            *(("pixel", _PIXEL), ("pixel x", _PIXEL_X), ("pixel y", _PIXEL_Y)),
        ):
            if match := pattern.match(line):
                self._lengths[key] = (_number(match[1]), match[2])
        for key, pattern in (
            *(("unit", _UNIT), ("x", _UNIT_X), ("y", _UNIT_Y), ("channel", _CHANNEL)),
        ):
            if match := pattern.match(line):
                self._texts[key] = match[1]
        for key, pattern in (("columns", _COLUMNS), ("rows", _ROWS)):
            if match := pattern.match(line):
                self._counts[key] = int(match[1][:9])
        for axis, unit in _HEADED.findall(line):
            self._texts["unit" if axis in "zZ" else axis.lower()] = unit.strip()
        if match := _BIT_TO_NM.match(line):
            self._factor = _number(match[1])
        self._spip = self._spip or bool(_SPIP.match(line))

    def header(self) -> Header:
        start, factor, unit = self._start, self._start.factor, self._texts.get("unit", "")
        otherwise = "nm" if self._spip else ""  # what SPIP means where it does not say it
        if self._spip and not unit and self._factor is not None:
            unit, factor = "nm", self._factor
        x, y = (self._texts.get(axis, "") for axis in "xy")
        x, y = x or y or otherwise, y or x or otherwise
        width, height = self._length("width", x), self._length("height", y)
        square, pixel = self._length("square", x), self._length("pixel", x)
        pixel_x = self._length("pixel x", x) or pixel
        pixel_y = self._length("pixel y", y) or pixel or pixel_x
        return replace(
            start,
            width=width or square or start.width,
            height=height or square or start.height,
            pixel=(pixel_y, pixel_x) if pixel_y and pixel_x else start.pixel,
            unit=unit or start.unit,
            factor=factor,
            lateral=(x, y) if x else start.lateral,
            columns=self._counts.get("columns", start.columns),
            rows=self._counts.get("rows", start.rows),
            channel=self._texts.get("channel", "").strip() or start.channel,
        )

    def _length(self, key: str, unit: str) -> float | None:
        """Return a length in m, in its own unit or in that of its axis."""
        number, own = self._lengths.get(key, (0.0, ""))
        factor = in_metres(own or unit)
        return number * factor if factor is not None and number > 0.0 else None


def _number(text: str) -> float:
    return float(text.replace(",", "."))
