"""The contenders, one file each. Registering one takes one line in ``MODELS``."""

from __future__ import annotations

from roughbench.models.base import Model
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.models.persson import Persson

MODELS: dict[str, type[Model]] = {
    "bem": HalfSpace,
    "foundation": Foundation,
    "persson": Persson,
}
"""Kind in the spec → model."""
