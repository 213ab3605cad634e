"""The contenders, one file each. Registering one takes one line in ``MODELS``."""

from __future__ import annotations

from roughbench.models.base import Model
from roughbench.models.bgt import BushGibsonThomas
from roughbench.models.foundation import Foundation
from roughbench.models.gw import GreenwoodWilliamson
from roughbench.models.gw_elliptic import Elliptic
from roughbench.models.halfspace import HalfSpace
from roughbench.models.hertz_top import HertzTop
from roughbench.models.line import Line
from roughbench.models.persson import Persson
from roughbench.models.winkler import Winkler

MODELS: dict[str, type[Model]] = {
    "bem": HalfSpace,
    "foundation": Foundation,
    "line": Line,
    "persson": Persson,
    "winkler": Winkler,
    "gw": GreenwoodWilliamson,
    "gw_elliptic": Elliptic,
    "bgt": BushGibsonThomas,
    "hertz_top": HertzTop,
}
"""Kind in the spec → model."""
