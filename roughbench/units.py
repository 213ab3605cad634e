"""Numbers with units: read into SI, and written with the prefix that a person would choose.

>>> to_si("2.5 GPa", "pressure"), to_si("10 um", "length"), to_si("0.1 / um", "wavevector")
(2500000000.0, 1e-05, 100000.0)
>>> in_words(2.5e9, "Pa"), in_words(3.2e14, "Pa/m"), prefix([1e3, 1e7], "Pa")
('2.5 GPa', '320 kPa/nm', (0.001, 'kPa'))
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable
from decimal import Decimal
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

from roughbench.errors import UnitError
from roughbench.text import suggestion

if TYPE_CHECKING:
    import pint

Dimension = Literal["length", "wavevector", "pressure"]
DIMENSIONS: tuple[Dimension, ...] = get_args(Dimension)


class _Meaning(NamedTuple):
    """SI unit and dimensions of what can be read, an example, and units that people mean."""

    unit: str
    powers: dict[str, float]
    example: str
    units: tuple[str, ...]


_MEANINGS: dict[Dimension, _Meaning] = {
    "length": _Meaning(
        "m", {"[length]": 1}, "10 um", ("m", "cm", "mm", "um", "µm", "nm", "pm", "angstrom")
    ),
    "wavevector": _Meaning(
        "1/m", {"[length]": -1}, "0.1 / um", ("m", "cm", "mm", "um", "µm", "nm", "pm")
    ),
    "pressure": _Meaning(
        "Pa",
        {"[length]": -1, "[mass]": 1, "[time]": -2},
        "2.5 GPa",
        ("Pa", "hPa", "kPa", "MPa", "GPa", "TPa", "bar", "mbar", "psi", "atm", "N", "mm", "m"),
    ),
}

EXAMPLES: dict[Dimension, str] = {name: one.example for name, one in _MEANINGS.items()}
SI: dict[Dimension, str] = {name: one.unit for name, one in _MEANINGS.items()}

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WORD = r"[^\W\d_]+(?:_[^\W\d_]+)*"
_POWER = r"(?:\s*(?:\^|\*\*)\s*[+-]?\d\b|⁻?[¹²³⁴])?"
_UNIT = rf"{_WORD}{_POWER}(?:\s*[*·/]?\s*{_WORD}{_POWER})*"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(?:({_UNIT})|(?:1\s*)?/\s*({_WORD}{_POWER}))\s*")
_BARE = re.compile(rf"\s*{_NUMBER}\s*")
_TWO_NUMBERS = re.compile(rf"\s*({_NUMBER})\s*/\s*({_NUMBER})\s*({_UNIT})\s*")
_LONGEST = 100
"""Characters; real ones have ten."""

_PREFIXES = {
    -18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m",
    0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P", 18: "E",
}  # fmt: skip


@functools.cache
def _registry() -> pint.UnitRegistry[Decimal]:
    """Return pint's units; decimals, so that 10 um is 1e-5 m to the last digit."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def to_si(value: str, dimension: Dimension, name: str = "") -> float:
    """Return a number with a unit in SI units: m, 1/m or Pa.

    One number and one unit, in this order. The same amount in another unit (``10 um`` and
    ``0.01 mm``) is the same float.

    Parameters
    ----------
    value : str
        Such as "10 um", "0.1 / um" or "2.5 GPa"; angles count as in SI, so that "1 cycle/um"
        is the wavevector 2π/µm.
    dimension : {"length", "wavevector", "pressure"}
        What it must be.
    name : str
        What it is called, such as ``pressures.min``, for the message.

    Raises
    ------
    UnitError
        If there is no such unit, or another dimension; or if the text can be read in two
        ways, as "1 / 10 um".
    """
    meaning = _MEANINGS[dimension]
    try:
        return _read(value, dimension, meaning)
    except ValueError as error:
        raise UnitError(str(error), name) from None


def _read(value: str, dimension: Dimension, meaning: _Meaning) -> float:
    found = _QUANTITY.fullmatch(value) if len(value) <= _LONGEST else None
    if found is None:
        raise ValueError(_unreadable(value, dimension, meaning.example))
    number, unit_text, below = found.groups()
    unit = _unit(unit_text or below, value, meaning)
    if below:
        unit = 1 / unit
    powers = {base: float(str(power)) for base, power in unit.dimensionality.items()}
    if powers != meaning.powers:
        other = next((d for d in DIMENSIONS if _MEANINGS[d].powers == powers), None)
        got = f"{value!r}, a {other}" if other else f"{value!r}"
        raise ValueError(f"must be a {dimension}, such as '{meaning.example}', got {got}")
    if not math.isfinite(float(number)):
        raise ValueError(f"must be finite, got {value!r}")
    if float(number) == 0.0:
        return 0.0
    registry = _registry()
    converted = float(registry.Quantity(Decimal(number), unit).to(meaning.unit).magnitude)
    if not math.isfinite(converted):
        raise ValueError(f"must be finite, got {value!r}")
    return converted


def _unit(text: str, value: str, meaning: _Meaning) -> Any:
    import pint

    text = text.replace("·", "*")
    try:
        return _registry().parse_units(text)
    except pint.UndefinedUnitError as error:
        unknown = re.findall(r"'([^']+)'", str(error))
        word = unknown[0] if unknown else text
        near = suggestion(word, meaning.units)
        hint = f" (did you mean {near!r}?)" if near else f"; write '{meaning.example}'"
        raise ValueError(f"has an unknown unit {word!r} in {value!r}{hint}") from None
    except (pint.PintError, ValueError, TypeError, ArithmeticError, AssertionError):
        raise ValueError(
            f"has no unit that can be read, got {value!r}; write '{meaning.example}'"
        ) from None


def _unreadable(value: str, dimension: Dimension, example: str) -> str:
    if _BARE.fullmatch(value):
        return f"has no unit, got {value!r}; write one behind the number, such as '{example}'"
    if two := _TWO_NUMBERS.fullmatch(value):
        above, below, unit = float(two[1]), float(two[2]), two[3]
        ratio = f"{above / below:.12g}" if below and math.isfinite(above / below) else "0.1"
        meant = {
            "length": f"'{ratio} {unit}'",
            "pressure": f"'{ratio} {unit}'",
            "wavevector": f"'{ratio} / {unit}'",
        }[dimension]
        return f"can be read in two ways, got {value!r}; write one number: {meant}"
    shown = value if len(value) <= _LONGEST else f"{value[:_LONGEST]}…"
    return f"must be one number and its unit, such as '{example}', got {shown!r}"


def begins_with_number(text: str) -> bool:
    """Return whether a text begins with a number that something follows.

    Examples
    --------
    >>> begins_with_number("1 / 10 um"), begins_with_number("high"), begins_with_number("2.5")
    (True, False, False)
    """
    return re.match(rf"\s*{_NUMBER}\s*[^\s\d.]", text) is not None


def is_quantity(value: object) -> bool:
    """Return whether a value is a text that begins with a number and has a unit.

    Examples
    --------
    >>> [is_quantity(value) for value in ("2.5 GPa", "1 / um", "2.5", 2.5, "8 springs", "bem")]
    [True, True, False, False, False, False]
    """
    if not isinstance(value, str) or len(value) > _LONGEST:
        return False
    found = _QUANTITY.fullmatch(value)
    if found is None:
        return False
    try:
        _unit(found[2] or found[3], value, _MEANINGS["length"])
    except ValueError:
        return False
    return True


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
