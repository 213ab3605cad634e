"""What a spec asks of the fields of states: taken while the curve is computed, and averaged."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from roughbench.ensemble import means_and_errors
from roughbench.errors import SolverError
from roughbench.models.base import Fields, FloatArray, IntArray, Sample, Status
from roughbench.observables import (
    Field,
    Observable,
    Origin,
    Profile,
    Scales,
    Units,
    of_fields,
)
from roughbench.observables.described import PREFIX, description, is_outside
from roughbench.planning.cells import Cell
from roughbench.planning.samples import rms_of
from roughbench.planning.tasks import Task
from roughbench.results import Array, Attribute
from roughbench.source_files import blamed
from roughbench.spec import ScanSurface, SelfAffineSurface
from roughbench.spectrum import Spectrum
from roughbench.variables import bins_of, describe_observable

_PRESSURE, _GAP = "field_pressure.", "field_gap."


class Observer:
    """Takes from the states of one realization what its cell asks of their fields.

    Attributes
    ----------
    fields : dict of int to Fields
        Those that are kept, by the number of the pressure in the task.
    """

    def __init__(self, task: Task, realization: int, sample: Sample) -> None:
        self.fields: dict[int, Fields] = {}
        self._observables = task.cell.asked.observables
        self._kept = {task.pressures.index(p) for p in task.kept(realization)}
        self._n_pressures = len(task.pressures)
        self._sample = sample
        self._values: dict[str, Array] = {}
        self._refused: dict[int, SolverError] = {}

    @property
    def is_idle(self) -> bool:
        """Whether nothing is asked for."""
        return not self._observables and not self._kept

    def note(self, k: int, take: Callable[[], Fields]) -> None:
        """Look at the state at pressure ``k`` of the task, if there is something to look at."""
        if not self._observables and k not in self._kept:
            return
        fields = take()
        if k in self._kept:
            self.fields[k] = fields
        if not self._observables:
            return
        try:
            field = of_fields(fields, self._sample.length, self._units())
        except SolverError as error:  # not finite, of a state that did not converge
            self._refused[k] = error
            return
        for observable in self._observables:
            self._enter(k, observable, field)

    def _units(self) -> Units:
        if self._sample.spectrum is not None:
            return self._sample.spectrum
        height, slope = rms_of(self._sample)
        return Scales(slope, height)

    def _enter(self, k: int, observable: Observable, field: Field) -> None:
        try:
            variable, profile = observable.variable, observable(field)
        except Exception as error:
            found = blamed(observable, error, f"the observable {observable.name}")
            if found is error:
                raise
            raise found from error
        self._values.setdefault(f"{variable}_bin", _places(profile))
        self._values.setdefault(f"{variable}_edges", profile.edges)
        self._row(variable, profile.values.shape)[k] = profile.values
        for scalar, value in profile.scalars.items():
            self._row(observable.scalar_variables()[scalar])[k] = value

    def _row(self, variable: str, shape: tuple[int, ...] = ()) -> Array:
        if variable not in self._values:
            self._values[variable] = np.full((self._n_pressures, *shape), math.nan)
        return self._values[variable]

    # -- checkpoints -----------------------------------------------------------------------

    def snapshot(self) -> dict[str, Array]:
        """Return all that was taken so far, for :meth:`restore`."""
        arrays = dict(self._values)
        for k, fields in self.fields.items():
            arrays |= {f"{_PRESSURE}{k}": fields.pressure, f"{_GAP}{k}": fields.gap}
        return arrays

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take up what :meth:`snapshot` returned."""
        own = {name: np.array(values) for name, values in arrays.items()}
        for name in [name for name in own if name.startswith(_PRESSURE)]:
            number = name.removeprefix(_PRESSURE)
            self.fields[int(number)] = Fields(own.pop(name), own.pop(f"{_GAP}{number}"))
        self._values = own

    # -- at the end ------------------------------------------------------------------------

    def finish(self, status: IntArray) -> dict[str, Array]:
        """Return the variables of the realization; nan where a state did not converge.

        Parameters
        ----------
        status : ndarray of int32, shape (pressures,)

        Returns
        -------
        dict of str to ndarray
            Observables (pressures, bins), single numbers (pressures,), and the places and
            ends of the bins.

        Raises
        ------
        SolverError
            If a converged state has fields that are none.
        """
        lost = status != Status.CONVERGED
        for k, error in self._refused.items():
            if not lost[k]:
                raise error
        if self._observables and not self._values and self._sample.heights is not None:
            self._know_bins(self._sample.heights)
        shared = bins_of(self._observables)
        for name, values in self._values.items():
            if name not in shared:
                values[lost] = math.nan
        return self._values

    def _know_bins(self, heights: FloatArray) -> None:
        """Enter bins without any state: those of a field without contact."""
        none = Fields(np.zeros(heights.shape), np.ones(heights.shape))
        field: Field = of_fields(none, self._sample.length, self._units())
        for observable in self._observables:
            self._enter(0, observable, field)


