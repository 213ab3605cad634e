"""What is to be computed: every experiment, model and realization, cut into tasks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roughbench.errors import SurfaceError
from roughbench.models.base import FloatArray, Model
from roughbench.runner.samples import Surface, check_sample
from roughbench.spec import FileSurface, SelfAffineSurface, Spec

# Realizations per task. A line takes milliseconds, the way to another process and back
# about one; a surface takes seconds to minutes.
_BATCH = {0: 1, 1: 16, 2: 1}


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
    """

    experiment: str
    model: Model
    surface: Surface
    pressures: tuple[float, ...]
    n_realizations: int
    seed: int

    def __str__(self) -> str:
        return f"{self.experiment}/{self.model.name}"

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return self.n_realizations * len(self.pressures)

    @property
    def work(self) -> float:
        """Estimated work of one realization, in microseconds; only progress relies on it.

        The exact solver takes about 1 µs per point and pressure (512² points: 0.3 s), the
        foundation 1 to 2 µs per spring for all pressures, Persson's theory a millisecond
        or two. Heights from a file count as 512 points per side.
        """
        dimension = self.model.dimension
        if dimension == 0:
            return 2e3
        n_points = 512
        if isinstance(self.surface, SelfAffineSurface):
            n_points = self.model.grid_points(self.surface.spectrum(), self.surface.length)
        return float(n_points) ** dimension * (len(self.pressures) if dimension == 2 else 1)

    def pressure_array(self) -> FloatArray:
        """Return the pressures p/E*, shape (pressures,)."""
        return np.array(self.pressures, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Task:
    """Some realizations of one cell, computed in one go by one process."""

    cell: Cell
    realizations: range

    def place(self, done: int) -> str:
        """Say where a computation stands that has done so many states of this task."""
        realization, pressure = divmod(done - 1, len(self.cell.pressures))
        here = self.realizations[realization]
        text = str(Task(self.cell, range(here, here + 1)))
        if pressure + 1 < len(self.cell.pressures):
            text += f", pressure {pressure + 1} of {len(self.cell.pressures)}"
        return text

    def __str__(self) -> str:
        first, last = self.realizations[0] + 1, self.realizations[-1] + 1
        if self.cell.n_realizations == 1:
            return str(self.cell)
        if first == last:
            return f"{self.cell}, realization {first} of {self.cell.n_realizations}"
        return f"{self.cell}, realizations {first} to {last} of {self.cell.n_realizations}"


def plan(spec: Spec) -> list[Cell]:
    """Return the cells of a spec, in its order."""
    return [
        Cell(
            experiment=experiment,
            model=model,
            surface=variant.surface,
            pressures=variant.pressures,
            n_realizations=_realizations(variant, model),
            seed=variant.seed,
        )
        for experiment, variant in spec.experiments()
        for model in variant.models
    ]


def check(cells: list[Cell]) -> None:
    """Refuse surfaces that a model cannot use, all of them at once.

    Raises
    ------
    SurfaceError
    """
    faults: dict[str, str] = {}
    for cell in cells:
        try:
            check_sample(cell.surface, cell.model)
        except SurfaceError as error:
            faults.setdefault(str(error), str(cell))
    if faults:
        raise SurfaceError("\n".join(f"{cell}: {fault}" for fault, cell in faults.items()))


def tasks_of(cell: Cell) -> list[Task]:
    """Cut the realizations of a cell into tasks."""
    size, n = _BATCH[cell.model.dimension], cell.n_realizations
    return [Task(cell, range(n)[first : first + size]) for first in range(0, n, size)]


def _realizations(spec: Spec, model: Model) -> int:
    """One where there is no randomness; else the model's own number, or the spec's."""
    if model.dimension == 0 or isinstance(spec.surface, FileSurface):
        return 1
    return model.realizations or spec.realizations
