"""What is to be computed: every experiment, model and realization, cut into tasks."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from roughbench.errors import SurfaceError
from roughbench.models.base import FloatArray, Model
from roughbench.observables import OBSERVABLES, Observable
from roughbench.planning.samples import Heights, Surface, check_sample, read_heights
from roughbench.results import Array
from roughbench.spec import FileSurface, SelfAffineSurface, Spec
from roughbench.variables import check_variables

Block = dict[str, Array]
"""What a task computes: variables by name, along the first axis its realizations, fields or
bins."""

SECONDS_PER_TASK = 1.0
"""Small realizations are batched to about this: to commit a task costs a hundredth of it."""


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
    surface : SelfAffineSurface or FileSurface
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
        if isinstance(self.surface, FileSurface) != (self.heights is not None):
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
        return math.prod(self.heights.shape) if self.heights is not None else 0

    def pressure_array(self) -> FloatArray:
        """Return the pressures p/E*, shape (pressures,)."""
        return np.array(self.pressures, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Task:
    """Some realizations of one cell at some pressures, computed in one go by one process.

    Attributes
    ----------
    cell : Cell
    realizations : range
        Not empty.
    pressures : tuple of float
        p/E*, ascending; of the cell, or those of them that are missing.
    threads : int
        Threads that the model may use.
    """

    cell: Cell
    realizations: range
    pressures: tuple[float, ...]
    threads: int = 1

    def __hash__(self) -> int:
        return hash((self.cell.experiment, self.realizations, self.pressures[0]))

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return len(self.realizations) * len(self.pressures)

    @property
    def work(self) -> float:
        """Estimated work of one state, in microseconds."""
        return self.cell.work / len(self.cell.pressures)

    def pressure_array(self) -> FloatArray:
        """Return the pressures p/E*, shape (pressures,)."""
        return np.array(self.pressures, dtype=np.float64)

    def kept(self, realization: int) -> tuple[float, ...]:
        """Return the pressures of this task at which a realization's fields are kept."""
        asked = self.cell.asked
        if realization not in asked.realizations:
            return ()
        return tuple(p for p in self.pressures if p in asked.pressures)

    def only(self, realization: int) -> Task:
        """Return the part of one realization."""
        return replace(self, realizations=range(realization, realization + 1))

    def place(self, done: int) -> str:
        """Say where a computation stands that has done so many states of this task."""
        realization, pressure = divmod(done - 1, len(self.pressures))
        text = str(self.only(self.realizations[realization]))
        if pressure + 1 < len(self.pressures):
            text += f", pressure {pressure + 1} of {len(self.pressures)}"
        return text

    def __str__(self) -> str:
        first, last = self.realizations[0] + 1, self.realizations[-1] + 1
        if self.cell.n_realizations == 1:
            return str(self.cell)
        if first == last:
            return f"{self.cell}, realization {first} of {self.cell.n_realizations}"
        return f"{self.cell}, realizations {first} to {last} of {self.cell.n_realizations}"


def plan(spec: Spec) -> list[Cell]:
    """Return the cells of a spec, in its order.

    A file with heights is read once: all that a run says of them, and computes with, is
    held to what was found here.

    Raises
    ------
    SurfaceError
        With every file that cannot be read.
    """
    experiments = spec.experiments()
    heights, faults = _read_files(experiments)
    if faults:
        raise SurfaceError("\n".join(faults))
    return [
        Cell(
            experiment=experiment,
            model=model,
            surface=variant.surface,
            pressures=variant.pressures,
            n_realizations=_realizations(variant, model),
            seed=variant.seed,
            asked=_asked(variant) if model.has_fields else NOTHING,
            heights=heights.get(variant.surface),
            modulus=variant.modulus,
        )
        for experiment, variant in experiments
        for model in variant.models
    ]


def _read_files(
    experiments: Sequence[tuple[str, Spec]],
) -> tuple[dict[Surface, Heights], list[str]]:
    heights: dict[Surface, Heights] = {}
    faults: dict[str, str] = {}
    for name, spec in experiments:
        surface = spec.surface
        if isinstance(surface, FileSurface) and surface not in heights:
            theories = any(
                model.dimension == 0 for _, other in experiments for model in other.models
            )
            try:
                heights[surface] = read_heights(surface, spectrum=theories)
            except SurfaceError as error:
                faults.setdefault(str(error), name)
    return heights, [f"{name}: {fault}" for fault, name in faults.items()]


def check(cells: list[Cell]) -> None:
    """Refuse surfaces that a model cannot use, all of them at once.

    Raises
    ------
    SurfaceError
    """
    faults: dict[str, str] = {}
    for cell in cells:
        try:
            check_sample(cell.surface, cell.model, cell.heights)
        except SurfaceError as error:
            faults.setdefault(str(error), str(cell))
    if faults:
        raise SurfaceError("\n".join(f"{cell}: {fault}" for fault, cell in faults.items()))


def cut(
    cell: Cell,
    realizations: range,
    pressures: tuple[float, ...],
    *,
    threads: int = 1,
    parts: int = 1,
) -> list[Task]:
    """Cut realizations of a cell into tasks of about a second, or one of a realization.

    Parameters
    ----------
    cell, realizations, pressures, threads
        As in :class:`Task`.
    parts : int
        Make at least so many tasks, where they stay longer than a tenth of a second.

    Returns
    -------
    list of Task
        The numbers do not depend on the cut.
    """
    seconds = 1e-6 * cell.work * len(pressures) / len(cell.pressures)
    wanted = min(SECONDS_PER_TASK / seconds, len(realizations) / parts)
    size = max(1, math.ceil(max(wanted, 0.1 * SECONDS_PER_TASK / seconds)))
    return [
        Task(cell, realizations[start : start + size], pressures, threads)
        for start in range(0, len(realizations), size)
    ]


@functools.lru_cache(maxsize=1024)  # asked for every task
def _grid_points(surface: SelfAffineSurface, model: Model) -> int:
    return model.grid_points(surface.spectrum(), surface.length)


def _asked(spec: Spec) -> Asked:
    known = [*OBSERVABLES, *(one.name for one in spec.observed if one.name not in OBSERVABLES)]
    observables = tuple(sorted(spec.observed, key=lambda one: known.index(one.name)))
    check_variables(observables)
    if spec.save_fields is None:
        return Asked(observables)
    return Asked(observables, spec.kept_pressures, tuple(sorted(spec.save_fields.realizations)))


def _realizations(spec: Spec, model: Model) -> int:
    """One where there is no randomness; else the model's own number, or the spec's."""
    if model.dimension == 0 or isinstance(spec.surface, FileSurface):
        return 1
    return model.realizations or spec.realizations
