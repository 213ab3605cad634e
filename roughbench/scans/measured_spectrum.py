"""A spectrum as it was measured: powers, modes, and moments with their band."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

HANN_WIDTH = 1.0 + 2.0 * ((2.0 / 3.0) ** 2 + (1.0 / 6.0) ** 2)
"""Modes that one independent mode takes under Hann's window along an axis: neighbours have the
correlations 2/3 and 1/6, and powers of Gaussian modes their squares."""
HANN_SMEAR = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)
"""Shares of a mode's power that Hann's window leaves to its lower neighbour, itself, its upper
one."""
BINS_PER_DECADE = 12


@dataclass(frozen=True, slots=True)
class MeasuredSpectrum:
    """A spectrum on wavevectors in rising order.

    Attributes
    ----------
    kind : str
        "surface" (C2D, length⁴), "along x" or "along y" (of profiles, length³).
    q : ndarray of float64, shape (n,)
        Root mean square wavevector of the modes averaged over, 1/length.
    power : ndarray of float64, shape (n,)
        Mean of the spectrum over these modes.
    modes : ndarray of float64, shape (n,)
        Wavevectors averaged over, ±q counted once; all q_y of a q_x together are one.
    independent : ndarray of float64, shape (n,)
        How many of them are as good as independent: of a Gaussian surface the standard
        error of the mean is ``power / √independent``.
    crowding : ndarray of float64, shape (n,)
        ⟨P²⟩/⟨P⟩² of the powers P of the modes: 2 for random Gaussian heights, 1 for
        random phases, many where few modes hold all the power.
    size, spacing : (float, float)
        Of the heights, and of their points, along (y, x), length.
    windowed : bool
        Whether Hann's window was used.
    """

    kind: str
    q: FloatArray
    power: FloatArray
    modes: FloatArray
    independent: FloatArray
    crowding: FloatArray
    size: tuple[float, float]
    spacing: tuple[float, float]
    windowed: bool

    @property
    def error(self) -> FloatArray:
        """Standard error of the power, in its unit."""
        error: FloatArray = self.power / np.sqrt(self.independent)
        return error

    @property
    def band(self) -> tuple[float, float]:
        """Smallest and largest wavevector, 1/length."""
        return float(self.q[0]), float(self.q[-1])

    def moment(self, order: int) -> float:
        r"""∫ q^k C over the plane, or over both directions of the axis, within the band.

        For order 0, 2, 4 and a surface that is M0, M2 = ⟨|∇h|²⟩ and M4 = ⟨(∇²h)²⟩; for
        profiles m0, m2 = ⟨h'²⟩ and m4 = ⟨h''²⟩.
        """
        if self.kind == "surface":
            cell = (2.0 * math.pi) ** 2 / (self.size[0] * self.size[1])
        else:
            cell = 2.0 * math.pi / self.size[0 if self.kind == "along y" else 1]
        return float(2.0 * cell * np.sum(self.modes * self.power * self.q**order))

    @property
    def profile_moments(self) -> tuple[float, float, float]:
        """Nayak's m0, m2, m4 of a profile; of a surface those of an isotropic one."""
        m0, m2, m4 = (self.moment(order) for order in (0, 2, 4))
        return (m0, m2 / 2.0, 3.0 * m4 / 8.0) if self.kind == "surface" else (m0, m2, m4)

    def binned(self, per_decade: int = BINS_PER_DECADE) -> MeasuredSpectrum:
        """Return the averages over bins of equal width in ln q, without empty ones."""
        place = np.log10(self.q / self.q[0]) * per_decade
        number = np.floor(place + 1e-9).astype(np.int64)
        weight = self.modes
        total: FloatArray = np.bincount(number, weight).astype(np.float64)
        filled = total > 0.0
        total = total[filled]

        def mean(values: FloatArray) -> FloatArray:
            return np.asarray(np.bincount(number, weight * values)[filled] / total)

        power = mean(self.power)
        # Of independent means the variances add; a window makes neighbours share theirs.
        shared = HANN_WIDTH if self.windowed and self.kind != "surface" else 1.0
        spread = np.bincount(number, weight**2 * self.power**2 / self.independent)[filled]
        variance = np.maximum(spread / total**2 * shared, 1e-300)
        safe = np.where(power > 0.0, power, 1.0)
        independent = np.where(power > 0.0, safe**2 / variance, np.bincount(number)[filled])
        return MeasuredSpectrum(
            kind=self.kind,
            q=np.sqrt(mean(self.q**2)),
            power=power,
            modes=total,
            independent=np.maximum(independent, 1.0 / HANN_WIDTH**2),
            crowding=mean(self.crowding),
            size=self.size,
            spacing=self.spacing,
            windowed=self.windowed,
        )
