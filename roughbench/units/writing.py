"""Numbers in SI as texts, with a prefix that fits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass

_PREFIXES = {
    -18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m",
    0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P", 18: "E",
}  # fmt: skip


def prefix(values: Iterable[float], unit: str) -> tuple[float, str]:
    """Return one factor and one prefixed unit for all values of an axis or a column.

    The prefix is chosen so that the median of the magnitudes (zeros, infinities and nan
    aside) lies between 1 and 1000; of stiffnesses, "Pa/m", over the length that keeps the
    numerator's prefix positive: MPa/nm rather than PPa/m.

    Parameters
    ----------
    values : iterable of float
        In ``unit``.
    unit : str
        SI: "m", "m^2", "1/m", "Pa", "Pa/m", "J/m^2", …; any other is returned as it is.

    Returns
    -------
    factor : float
        What the values are multiplied with.
    unit : str
        As pint reads it, such as "nm" or "MPa/nm".

    Examples
    --------
    >>> prefix([0.0, 2e-9, 30e-9], "m"), prefix([1e12, 1e15, 1e18], "Pa/m")
    ((1000000000.0, 'nm'), (1e-15, 'MPa/nm'))
    >>> prefix([4e7], "1/m"), prefix([5e-12], "m^2"), prefix([0.3], "1")
    ((1e-06, '1/µm'), (1000000000000.0, 'µm^2'), (1.0, '1'))
    """
    return _prefix(_typical(values), unit)


def _prefix(size: float, unit: str) -> tuple[float, str]:
    """Return factor and unit for a typical magnitude in SI."""
    found = re.fullmatch(r"(1|J|Pa)/m(?:\^(\d))?|m(?:\^(\d))?|Pa|J", unit)
    if found is None or not size:
        return 1.0, unit
    above, below, power = found[1], int(found[2] or 1), int(found[3] or 1)
    if above == "1":
        exponent = -_thousands(size, below, up=True)
        end = f"^{below}" if below > 1 else ""
        return _factor(exponent * below), f"1/{_PREFIXES[exponent]}m{end}"
    if above == "Pa" and below == 1:
        length = next((n for n in (-9, -6, -3) if _digits(size) >= -n), 0)
        exponent = _thousands(size * 10.0**length)
        return _factor(length - exponent), f"{_PREFIXES[exponent]}Pa/{_PREFIXES[length]}m"
    exponent = _thousands(size, power)
    return _factor(-exponent * power), f"{_PREFIXES[exponent]}{unit}"


def _factor(exponent: int) -> float:
    return float(f"1e{exponent}")  # as it is written, which a power of ten need not be


def _thousands(size: float, power: int = 1, *, up: bool = False) -> int:
    """Return the exponent n of the prefix, a multiple of 3, with 1 ≤ size/10ⁿᵖ < 1000ᵖ.

    ``up``: of the size's inverse rather, 1 ≤ size · 10ⁿᵖ.
    """
    exponent = 3 * math.floor(_digits(size) / (3 * power))
    lowest, highest = min(_PREFIXES), max(_PREFIXES)
    return max(-highest, min(-lowest, exponent)) if up else max(lowest, min(highest, exponent))


def _digits(size: float) -> float:
    return math.log10(size) + 1e-9  # a rounded thousand is a thousand


def _typical(values: Iterable[float]) -> float:
    sizes = sorted(abs(float(v)) for v in values if math.isfinite(v) and v != 0)
    if not sizes:
        return 0.0
    middle = sizes[(len(sizes) - 1) // 2], sizes[len(sizes) // 2]
    return math.sqrt(middle[0]) * math.sqrt(middle[1])


def in_words(value: float, unit: str, digits: int = 3) -> str:
    """Return a value with its unit, prefixed and rounded.

    Parameters
    ----------
    value : float
        In ``unit``.
    unit : str
        As for :func:`prefix`.
    digits : int
        That are shown.

    Examples
    --------
    >>> in_words(12.34e-9, "m"), in_words(999999.6, "Pa"), in_words(0.0, "Pa")
    ('12.3 nm', '1 MPa', '0 Pa')
    >>> in_words(0.25, "1"), in_words(6.28e5, "1/m")
    ('0.25', '628 / mm')
    """
    rounded = float(f"{value:.{digits}g}")
    factor, prefixed = prefix([rounded], unit)
    shown = f"{rounded * factor:.{max(digits, 3)}g}"
    if prefixed.startswith("1/"):
        return f"{shown} / {prefixed[2:]}"
    return shown if prefixed == "1" else f"{shown} {prefixed}"
