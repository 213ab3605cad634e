"""The exact contender: a hard rough wall pressed against a periodic elastic half-space.

``contact`` holds the public functions, ``solver`` the outer loop and the certificate,
``relaxation`` the inner one, ``preconditioner`` its second level, ``operator`` the
elasticity, ``loops`` and :mod:`roughbench.transform` the array work; ``options`` those that
it shares with :mod:`roughbench.models.line`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from numpy.typing import NDArray
from pydantic import Field

from roughbench.errors import SolverError
from roughbench.models._grids import GridModel, GridOption
from roughbench.models.base import Curve, FloatArray, Sample, Solved
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

    def curve(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        solved: Solved | None = None,
    ) -> Curve:
        """Solve the states at ``pressures`` on the heights of the sample."""
        return self._solve(sample, pressures, threads, solved, None)

    def resume(
        self,
        sample: Sample,
        pressures: FloatArray,
        finished: Mapping[str, NDArray[Any]],
        *,
        threads: int = 1,
        solved: Solved | None = None,
    ) -> Curve:
        """Go on from the last state that was solved."""
        return self._solve(sample, pressures, threads, solved, finished)

    def _solve(
        self,
        sample: Sample,
        pressures: FloatArray,
        threads: int,
        solved: Solved | None,
        finished: Mapping[str, NDArray[Any]] | None,
    ) -> Curve:
        # Numba and FFTW load only where they are needed.
        from roughbench.models.halfspace.contact import solve_curve

        if sample.heights is None or sample.heights.ndim != 2:
            raise SolverError("the exact solver needs the heights of a surface, shape (n, m)")
        return solve_curve(
            sample.heights,
            pressures,
            length=sample.length,
            tolerance=self.tolerance,
            precision=self.precision,
            correction=self.correction,
            threads=threads,
            solved=solved,
            finished=finished,
        )
