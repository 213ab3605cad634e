"""Doors to other codes: heights and states from their objects, and to them.

SurfaceTopography and ContactMechanics, Tamaas and ASPHER. Their objects are known by what they
have, so that none of them is imported to read from it; what makes an object of theirs imports
the code that it belongs to. What a number means there and here: docs/conventions.md.

>>> import numpy as np
>>> from roughbench import neighbours
>>> class Topography:  # as SurfaceTopography has it: the first axis is x
...     physical_sizes, unit, is_periodic = (3.0, 2.0), "mm", True
...     def heights(self):
...         return np.arange(6.0).reshape(3, 2)
>>> surface = neighbours.surface_of(Topography())
>>> surface.heights.tolist(), surface.size
([[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]], (2.0, 3.0))
"""

from __future__ import annotations

from roughbench.neighbours.problems import (
    aspher_arguments,
    contactmechanics_system,
    tamaas_model,
    topography,
)
from roughbench.neighbours.states import PressedFields, fields_of
from roughbench.neighbours.surfaces import PeriodicSurface, surface_of

__all__ = [
    "PeriodicSurface",
    "PressedFields",
    "aspher_arguments",
    "contactmechanics_system",
    "fields_of",
    "surface_of",
    "tamaas_model",
    "topography",
]
