"""Texts with units into SI: what is a quantity, of which dimension, and how much."""

from __future__ import annotations

import functools
import math
import re
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


def factor_to_si(unit: str, target: str) -> float:
    """Return what numbers in a unit are multiplied with to be in another of its dimension.

    Parameters
    ----------
    unit : str
        Such as "MPa/nm".
    target : str
        One of SI, such as "Pa/m".

    Raises
    ------
    UnitError
        If there is no such unit, or it is of another dimension.

    Examples
    --------
    >>> factor_to_si("MPa/nm", "Pa/m"), factor_to_si("um", "m")
    (1000000000000000.0, 1e-06)
    """
    import pint

    try:
        found = _registry().parse_units(unit[:_LONGEST])
        return float(_registry().Quantity(Decimal(1), found).to(target).magnitude)
    except pint.DimensionalityError:
        raise UnitError(f"{unit!r} is no unit like {target}") from None
    except (pint.PintError, ValueError, TypeError, ArithmeticError, AssertionError):
        raise UnitError(f"{unit!r} is no unit that can be read") from None


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
