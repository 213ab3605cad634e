"""Units of length as files of topographies write them."""

from __future__ import annotations

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


def in_metres(unit: str) -> float | None:
    """Return metres per unit, None for what is no length.

    Examples
    --------
    >>> in_metres("um"), in_metres("Nanometers"), in_metres("V")
    (1e-06, 1e-09, None)
    """
    name = unit.strip()
    return _METRES.get(name) or _METRES.get(name.lower() if len(name) > 2 else "")
