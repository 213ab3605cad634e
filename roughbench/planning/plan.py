"""What is to be computed: every experiment, model and realization, cut into tasks."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roughbench.errors import SurfaceError
from roughbench.models.base import FloatArray, Model
from roughbench.observables import OBSERVABLES, Observable
from roughbench.planning.measured import Heights, read_heights
from roughbench.planning.samples import Surface, check_sample, draws_lines, is_drawn
from roughbench.results import Array
from roughbench.spec import MeasuredSurface, SelfAffineSurface, Spec
from roughbench.variables import check_variables

Block = dict[str, Array]
"""What a task computes: variables by name, along the first axis its realizations, fields or
bins."""

LINES = 20
"""Lines with the spectrum of a measured surface, where no spec says how many."""

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
            model=model.reduced(variant.modulus),
            surface=variant.surface,
            pressures=variant.pressures,
            n_realizations=_realizations(variant, model, heights),
            seed=variant.seed,
            asked=_asked(variant) if model.has_fields else NOTHING,
            heights=_known(variant.surface, heights),
            modulus=variant.modulus,
        )
        for experiment, variant in experiments
        for model in variant.models
    ]


def _read_files(
    experiments: Sequence[tuple[str, Spec]],
) -> tuple[dict[MeasuredSurface, Heights], list[str]]:
    heights: dict[MeasuredSurface, Heights] = {}
    faults: dict[str, str] = {}
    for name, spec in experiments:
        if not isinstance(spec.surface, MeasuredSurface):
            continue
        surface = spec.surface.original()
        if surface not in heights:
            lowest = min(min(other.pressures) for _, other in experiments)
            try:
                heights[surface] = read_heights(surface, pressure=lowest)
            except SurfaceError as error:
                faults.setdefault(str(error), name)
    return heights, [f"{name}: {fault}" for fault, name in faults.items()]


def _known(surface: Surface, heights: Mapping[MeasuredSurface, Heights]) -> Heights | None:
    return heights[surface.original()] if isinstance(surface, MeasuredSurface) else None


def check(cells: list[Cell]) -> None:
    """Refuse surfaces that a model cannot use, or that make the answer wrong, all at once.

    Raises
    ------
    SurfaceError
    """
    faults = dict(_doubts(cells, wrong=True))
    for cell in cells:
        try:
            check_sample(cell.surface, cell.model, cell.heights)
        except SurfaceError as error:
            faults.setdefault(str(error), str(cell))
    if faults:
        raise SurfaceError("\n".join(f"{where}: {fault}" for fault, where in faults.items()))


def warnings(cells: list[Cell]) -> list[str]:
    """Return what makes answers on measured surfaces doubtful: a line for each."""
    return [f"{where}: {text}" for text, where in _doubts(cells, wrong=False)]


def _doubts(cells: list[Cell], *, wrong: bool) -> list[tuple[str, str]]:
    """Return what is doubtful, or wrong, about measured surfaces, and the experiment."""
    found: dict[str, str] = {}
    for cell in cells:
        for doubt in cell.heights.doubts if cell.heights is not None else ():
            if doubt.is_wrong == wrong:
                found.setdefault(doubt.text, cell.experiment)
    return [*found.items()]


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


@functools.lru_cache(maxsize=64)
def _line_points(heights: Heights, model: Model) -> int:
    return model.grid_points(heights.needed_spectrum(), heights.longest_side)


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


def _realizations(spec: Spec, model: Model, heights: Mapping[MeasuredSurface, Heights]) -> int:
    """One where there is no randomness; else the model's own number, or the spec's.

    Twins count as the spec says, and lines with the spectrum of a measured surface are
    :data:`LINES` where it says nothing.
    """
    if model.dimension == 0:
        return 1
    if isinstance(spec.surface, MeasuredSurface):
        known = heights[spec.surface.original()]
        if not draws_lines(model, known):
            return spec.twins or 1 if spec.surface.is_twins else 1
        if "realizations" not in spec.model_fields_set:
            return model.realizations or LINES
    return model.realizations or spec.realizations
