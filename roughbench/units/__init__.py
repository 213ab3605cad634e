"""Numbers with units: read into SI, and written with the prefix that a person would choose.

>>> to_si("2.5 GPa", "pressure"), to_si("10 um", "length"), to_si("0.1 / um", "wavevector")
(2500000000.0, 1e-05, 100000.0)
>>> in_words(2.5e9, "Pa"), in_words(3.2e14, "Pa/m"), prefix([1e3, 1e7], "Pa")
('2.5 GPa', '320 kPa/nm', (0.001, 'kPa'))
"""

from __future__ import annotations

from roughbench.units.reading import (
    DIMENSIONS,
    EXAMPLES,
    SI,
    Dimension,
    begins_with_number,
    factor_to_si,
    is_quantity,
    to_si,
)
from roughbench.units.writing import in_words, prefix

__all__ = [
    "DIMENSIONS",
    "EXAMPLES",
    "SI",
    "Dimension",
    "begins_with_number",
    "factor_to_si",
    "in_words",
    "is_quantity",
    "prefix",
    "to_si",
]
