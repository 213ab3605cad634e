"""What a run leaves: arrays by experiment, model and name, with their dimensions and units."""

from __future__ import annotations

from roughbench.results.display import MOST_LINES
from roughbench.results.model_result import MODULUS, Attribute, ModelResult
from roughbench.results.results import MadeWhenAsked, Results
from roughbench.results.scaling import Array

__all__ = [
    "MODULUS",
    "MOST_LINES",
    "Array",
    "Attribute",
    "MadeWhenAsked",
    "ModelResult",
    "Results",
]
