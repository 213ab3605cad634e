"""A contact problem as it is given: checked arguments, the solver on them, and their units."""

from __future__ import annotations

import math
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SolverError
from roughbench.inputs import (
    check_heights,
    float_array,
    positive_number,
    real_array,
    real_number,
    whole_number,
)
from roughbench.models.base import Fields, FloatArray
from roughbench.models.halfspace import memory
from roughbench.models.halfspace.kernel import Kernel
from roughbench.models.halfspace.options import Boundary, Correction, Precision
from roughbench.models.halfspace.solver import FLOAT32_FLOOR, Solution, Solver
from roughbench.system import available_cores

SMALLEST_LOAD = 1e-20
"""In E* h_rms/Δ. A single point of a grid carries its share of less; float32 does not."""

LARGEST_SCREENING = 1e9
"""q_cΔ. At 1e9 the coupling that is left is below float64's rounding by far."""

LARGEST_ASPECT = 1e3
"""Of the two spacings of a grid."""

Length = float | tuple[float, float]
"""Side of the cell along the first axis, of square points, or those along both axes."""


SMALLEST_GAP = 1e-12
"""In h_rms. Rounding errors of float64 decide about less."""


class Options(TypedDict):
    """Those of :class:`Solver`."""

    double: bool
    threads: int
    max_iterations: int
    kernel: Kernel
    flat: float
    hardness: float | None


