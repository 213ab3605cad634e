"""A contact problem as it is given: checked arguments, the solver on them, and their units."""

from __future__ import annotations

import math
import os
from typing import TypedDict

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
from roughbench.models.halfspace.options import Correction, Precision
from roughbench.models.halfspace.solver import FLOAT32_FLOOR, Solution, Solver

SMALLEST_LOAD = 1e-20
"""In E* h_rms/Δ. A single point of a grid carries its share of less; float32 does not."""


SMALLEST_GAP = 1e-12
"""In h_rms. Rounding errors of float64 decide about less."""


class Options(TypedDict):
    """Those of :class:`Solver`."""

    double: bool
    threads: int
    max_iterations: int
    hardness: float | None


class Problem:
    """Checked arguments, the solver on them, and the units between the two."""

    def __init__(
        self,
        heights: ArrayLike,
        length: float,
        modulus: float,
        tolerance: float,
        precision: Precision,
        threads: int | None,
        max_iterations: int,
        correction: Correction,
        hardness: float | None = None,
    ) -> None:
        h = real_array(heights, "heights", kinds="buif")
        if h.ndim not in (1, 2) or min(h.shape, default=0) < 2:
            raise SolverError(
                "heights must be a line (n,) or a surface (n, m) of at least 2 points a "
                f"side, got shape {h.shape}"
            )
        length = positive_number(length, "length")
        modulus = positive_number(modulus, "modulus")
        tolerance = positive_number(tolerance, "tolerance")
        if tolerance > 0.1:
            raise SolverError(f"tolerance must be at most 0.1, got {tolerance}")
        if not (isinstance(precision, str) and precision in ("mixed", "double")):
            raise SolverError(f"precision must be 'mixed' or 'double', got {precision!r}")
        if not (isinstance(correction, str) and correction in ("perimeter", "none")):
            raise SolverError(f"correction must be 'perimeter' or 'none', got {correction!r}")
        if threads is not None:
            threads = whole_number(threads, "threads")
        max_iterations = whole_number(max_iterations, "max_iterations")
        if hardness is not None:
            hardness = positive_number(hardness, "hardness")
        # What makes the solver iterate in float64, and would have to be otherwise.
        reasons = ["precision: mixed"] * (precision == "double")
        reasons += [f"tolerance: {FLOAT32_FLOOR:g}"] * (tolerance < FLOAT32_FLOOR)
        memory.check(
            h.shape,
            double=bool(reasons),
            instead=" with ".join(reasons),
            converted=h.dtype not in (np.float32, np.float64),
            bounded=hardness is not None,
        )
        check_heights(h, per_point=0)
        if h.dtype not in (np.float32, np.float64):
            h = h.astype(np.float64)
        self.shape = h.shape
        self.spacing = length / h.shape[0]
        self.modulus = modulus
        self.hardness = hardness
        self.correction: Correction = correction
        self.options = Options(
            double=precision == "double",
            threads=threads or len(os.sched_getaffinity(0)),
            max_iterations=max_iterations,
            hardness=None if hardness is None else hardness / modulus * self.spacing,
        )
        surface = h.reshape((1, -1)) if h.ndim == 1 else h
        self.solver = Solver(surface, tolerance, **self.options)
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
                    f"with a length of {length:g}, a modulus of {modulus:g} and an rms height "
                    f"of {rms:g} the results leave the range of float64; choose units in which "
                    "they are nearer to 1"
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
        return (p / self.pressure_unit).reshape(self.solver.heights.shape)

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
            pressure = (sigma + load) * self.pressure_unit
            gap = np.zeros_like(pressure)
        elif solution.load == 0.0:
            h = self.solver.scaled_heights
            pressure = np.zeros(self.solver.heights.shape)
            gap = (h.mean - self.solver.heights) + solution.separation * self.height_unit
        else:
            pressure, gap = self.solver.dense(solution)
            bound = self.solver.hardness
            plastic = None if bound is None else pressure >= bound
            pressure *= self.pressure_unit
            if plastic is not None and self.hardness is not None:
                pressure[plastic] = self.hardness  # float32 may hold a little less
                np.minimum(pressure, self.hardness, out=pressure)
            gap *= self.solver.rms
        return Fields(pressure.reshape(self.shape), gap.reshape(self.shape))
