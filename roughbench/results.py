"""What a run leaves: arrays by experiment, model and name, with their dimensions and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.ensemble import STATISTICS

Array = NDArray[Any]
"""float64, float32, int64 or int32, as the results file knows them."""
Attribute = str | int | float


@dataclass(frozen=True, slots=True)
class _Meaning:
    """Unit and description of one variable."""

    units: str
    long_name: str


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


def dimensions(name: str) -> tuple[str, ...]:
    """Names of the dimensions of a variable.

    Everything that is not known to be one value a pressure or one a realization, such
    as a model's diagnostics, has both.

    Examples
    --------
    >>> dimensions("area"), dimensions("area_mean"), dimensions("rms_slope")
    (('realization', 'pressure'), ('pressure',), ('realization',))
    """
    if name in _PER_PRESSURE:
        return ("pressure",)
    if name in _PER_REALIZATION:
        return ("realization",)
    return ("realization", "pressure")


@dataclass(frozen=True, slots=True, eq=False)
class ModelResult:
    """The curves of one model in one experiment.

    Attributes
    ----------
    label : str
        Name of the model in the results.
    kind, title : str
        Kind of the model in a spec, and its name in legends and tables.
    attributes : mapping of str to str, int or float
        ``length``, ``rms_height`` and ``rms_slope`` of the spectrum, the surface's and
        the model's parameters.
    variables : mapping of str to ndarray
        Arrays by name; also ``result["area_mean"]``.
    """

    label: str
    kind: str
    title: str
    attributes: Mapping[str, Attribute]
    variables: Mapping[str, Array]

    def __getitem__(self, name: str) -> Array:
        return self.variables[name]

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    @property
    def n_realizations(self) -> int:
        """Number of realizations."""
        return int(self.variables["status"].shape[0])

    @property
    def n_states(self) -> int:
        """Number of states: realizations × pressures."""
        return int(self.variables["status"].size)

    @property
    def n_unconverged(self) -> int:
        """Number of states that did not converge and are left out of the averages."""
        return int(np.count_nonzero(self.variables["status"]))

    def units(self, name: str) -> str:
        """Return the unit of a variable; "length" is the spec's length unit, "1" is none."""
        base, _ = _SUMMARIES.get(name, (name, ""))
        return _MEANING[base].units if base in _MEANING else "1"

    def long_name(self, name: str) -> str:
        """Return the description of a variable in words."""
        base, kind = _SUMMARIES.get(name, (name, ""))
        words = _MEANING[base].long_name if base in _MEANING else base.replace("_", " ")
        return f"{words}, {_STATISTIC[kind]}" if kind else words


@dataclass(frozen=True, slots=True, eq=False)
class Results(Mapping[str, Mapping[str, ModelResult]]):
    """The results of a run: ``results["main"]["bem"]["area_mean"]``.

    Attributes
    ----------
    experiments : mapping of str to mapping of str to ModelResult
        By experiment (``main`` without a sweep) and label, in the order of the spec.
    spec_text : str
        The spec as YAML.
    spec_sha256 : str
        Hash of the resolved spec.
    name : str
        Name of the run.
    """

    experiments: Mapping[str, Mapping[str, ModelResult]]
    spec_text: str
    spec_sha256: str
    name: str = ""

    def __getitem__(self, experiment: str) -> Mapping[str, ModelResult]:
        return self.experiments[experiment]

    def __iter__(self) -> Iterator[str]:
        return iter(self.experiments)

    def __len__(self) -> int:
        return len(self.experiments)

    def models(self) -> Iterator[tuple[str, ModelResult]]:
        """Every (experiment, result), in the order of the spec.

        Yields
        ------
        (str, ModelResult)
        """
        for experiment, models in self.experiments.items():
            for result in models.values():
                yield experiment, result
