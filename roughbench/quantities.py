"""The quantities of a state, each described once: what all tables, fits and figures read.

A quantity comes from a model as one number for each realization and pressure. One more is one
more entry of :data:`QUANTITIES`, or of another package in the group ``roughbench.quantities``:
runs average and store it, ``show`` and ``export`` list it, fits compare it, and figures and
reports draw it.

>>> QUANTITIES["stiffness"].scaled, QUANTITIES["stiffness"].units()
('K h_rms/E*', '1/length')
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from roughbench.registry import Registry


@dataclass(frozen=True, slots=True)
class Variable:
    """What a variable of a results file means, and its unit: powers of length and modulus.

    Attributes
    ----------
    long_name : str
    length : int
        Power of the length in its unit.
    per_dimension : int
        Further powers for every dimension of the heights: a spectrum of a surface has another
        unit than that of a line.
    modulus : int
        Power of the contact modulus E*, by which values are divided without units.
    """

    long_name: str
    length: int = 0
    per_dimension: int = 0
    modulus: int = 0

    def units(self, dimension: int = 2) -> str:
        """Return the unit; "length" is the spec's length unit, "1" is none.

        Examples
        --------
        >>> Variable("a spectrum", per_dimension=1).units(), Variable("1/K", length=-1).units()
        ('length^2', '1/length')
        """
        power = self._power(dimension)
        return _over(_to_power("length", power), _to_power("length", -power))

    def si_units(self, dimension: int = 2) -> str:
        """Return the unit of a spec with units, as xarray's and pint's users write it.

        Examples
        --------
        >>> [QUANTITIES[name].si_units() for name in ("area", "separation", "stiffness")]
        ['1', 'm', 'Pa/m']
        >>> QUANTITIES["energy"].si_units(), Variable("a spectrum", 2, modulus=2).si_units()
        ('J/m^2', 'Pa^2*m^2')
        """
        power = self._power(dimension)
        if (power, self.modulus) == (1, 1):
            return "J/m^2"
        moduli, lengths = _to_power("Pa", self.modulus), _to_power("m", power)
        above = "*".join(filter(None, (moduli, lengths)))
        below = "*".join(filter(None, (_to_power("Pa", -self.modulus), _to_power("m", -power))))
        return _over(above, below)

    def si_name(self) -> str:
        """Return what it means without the modulus that values are divided by.

        Examples
        --------
        >>> [one.si_name() for one in (PRESSURE, QUANTITIES["energy"], QUANTITIES["area"])]
        ['nominal pressure p', 'elastic energy U/A0', 'real contact area A/A0']
        """
        if not self.modulus:
            return self.long_name
        return re.sub(r" ?/ ?E\*|(?<=[A0]) E\*", "", self.long_name).replace("/(A0)", "/A0")

    def _power(self, dimension: int) -> int:
        return self.length + dimension * self.per_dimension


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity(Variable):
    """A quantity: one number for each realization and pressure.

    Attributes
    ----------
    name : str
        Of its variable, and of its figure.
    words : str
        As in "the contact area" and on an axis.
    symbol : str
        A formula of :mod:`roughbench.notation`, without dollars.
    is_compared : bool
        Whether tables, fits, figures and reports show it; else it is only stored.
    is_expected : bool
        Whether a report names the models that do not give it.
    lowest, highest : float
        What figures cut off at first, scaled.
    at_full_contact : float or None
        The value (0 or inf) that has no place on a logarithmic axis; None where it has one.
    has_harmonic_mean : bool
        Whether 1/⟨1/x⟩ is stored too, which stays finite where single values are infinite.
    digits : int
        That a table shows.
    """

    name: str
    words: str
    symbol: str
    is_compared: bool = True
    is_expected: bool = False
    lowest: float = 0.0
    highest: float = math.inf
    at_full_contact: float | None = None
    has_harmonic_mean: bool = False
    digits: int = 5

    @property
    def averaged(self) -> str:
        """Name of the variable that comparisons take: of the harmonic mean, if there is one."""
        return f"{self.name}_harmonic" if self.has_harmonic_mean else self.name

    @property
    def in_heights(self) -> str:
        """The symbol of the value with lengths in units of h_rms.

        Examples
        --------
        >>> [quantity.in_heights for quantity in QUANTITIES.values() if quantity.is_compared]
        ['A/A_0', 'ū/h_rms', 'K h_rms']
        """
        return self._divided(())

    @property
    def scaled(self) -> str:
        """The symbol of the dimensionless value: lengths in units of h_rms, moduli of E*."""
        return self._divided(("E*",) * self.modulus)

    @property
    def label(self) -> str:
        """What an axis says: words and :attr:`scaled`, for :mod:`roughbench.notation`."""
        return f"{self.words} ${self.scaled}$"

    def unit(self, rms_height: float) -> float:
        """Return what values are divided by to be dimensionless."""
        power = float(rms_height) ** abs(self.length)
        return power if self.length >= 0 else 1.0 / power

    def _divided(self, moduli: tuple[str, ...]) -> str:
        above, _, below = self.symbol.partition("/")
        parts = below.strip("()").split() + ["h_rms"] * self.length + list(moduli)
        above += " h_rms" * -self.length
        if not parts:
            return above
        return f"{above}/{parts[0]}" if len(parts) == 1 else f"{above}/({' '.join(parts)})"


def _to_power(unit: str, power: int) -> str:
    if power <= 0:
        return ""
    return unit if power == 1 else f"{unit}^{power}"


def modulus_power_of(unit: str) -> int:
    """Return the power of E* in a variable from its unit, as :meth:`Variable.si_units` has it.

    Examples
    --------
    >>> [modulus_power_of(unit) for unit in ("Pa/m", "J/m^2", "Pa^2*m^2", "1/Pa", "m", "1")]
    [1, 1, 2, -1, 0, 0]
    """
    found = re.fullmatch(r"(1/\(?)?(?:J|Pa(?:\^(\d+))?)(?:[*/)].*)?", unit)
    if found is None:
        return 0
    power = int(found[2] or 1)
    return -power if found[1] else power


def _over(above: str, below: str) -> str:
    if not below:
        return above or "1"
    return f"{above or 1}/({below})" if "*" in below else f"{above or 1}/{below}"


PRESSURE = Quantity(
    name="pressure",
    long_name="nominal pressure p/E*",
    words="pressure",
    symbol="p",
    modulus=1,
)
"""What everything is a function of."""

_AREA = Quantity(
    name="area",
    long_name="real contact area A/A0",
    words="contact area",
    symbol="A/A_0",
    is_expected=True,
    highest=1.0,  # all of A0; what models without a bound say beyond it is cut off
)
_AREA_RAW = Quantity(
    name="area_raw",
    long_name="contact points / all points",
    words="share of points in contact",
    symbol="A_raw/A_0",
    is_compared=False,
)
_SEPARATION = Quantity(
    name="separation",
    long_name="mean separation",
    words="mean separation",
    symbol="ū",
    is_expected=True,
    length=1,
    lowest=1e-4,  # a hundred times thinner than any drawn gap
    at_full_contact=0.0,
)
_STIFFNESS = Quantity(
    name="stiffness",
    long_name="contact stiffness K/E*",
    words="stiffness",
    symbol="K",
    is_expected=True,
    length=-1,
    modulus=1,
    highest=1e2,  # there is hardly a gap left to close
    at_full_contact=math.inf,
    has_harmonic_mean=True,
)
_ENERGY = Quantity(
    name="energy",
    long_name="elastic energy U/(A0 E*)",
    words="elastic energy",
    symbol="U/A_0",
    length=1,
    modulus=1,
    is_compared=False,
)


_OWN = (_AREA, _AREA_RAW, _SEPARATION, _STIFFNESS, _ENERGY)

QUANTITIES: Mapping[str, Quantity] = Registry(
    "roughbench.quantities", {quantity.name: quantity for quantity in _OWN}
)
"""Name → quantity; all of them are averaged over the realizations, where a model has them."""


def compared() -> dict[str, Quantity]:
    """Return the quantities that tables, fits, figures and reports show."""
    return {name: quantity for name, quantity in QUANTITIES.items() if quantity.is_compared}
