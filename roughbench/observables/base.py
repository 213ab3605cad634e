"""What describes an observable: one class says all that anything needs to know of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from roughbench.errors import SolverError
from roughbench.observables.fields import Field, FloatArray, Profile
from roughbench.quantities import Variable
from roughbench.spectrum import Spectrum

IN_CONTACT = Variable("points in contact / all points")


@dataclass(frozen=True, slots=True)
class Origin:
    """What the fields of a model's states come from.

    Attributes
    ----------
    spectrum : Spectrum or None
        Of the surfaces; None for heights from a file.
    dimension : int
        1 for lines, 2 for surfaces.
    pressures : tuple of float
        p/E* of the states.
    """

    spectrum: Spectrum | None
    dimension: int
    pressures: tuple[float, ...]


class Observable(ABC):
    """A function of the fields of a state, with values over bins and single numbers.

    An instance is called with a :class:`~roughbench.observables.Field` and returns a
    :class:`~roughbench.observables.Profile`. Titles and axes may hold formulas of
    :mod:`roughbench.notation`.

    Attributes
    ----------
    name : str
        In specs.
    variable : str
        Of the results file, and of the figure; its name, if it gives no other.
    title : str
    x, y : str
        What figures write at the axes.
    x_is_log : bool
        Whether the abscissa is logarithmic; the ordinate is.
    values, places : Variable
        What the values are, and what they are a function of.
    scalars : mapping of str to Variable
        Single numbers that belong to it.
    attributes : tuple of str
        Names of what :meth:`parameters` returns.
    is_in_heights : bool
        Whether places are in units of h_rms, which a figure then has to name.
    """

    name: ClassVar[str]
    variable: ClassVar[str]
    title: ClassVar[str]
    x: ClassVar[str]
    y: ClassVar[str]
    x_is_log: ClassVar[bool] = True
    values: ClassVar[Variable]
    places: ClassVar[Variable]
    scalars: ClassVar[Mapping[str, Variable]] = {}
    attributes: ClassVar[tuple[str, ...]] = ()
    is_in_heights: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        if "name" in cls.__dict__ and "variable" not in cls.__dict__:
            cls.variable = cls.name

    @abstractmethod
    def compute(self, field: Field) -> Profile:
        """Return the observable of one state; the bins are the same for an ensemble."""

    def theory(self, origin: Origin, places: FloatArray) -> FloatArray | None:  # noqa: ARG002
        """Return what Persson's theory says, None for nothing.

        Parameters
        ----------
        origin : Origin
        places : ndarray of float64, shape (K,)

        Returns
        -------
        ndarray of float64, shape (pressures, K), or None
        """
        return None

    def theory_title(self, attributes: Mapping[str, object]) -> str:  # noqa: ARG002
        """Return how a figure calls Persson's theory, from the attributes of a result."""
        return "Persson"

    def parameters(self, origin: Origin) -> Mapping[str, float]:  # noqa: ARG002
        """Return what belongs to the observable of a model but is no array."""
        return {}

    def drawn_unit(self, places: FloatArray, dimension: int) -> FloatArray:  # noqa: ARG002
        """Return what figures divide the values by."""
        return np.ones(places.shape)

    def scalar_variables(self) -> dict[str, str]:
        """Return the variables of the single numbers, by name."""
        return {scalar: f"{self.variable}_{scalar}" for scalar in self.scalars}

    def __call__(self, field: Field) -> Profile:
        """Return the observable of one state, if it is what the class describes.

        Raises
        ------
        SolverError
            If it is not.
        """
        profile = self.compute(field)
        bins = profile.edges.size - 1
        if profile.places.shape != (bins,) or profile.values.shape != (bins,):
            raise SolverError(
                f"the observable {self.name} has {bins} bins, places of shape "
                f"{profile.places.shape} and values of shape {profile.values.shape}"
            )
        if unknown := profile.scalars.keys() - self.scalars.keys():
            raise SolverError(
                f"the observable {self.name} returns {', '.join(sorted(unknown))}, which its "
                "scalars do not describe"
            )
        return profile
