"""What a contender says: the state at one pressure, its fields, the curve of all pressures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SolverError

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
    screening : float
        q_c of a half-space, 1/length: its compliance is 2/(E*√(q² + q_c²)).
    """

    pressure: FloatArray
    gap: FloatArray
    modulus: float | None = None
    screening: float = 0.0


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
