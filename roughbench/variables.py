"""The variables of a results file: their dimensions, units and descriptions, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from roughbench.ensemble import STATISTICS
from roughbench.observables import ObservableName


@dataclass(frozen=True, slots=True)
class _Meaning:
    """Unit and description of one variable."""

    units: str
    long_name: str


STORABLE = tuple(np.dtype(name) for name in ("f4", "f8", "i4", "i8"))
"""Types of arrays in results files and shards."""

AVERAGED = ("area", "area_raw", "separation", "stiffness", "energy")
"""Variables that are summarized over the realizations, where a model has them."""

_MEANING = {
    "realization": _Meaning("1", "index of the realization"),
    "pressure": _Meaning("1", "nominal pressure p/E*"),
    "area": _Meaning("1", "real contact area A/A0"),
    "area_raw": _Meaning("1", "contact points / all points"),
    "separation": _Meaning("length", "mean separation"),
    "stiffness": _Meaning("1/length", "contact stiffness K/E*"),
    "stiffness_harmonic": _Meaning("1/length", "harmonic mean of the contact stiffness K/E*"),
    "energy": _Meaning("length", "elastic energy U/(A0 E*)"),
    "status": _Meaning("1", "how the computation of the state ended"),
    "n_converged": _Meaning("1", "number of converged realizations"),
    "rms_height": _Meaning("length", "rms height of the realized surface"),
    "rms_slope": _Meaning("1", "rms slope of the realized surface"),
}


@dataclass(frozen=True, slots=True)
class _Observable:
    """What the variables of one observable mean: its values, their places, single numbers."""

    values: _Meaning
    places: _Meaning
    scalars: Mapping[str, _Meaning]


_WAVEVECTOR = _Meaning("1/length", "wavevector q")
_IN_CONTACT = _Meaning("1", "points in contact / all points")
_OBSERVABLE: Mapping[ObservableName, _Observable] = {
    "pressure_pdf": _Observable(
        _Meaning("1", "density of the contact pressure over all points, per E* ξ"),
        _Meaning("1", "contact pressure / (E* ξ)"),
        {
            "contact": _IN_CONTACT,
            "nominal": _Meaning("1", "nominal pressure p/(E* ξ)"),
            "above": _Meaning("1", "share of points with a pressure above the bins"),
        },
    ),
    "gap_pdf": _Observable(
        _Meaning("1", "density of the gap out of contact over all points, per h_rms"),
        _Meaning("1", "gap / h_rms"),
        {
            "contact": _IN_CONTACT,
            "separation": _Meaning("1", "mean separation / h_rms"),
            "below": _Meaning("1", "share of points with a gap below the bins"),
            "above": _Meaning("1", "share of points with a gap above the bins"),
        },
    ),
    "stress_spectrum": _Observable(
        _Meaning("length^d", "power spectrum C(q) of the contact pressure / E*"),
        _WAVEVECTOR,
        {
            "variance": _Meaning("1", "variance of the contact pressure / E*"),
            "exponent": _Meaning("1", "exponent of the power spectrum of the pressure"),
        },
    ),
    "contact_spectrum": _Observable(
        _Meaning("length^d", "power spectrum C(q) of the contact, 1 in it and 0 elsewhere"),
        _WAVEVECTOR,
        {
            "variance": _Meaning("1", "variance of the contact, 1 in it and 0 elsewhere"),
            "exponent": _Meaning("1", "exponent of the power spectrum of the contact"),
        },
    ),
    "energy": _Observable(
        _Meaning("length", "elastic energy U/(A0 E*) held by a ring of wavevectors"),
        _WAVEVECTOR,
        {"total": _Meaning("length", "elastic energy U/(A0 E*) held by all wavevectors")},
    ),
    "clusters": _Observable(
        _Meaning("1", "number of patches of contact"),
        _Meaning("1", "least size of a patch, points"),
        {
            "number": _Meaning("1", "number of patches of all sizes"),
            "mean_area": _Meaning("1", "mean area of a patch / A0"),
            "largest_area": _Meaning("1", "area of the largest patch / A0"),
            "perimeter": _Meaning("length^(d-1)", "perimeter of all patches"),
        },
    ),
}
_BY_DIMENSION = {
    1: {"length^d": "length", "length^(d-1)": "1"},
    2: {"length^d": "length^2", "length^(d-1)": "length"},
}


def variable_of(observable: ObservableName) -> str:
    """Return the name of an observable's variable; ``energy`` is one of the curves' already.

    Examples
    --------
    >>> variable_of("clusters"), variable_of("energy")
    ('clusters', 'energy_spectrum')
    """
    return "energy_spectrum" if observable == "energy" else observable


def scalars_of(observable: ObservableName) -> dict[str, str]:
    """Return the single numbers of an observable, by name: their variables.

    Examples
    --------
    >>> scalars_of("stress_spectrum")["exponent"]
    'stress_spectrum_exponent'
    """
    name = variable_of(observable)
    return {scalar: f"{name}_{scalar}" for scalar in _OBSERVABLE[observable].scalars}


_FIELD = {
    "field": _Meaning("1", "index of the field"),
    "field_realization": _Meaning("1", "realization of the field"),
    "field_nominal_pressure": _Meaning("1", "nominal pressure p/E* of the field"),
    "field_status": _Meaning("1", "how the computation of the field's state ended"),
    "field_pressure": _Meaning("1", "contact pressure / E* at every point"),
    "field_gap": _Meaning("length", "gap at every point"),
    "x": _Meaning("length", "position along the last axis"),
    "y": _Meaning("length", "position along the first axis of a surface"),
}
FIELD_VARIABLES = tuple(name for name in _FIELD if name.startswith("field_"))
"""Of states whose fields are kept."""
_STATISTIC = {
    "mean": "mean",
    "sem": "standard error of the mean",
    "median": "median",
    "q16": "16 % quantile",
    "q84": "84 % quantile",
}
_SUMMARIES = {f"{name}_{kind}": (name, kind) for name in AVERAGED for kind in STATISTICS}
_PER_PRESSURE = {"pressure", "n_converged", "stiffness_harmonic", *_SUMMARIES}
_PER_REALIZATION = {"realization", "rms_height", "rms_slope"}


def _collect() -> dict[str, tuple[str, ...]]:
    """Return the dimensions of all variables that do not have a value for every state.

    Adds the variables of the observables to the tables above.
    """
    known: dict[str, tuple[str, ...]] = dict.fromkeys(_PER_PRESSURE, ("pressure",))
    known |= dict.fromkeys(_PER_REALIZATION, ("realization",))
    known |= dict.fromkeys(["field", *FIELD_VARIABLES], ("field",))
    known |= {"x": ("x",), "y": ("y",)}
    known |= dict.fromkeys(["field_pressure", "field_gap"], ("field", "y", "x"))
    _MEANING.update(_FIELD)
    for observable, meaning in _OBSERVABLE.items():
        name = variable_of(observable)
        places, edges, theory = f"{name}_bin", f"{name}_edges", f"{name}_persson"
        words = meaning.values.long_name
        _MEANING[name] = meaning.values
        _MEANING[places] = meaning.places
        _MEANING[edges] = _Meaning(meaning.places.units, "ends of the bins")
        _MEANING[theory] = _Meaning(meaning.values.units, f"{words}, Persson's theory")
        known |= {name: ("realization", "pressure", places), theory: ("pressure", places)}
        known |= {places: (places,), edges: (edges,)}
        for scalar, variable in scalars_of(observable).items():
            _MEANING[variable] = meaning.scalars[scalar]
            for kind in ("mean", "sem"):
                _SUMMARIES[f"{variable}_{kind}"] = variable, kind
                known[f"{variable}_{kind}"] = ("pressure",)
        for kind in ("mean", "sem"):
            _SUMMARIES[f"{name}_{kind}"] = name, kind
            known[f"{name}_{kind}"] = ("pressure", places)
    return known


_DIMENSIONS = _collect()


def dimensions(name: str, n_axes: int = 3) -> tuple[str, ...]:
    """Names of the dimensions of a variable.

    Everything that is not known to have others, such as a model's diagnostics, has a value
    for every realization and pressure.

    Parameters
    ----------
    name : str
    n_axes : int
        Of the array: tells the fields of lines (2) from those of surfaces.

    Examples
    --------
    >>> dimensions("area"), dimensions("area_mean"), dimensions("rms_slope")
    (('realization', 'pressure'), ('pressure',), ('realization',))
    >>> dimensions("clusters"), dimensions("field_gap"), dimensions("field_gap", 2)
    (('realization', 'pressure', 'clusters_bin'), ('field', 'y', 'x'), ('field', 'x'))
    """
    axes = _DIMENSIONS.get(name, ("realization", "pressure"))
    return ("field", "x") if axes == ("field", "y", "x") and n_axes == 2 else axes


def fits(
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


def units_of(name: str, dimension: int = 2) -> str:
    """Return the unit of a variable; "length" is the spec's length unit, "1" is none.

    Parameters
    ----------
    name : str
    dimension : int
        Of the heights: the spectra of a line have another unit than those of a surface.

    Examples
    --------
    >>> units_of("separation_sem"), units_of("stress_spectrum"), units_of("stress_spectrum", 1)
    ('length', 'length^2', 'length')
    """
    base, _ = _SUMMARIES.get(name, (name, ""))
    units = _MEANING[base].units if base in _MEANING else "1"
    return _BY_DIMENSION[dimension].get(units, units)


def quantity_of(name: str) -> str | None:
    """Return which of :data:`AVERAGED` a variable is, or is an average of.

    Examples
    --------
    >>> quantity_of("area_sem"), quantity_of("stiffness_harmonic"), quantity_of("status")
    ('area', 'stiffness', None)
    """
    base = "stiffness" if name == "stiffness_harmonic" else _SUMMARIES.get(name, (name, ""))[0]
    return base if base in AVERAGED else None


def long_name_of(name: str) -> str:
    """Return the description of a variable in words.

    Examples
    --------
    >>> long_name_of("area_mean"), long_name_of("transform_pairs")
    ('real contact area A/A0, mean', 'transform pairs')
    """
    base, kind = _SUMMARIES.get(name, (name, ""))
    words = _MEANING[base].long_name if base in _MEANING else base.replace("_", " ")
    return f"{words}, {_STATISTIC[kind]}" if kind else words
