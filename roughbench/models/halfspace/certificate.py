"""What a state violates of the conditions of contact, and when it counts as solved."""

from __future__ import annotations

import math
from dataclasses import dataclass

PENETRATION_SLACK = 10.0
"""Penetration allowed at convergence, in units of the tolerance."""

DISPLACEMENT_FACTOR = 4.0
"""Errors are measured against h_rms, or this many times the mean displacement of the loaded
points where that is less. With 1 the curves of the benchmarks take 1 to 3 % more transform
pairs, with 4 and more none."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """What a returned state violates, recomputed in float64 from its pressure.

    Attributes
    ----------
    complementarity : float
        Σ|p g| / (Σp · h_rms).
    penetration : float
        max(−g) / h_rms over all points.
    load_error : float
        |⟨p⟩/p̄ − 1|.
    displacement : float
        Σp u / (Σp · h_rms): how far the surface is displaced where it carries.
    """

    complementarity: float
    penetration: float
    load_error: float
    displacement: float

    @property
    def error(self) -> float:
        """Complementarity, or a tenth of the penetration if that is more.

        The penetration is a maximum over all points, the complementarity a mean.
        """
        return max(self.complementarity, self.penetration / PENETRATION_SLACK)

    @property
    def pressure_error(self) -> float:
        r"""Bound on the relative error of the pressures, ‖p − p*‖/‖p‖ with ‖p‖² = ⟨p·Gp⟩.

        For the exact pressures p*, ‖p − p*‖² ≤ ⟨g·(p − p*)⟩ ≤ ⟨pg⟩ + p̄ max(−g).
        """
        wrong = self.complementarity + self.penetration
        return math.sqrt(wrong / self.displacement) if wrong > 0.0 else 0.0

    def holds(self, tolerance: float) -> bool:
        """Whether a state may be called converged.

        Its error is at most ``tolerance``, in units of :attr:`scale`.
        """
        return self.error <= self.scale * tolerance and self.load_error <= max(tolerance, 1e-12)

    @property
    def scale(self) -> float:
        """Length, in h_rms, that errors are measured against."""
        return min(1.0, DISPLACEMENT_FACTOR * self.displacement)
