"""One model in one experiment: what is computed for it."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from roughbench.models.base import FloatArray, Model
from roughbench.observables import Observable
from roughbench.planning.measured import Heights
from roughbench.planning.samples import Surface, draws_lines, is_drawn
from roughbench.spec import MeasuredSurface, SelfAffineSurface


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of the fields of a model.

    Attributes
    ----------
    observables : tuple of Observable
        In the order of :data:`roughbench.observables.OBSERVABLES`, then those of files.
    pressures : tuple of float
        p/E* of the states whose fields are kept, ascending.
    realizations : tuple of int
        Those of these states, from 0, ascending.
    """

    observables: tuple[Observable, ...] = ()
    pressures: tuple[float, ...] = ()
    realizations: tuple[int, ...] = ()

    @property
    def kept(self) -> list[tuple[int, float]]:
        """Realization and pressure of every field that is kept."""
        return [(r, p) for r in self.realizations for p in self.pressures]


NOTHING = Asked()


@dataclass(frozen=True, slots=True)
class Cell:
    """One model in one experiment: one group of the results file.

    Attributes
    ----------
    experiment : str
    model : Model
    surface : SelfAffineSurface or MeasuredSurface
    pressures : tuple of float
        p/E*.
    n_realizations : int
    seed : int
    asked : Asked
        Of its fields; nothing for a model without.
    heights : Heights or None
        Those of a file, as the plan found them; None for a surface that is generated.
    modulus : float or None
        E*, Pa, of a spec with units; nothing that is computed depends on it.

    Raises
    ------
    ValueError
        If heights come from a file and nobody has read it.
    """

    experiment: str
    model: Model
    surface: Surface
    pressures: tuple[float, ...]
    n_realizations: int
    seed: int
    asked: Asked = NOTHING
    heights: Heights | None = None
    modulus: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.surface, MeasuredSurface) != (self.heights is not None):
            raise ValueError(f"{self}: heights belong to surfaces from a file, and to these")

    def __str__(self) -> str:
        return f"{self.experiment}/{self.model.name}"

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return self.n_realizations * len(self.pressures)

    @property
    def work(self) -> float:
        """Estimated work of one realization on one core, in microseconds.

        That of the model, and of all observables 0.17 µs per point and pressure.
        """
        work = self.model.work(self.n_points, len(self.pressures))
        observed = 0.17 * len(self.pressures) if self.asked.observables else 0.0
        return work + observed * float(self.n_points)

    @property
    def n_points(self) -> int:
        """Points of a sample."""
        dimension = self.model.dimension
        if dimension == 0:
            return 0
        if isinstance(self.surface, SelfAffineSurface):
            return _grid_points(self.surface, self.model) ** dimension
        if self.heights is None:
            return 0
        if draws_lines(self.model, self.heights):
            return _line_points(self.heights, self.model)
        return math.prod(self.heights.shape)

    @property
    def length(self) -> float:
        """Period of its heights along the first axis, length."""
        if isinstance(self.surface, SelfAffineSurface):
            return self.surface.length
        if self.heights is None:
            raise ValueError(f"{self}: nobody has read its heights")
        if draws_lines(self.model, self.heights):
            return self.heights.longest_side
        return self.heights.length

    @property
    def is_random(self) -> bool:
        """Whether its heights are drawn at random."""
        if isinstance(self.surface, SelfAffineSurface) or self.heights is None:
            return self.model.dimension > 0
        return is_drawn(self.surface, self.model, self.heights)

    def pressure_array(self) -> FloatArray:
        """Return the pressures p/E*, shape (pressures,)."""
        return np.array(self.pressures, dtype=np.float64)


@functools.lru_cache(maxsize=64)
def _line_points(heights: Heights, model: Model) -> int:
    return model.grid_points(heights.needed_spectrum(), heights.longest_side)


@functools.lru_cache(maxsize=1024)  # asked for every task
def _grid_points(surface: SelfAffineSurface, model: Model) -> int:
    return model.grid_points(surface.spectrum(), surface.length)
