"""How a run says how far it is, without knowing who listens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

COMPILING = "compiling, once"
"""What is said while loops are compiled: later runs find them."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    done, total : int
        States (one realization at one pressure) computed so far, and in all.
    share : float
        Estimated share of the work that is done, 0 to 1: a state of the exact solver
        takes a thousand times as long as one of the foundation.
    text : str
        What was computed last, such as ``main/bem, realization 3 of 10``.
    """

    done: int
    total: int
    share: float
    text: str


ProgressListener = Callable[[Progress], None]
"""Called from the process and thread that called ``run``, as often as there is news."""