def _places(profile: Profile) -> FloatArray:
    """Return where the values of a profile stand; the middle of a ring without modes."""
    edges = profile.edges
    middle = np.sqrt(edges[1:] * edges[:-1])
    return np.where(np.isnan(profile.places), middle, profile.places)


# -- of the whole cell ---------------------------------------------------------------------


def averages(
    cell: Cell, variables: Mapping[str, Array], converged: NDArray[np.bool_]
) -> dict[str, Array]:
    """Return mean and standard error of the observables, and Persson's theory beside them.

    Parameters
    ----------
    cell : Cell
    variables : mapping of str to ndarray
        Of all states.
    converged : ndarray of bool, shape (realizations, pressures)
        States that count.
    """
    found: dict[str, Array] = {}
    theories: dict[str, Array] = {}
    origin = _origin(cell)
    for observable in cell.asked.observables:
        name = observable.variable
        for variable in (name, *observable.scalar_variables().values()):
            if variable in variables:
                mean, sem = means_and_errors(variables[variable], converged)
                found |= {f"{variable}_mean": mean, f"{variable}_sem": sem}
        if (bins := variables.get(f"{name}_bin")) is None:
            continue
        if (theory := observable.theory(origin, bins)) is not None:
            theories[f"{name}_persson"] = theory
        if is_outside(observable):  # a figure may be drawn where its code is not
            unit = observable.drawn_unit(bins, cell.model.dimension)
            if not np.all(unit == 1.0):
                theories[f"{name}_drawn_unit"] = unit
    return found | theories


def attributes(cell: Cell) -> dict[str, Attribute]:
    """Return what belongs to observables and fields but is no array."""
    if not cell.asked.observables and not cell.asked.kept:
        return {}
    found: dict[str, Attribute] = {"dimension": cell.model.dimension}
    for observable in cell.asked.observables:
        found |= observable.parameters(_origin(cell))
    outside = [one for one in cell.asked.observables if is_outside(one)]
    return found | {f"{PREFIX}{one.name}": description(one, found) for one in outside}


def described(cell: Cell) -> dict[str, tuple[str, str]]:
    """Return unit and description of the variables of observables from outside."""
    found: dict[str, tuple[str, str]] = {}
    for observable in cell.asked.observables:
        if is_outside(observable):
            has_units = cell.modulus is not None
            found |= describe_observable(observable, cell.model.dimension, si=has_units)
    return found


def _origin(cell: Cell) -> Origin:
    surface = cell.surface
    if isinstance(surface, SelfAffineSurface):
        spectrum: Spectrum | None = surface.spectrum()
    else:
        known = isinstance(surface, ScanSurface) or cell.is_random
        spectrum = cell.heights.spectrum if known and cell.heights is not None else None
    return Origin(spectrum, cell.model.dimension, cell.pressures)
