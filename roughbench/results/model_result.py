"""The curves of one model in one experiment, with their dimensions and units."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from roughbench.ensemble import STATISTICS
from roughbench.errors import UnknownNameError
from roughbench.results import display, tabular
from roughbench.results.scaling import Array, Scaled
from roughbench.units import prefix
from roughbench.variables import long_name_of, quantity_of, units_of

if TYPE_CHECKING:
    from roughbench.labelled import DataFrame, Dataset

Attribute = str | int | float
MODULUS = "contact_modulus"
"""Attribute of results with units: E*, Pa."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
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
        the model's parameters. Of a spec with units lengths are in m, and
        ``contact_modulus`` is E* in Pa.
    variables : mapping of str to ndarray
        Arrays by name; also ``result["area_mean"]``.
    described : mapping of str to (str, str)
        Unit and description of variables that only their file knows: those of packages that
        are not installed.
    made_with : mapping of str to str or int
        What its states were computed with: versions by package, ``python``, ``platform``,
        ``code``, and ``fft`` and ``threads`` where numbers depend on them. Empty where a file
        of an earlier version does not say.
    """

    label: str
    kind: str
    title: str
    attributes: Mapping[str, Attribute]
    variables: Mapping[str, Array]
    described: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    made_with: Mapping[str, str | int] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self.variables:
            quantity = quantity_of(name)
            if quantity is not None and quantity not in self.variables:
                raise UnknownNameError(
                    f"{self.title} ({self.label}) does not give {name}: it "
                    f"knows no {long_name_of(quantity)}"
                )
            raise display.unknown_name("variable", name, list(self.variables), self.primary())
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

    @property
    def is_random(self) -> bool:
        """Whether it looked at random heights, so that realizations differ."""
        if self.is_measured:
            return "drawn" in self.attributes
        return "grid_points" in self.attributes

    @property
    def is_measured(self) -> bool:
        """Whether its surface was measured, or its spectrum was."""
        return self.attributes.get("surface") in ("file", "scan")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What makes answers on its measured surface doubtful, a sentence each."""
        try:
            found = json.loads(str(self.attributes.get("warnings", "[]")))
        except ValueError:
            return ()
        return tuple(map(str, found)) if isinstance(found, list) else ()

    @property
    def modulus(self) -> float | None:
        """Contact modulus E*, Pa; None without units, where pressures are p/E*."""
        found = self.attributes.get(MODULUS)
        return None if found is None else float(found)

    @property
    def has_units(self) -> bool:
        """Whether variables are in SI; else pressures are p/E*, lengths in any one unit."""
        return MODULUS in self.attributes

    def units(self, name: str) -> str:
        """Return the unit of a variable: "1" is none.

        With units it is one of SI, such as "Pa/m"; else "length" is the spec's length unit.
        """
        if name in self.described:
            return self.described[name][0]
        dimension = 1 if self.attributes.get("dimension") == 1 else 2
        return units_of(name, dimension, si=self.has_units)

    def long_name(self, name: str) -> str:
        """Return the description of a variable in words."""
        if name in self.described:
            return self.described[name][1]
        return long_name_of(name, si=self.has_units)

    def prefixed(self, name: str, of: str = "") -> tuple[float, str]:
        """Return a factor and a unit that suit all values of a variable, as nm for m.

        Parameters
        ----------
        name : str
        of : str
            Variable of the same unit that is shown; default: itself.
        """
        unit = self.units(name)
        if not self.has_units:
            return 1.0, unit
        return prefix(np.ravel(self[of or name]).tolist(), unit)

    def in_si(self, modulus: float) -> ModelResult:
        """Return what was computed with E* = 1 and lengths in m as of a contact modulus.

        Parameters
        ----------
        modulus : float
            E*, Pa.
        """
        attributes = {**self.attributes, MODULUS: float(modulus)}
        units = {name: unit for name, (unit, _) in self.described.items()}
        variables = dict(Scaled(self.variables, float(modulus), units))
        return replace(self, attributes=attributes, variables=variables)

    def reduced(self) -> ModelResult:
        """Return these results without units: p/E*, K/E* and U/(A0 E*), lengths in m.

        What compares models, and laws between dimensionless numbers, works with these. They
        are themselves where there are no units.
        """
        if self.modulus is None:
            return self
        attributes = {name: one for name, one in self.attributes.items() if name != MODULUS}
        units = {name: unit for name, (unit, _) in self.described.items()}
        variables = Scaled(self.variables, 1.0 / self.modulus, units)
        return replace(self, attributes=attributes, variables=variables)

    def primary(self) -> list[str]:
        """Return the variables without those that are statistics of another."""
        ends = tuple(f"_{statistic}" for statistic in STATISTICS)
        return [name for name in self.variables if not name.endswith(ends)]

    def to_xarray(self) -> Dataset:
        """Return the variables as a dataset of xarray, with dimensions, units and names.

        Raises
        ------
        RoughbenchError
            Without xarray.
        """
        return tabular.model_dataset(self)

    def to_frame(self, *, averages: bool = True) -> DataFrame:
        """Return the curves as a table of pandas, see :meth:`Results.to_frame`."""
        return tabular.model_frame(self, averages=averages)

    def __repr__(self) -> str:
        return display.model_text(self)

    def _repr_html_(self) -> str:
        return display.model_table(self)
