"""Observables of the fields of a spec's contacts, averaged over its realizations.

A run keeps curves; the fields behind them are gone. This module solves the states of a
spec once more, takes from each what the spec's ``observables`` name, and keeps the fields
that ``save_fields`` asks for. Models without a field (theories, asperities) have no part in
it, and it says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import Fault, SolverError, SpecError, SurfaceError
from roughbench.models.base import Model, Sample, Status
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.models.line import Line
from roughbench.models.winkler import Winkler, matched_modulus
from roughbench.observables import (
    OBSERVABLES,
    Average,
    Field,
    Profile,
    Scales,
    Units,
    average,
    exponent,
    of_springs,
    of_state,
    persson_pressure_shares,
    persson_stress_spectrum,
)
from roughbench.runner.plan import Cell, check, plan
from roughbench.runner.samples import make_sample, rms_of
from roughbench.spec import SelfAffineSurface, Spec

GAMMA = 0.45
"""Of Persson's stress spectrum beside the models'."""
FloatArray = NDArray[np.float64]
_SPECTRA = ("stress_spectrum", "contact_spectrum")

Told = Callable[[int, int], None]
"""Called with the states that are done and all there are."""


@dataclass(frozen=True, slots=True)
class Observed:
    """One model in one experiment.

    Attributes
    ----------
    kind, title : str
    dimension : int
        2 for surfaces, 1 for lines.
    pressures : tuple of float
        p/E*.
    averages : mapping of str to sequence of (Average or None)
        By observable; one a pressure, None where no state converged.
    exponents : mapping of str to sequence of (float, float)
        Of the spectra, between ``wavevectors``: mean and standard error, one a pressure;
        nan where a spectrum has too few rings there.
    wavevectors : (float, float) or None
        Largest of twice the roll-off and an eighth of the cut-off, and half the cut-off;
        None without a self-affine spectrum.
    persson : mapping of str to sequence of ndarray
        Persson's theory in the bins of ``pressure_pdf``, and of ``stress_spectrum`` of
        surfaces with γ = 0.45.
    unconverged : sequence of int
        Realizations that are left out, one a pressure.
    count : int
        Realizations.
    """

    kind: str
    title: str
    dimension: int
    pressures: tuple[float, ...]
    averages: Mapping[str, Sequence[Average | None]]
    exponents: Mapping[str, Sequence[tuple[float, float]]]
    wavevectors: tuple[float, float] | None
    persson: Mapping[str, Sequence[FloatArray]]
    unconverged: Sequence[int]
    count: int


@dataclass(frozen=True, slots=True)
class Saved:
    """A state that was asked for.

    Attributes
    ----------
    experiment, label, title : str
    realization : int
    pressure : float
        p/E*.
    state : Field
    status : Status
    """

    experiment: str
    label: str
    title: str
    realization: int
    pressure: float
    state: Field
    status: Status


@dataclass(frozen=True, slots=True)
class Observations:
    """All of a spec.

    Attributes
    ----------
    name, spec_sha256 : str
        Of the spec.
    experiments : mapping of str to mapping of str to Observed
        By experiment and label.
    saved : list of Saved
    without_fields : list of str
        Experiment and label of the models that have none.
    """

    name: str
    spec_sha256: str
    experiments: Mapping[str, Mapping[str, Observed]]
    saved: list[Saved] = field(default_factory=list)
    without_fields: list[str] = field(default_factory=list)


def observe(spec: Spec, *, threads: int = 1, told: Told | None = None) -> Observations:
    """Compute the observables and the fields that a spec asks for.

    Parameters
    ----------
    spec : Spec
        With ``observables`` or ``save_fields``. Observables are taken at all its pressures.
    threads : int
        Of the exact solvers.
    told : callable, optional
        Progress.

    Returns
    -------
    Observations

    Raises
    ------
    SpecError
        If the spec asks for neither.
    SurfaceError
        If a model cannot use the surface.
    """
    names = spec.observables or ()
    if not names and spec.save_fields is None:
        message = (
            "asks for nothing of the fields; give it observables: [pressure_pdf, …] or "
            "save_fields: {pressures: […]}"
        )
        raise SpecError([Fault(message, source=spec.name)])
    cells = plan(spec)
    check(cells)
    with_fields = [cell for cell in cells if has_field(cell.model)]
    kept = _kept(spec)
    total = sum(
        len(_asked(cell, r, names, kept))
        for cell in with_fields
        for r in _realizations(cell, names, kept)
    )
    done = 0
    experiments: dict[str, dict[str, Observed]] = {name: {} for name, _ in spec.experiments()}
    saved: list[Saved] = []
    for cell in with_fields:
        profiles: dict[str, list[list[Profile]]] = {
            name: [[] for _ in cell.pressures] for name in names
        }
        failed = [0] * len(cell.pressures)
        for r in _realizations(cell, names, kept):
            sample = make_sample(cell.surface, cell.model, cell.seed, r)
            for pressure in _asked(cell, r, names, kept):
                state, status = solve_field(
                    cell.model, sample, pressure, _units(sample), threads
                )
                if (r, pressure) in kept:
                    label, title = cell.model.name, cell.model.title
                    saved.append(
                        Saved(cell.experiment, label, title, r, pressure, state, status)
                    )
                if names and r < cell.n_realizations and pressure in cell.pressures:
                    k = cell.pressures.index(pressure)
                    if status != Status.CONVERGED:
                        failed[k] += 1
                    else:
                        for name in names:
                            profiles[name][k].append(OBSERVABLES[name](state))
                done += 1
                if told is not None:
                    told(done, total)
        if names:
            experiments[cell.experiment][cell.model.name] = _summarize(cell, profiles, failed)
    return Observations(
        spec.name,
        spec.sha256,
        experiments,
        saved,
        [str(cell) for cell in cells if not has_field(cell.model)],
    )


def has_field(model: Model) -> bool:
    """Return whether a model solves for pressure and gap at every point."""
    if isinstance(model, Winkler):
        return model.dimension == 2
    return isinstance(model, HalfSpace | Line | Foundation)


def solve_field(
    model: Model, sample: Sample, pressure: float, units: Units, threads: int = 1
) -> tuple[Field, Status]:
    """Return the field of one state.

    Parameters
    ----------
    model : Model
        See :func:`has_field`.
    sample : Sample
        With heights.
    pressure : float
        p/E*.
    units : Units
        rms slope and rms height, as a spectrum has them.
    threads : int
        Of the exact solvers.

    Returns
    -------
    (Field, Status)
        The pressure of the foundation is that per nominal area, (4/π)E*δ/L.

    Raises
    ------
    SurfaceError
        If the model has no field, or the sample no heights.
    """
    if sample.heights is None or not has_field(model):
        raise SurfaceError(f"{model.name} has no field of pressures")
    if isinstance(model, HalfSpace | Line):
        from roughbench.models.halfspace.contact import solve_contact

        solved = solve_contact(
            sample.heights,
            pressure,
            length=sample.length,
            tolerance=model.tolerance,
            precision=model.precision,
            threads=threads,
        )
        return of_state(solved, sample.length, units), Status(solved.status)
    modulus = 4.0 / (math.pi * sample.length)
    if isinstance(model, Winkler):
        modulus = model.modulus or matched_modulus(sample)
    state = of_springs(sample.heights, pressure, modulus, sample.length, units)
    return state, Status.CONVERGED


def _units(sample: Sample) -> Units:
    if sample.spectrum is not None:
        return sample.spectrum
    height, slope = rms_of(sample)
    return Scales(slope, height)


def _kept(spec: Spec) -> set[tuple[int, float]]:
    if spec.save_fields is None:
        return set()
    wanted = spec.save_fields
    return {(r, p) for r in wanted.realizations for p in wanted.pressures}


def _realizations(cell: Cell, names: Sequence[str], kept: set[tuple[int, float]]) -> list[int]:
    """Return the realizations of a cell that are needed."""
    wanted = set(range(cell.n_realizations)) if names else set()
    return sorted(wanted | {r for r, _ in kept})


def _asked(
    cell: Cell, realization: int, names: Sequence[str], kept: set[tuple[int, float]]
) -> list[float]:
    wanted = {p for r, p in kept if r == realization}
    if names and realization < cell.n_realizations:
        wanted |= set(cell.pressures)
    return sorted(wanted)


def _summarize(
    cell: Cell, profiles: Mapping[str, list[list[Profile]]], failed: list[int]
) -> Observed:
    between = _between(cell)
    exponents: dict[str, list[tuple[float, float]]] = {}
    for name in _SPECTRA:
        if between is not None and name in profiles:
            exponents[name] = [_exponent(some, *between) for some in profiles[name]]
    averages = {
        name: [average(some) if some else None for some in columns]
        for name, columns in profiles.items()
    }
    return Observed(
        kind=cell.model.kind,
        title=cell.model.title,
        dimension=cell.model.dimension,
        pressures=cell.pressures,
        averages=averages,
        exponents=exponents,
        wavevectors=between,
        persson=_persson(cell, averages),
        unconverged=failed,
        count=cell.n_realizations,
    )


def _between(cell: Cell) -> tuple[float, float] | None:
    if not isinstance(cell.surface, SelfAffineSurface):
        return None
    spectrum = cell.surface.spectrum()
    rolloff = spectrum.q_rolloff or spectrum.q_min
    return max(2.0 * rolloff, spectrum.q_max / 8.0), spectrum.q_max / 2.0


def _exponent(profiles: list[Profile], low: float, high: float) -> tuple[float, float]:
    try:
        return exponent(profiles, low, high)
    except SolverError:  # too few rings, or none with power: there is no exponent
        return math.nan, math.nan


def _persson(
    cell: Cell, averages: Mapping[str, Sequence[Average | None]]
) -> dict[str, list[FloatArray]]:
    if not isinstance(cell.surface, SelfAffineSurface):
        return {}
    spectrum = cell.surface.spectrum()
    theory = {}
    if "pressure_pdf" in averages:
        theory["pressure_pdf"] = [
            persson_pressure_shares(p, spectrum.rms_slope) for p in cell.pressures
        ]
    if "stress_spectrum" in averages and cell.model.dimension == 2:
        columns = []
        for p, found in zip(cell.pressures, averages["stress_spectrum"], strict=True):
            values = np.full(0 if found is None else found.places.size, math.nan)
            if found is not None:
                held = found.places > spectrum.q_min  # not nan, and ξ(q) > 0
                values[held] = persson_stress_spectrum(spectrum, found.places[held], p, GAMMA)
            columns.append(values)
        theory["stress_spectrum"] = columns
    return theory
