"""Numbers as the messages of this folder write them."""

from __future__ import annotations

import math

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: ""}


def length_in_words(value: float, unit: str = "m") -> str:
    """Return a length with three digits; of one without a unit, the number alone.

    Examples
    --------
    >>> length_in_words(1.234e-9), length_in_words(1.234e-9, "")
    ('1.23 nm', '1.23e-09')
    """
    if not unit:
        return f"{value:.3g}"
    rounded = float(f"{value:.3g}")
    power = 3 * math.floor(math.log10(abs(rounded)) / 3) if rounded else 0
    power = min(max(power, -12), 0)
    return f"{rounded / 10.0**power:.4g} {_PREFIXES[power]}{unit}"


def per_cent(share: float) -> str:
    """Return a share in percent.

    Examples
    --------
    >>> per_cent(0.0512), per_cent(0.00001)
    ('5.12 %', '0.001 %')
    """
    return f"{100.0 * share:.3g} %"
