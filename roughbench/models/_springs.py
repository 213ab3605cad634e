"""What independent springs share: how stiff they are, and their fields in a solved state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal, cast

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Discriminator, Tag

from roughbench.inputs import float_array
from roughbench.models.base import Fields, FloatArray, Sample, State
from roughbench.models.dimensional import WavevectorOption
from roughbench.units import begins_with_number

_Named = Literal["published", "matched"]


def _form(value: object) -> str | None:
    if isinstance(value, str) and not begins_with_number(value):
        return "word" if value in ("published", "matched") else None
    return "number"


ModulusOption = Annotated[
    Annotated[_Named, Tag("word")] | Annotated[WavevectorOption, Tag("number")],
    Discriminator(
        _form,
        custom_error_type="modulus_choice",
        custom_error_message="must be published, matched, or k_w/E*, 1/length",
    ),
]


def spring_fields(
    heights: ArrayLike, pressure: float, separation: float, modulus: float
) -> Fields:
    """Return pressure and gap of every spring in a state that is solved already.

    Parameters
    ----------
    heights : array_like of float64, any shape
        Length.
    pressure : float
        Nominal pressure p/E*.
    separation : float
        ū at this pressure, length; the plane is at d = ū + ⟨h⟩ − p/k_w.
    modulus : float
        k_w/E*, 1/length.

    Examples
    --------
    >>> fields = spring_fields([3.0, 2.0, 0.0, 0.0], 0.5, 0.75, modulus=1.0)
    >>> fields.pressure.tolist(), fields.gap.tolist()
    ([1.5, 0.5, 0.0, 0.0], [0.0, 0.0, 1.5, 1.5])
    """
    h = float_array(heights, "heights", kinds="buif")
    overlap = h - (separation + h.mean() - pressure / modulus)
    return Fields(modulus * np.maximum(overlap, 0.0), np.maximum(-overlap, 0.0), modulus)


def make_spring_fields(sample: Sample, modulus: float) -> Callable[[State], Fields]:
    """Return what computes the fields of a state of springs under the sample's heights.

    Parameters
    ----------
    sample : Sample
    modulus : float
        k_w/E*, 1/length.
    """
    heights = cast(FloatArray, sample.heights)

    def fields(state: State) -> Fields:
        separation = cast(float, state.separation)
        return spring_fields(heights, state.pressure, separation, modulus)

    return fields
