"""What every contender shares: the sample it gets, the curve it returns, its options.

A contender is one file, in this package or elsewhere: a subclass of :class:`Model` that holds
its options, declares all that is special about it, and computes a :class:`Curve` from a
:class:`Sample` and a list of pressures, or yields its :class:`State` one by one. It knows
nothing of specs, files, progress bars or
figures.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import partial
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    SerializerFunctionWrapHandler,
    model_serializer,
)

from roughbench.errors import SolverError
from roughbench.inputs import BYTES_PER_POINT
from roughbench.models.dimensional import dimension_of
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum
from roughbench.surface import Undersampled, check_grid, highest_mode

Needs = Literal["spectrum", "line", "surface"]
_DIMENSIONS: Mapping[Needs, int] = {"spectrum": 0, "line": 1, "surface": 2}

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


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


@dataclass(frozen=True, slots=True)
class Sample:
    """One realization of the roughness, as a contender gets it.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m), or None
        Heights of a line or a surface with zero mean, length; None where the model
        works on the spectrum alone.
    length : float
        Side of the periodic cell, length: the period along the first axis. Pixels are
        square, so that that along the second is m/n times as long.
    spectrum : Spectrum or None
        The spectrum behind the heights; None for heights from a file.
    area : float or None
        A0 of a cell that is no square, where there are no heights to show it, length².
    """

    heights: FloatArray | None
    length: float
    spectrum: Spectrum | None = None
    area: float | None = None

    @property
    def nominal_area(self) -> float:
        """A0 of the cell of a surface, length²."""
        if self.area is not None:
            return self.area
        return cell_area(() if self.heights is None else self.heights.shape, self.length)


def cell_area(shape: tuple[int, ...], length: float) -> float:
    """Return the area of a cell of square pixels, length²; of a square one without a shape.

    Parameters
    ----------
    shape : tuple of int
        Of heights (n, m).
    length : float
        Period along the first axis, length.

    Examples
    --------
    >>> cell_area((4, 8), 2.0), cell_area((8, 4), 4.0), cell_area((), 3.0)
    (8.0, 8.0, 9.0)
    """
    square = length * length
    return square * shape[1] / shape[0] if len(shape) == 2 else square


QUANTITIES = ("area", "area_raw", "separation", "stiffness", "energy")
"""What a contender may say of a state, in the order of the results; the area it must."""


@dataclass(frozen=True, slots=True)
class State:
    """What a contender says at one pressure; what it does not know is None.

    Attributes
    ----------
    pressure : float
        Nominal pressure p, in the unit of the contact modulus E*.
    area, separation, stiffness, energy, area_raw
        As in :class:`Curve`.
    status : Status
        How the computation ended.
    diagnostics : mapping of str to number
        Further numbers (certificate, iterations).
    fields : callable, optional
        Returns the :class:`Fields` of the state.
    snapshot : callable, optional
        Returns the arrays that :meth:`Model.states` goes on from, after this state.

    Notes
    -----
    ``fields`` and ``snapshot`` may be called until the next state is asked for, and not
    later: a model need not keep what they return.
    """

    pressure: float
    area: float
    separation: float | None = None
    stiffness: float | None = None
    energy: float | None = None
    status: Status = Status.CONVERGED
    area_raw: float | None = None
    diagnostics: Mapping[str, float | np.number[Any]] = field(default_factory=dict)
    fields: Callable[[], Fields] | None = None
    snapshot: Callable[[], Mapping[str, NDArray[Any]]] | None = None

    def given(self) -> dict[str, Any]:
        """Return its quantities and diagnostics by name, without those that are not given."""
        quantities = {name: getattr(self, name) for name in QUANTITIES}
        return {k: x for k, x in quantities.items() if x is not None} | dict(self.diagnostics)


@dataclass(frozen=True, slots=True)
class Curve:
    """What a contender says at each pressure; all arrays have shape (pressures,).

    Pressure and area are enough: what is None is not given, and no variable of the results.

    Attributes
    ----------
    pressure : ndarray of float64
        Nominal pressure p, in the unit of the contact modulus E*.
    area : ndarray of float64
        Real contact area A/A0.
    separation : ndarray of float64, optional
        Mean separation ū, length.
    stiffness : ndarray of float64, optional
        K = −dp/dū, E*/length; inf at full contact.
    energy : ndarray of float64, optional
        Elastic energy U/(A0 E*), length.
    status : ndarray of int32
        :class:`Status` of each state; default: all have converged.
    area_raw : ndarray of float64, optional
        Contact points / all points, before the perimeter correction.
    diagnostics : mapping of str to ndarray, optional
        Further numbers per pressure (certificate, iterations).
    """

    pressure: FloatArray
    area: FloatArray
    separation: FloatArray | None = None
    stiffness: FloatArray | None = None
    energy: FloatArray | None = None
    status: IntArray = field(default_factory=lambda: np.zeros(0, np.int32))
    area_raw: FloatArray | None = None
    diagnostics: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.status.size == 0:
            object.__setattr__(self, "status", np.zeros(self.pressure.shape, np.int32))

    @classmethod
    def from_states(cls, states: Iterable[State], pressures: FloatArray) -> Self:
        """Return the curve that states in the order of rising pressure make.

        Parameters
        ----------
        states : iterable of State
        pressures : ndarray of float64
            p/E* of the curve, in any order.

        Raises
        ------
        SolverError
            If they are not the states of these pressures, or not all of them give the same
            quantities.
        """
        rows = list(states)
        order = np.argsort(pressures, kind="stable")
        if [state.pressure for state in rows] != pressures[order].tolist():
            raise SolverError(
                f"the model gives {len(rows)} states for {pressures.size} pressures, or not in "
                "the order of rising pressure"
            )
        given = [state.given() for state in rows]
        for state, values in zip(rows, given, strict=True):
            if values.keys() != given[0].keys():
                raise SolverError(
                    f"the model gives {', '.join(values)} at p/E* = {state.pressure:g}, but "
                    f"{', '.join(given[0])} at {rows[0].pressure:g}; give the same at every "
                    "pressure, nan where it is unknown"
                )
        place = np.argsort(order)
        columns = {
            name: np.array([values[name] for values in given])[place] for name in given[0]
        }
        quantities = {name: columns.pop(name) for name in QUANTITIES if name in columns}
        status = np.array([state.status for state in rows], np.int32)[place]
        return cls(pressure=pressures, status=status, diagnostics=columns, **quantities)

    def states(self) -> Iterator[State]:
        """Yield its states, in the order of rising pressure."""
        given = [name for name in QUANTITIES if getattr(self, name) is not None]
        for k in np.argsort(self.pressure, kind="stable"):
            yield State(
                pressure=float(self.pressure[k]),
                status=Status(self.status[k]),
                diagnostics={name: values[k] for name, values in self.diagnostics.items()},
                **{name: getattr(self, name)[k] for name in given},
            )


@dataclass(frozen=True, slots=True)
class CompleteCurve(Curve):
    """A curve with separation, stiffness and energy."""

    separation: FloatArray
    stiffness: FloatArray
    energy: FloatArray


MOST_REALIZATIONS = 1_000_000
"""Far more than averages need; files of finished ones are named with six digits."""


class Model(BaseModel, ABC):
    """Options of one contender, all that is special about it, and how it computes a curve.

    Subclasses declare ``kind: Literal["…"]``, their options as pydantic fields with
    descriptions, ``needs`` and ``title``, and of the rest what differs from the defaults: as
    class variables, or as properties where it depends on an option.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")

    @property
    @abstractmethod
    def needs(self) -> Needs:
        """What it computes from: the heights of a line or a surface, or the spectrum alone."""

    @property
    @abstractmethod
    def title(self) -> str:
        """Name in legends and tables."""

    style: ClassVar[Style] = Style()
    """How it is drawn; by default in colours and dashes that no built-in model has."""

    page: ClassVar[str] = ""
    """Where it is described: an address, or a path in roughbench's documentation."""

    @property
    def has_fields(self) -> bool:
        """Whether it knows pressure and gap at every point: its states have ``fields``."""
        return False

    iterative: ClassVar[bool] = True
    """Whether it iterates each state to a tolerance. Threads may change its last bits then,
    and states that are there are kept when other pressures are asked for."""

    is_reference: ClassVar[bool] = False
    """Whether it is the exact solution, which all others are compared with."""

    sampling: ClassVar[tuple[str, ...]] = ()
    """Options that choose how heights are generated, first that of the points per side; they
    mean nothing for heights from a file."""

    @property
    def undersampling(self) -> Undersampled:
        """What happens to waves of a line that its points are too few for."""
        return "error"

    @property
    def highest_pressure(self) -> float | None:
        """Largest nominal pressure that can be carried, in the spec's unit; None for any."""
        return None

    points_per_wave: ClassVar[int] = 4
    """Points on the shortest wavelength where no option says how many points there are."""

    fewest_points_per_wave: ClassVar[float] = 2.0
    """Points on the shortest wavelength below which a report warns of a coarse grid."""

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

    _reference: str = PrivateAttr(default="")

    @model_serializer(mode="wrap")
    def _as_in_a_spec(self, tree: SerializerFunctionWrapHandler) -> dict[str, Any]:
        values: dict[str, Any] = tree(self)
        if self._reference and "kind" in values:
            values["kind"] = self._reference
        for name in self.later:
            if getattr(self, name) == type(self).model_fields[name].default:
                values.pop(name, None)
        return values

    def reduced(self, modulus: float | None) -> Self:
        """Return this model with options that are pressures in E*, as samples and states are.

        Parameters
        ----------
        modulus : float or None
            E* in the unit of the options; None where they are p/E* already.
        """
        fields = type(self).model_fields.items()
        given = {
            name: value
            for name, field in fields
            if dimension_of(field) == "pressure" and (value := getattr(self, name)) is not None
        }
        if modulus is None or not given:
            return self
        return self.model_copy(update={k: value / modulus for k, value in given.items()})

    @property
    def name(self) -> str:
        """Label of the model in the results."""
        return self.label or self.kind

    @property
    def reference(self) -> str:
        """What the spec says for ``kind`` if that is a file: ``mytheory.py:Erf09``."""
        return self._reference

    def referred_to(self, reference: str) -> Self:
        """Return this model as one that a spec names by a file and a class."""
        model = self.model_copy()
        model._reference = reference  # noqa: SLF001  (of its own class)
        return model

    @property
    def dimension(self) -> int:
        """Of the heights: 1 for a line, 2 for a surface, 0 where the spectrum is enough."""
        return _DIMENSIONS[self.needs]

    def unused_options(self) -> Mapping[str, str]:
        """Options that change nothing beside the others, each with what to do about it."""
        return {}

    def refused_with_given_heights(self) -> Mapping[str, str]:
        """Options that cannot be had for heights from a file, each with what to do about it."""
        return {}

    @classmethod
    def legend(cls, attributes: Mapping[str, Any], quantity: str) -> Sequence[str]:
        """Return the parameters that a legend shows with its curve of a quantity.

        Parameters
        ----------
        attributes : mapping
            Those of its results: the options, and parameters of the surface.
        quantity : str
            ``area``, ``separation`` or ``stiffness``.
        """
        del attributes, quantity
        return ()

    def memory(self, n_points: int) -> int:
        """Estimate the bytes to compute a sample of so many points, the heights included."""
        return BYTES_PER_POINT * n_points

    def thriftier(self) -> Mapping[str, str]:
        """Options, and their values, with which the same needs less memory."""
        return {}

    def work(self, n_points: int, n_pressures: int) -> float:
        """Estimate the work of one realization on one core, in microseconds.

        Progress and batches rely on it, and ``run -n``, which measures how fast this machine
        is. Measured, November 2026, on a shared machine: models that do not iterate take 1 ms
        and 0.25 µs per point of a line, or 0.4 µs per point of a surface, for all pressures;
        theories of the spectrum 1 to 400 ms. Models that iterate had better say it themselves.
        """
        if self.needs == "spectrum":
            return 1e4
        if self.iterative:
            return (n_pressures + 1) * (n_points + 1e4)
        return 1e3 + n_points * (0.25 if self.needs == "line" else 0.4)

    def grid_points(self, spectrum: Spectrum, length: float) -> int:
        """Points per side of the heights that this model needs.

        Those that the first option of :attr:`sampling` asks for, or so many on the shortest
        wavelength as :attr:`points_per_wave` says.

        Raises
        ------
        SurfaceError
            If they are fewer than two on the shortest wavelength; names how many would do.
        """
        if self.needs == "spectrum":
            raise NotImplementedError(f"{self.kind} uses no heights")
        wanted: int | None = getattr(self, self.sampling[0]) if self.sampling else None
        if wanted is None:
            return max(2, self.points_per_wave * highest_mode(spectrum, length))
        check_grid(wanted, spectrum, length)
        return wanted

    # -- computing -------------------------------------------------------------------------

    def curve(self, sample: Sample, pressures: FloatArray) -> Curve:
        """Return the curve at ``pressures`` (p/E*, any order), with E* = 1.

        A contender that computes all pressures at once overrides this, any other
        :meth:`states`.
        """
        return Curve.from_states(self.states(sample, pressures), pressures)

    def states(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        finished: Mapping[str, NDArray[Any]] | None = None,
    ) -> Iterator[State]:
        """Yield the states at ``pressures`` in the order of rising pressure, with E* = 1.

        A contender that takes its time over each pressure overrides this.

        Parameters
        ----------
        sample : Sample
        pressures : ndarray of float64
            p/E*, in any order.
        threads : int
            Threads that it may use.
        finished : mapping of str to ndarray, optional
            What :attr:`State.snapshot` of the same curve returned: only the states after
            that one are yielded, to the bits that they would have had.
        """
        del threads
        if type(self).curve is Model.curve:
            raise NotImplementedError(f"{type(self).__name__} has neither curve nor states")
        if finished is not None:
            raise NotImplementedError(f"{self.kind} hands out no snapshots")
        states = self.curve(sample, pressures).states()
        if not self.has_fields:
            yield from states
            return
        fields = self.make_fields(sample)
        for state in states:
            yield replace(state, fields=partial(fields, state))

    def make_fields(self, sample: Sample) -> Callable[[State], Fields]:
        """Return what computes the fields of a state of :meth:`curve`.

        A contender that overrides ``curve`` and has fields overrides this as well.
        """
        raise NotImplementedError(f"{type(self).__name__} has fields without make_fields")

    @property
    def is_vectorized(self) -> bool:
        """Whether :meth:`curve` computes all pressures at once."""
        for owner in type(self).__mro__[: type(self).__mro__.index(Model)]:
            if not vars(owner).keys().isdisjoint(("curve", "states")):
                return "curve" in vars(owner)
        return False
