"""The exact contender: a hard rough wall pressed against a periodic elastic half-space.

``contact`` holds the public functions and ``solver`` the outer loop, with ``start`` for where
it begins, ``evaluation`` for the gap that a pressure leads to, and ``certificate`` for when
that counts as solved. ``relaxation`` is the inner loop, ``tangent`` the stiffness, both on a
``workspace``: ``operator`` or ``direct`` for the elasticity, and ``preconditioner``.
``loops``, run by ``threads``, and :mod:`roughbench.transform` do the array work; ``options``
are those that it shares with :mod:`roughbench.models.line`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Literal

from numpy.typing import NDArray
from pydantic import Field

from roughbench.errors import SolverError
from roughbench.models._grids import GridModel, GridOption
from roughbench.models.base import FloatArray, Sample, State
from roughbench.models.halfspace.options import (
    CorrectionOption,
    PrecisionOption,
    ToleranceOption,
)


class HalfSpace(GridModel):
    """Exact boundary-element solution on a periodic grid."""

    dimension: ClassVar[int] = 2
    title: ClassVar[str] = "Exact (BEM)"
    has_fields: ClassVar[bool] = True
    later: ClassVar[tuple[str, ...]] = ("correction",)

    kind: Literal["bem"] = "bem"
    grid: GridOption = Field(
        default=None,
        description=(
            "Points per side; default: 4 on the shortest wavelength, 4 q1 length / 2π. "
            "At least 2 are needed. Heights from a file bring their own grid."
        ),
    )
    tolerance: ToleranceOption = 1e-6
    precision: PrecisionOption = "mixed"
    correction: CorrectionOption = "perimeter"

    def states(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        finished: Mapping[str, NDArray[Any]] | None = None,
    ) -> Iterator[State]:
        """Solve the states on the heights of the sample, each started from its neighbour."""
        # Numba and FFTW load only where they are needed.
        from roughbench.models.halfspace.contact import solve_states

        if sample.heights is None or sample.heights.ndim != 2:
            raise SolverError("the exact solver needs the heights of a surface, shape (n, m)")
        return solve_states(
            sample.heights,
            pressures,
            length=sample.length,
            tolerance=self.tolerance,
            precision=self.precision,
            correction=self.correction,
            threads=threads,
            finished=finished,
        )
