"""The variables of a results file: their dimensions, units and descriptions, by name.

Quantities and observables describe themselves; here their variables are put together with
what every file has.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from roughbench.ensemble import STATISTICS
from roughbench.errors import RoughbenchError
from roughbench.observables import OBSERVABLES, Observable
from roughbench.quantities import PRESSURE, QUANTITIES, Variable

STORABLE = tuple(np.dtype(name) for name in ("f4", "f8", "i4", "i8"))
"""Types of arrays in results files and shards."""

Axes = tuple[str, ...]

STATES: Axes = ("realization", "pressure")
_AT_POINTS: Axes = ("field", "y", "x")
_FIELDS: dict[str, tuple[Axes, Variable]] = {
    "field_realization": (("field",), Variable("realization of the field")),
    "field_nominal_pressure": (
        ("field",),
        Variable("nominal pressure p/E* of the field", modulus=1),
    ),
    "field_status": (
        ("field",),
        Variable("how the computation of the field's state ended"),
    ),
    "field_pressure": (_AT_POINTS, Variable("contact pressure / E* at every point", modulus=1)),
    "field_gap": (_AT_POINTS, Variable("gap at every point", length=1)),
}
FIELD_VARIABLES = tuple(_FIELDS)
"""Of states whose fields are kept."""

_OTHERS: dict[str, tuple[Axes, Variable]] = {
    "realization": (("realization",), Variable("index of the realization")),
    "status": (STATES, Variable("how the computation of the state ended")),
    "plastic_depth": (
        STATES,
        Variable("mean depth to which plastic points have given way", length=1),
    ),
    "n_converged": (("pressure",), Variable("number of converged realizations")),
    "rms_height": (
        ("realization",),
        Variable("rms height of the realized surface", length=1),
    ),
    "rms_slope": (("realization",), Variable("rms slope of the realized surface")),
    "field": (("field",), Variable("index of the field")),
    "x": (("x",), Variable("position along the last axis", length=1)),
    "y": (("y",), Variable("position along the first axis of a surface", length=1)),
}


def _of_quantities() -> Iterator[tuple[str, Axes, Variable]]:
    yield "pressure", ("pressure",), PRESSURE
    for name, quantity in QUANTITIES.items():
        yield name, STATES, quantity
        yield from _summaries(name, ("pressure",), quantity, tuple(STATISTICS))
        if quantity.has_harmonic_mean:
            words = f"harmonic mean of the {quantity.long_name}"
            yield f"{name}_harmonic", ("pressure",), _renamed(quantity, words)


def _of_observable(observable: Observable) -> Iterator[tuple[str, Axes, Variable]]:
    name, values, places = observable.variable, observable.values, observable.places
    bins, edges = f"{name}_bin", f"{name}_edges"
    theory = _renamed(values, f"{values.long_name}, Persson's theory")
    yield name, (*STATES, bins), values
    yield f"{name}_persson", ("pressure", bins), theory
    yield bins, (bins,), places
    yield edges, (edges,), _renamed(places, "ends of the bins")
    yield from _summaries(name, ("pressure", bins), values)
    for scalar, variable in observable.scalar_variables().items():
        meaning = observable.scalars[scalar]
        yield variable, STATES, meaning
        yield from _summaries(variable, ("pressure",), meaning)


def _summaries(
    name: str, axes: Axes, variable: Variable, kinds: Sequence[str] = ("mean", "sem")
) -> Iterator[tuple[str, Axes, Variable]]:
    for kind in kinds:
        words = f"{variable.long_name}, {STATISTICS[kind]}"
        yield f"{name}_{kind}", axes, _renamed(variable, words)


def _renamed(variable: Variable, long_name: str) -> Variable:
    return Variable(long_name, variable.length, variable.per_dimension, variable.modulus)


@functools.cache
def _known() -> dict[str, tuple[Axes, Variable]]:
    known = _OTHERS | _FIELDS
    described = [*_of_quantities()]
    for observable in OBSERVABLES.values():
        described += _of_observable(observable)
    for name, axes, variable in described:
        if name in known:
            raise RoughbenchError(
                f"two quantities or observables have a variable {name!r}; rename one of them"
            )
        known[name] = axes, variable
    return known


def dimensions(name: str, n_axes: int | None = None) -> Axes:
    """Names of the dimensions of a variable.

    Everything that is not known to have others, such as a model's diagnostics, has a value
    for every realization and pressure.

    Parameters
    ----------
    name : str
    n_axes : int, optional
        Of the array: tells the fields of lines (2) from those of surfaces, and what an
        observable of a package that is not installed has left in a file.

    Examples
    --------
    >>> dimensions("area"), dimensions("area_mean"), dimensions("rms_slope")
    (('realization', 'pressure'), ('pressure',), ('realization',))
    >>> dimensions("clusters"), dimensions("field_gap"), dimensions("field_gap", 2)
    (('realization', 'pressure', 'clusters_bin'), ('field', 'y', 'x'), ('field', 'x'))
    >>> dimensions("unknown", 3), dimensions("unknown_sem", 2), dimensions("unknown_bin", 1)
    (('realization', 'pressure', 'unknown_bin'), ('pressure', 'unknown_bin'), ('unknown_bin',))
    """
    if is_known(name):
        axes, _ = _known()[name]
        return ("field", "x") if axes == _AT_POINTS and n_axes == 2 else axes
    if n_axes == 1 and name.endswith("_drawn_unit"):
        return (f"{name.removesuffix('_drawn_unit')}_bin",)
    if n_axes == 1:
        return (name,) if name.endswith(("_bin", "_edges")) else ("pressure",)
    if n_axes == 2 and name.endswith(("_mean", "_sem", "_persson")):
        return ("pressure", f"{name.rpartition('_')[0]}_bin")
    return (*STATES, f"{name}_bin") if n_axes == 3 else STATES


def bins_of(observables: Iterable[Observable]) -> set[str]:
    """Return the variables that say where the values of observables stand: one for all states.

    Examples
    --------
    >>> sorted(bins_of([OBSERVABLES["gap_pdf"]]))
    ['gap_pdf_bin', 'gap_pdf_edges']
    """
    return {f"{one.variable}_{end}" for one in observables for end in ("bin", "edges")}


def check_variables(observables: Iterable[Observable]) -> None:
    """Refuse observables of files whose variables are others' too.

    Raises
    ------
    RoughbenchError
        That names one.
    """
    taken = dict.fromkeys(_known(), "roughbench")
    for observable in observables:
        if OBSERVABLES.get(observable.name) is observable:
            continue
        names = [name for name, _, _ in _of_observable(observable)]
        for name in names:
            if name in taken or names.count(name) > 1:
                raise RoughbenchError(
                    f"the observable {observable.name} would have a variable {name!r}, which "
                    f"is there already, of {taken.get(name, observable.name)}; rename it, its "
                    "variable or its scalars"
                )
        taken |= dict.fromkeys(names, observable.name)


def describe_observable(
    observable: Observable, dimension: int, *, si: bool = False
) -> dict[str, tuple[str, str]]:
    """Return unit and description of every variable of an observable, by name.

    Parameters
    ----------
    observable : Observable
    dimension : int
        Of the heights.
    si : bool
        Of a spec with units.
    """
    values, words = observable.values, "what figures divide the values by"
    drawn = Variable(words, values.length, values.per_dimension)  # E* is divided by apart
    variables = {name: variable for name, _, variable in _of_observable(observable)}
    variables[f"{observable.variable}_drawn_unit"] = drawn
    return {
        name: (one.si_units(dimension) if si else one.units(dimension), one.long_name)
        for name, one in variables.items()
    }


def every_variable() -> dict[str, tuple[Axes, Variable]]:
    """Return dimensions, unit and description of every variable that is known, by name.

    Examples
    --------
    >>> axes, separation = every_variable()["separation_mean"]
    >>> axes, separation.units(), separation.long_name
    (('pressure',), 'length', 'mean separation, mean')
    """
    return dict(_known())


def is_known(name: str) -> bool:
    """Return whether a variable is described here: a diagnostic of a model is not."""
    return name in _known()


def compare_shape(
    name: str, shape: Sequence[int], lengths: dict[str, int]
) -> tuple[bool, tuple[int, ...]]:
    """Return whether a shape agrees with lengths of dimensions, and the shape that would.

    Parameters
    ----------
    name : str
        Of a variable.
    shape : sequence of int
    lengths : dict of str to int
        By dimension; those that are not known yet are taken from ``shape``.
    """
    axes = dimensions(name, len(shape))
    for axis, length in zip(axes, shape, strict=False):
        lengths.setdefault(axis, length)
    wanted = tuple(lengths.get(axis, 0) for axis in axes)
    return wanted == tuple(shape), wanted


def _variable(name: str) -> Variable:
    return _known().get(name, (STATES, Variable(name.replace("_", " "))))[1]


def modulus_power(name: str) -> int:
    """Return which power of E* the values of a variable are divided by without units.

    Examples
    --------
    >>> modulus_power("stiffness_mean"), modulus_power("separation"), modulus_power("status")
    (1, 0, 0)
    """
    return _variable(name).modulus


def units_of(name: str, dimension: int = 2, *, si: bool = False) -> str:
    """Return the unit of a variable; "length" is the spec's length unit, "1" is none.

    Parameters
    ----------
    name : str
    dimension : int
        Of the heights: the spectra of a line have another unit than those of a surface.
    si : bool
        Of a spec with units.

    Examples
    --------
    >>> units_of("separation_sem"), units_of("stress_spectrum"), units_of("stress_spectrum", 1)
    ('length', 'length^2', 'length')
    >>> units_of("stiffness", si=True), units_of("stress_spectrum", si=True)
    ('Pa/m', 'Pa^2*m^2')
    """
    variable = _variable(name)
    return variable.si_units(dimension) if si else variable.units(dimension)


def quantity_of(name: str) -> str | None:
    """Return which of the quantities a variable is, or is an average of.

    Examples
    --------
    >>> quantity_of("area_sem"), quantity_of("stiffness_harmonic"), quantity_of("status")
    ('area', 'stiffness', None)
    """
    base, _, end = name.rpartition("_")
    if end == "harmonic" or end in STATISTICS:
        name = base
    return name if name in QUANTITIES else None


def long_name_of(name: str, *, si: bool = False) -> str:
    """Return the description of a variable in words; ``si``: of a spec with units.

    Examples
    --------
    >>> long_name_of("area_mean"), long_name_of("transform_pairs")
    ('real contact area A/A0, mean', 'transform pairs')
    >>> long_name_of("stiffness_sem"), long_name_of("stiffness_sem", si=True)
    ('contact stiffness K/E*, standard error of the mean',
     'contact stiffness K, standard error of the mean')
    """
    variable = _variable(name)
    return variable.si_name() if si else variable.long_name
