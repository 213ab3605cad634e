"""What the axes of figures and reports show: numbers without units, or SI with one prefix.

Of results without units pressures are p/E* and lengths stand in h_rms. With units an axis is
one of MPa, nm, MPa/nm …: each has a prefix of its own, the same for all curves of a file.

>>> import roughbench as rb
>>> results = rb.run(
...     {
...         "surface": {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1},
...         "pressures": [1e-4, 1e-3, 1e-2],
...         "models": [{"kind": "persson"}],
...     }
... )
>>> axes = axes_of(results)
>>> axes.pressure.label, axes["separation"].label
('pressure $p/E*$', 'mean separation $ū/h_rms$')
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from roughbench.quantities import PRESSURE, QUANTITIES, Quantity
from roughbench.results import ModelResult, Results
from roughbench.units import prefix


@dataclass(frozen=True, slots=True)
class Axis:
    """How the values of a quantity are shown.

    Attributes
    ----------
    quantity : Quantity
    unit : str
        As pint reads it: MPa/nm. Empty without units, and of a fraction.
    factor : float or None
        What values in SI are multiplied with; None without units.
    """

    quantity: Quantity
    unit: str = ""
    factor: float | None = None

    @property
    def symbol(self) -> str:
        """A formula without dollars: ``ū/h_rms``, or ``ū`` where there is a unit."""
        return self.quantity.scaled if self.factor is None else self.quantity.symbol

    @property
    def title(self) -> str:
        """Symbol and unit, without dollars: ``K h_rms/E*``, or ``K (MPa/nm)``."""
        return f"{self.symbol} ({self.unit})" if self.unit else self.symbol

    @property
    def label(self) -> str:
        """Words, symbol and unit, for :mod:`roughbench.notation`."""
        unit = f" ({self.unit})" if self.unit else ""
        return f"{self.quantity.words} ${self.symbol}${unit}"

    def divisor(self, result: ModelResult) -> float:
        """Return what the values of a model are divided by to be shown."""
        if self.factor is None:
            return self.quantity.unit(float(result.attributes["rms_height"]))
        return 1.0 / self.factor

    def limits(self, result: ModelResult) -> tuple[float, float]:
        """Return what a figure cuts off at first, in what is shown."""
        low, high = self.quantity.lowest, self.quantity.highest
        if self.factor is None:
            return low, high
        unit = self.quantity.unit(float(result.attributes["rms_height"])) * self.factor
        unit *= (result.modulus or 1.0) ** self.quantity.modulus
        return low * unit, high * unit


@dataclass(frozen=True, slots=True)
class Axes:
    """The axes of all figures of some results: ``axes["separation"]``, ``axes.pressure``."""

    axes: Mapping[str, Axis]

    def __getitem__(self, name: str) -> Axis:
        return self.axes.get(name) or Axis(QUANTITIES[name])

    @property
    def pressure(self) -> Axis:
        """Of what everything is a function of."""
        return self.axes.get("pressure") or Axis(PRESSURE)

    @property
    def have_units(self) -> bool:
        """Whether they are in SI."""
        return self.pressure.factor is not None


BARE = Axes({})
"""Without units."""


def axes_of(results: Results) -> Axes:
    """Return the axes that suit results: one prefix for each quantity."""
    if not results.has_units:
        return BARE
    found = {}
    for quantity in (PRESSURE, *QUANTITIES.values()):
        name = "pressure" if quantity is PRESSURE else f"{quantity.name}_mean"
        values = [one[name] for _, one in results.models() if name in one]
        if values:
            known = np.concatenate([np.ravel(array) for array in values]).tolist()
            factor, unit = prefix(known, quantity.si_units())
            found[quantity.name] = Axis(quantity, "" if unit == "1" else unit, factor)
    return Axes(found)
