"""What a run leaves: arrays by experiment, model and name, with their dimensions and units."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.variables import long_name_of, units_of

Array = NDArray[Any]
"""float64, float32, int64 or int32, as the results file knows them."""
Attribute = str | int | float


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
        return units_of(name, 1 if self.attributes.get("dimension") == 1 else 2)

    def long_name(self, name: str) -> str:
        """Return the description of a variable in words."""
        return long_name_of(name)


class MadeWhenAsked(Mapping[str, ModelResult]):
    """Results of models that are made whenever one is asked for, and not kept.

    Parameters
    ----------
    make : mapping of str to callable
        By label.
    """

    def __init__(self, make: Mapping[str, Callable[[], ModelResult]]) -> None:
        self._make = make

    def __getitem__(self, label: str) -> ModelResult:
        return self._make[label]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._make)

    def __len__(self) -> int:
        return len(self._make)


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
