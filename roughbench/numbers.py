"""Numbers as they stand in a text, and in JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable

_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def number(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits.

    Examples
    --------
    >>> number(1.6e-5), number(-0.25), number(math.inf), number(math.nan), number(2048, 4)
    ('1.6·10⁻⁵', '−0.25', '∞', '–', '2048')
    """
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    power = math.floor(math.log10(abs(value)))
    text = f"{value:.{digits}g}"
    if -4 < power < max(4, digits + 1):
        return (f"{value:.0f}" if "e" in text else text).replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    times = "" if mantissa in ("1", "-1") else f"{mantissa}·"
    sign = "-" if mantissa == "-1" else ""
    return f"{sign}{times}{_power(int(exponent))}".replace("-", "−")


def with_error(value: float, error: float, digits: int = 3, *, of_error: int = 2) -> str:
    """Return value ± error, both to the last digit of the error that is shown.

    Parameters
    ----------
    value, error : float
        nan: there is none.
    digits : int
        Significant digits of a value without an error.
    of_error : int
        Significant digits of the error.

    Examples
    --------
    >>> with_error(2.0512, 0.0231), with_error(1.234e-5, 2.2e-7), with_error(1.5, math.nan)
    ('2.051 ± 0.023', '(1.234 ± 0.022)·10⁻⁵', '1.5')
    """
    if not (math.isfinite(value) and math.isfinite(error) and error > 0.0):
        return number(value, digits)
    power = math.floor(math.log10(max(abs(value), error)))
    if -4 < power < 4:
        power = 0
    places = max(0, of_error - 1 - math.floor(math.log10(error)) + power)
    if places > 12:  # an error of rounding only
        return number(value, digits)
    scale = 10.0**power
    text = f"{value / scale:.{places}f} ± {error / scale:.{places}f}".replace("-", "−")
    return f"({text})·{_power(power)}" if power else text


_ROUNDING = 1e-9
LOPSIDED = 1.5
"""From this ratio of both sides on, an interval is said with its two sides."""


def is_lopsided(value: float, low: float, high: float) -> bool:
    """Return whether the sides of an interval differ so much that ± would mislead."""
    if math.isnan(low) or math.isnan(high):
        return False
    sides = sorted((value - low, high - value))
    return sides[1] != 0.0 and not (sides[0] > 0.0 and sides[1] <= LOPSIDED * sides[0])


def with_interval(value: float, low: float, high: float, digits: int = 3) -> str:
    """Return a value with its interval: ± where both sides are alike, else each of them.

    Parameters
    ----------
    value, low, high : float
        nan: there is none.
    digits : int
        Significant digits of a value without an interval.

    Examples
    --------
    >>> with_interval(2.05, 2.03, 2.07), with_interval(3.2, 3.1, 22.2)
    ('2.050 ± 0.020', '3.2 (+19/−0.1)')
    >>> with_interval(3.2, 3.1, math.inf), with_interval(9.4, 6.02, 9.3)
    ('3.2 (+∞/−0.1)', '9.4 (68 %: 6.0 to 9.3)')
    >>> with_interval(2e-5, 2.00000000000001e-5, 2.00000000000001e-5)  # but for rounding
    '2·10⁻⁵'
    """
    if math.isnan(value) or math.isinf(value) or math.isnan(low) or math.isnan(high):
        return number(value, digits)
    down, up = (
        0.0 if abs(side) <= _ROUNDING * abs(value) else side
        for side in (value - low, high - value)
    )
    sides = [side for side in (down, up) if math.isfinite(side) and side != 0.0]
    if not sides:
        return number(value, digits)
    if not is_lopsided(value, value - down, value + up):
        return with_error(value, 0.5 * (down + up), digits)
    power = math.floor(math.log10(abs(value))) if value else 0
    power = 0 if -4 < power < 4 else power
    smallest = min(map(abs, sides)) if min(down, up) >= 0.0 else 0.1 * (high - low)
    places = min(max(0, power - math.floor(math.log10(smallest))), 6)

    def text(one: float, most: int = places) -> str:
        return f"{one / 10.0**power:.{most}f}" if math.isfinite(one) else number(one)

    def side(one: float) -> str:
        if not (math.isfinite(one) and one > 0.0):
            return text(one)
        return text(one, min(places, max(0, 1 + power - math.floor(math.log10(one)))))

    if min(down, up) < 0.0:
        shown = f"{text(value)} (68 %: {text(low)} to {text(high)})"
    else:
        shown = f"{text(value)} (+{side(up)}/-{side(down)})"
    shown = shown.replace("-", "−")
    return f"({shown})·{_power(power)}" if power else shown


def measured(value: float, error: float, bound: str = "") -> str:
    """Return value ± error after its bound, "≤" or "≥"; nothing bounds what is not there.

    Examples
    --------
    >>> measured(2.0, 0.1, "≥"), measured(math.nan, math.nan, "≥")
    ('≥ 2.00 ± 0.10', '–')
    """
    text = with_error(value, error)
    return f"{bound} {text}" if bound and math.isfinite(value) else text


def _power(exponent: int) -> str:
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


def series(values: Iterable[float], digits: int = 3, most: int = 6) -> str:
    """Return a list of numbers; of a long one the ends and how many there are.

    Examples
    --------
    >>> series([8.0, 1.0, 1.0]), series(range(1, 21))
    ('1, 8', '1 … 20 (20 values)')
    """
    found = sorted(set(values))
    if len(found) <= most:
        return ", ".join(number(value, digits) for value in found)
    return f"{number(found[0], digits)} … {number(found[-1], digits)} ({len(found)} values)"


def json_number(value: float) -> float | str | None:
    """Return a number as strict JSON has it: infinity is a text, nan null.

    Examples
    --------
    >>> json_number(0.5), json_number(-math.inf), json_number(math.nan)
    (0.5, '-inf', None)
    """
    if math.isfinite(value):
        return value
    return None if math.isnan(value) else str(value)
