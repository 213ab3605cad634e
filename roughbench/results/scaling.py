"""Variables with units made of those without, and back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from numpy.typing import NDArray

from roughbench.quantities import modulus_power_of
from roughbench.variables import modulus_power

Array = NDArray[Any]
"""float64, float32, int64 or int32, as the results file knows them."""


class Scaled(Mapping[str, Array]):
    """Variables times E* to the power that each has of it; made whenever one is asked for.

    Of a variable that only its file knows, its unit tells the power.
    """

    def __init__(
        self,
        variables: Mapping[str, Array],
        modulus: float,
        units: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._variables, self._modulus, self._units = variables, modulus, units

    def __getitem__(self, name: str) -> Array:
        values = self._variables[name]
        power = (
            modulus_power_of(self._units[name]) if name in self._units else modulus_power(name)
        )
        return values * self._modulus**power if power else values

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)
