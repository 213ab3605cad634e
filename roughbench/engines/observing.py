"""What a spec asks of the fields of states: taken while the curve is computed, and averaged."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SolverError
from roughbench.models.base import Fields, FloatArray, IntArray, Sample, Status
from roughbench.observables import (
    OBSERVABLES,
    Field,
    ObservableName,
    Profile,
    Scales,
    Units,
    exponent,
    of_fields,
    persson_pressure_shares,
    persson_stress_spectrum,
)
from roughbench.observables.fields import mean_and_error
from roughbench.planning.plan import Cell, Task
from roughbench.planning.samples import Surface, rms_of
from roughbench.results import Array, Attribute
from roughbench.spec import SelfAffineSurface
from roughbench.variables import dimensions, scalars_of, variable_of

GAMMA = 0.45
"""Of Persson's stress spectrum beside the models'."""

_SPECTRA: tuple[ObservableName, ...] = ("stress_spectrum", "contact_spectrum")
_PRESSURE, _GAP = "field_pressure.", "field_gap."


class Observer:
    """Takes from the states of one realization what its cell asks of their fields.

    Parameters
    ----------
    task : Task
    realization : int
    sample : Sample

    Attributes
    ----------
    fields : dict of int to Fields
        Those that are kept, by the number of the pressure in the task.
    """

    def __init__(self, task: Task, realization: int, sample: Sample) -> None:
        self.fields: dict[int, Fields] = {}
        self._names = task.cell.asked.observables
        self._kept = {task.pressures.index(p) for p in task.kept(realization)}
        self._n_pressures = len(task.pressures)
        self._sample = sample
        self._between = exponent_range(task.cell.surface)
        self._values: dict[str, Array] = {}
        self._refused: dict[int, SolverError] = {}

    @property
    def is_idle(self) -> bool:
        """Whether nothing is asked for."""
        return not self._names and not self._kept

    def note(self, k: int, take: Callable[[], Fields]) -> None:
        """Look at the state at pressure ``k`` of the task, if there is something to look at."""
        if not self._names and k not in self._kept:
            return
        fields = take()
        if k in self._kept:
            self.fields[k] = fields
        if not self._names:
            return
        try:
            field = of_fields(fields, self._sample.length, self._units())
        except SolverError as error:  # not finite, of a state that did not converge
            self._refused[k] = error
            return
        for name in self._names:
            self._enter(k, name, OBSERVABLES[name](field))

    def _units(self) -> Units:
        if self._sample.spectrum is not None:
            return self._sample.spectrum
        height, slope = rms_of(self._sample)
        return Scales(slope, height)

    def _enter(self, k: int, name: ObservableName, profile: Profile) -> None:
        variable, scalars = variable_of(name), dict(profile.scalars)
        if name in _SPECTRA and self._between is not None:
            scalars["exponent"] = _exponent(profile, *self._between)
        self._values.setdefault(f"{variable}_bin", _places(profile))
        self._values.setdefault(f"{variable}_edges", profile.edges)
        self._row(variable, profile.values.shape)[k] = profile.values
        for scalar, value in scalars.items():
            self._row(scalars_of(name)[scalar])[k] = value

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
        if self._names and not self._values and self._sample.heights is not None:
            self._know_bins(self._sample.heights)
        for name, values in self._values.items():
            if dimensions(name)[0] == "realization":
                values[lost] = math.nan
        return self._values

    def _know_bins(self, heights: FloatArray) -> None:
        """Enter bins without any state: those of a field without contact."""
        none = Fields(np.zeros(heights.shape), np.ones(heights.shape))
        field: Field = of_fields(none, self._sample.length, self._units())
        for name in self._names:
            self._enter(0, name, OBSERVABLES[name](field))


def _places(profile: Profile) -> FloatArray:
    """Return where the values of a profile stand; the middle of a ring without modes."""
    edges = profile.edges
    middle = np.sqrt(edges[1:] * edges[:-1])
    return np.where(np.isnan(profile.places), middle, profile.places)


def exponent_range(surface: Surface) -> tuple[float, float] | None:
    """Return the wavevectors between which spectra of the fields are fitted.

    Returns
    -------
    (float, float) or None
        The larger of twice the roll-off and an eighth of the cut-off, and half the cut-off;
        None for heights from a file.
    """
    if not isinstance(surface, SelfAffineSurface):
        return None
    spectrum = surface.spectrum()
    rolloff = spectrum.q_rolloff or spectrum.q_min
    return max(2.0 * rolloff, spectrum.q_max / 8.0), spectrum.q_max / 2.0


def _exponent(profile: Profile, low: float, high: float) -> float:
    try:
        return exponent([profile], low, high)[0]
    except SolverError:  # too few rings, or none with power: there is no exponent
        return math.nan


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

    Returns
    -------
    dict of str to ndarray
    """
    found: dict[str, Array] = {}
    for name in cell.asked.observables:
        for variable in (variable_of(name), *scalars_of(name).values()):
            if variable in variables:
                mean, sem = _over_realizations(variables[variable], converged)
                found |= {f"{variable}_mean": mean, f"{variable}_sem": sem}
    return found | _persson(cell, variables)


def _over_realizations(
    values: FloatArray, converged: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    mean, sem = np.full((2, *values.shape[1:]), math.nan)
    for k, counts in enumerate(converged.T):
        if counts.any():
            mean[k], sem[k] = mean_and_error(values[counts, k])
    return mean, sem


def _persson(cell: Cell, variables: Mapping[str, Array]) -> dict[str, Array]:
    theory: dict[str, Array] = {}
    if not isinstance(cell.surface, SelfAffineSurface):
        return theory
    spectrum = cell.surface.spectrum()
    if "pressure_pdf" in cell.asked.observables:
        theory["pressure_pdf_persson"] = np.stack(
            [persson_pressure_shares(p, spectrum.rms_slope) for p in cell.pressures]
        )
    if "stress_spectrum" in cell.asked.observables and cell.model.dimension == 2:
        q = variables["stress_spectrum_bin"]
        held = q > spectrum.q_min  # ξ(q) > 0
        values = np.full((len(cell.pressures), q.size), math.nan)
        for k, p in enumerate(cell.pressures):
            values[k, held] = persson_stress_spectrum(spectrum, q[held], p, GAMMA)
        theory["stress_spectrum_persson"] = values
    return theory


def attributes(cell: Cell) -> dict[str, Attribute]:
    """Return what belongs to observables and fields but is no array."""
    asked = cell.asked
    if not asked.observables and not asked.kept:
        return {}
    found: dict[str, Attribute] = {"dimension": cell.model.dimension}
    between = exponent_range(cell.surface)
    if between is not None and not set(_SPECTRA).isdisjoint(asked.observables):
        found |= {"exponent_from": between[0], "exponent_to": between[1]}
    surfaces = between is not None and cell.model.dimension == 2
    if surfaces and "stress_spectrum" in asked.observables:
        found["persson_gamma"] = GAMMA
    return found
