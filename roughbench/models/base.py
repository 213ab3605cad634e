"""What every contender shares: its options, its declarations, how it computes.

A contender is one file, in this package or elsewhere: a subclass of :class:`Model` that holds
its options, declares all that is special about it, and computes a
:class:`~roughbench.models.states.Curve` from a :class:`~roughbench.models.sample.Sample` and a
list of pressures, or yields its :class:`~roughbench.models.states.State` one by one. It knows
nothing of specs, files, progress bars or figures. All that its file needs can be imported from
here.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar, Literal, Self

from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    SerializerFunctionWrapHandler,
    model_serializer,
)

from roughbench.inputs import BYTES_PER_POINT
from roughbench.models.dimensional import dimension_of
from roughbench.models.sample import Sample, cell_area
from roughbench.models.states import (
    QUANTITIES,
    CompleteCurve,
    Curve,
    Fields,
    FloatArray,
    IntArray,
    State,
    Status,
)
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum
from roughbench.surface import Undersampled, check_grid, highest_mode

__all__ = [
    "MOST_REALIZATIONS",
    "QUANTITIES",
    "CompleteCurve",
    "Curve",
    "Fields",
    "FloatArray",
    "IntArray",
    "Model",
    "Needs",
    "Sample",
    "State",
    "Status",
    "cell_area",
]

Needs = Literal["spectrum", "line", "surface"]
_DIMENSIONS: Mapping[Needs, int] = {"spectrum": 0, "line": 1, "surface": 2}

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

    modifying: ClassVar[tuple[str, ...]] = ()
    """Options that make another model of it than its kind stands for. With one of them it is no
    reference, and no claim on its kind is about it; as a contender it counts."""

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
