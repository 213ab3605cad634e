"""The exact contender: a hard rough wall pressed against a periodic elastic half-space.

``contact`` holds the public functions, ``states`` a curve, ``problem`` the arguments of both
and their units. ``solver`` is the outer loop, with ``start`` for where it begins,
``evaluation`` for the gap that a pressure leads to, and ``certificate`` for when that counts
as solved. ``relaxation`` is the inner loop, ``tangent`` the stiffness, both on a
``workspace``: ``operator`` or ``direct`` for the elasticity, and ``preconditioner``. With an
upper bound on the pressure, ``bounded`` and ``plastic`` take the place of some of these.
``loops``, run by ``threads``, and :mod:`roughbench.transform` do the array work; ``options``
are those that it shares with :mod:`roughbench.models.line`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal, Self

from numpy.typing import NDArray
from pydantic import Field, model_validator

from roughbench.errors import SolverError
from roughbench.models._grids import GridOption
from roughbench.models.base import FloatArray, Model, Needs, Sample, State
from roughbench.models.halfspace.memory import needed
from roughbench.models.halfspace.options import (
    BoundaryOption,
    CorrectionOption,
    HardnessOption,
    PrecisionOption,
    ScreeningOption,
    ToleranceOption,
)
from roughbench.models.style import Style


class HalfSpace(Model):
    """Exact boundary-element solution on a periodic grid."""

    needs: ClassVar[Needs] = "surface"
    style: ClassVar[Style] = Style("#000000", markers="soD^v", order=4)
    page: ClassVar[str] = "docs/models/bem.md"
    is_reference: ClassVar[bool] = True
    sampling: ClassVar[tuple[str, ...]] = ("grid",)
    fewest_points_per_wave: ClassVar[float] = 4.0
    has_fields: ClassVar[bool] = True
    modifying: ClassVar[tuple[str, ...]] = ("screening",)
    later: ClassVar[tuple[str, ...]] = ("correction", "hardness", "screening", "boundary")

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
    hardness: HardnessOption = None
    screening: ScreeningOption = 0.0
    boundary: BoundaryOption = "periodic"

    @model_validator(mode="after")
    def _go_together(self) -> Self:
        """Refuse options that are not computed together."""
        if self.screening > 0.0 and self.boundary == "free":
            raise ValueError("screening needs boundary: periodic")
        if self.hardness is not None and (self.screening > 0.0 or self.boundary == "free"):
            raise ValueError("hardness needs boundary: periodic, and no screening")
        return self

    @property
    def title(self) -> str:
        """Name in legends and tables: with screening it is no exact half-space."""
        return "Screened half-space (BEM)" if self.screening > 0.0 else "Exact (BEM)"

    @classmethod
    def legend(cls, attributes: Mapping[str, Any], quantity: str) -> Sequence[str]:
        """Return the screening wavevector, in units of q0 where that is known."""
        del quantity
        q_c = float(attributes.get("screening", 0.0))
        if not q_c > 0.0:
            return []
        if "q_min" in attributes:
            return [rf"$q_c/q_0 = {q_c / float(attributes['q_min']):.3g}$"]
        unit = " 1/m" if "contact_modulus" in attributes else ""
        return [rf"$q_c = {q_c:.3g}${unit}"]

    @property
    def highest_pressure(self) -> float | None:
        """The hardness: no more can be carried on average."""
        return self.hardness

    def memory(self, n_points: int) -> int:
        """Estimate the bytes of a sample: its heights, and what the solver counts."""
        return 8 * n_points + needed(
            n_points,
            double=self.precision == "double",
            free=self.boundary == "free",
            bounded=self.hardness is not None,
        )

    def thriftier(self) -> Mapping[str, str]:
        """Single precision where there was double."""
        return {"precision": "mixed"} if self.precision == "double" else {}

    def work(self, n_points: int, n_pressures: int) -> float:
        """Estimate the work of one realization, in microseconds.

        Measured, for 32² to 1024² points: 0.7 µs per point and pressure, and as long as for
        12500 points more for what does not grow with them; the first state, which starts from
        nothing, takes as long as two.
        """
        return (n_pressures + 1) * 0.7 * (n_points + 12500.0)

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
        from roughbench.models.halfspace.states import solve_states

        if sample.heights is None or sample.heights.ndim != 2:
            raise SolverError("the exact solver needs the heights of a surface, shape (n, m)")
        return solve_states(
            sample.heights,
            pressures,
            length=sample.length,
            tolerance=self.tolerance,
            precision=self.precision,
            correction=self.correction,
            screening=self.screening,
            boundary=self.boundary,
            hardness=self.hardness,
            threads=threads,
            finished=finished,
        )
