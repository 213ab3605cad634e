"""What every contender shares: the sample it gets, the curve it returns, its options.

A contender is one file in this package: a subclass of :class:`Model` that holds its
options and computes a :class:`Curve` from a :class:`Sample` and a list of pressures.
It knows nothing of specs, files, progress bars or figures.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
)

from roughbench.spectrum import Spectrum

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


Snapshot = Callable[[], Mapping[str, NDArray[Any]]]
"""Returns the arrays that :meth:`Model.resume` continues a curve from."""


class Status(IntEnum):
    """How the computation of one state ended; stored as int32."""

    CONVERGED = 0
    STAGNATED = 1
    MAX_ITERATIONS = 2
    NOT_FINITE = 3


@dataclass(frozen=True, slots=True)
class Fields:
    """Pressure and gap of one state at every point of the heights.

    Attributes
    ----------
    pressure : ndarray of float64, shape of the heights
        Contact pressure σ, in the unit of the contact modulus E*; zero out of contact.
    gap : ndarray of float64, shape of the heights
        Local separation, length; of no account where the pressure is positive.
    modulus : float or None
        k_w/E* of independent springs, 1/length; None for a half-space.
    """

    pressure: FloatArray
    gap: FloatArray
    modulus: float | None = None


TakeFields = Callable[[], Fields]
"""Returns the fields of the state that was finished last."""


class Solved(Protocol):
    """Called when one more pressure is done, in the order of rising pressure."""

    def __call__(
        self, snapshot: Snapshot | None = None, fields: TakeFields | None = None, /
    ) -> None:
        """Note it.

        ``snapshot`` comes from a model that can resume, ``fields`` from one with
        :attr:`Model.has_fields`; each is called at once or never.
        """


@dataclass(frozen=True, slots=True)
class Sample:
    """One realization of the roughness, as a contender gets it.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m), or None
        Heights of a line or a surface with zero mean, length; None where the model
        works on the spectrum alone.
    length : float
        Side of the periodic cell, length.
    spectrum : Spectrum or None
        The spectrum behind the heights; None for heights from a file.
    """

    heights: FloatArray | None
    length: float
    spectrum: Spectrum | None = None


@dataclass(frozen=True, slots=True)
class Curve:
    """What a contender says at each pressure; all arrays have shape (pressures,).

    Attributes
    ----------
    pressure : ndarray of float64
        Nominal pressure p, in the unit of the contact modulus E*.
    area : ndarray of float64
        Real contact area A/A0.
    separation : ndarray of float64
        Mean separation ū, length.
    stiffness : ndarray of float64
        K = −dp/dū, E*/length; inf at full contact.
    energy : ndarray of float64
        Elastic energy U/(A0 E*), length.
    status : ndarray of int32
        :class:`Status` of each state.
    area_raw : ndarray of float64, optional
        Contact points / all points, before the perimeter correction.
    diagnostics : mapping of str to ndarray, optional
        Further numbers per pressure (certificate, iterations).
    """

    pressure: FloatArray
    area: FloatArray
    separation: FloatArray
    stiffness: FloatArray
    energy: FloatArray
    status: IntArray
    area_raw: FloatArray | None = None
    diagnostics: Mapping[str, NDArray[Any]] = field(default_factory=dict)


MOST_REALIZATIONS = 1_000_000
"""Far more than averages need; files of finished ones are named with six digits."""


class Model(BaseModel, ABC):
    """Options of one contender, and how it computes a curve.

    Subclasses declare ``kind: Literal["…"]``, their options as pydantic fields with
    descriptions, and ``dimension`` and ``title``: as class variables, or as properties
    where they depend on an option.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")

    @property
    @abstractmethod
    def dimension(self) -> int:
        """0: spectrum only, 1: heights of a line, 2: heights of a surface."""

    @property
    @abstractmethod
    def title(self) -> str:
        """Name in legends and tables."""

    @property
    def has_fields(self) -> bool:
        """Whether it knows pressure and gap at every point, and hands them to ``solved``."""
        return False

    iterative: ClassVar[bool] = True
    """Whether it iterates each state to a tolerance. Threads may change its last bits then,
    and states that are there are kept when other pressures are asked for."""

    later: ClassVar[tuple[str, ...]] = ()
    """Options that came after results had been written. With their default values they are
    left out of the model's tree, and so of hashes and results: a spec that does not name
    them stays the spec that it was."""

    kind: str
    label: str | None = Field(
        default=None,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.+-]*$",
        description="Name of this model in the results; default: its kind.",
    )
    realizations: int | None = Field(
        default=None,
        ge=1,
        le=MOST_REALIZATIONS,
        description="Overrides the spec's realizations for this model.",
    )

    @model_serializer(mode="wrap")
    def _without_later_defaults(self, tree: SerializerFunctionWrapHandler) -> dict[str, Any]:
        values: dict[str, Any] = tree(self)
        for name in self.later:
            if getattr(self, name) == type(self).model_fields[name].default:
                values.pop(name, None)
        return values

    @property
    def name(self) -> str:
        """Label of the model in the results."""
        return self.label or self.kind

    def unused_options(self) -> Mapping[str, str]:
        """Options that change nothing beside the others, each with what to do about it."""
        return {}

    def grid_points(self, spectrum: Spectrum, length: float) -> int:
        """Points per side of the heights that this model needs.

        Raises
        ------
        SurfaceError
            If its grid option is too coarse for the spectrum; names one that would do.
        """
        raise NotImplementedError(f"{self.kind} uses no heights")

    @abstractmethod
    def curve(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        solved: Solved | None = None,
    ) -> Curve:
        """Return the curve at ``pressures`` (p/E*, any order), with E* = 1.

        A model that takes its time over each pressure, or has fields, calls ``solved``
        after it.
        """

    def resume(
        self,
        sample: Sample,
        pressures: FloatArray,
        finished: Mapping[str, NDArray[Any]],
        *,
        threads: int = 1,
        solved: Solved | None = None,
    ) -> Curve:
        """Continue a curve whose process was killed, to the bits it would have had.

        Parameters
        ----------
        finished : mapping of str to ndarray
            What a snapshot of the same curve returned; ``solved`` is called for the
            pressures after it only.
        sample, pressures, threads, solved
            As in :meth:`curve`.
        """
        raise NotImplementedError(f"{self.kind} hands out no snapshots")