class Problem:
    """Checked arguments, the solver on them, and the units between the two."""

    def __init__(
        self,
        heights: ArrayLike,
        length: Length,
        modulus: float,
        tolerance: float,
        precision: Precision,
        threads: int | None,
        max_iterations: int,
        correction: Correction,
        hardness: float | None = None,
        screening: float = 0.0,
        boundary: Boundary = "periodic",
    ) -> None:
        h = real_array(heights, "heights", kinds="buif")
        if h.ndim not in (1, 2) or min(h.shape, default=0) < 2:
            raise SolverError(
                "heights must be a line (n,) or a surface (n, m) of at least 2 points a "
                f"side, got shape {h.shape}"
            )
        self.spacing, aspect = spacings(length, h.shape)
        modulus = positive_number(modulus, "modulus")
        tolerance = positive_number(tolerance, "tolerance")
        if tolerance > 0.1:
            raise SolverError(f"tolerance must be at most 0.1, got {tolerance}")
        if not (isinstance(precision, str) and precision in ("mixed", "double")):
            raise SolverError(f"precision must be 'mixed' or 'double', got {precision!r}")
        if not (isinstance(correction, str) and correction in ("perimeter", "none")):
            raise SolverError(f"correction must be 'perimeter' or 'none', got {correction!r}")
        q_c = real_number(screening, "screening")
        if not 0.0 <= q_c < math.inf:
            raise SolverError(f"screening must be a wavevector of at least 0, got {q_c}")
        if not (isinstance(boundary, str) and boundary in ("periodic", "free")):
            raise SolverError(f"boundary must be 'periodic' or 'free', got {boundary!r}")
        free = boundary == "free"
        if free and h.ndim == 1:
            raise SolverError(
                "boundary: a line needs the periodic one; the displacement of a half-plane "
                "by a line of force grows like the logarithm of the distance, so that without "
                "a period there is no approach"
            )
        if free and q_c > 0.0:
            raise SolverError(f"screening needs boundary: periodic, got {q_c:g} with free")
        if threads is not None:
            threads = whole_number(threads, "threads")
        max_iterations = whole_number(max_iterations, "max_iterations")
        if hardness is not None:
            hardness = positive_number(hardness, "hardness")
            if free or q_c > 0.0 or aspect != 1.0:
                raise SolverError(
                    "hardness needs boundary: periodic, square points and no screening"
                )
        # What makes the solver iterate in float64, and would have to be otherwise.
        reasons = ["precision: mixed"] * (precision == "double")
        reasons += [f"tolerance: {FLOAT32_FLOOR:g}"] * (tolerance < FLOAT32_FLOOR)
        memory.check(
            h.shape,
            double=bool(reasons),
            instead=" with ".join(reasons),
            converted=not _as_compiled_for(h),
            free=free,
            bounded=hardness is not None,
        )
        check_heights(h, per_point=0)
        if not _as_compiled_for(h):
            h = np.array(h, np.float32 if h.dtype == np.float32 else np.float64, order="C")
        self.shape: tuple[int, ...] = h.shape
        if q_c * self.spacing > LARGEST_SCREENING:
            raise SolverError(
                f"screening must be at most {LARGEST_SCREENING / self.spacing:.1e} on this "
                f"grid ({LARGEST_SCREENING:g}/Δ), got {q_c:g}; points are independent springs "
                "long before: see the model winkler"
            )
        self.modulus = modulus
        self.hardness = hardness
        self.correction: Correction = correction
        self.screening = q_c
        self.options = Options(
            double=precision == "double",
            threads=threads or available_cores(),
            max_iterations=max_iterations,
            kernel=Kernel(aspect=aspect, screening=q_c * self.spacing, free=free),
            # A flat punch goes in by less than its side.
            flat=self.spacing * h.shape[0] if free else 0.0,
            hardness=None if hardness is None else hardness / modulus * self.spacing,
        )
        surface = h.reshape((1, -1)) if h.ndim == 1 else h
        self.solver = Solver(surface, tolerance, **self.options)
        # Σ of the areas of all points; of a line its length.
        self.area = self.spacing * h.size * (self.spacing * aspect if h.ndim == 2 else 1.0)
        steps = (self.spacing, self.spacing * aspect)
        self.size = tuple(n * step for n, step in zip(h.shape, steps, strict=False))
        self.free = free
        rms = self.solver.rms
        if not (rms == 0.0 or 1e-152 < rms < 1e152) or (rms == 0.0 and np.ptp(h) > 0):
            raise SolverError(
                f"heights with an rms value of {rms:g} are out of the range of float64; "
                "choose another unit of length"
            )
        # A flat wall has no scale of its own; its only state is full contact.
        rms = self.solver.rms or 1.0
        self.height_unit = rms
        self.pressure_unit = modulus * rms / self.spacing
        self.energy_unit = modulus * rms**2 / self.spacing
        for unit in (self.pressure_unit, self.energy_unit, self.pressure_unit / rms):
            if not np.finfo(np.float64).tiny <= unit < math.inf:
                raise SolverError(
                    f"with a spacing of {self.spacing:g}, a modulus of {modulus:g} and an rms "
                    f"height of {rms:g} the results leave the range of float64; choose units "
                    "in which they are nearer to 1"
                )

    def loads(self, pressures: ArrayLike) -> NDArray[np.float64]:
        """Dimensionless nominal pressures."""
        p: FloatArray = float_array(pressures, "pressures")
        if p.ndim != 1 or p.size == 0:
            raise SolverError(f"pressures must be a list of numbers, got shape {p.shape}")
        bad = ~((p > 0.0) & np.isfinite(p))
        if bad.any():
            raise SolverError(f"pressures must be positive and finite, got {p[bad][0]}")
        if self.hardness is not None and (p > self.hardness).any():
            raise SolverError(
                f"a hardness of {self.hardness:g} bears no mean pressure above it, got "
                f"{p.max():g}"
            )
        loads = p / self.pressure_unit
        low = p[loads < SMALLEST_LOAD]
        if low.size:
            raise SolverError(
                f"pressures must be at least {SMALLEST_LOAD * self.pressure_unit:.1e} on "
                f"these heights ({SMALLEST_LOAD:g} E* h_rms/Δ), got {low[0]}"
            )
        return loads

    def start(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Dimensionless pressures to start from, as the solver's heights lie."""
        p: FloatArray = float_array(pressure, "start")
        if p.shape != self.shape:
            raise SolverError(
                f"start must have the shape of the heights, {self.shape}, got {p.shape}"
            )
        if not (np.isfinite(p).all() and p.min() >= 0.0 and p.max() > 0.0):
            raise SolverError(
                "start must be pressures: finite, none negative, and not all zero; got values "
                f"from {p.min():g} to {p.max():g}"
            )
        return np.asarray(p / self.pressure_unit, np.float64).reshape(self.solver.heights.shape)

    def approach_wanted(self, separation: float) -> float:
        """Dimensionless approach of a state to be found, without a period."""
        wanted = real_number(separation, "separation")
        if not -math.inf < wanted < 0.0:
            raise SolverError(
                "separation must be negative with boundary: free, minus the approach from the "
                f"first contact (at 0 the bodies only touch), got {wanted:g}"
            )
        return -wanted / self.solver.rms

    def gap_wanted(self, separation: float) -> float:
        """Dimensionless mean gap ū of a state to be found."""
        wanted = real_number(separation, "separation")
        if not wanted > 0.0:
            raise SolverError(
                f"separation must be greater than 0, got {wanted:g}: in full contact, from a "
                f"pressure of {self.solver.full_load * self.pressure_unit:g} on, it is 0 at "
                "every pressure; give a pressure there"
            )
        rms = self.height_unit
        if not SMALLEST_GAP <= wanted / rms < math.inf:
            raise SolverError(
                f"separation must be at least {SMALLEST_GAP * rms:.1e} on these heights "
                f"({SMALLEST_GAP:g} h_rms) and finite, got {wanted:g}"
            )
        return wanted / rms

    def fields(self, solution: Solution | None, load: float) -> Fields:
        """Return pressure, in the unit of the modulus, and gap of a state, None for full."""
        if solution is None:
            sigma, _ = self.solver.traction_at_full_contact()
            pressure = np.asarray((sigma + load) * self.pressure_unit, np.float64)
            gap: FloatArray = np.zeros_like(pressure)
        elif solution.load == 0.0:
            h = self.solver.scaled_heights
            pressure = np.zeros(self.solver.heights.shape)
            above = np.subtract(h.mean, self.solver.heights, dtype=np.float64)
            gap = above + solution.separation * self.height_unit
        else:
            pressure, gap = self.solver.dense(solution)
            bound = self.solver.hardness
            plastic = None if bound is None else pressure >= bound
            pressure *= self.pressure_unit
            if plastic is not None and self.hardness is not None:
                pressure[plastic] = self.hardness  # float32 may hold a little less
                np.minimum(pressure, self.hardness, out=pressure)
            gap *= self.solver.rms
        return Fields(
            pressure.reshape(self.shape), gap.reshape(self.shape), screening=self.screening
        )


def _as_compiled_for(heights: NDArray[Any]) -> bool:
    """Whether heights lie in memory as usual, in float32 or float64: others are copied.

    The loops are compiled for each way anew, in half a minute, and are slower where rows are
    no vectors; with a copy, the same numbers give the same bytes however they lie.
    """
    return heights.dtype in (np.float32, np.float64) and heights.flags.carray


def spacings(length: Length, shape: tuple[int, ...]) -> tuple[float, float]:
    """Spacing along the first axis, and that along the second in its unit.

    Parameters
    ----------
    length : float or (float, float)
        Of square points the side of the cell along the first axis, else both sides.
    shape : tuple of int
        Of the heights.

    Raises
    ------
    SolverError
        If it is neither, or the points are too oblong.

    Examples
    --------
    >>> spacings(2.0, (4, 8)), spacings((2.0, 2.0), (4, 8))
    ((0.5, 1.0), (0.5, 0.5))
    """
    if not isinstance(length, tuple | list | np.ndarray) or np.ndim(length) == 0:
        return positive_number(length, "length") / shape[0], 1.0
    if len(shape) != 2 or len(length) != 2:
        raise SolverError(
            "length must be a number, or for a surface the two sides (y, x) of its cell, got "
            f"{length!r} for heights of shape {shape}"
        )
    y, x = (positive_number(side, f"length[{axis}]") for axis, side in enumerate(length))
    spacing = y / shape[0]
    aspect = x / shape[1] / spacing
    if not 1.0 / LARGEST_ASPECT <= aspect <= LARGEST_ASPECT:
        raise SolverError(
            f"length: points of {spacing:g} × {x / shape[1]:g} are too oblong; neither side "
            f"may be more than {LARGEST_ASPECT:g} times the other"
        )
    return spacing, aspect
