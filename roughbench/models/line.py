r"""The exact solution in one dimension: a rough line on an elastic half-plane.

The line has the spectrum :math:`C_{1D} = \pi q C_{2D}` of the foundation's
(:mod:`.foundation`), but the elasticity of a half-plane, :math:`u(q) = 2p(q)/(E^*|q|)`
(the mean excepted), as the surface has in two dimensions. So it is the foundation with
the one thing that it lacks, long-range coupling, and tells what the *dimension* alone
changes.

Persson's theory knows the roughness by :math:`\xi(q)` and by the integrals
:math:`\int q^2C_{2D}\,(\dots)\,dq` only, and the mapping keeps both: all its formulas are
the same for the line. At low pressure the two part, because the contacts do. A single
contact of width 2a in the period L has, whatever its shape, the stiffness of a flat punch,

.. math:: K = \frac{\pi E^*}{2L\,\ln[1/\sin(\pi a/L)]},

which falls logarithmically with the load where that of a surface, :math:`2E^*a/L^2`,
follows the power :math:`p^{1/(1+H)}`.

Source: H. M. Westergaard (1939) for the periodic half-plane; the solver is that of
:mod:`.halfspace`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from roughbench.errors import SolverError
from roughbench.inputs import float_array
from roughbench.models._checks import checked_length
from roughbench.models._grids import GridOption
from roughbench.models.base import FloatArray, Model, Needs, Sample, State
from roughbench.models.halfspace.memory import needed
from roughbench.models.halfspace.options import (
    CorrectionOption,
    PrecisionOption,
    ToleranceOption,
)
from roughbench.models.style import Style


def single_contact_stiffness(width: ArrayLike, length: float) -> FloatArray:
    r"""Return K/E* = π/(2L ln[1/sin(πa/L)]) of one contact of width 2a per period L.

    Parameters
    ----------
    width : array_like of float64
        2a, 0 < 2a ≤ L, length.
    length : float
        Period L, length.

    Returns
    -------
    ndarray of float64
        1/length; inf at full contact.

    Raises
    ------
    SolverError
        If a width is outside its range.

    Examples
    --------
    >>> single_contact_stiffness([0.5, 1.0], length=1.0).round(6).tolist()
    [4.53236, inf]
    """
    period = checked_length(length)
    share = float_array(width, "widths") / period
    if not ((share > 0.0) & (share <= 1.0)).all():
        raise SolverError("the width of a contact must lie between 0 and the period")
    with np.errstate(divide="ignore"):
        return np.asarray(
            math.pi / (2.0 * period * np.abs(np.log(np.sin(math.pi * share / 2.0))))
        )


class Line(Model):
    """Exact solution for a rough line on an elastic half-plane."""

    needs: ClassVar[Needs] = "line"
    title: ClassVar[str] = "Exact line (1D half-plane)"
    style: ClassVar[Style] = Style("#009E73", ((9, 2, 1.5, 2),))
    page: ClassVar[str] = "docs/models/line.md"
    sampling: ClassVar[tuple[str, ...]] = ("points",)
    points_per_wave: ClassVar[int] = 16
    fewest_points_per_wave: ClassVar[float] = 4.0
    has_fields: ClassVar[bool] = True
    later: ClassVar[tuple[str, ...]] = ("correction",)

    kind: Literal["line"] = "line"
    points: GridOption = Field(
        default=None,
        description="Points on the line; default: 16 on the shortest wavelength.",
    )
    tolerance: ToleranceOption = 1e-6
    precision: PrecisionOption = "mixed"
    correction: CorrectionOption = "perimeter"

    def memory(self, n_points: int) -> int:
        """Estimate the bytes of a sample: its heights, and what the solver counts."""
        return 8 * n_points + needed(n_points, double=self.precision == "double")

    def thriftier(self) -> Mapping[str, str]:
        """Single precision where there was double."""
        return {"precision": "mixed"} if self.precision == "double" else {}

    def work(self, n_points: int, n_pressures: int) -> float:
        """Estimate the work of one realization, in microseconds.

        Measured: 3.3 µs per point and pressure, and as long as for 4500 points more for what
        does not grow with them; the first state, which starts from nothing, takes as long as
        two.
        """
        return (n_pressures + 1) * 3.3 * (n_points + 4500.0)

    def states(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        finished: Mapping[str, NDArray[Any]] | None = None,
    ) -> Iterator[State]:
        """Solve the states on the line of the sample."""
        # Numba and FFTW load only where they are needed.
        from roughbench.models.halfspace.states import solve_states

        del finished
        if sample.heights is None or sample.heights.ndim != 1:
            raise SolverError("the half-plane needs the heights of a line, shape (n,)")
        states = solve_states(
            sample.heights,
            pressures,
            length=sample.length,
            tolerance=self.tolerance,
            precision=self.precision,
            correction=self.correction,
            threads=threads,
        )
        for state in states:
            # A line takes seconds: it is not worth a checkpoint, and offers none.
            yield replace(state, snapshot=None)
