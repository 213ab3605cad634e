"""Units of length as files of topographies write them."""

from __future__ import annotations

import math

_METRES = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    "cm": 1e-2,
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 1e-3),
    # The micro sign, the Greek letter, and what stands for them in ASCII.
    **dict.fromkeys(("µm", "μm", "um", "~m", "micron", "microns"), 1e-6),
    **dict.fromkeys(("micrometer", "micrometers", "micrometre", "micrometres"), 1e-6),
    **dict.fromkeys(("nm", "nanometer", "nanometers", "nanometre", "nanometres"), 1e-9),
    # Å as one character, and as a sign of its own. A plain A is the ampere.
    **dict.fromkeys(("Å", "Å", "angstrom", "angstroms", "ångström"), 1e-10),
    "pm": 1e-12,
}
_PREFIXES = {0: "m", -1: "mm", -2: "µm", -3: "nm", -4: "pm"}


def in_metres(unit: str) -> float | None:
    """Return metres per unit, None for what is no length.

    Examples
    --------
    >>> in_metres("um"), in_metres("Nanometers"), in_metres("V")
    (1e-06, 1e-09, None)
    """
    name = unit.strip()
    return _METRES.get(name) or _METRES.get(name.lower() if len(name) > 2 else "")


def in_words(length: float) -> str:
    """Return a length in m with a prefix, to nine digits.

    Examples
    --------
    >>> in_words(1e-5), in_words(0.0), in_words(1.23456789e-7)
    ('10 µm', '0 m', '123.456789 nm')
    """
    if not 0.0 < abs(length) < math.inf:
        return f"{length:g} m"
    power = math.floor(math.log10(abs(length)) / 3.0 + 1e-12)
    power = min(max(power, min(_PREFIXES)), max(_PREFIXES))
    return f"{length * 1000.0**-power:.9g} {_PREFIXES[power]}"
