"""Points and weights for the integrals of Persson's theory; see :mod:`.persson`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.spectrum import Spectrum, power_integral

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

_POINTS = 8
_PANEL = 0.35
"""Largest logarithmic width of a panel, in q and in ξ."""
_ONSET = 1e-26
"""(q - q0)/q0 where the panels start: what lies below is 1e-13 of the integrals."""
_TOUCH = 30.0
"""Argument x of e^{-x²} past which nothing is left: the panels start where x is larger."""
_LOWEST = -600.0
"""Logarithm of the smallest (q - q0)/q0 at all."""


@dataclass(frozen=True, slots=True)
class Quadrature:
    """Points ξ(q) on q0 … q1, and the weights of the three integrals over them."""

    slope: FloatArray
    """ξ at the points."""
    stiffness: FloatArray
    """√π q² C w dq = dB."""
    separation: FloatArray
    """[B(q1) - B] d ln ξ."""
    energy: FloatArray
    """(π/2) q² C dq."""
    slope_end: float
    """ξ(q1)."""
    total: float
    """B(q1)."""


class _Chain:
    """The segments of a spectrum that hold power, and ξ² on them.

    The place on a segment is t: on the first ln(q/q0 - 1), since ξ starts as
    √(q - q0), on the others ln(q/lower).
    """

    def __init__(self, spectrum: Spectrum) -> None:
        power = np.asarray(spectrum.prefactors, float)
        held = power > 0.0
        if not held.any():
            raise SurfaceError("the spectrum has no power; Persson's theory needs roughness")
        self.power = power[held]
        self.lower = np.asarray(spectrum.edges[:-1], float)[held]
        self.width = np.asarray(spectrum.edges[1:], float)[held] / self.lower - 1.0
        self.exponent = np.asarray(spectrum.exponents, float)[held]
        gain = (2.0 * np.pi) * self.power
        gain *= power_integral(self.lower, self.width, 4.0 - self.exponent)
        until = np.cumsum(gain)
        self.slope_squared_below = np.append(0.0, until[:-1])
        self.slope_squared_end = float(until[-1])

    def stretch(self, i: IndexArray, t: FloatArray) -> FloatArray:
        """q/lower - 1."""
        return np.where(i == 0, np.exp(t), np.expm1(t))

    def slope_squared(self, i: IndexArray, t: FloatArray) -> FloatArray:
        """ξ²(q) = M_2 up to q, without cancellation near q0."""
        part = power_integral(self.lower[i], self.stretch(i, t), 4.0 - self.exponent[i])
        return np.asarray(self.slope_squared_below[i] + 2.0 * np.pi * self.power[i] * part)


@dataclass(frozen=True, slots=True)
class _Panels:
    segment: IndexArray
    left: FloatArray
    right: FloatArray

    def halved(self, which: NDArray[np.bool_]) -> _Panels:
        """Return the panels with the chosen ones cut into halves, in order."""
        copies = np.where(which, 2, 1)
        middle = ((self.left + self.right) / 2.0)[which]
        left, right = np.repeat(self.left, copies), np.repeat(self.right, copies)
        first = (np.cumsum(copies) - copies)[which]
        right[first] = middle
        left[first + 1] = middle
        return _Panels(np.repeat(self.segment, copies), left, right)


def _lay_panels(chain: _Chain, lowest_pressure: float) -> _Panels:
    """Halve the segments until q, ξ and e^{-2p²/ξ²} change little on each panel."""
    right = np.log1p(chain.width)
    left = np.zeros(right.size)
    right[0] = math.log(chain.width[0])
    # At the onset ξ² = 2πC q0^(4-s) x: either is e^{-2p²/ξ²} gone there, or ξ negligible.
    steepness = 2.0 * math.pi * chain.power[0] * chain.lower[0] ** (4.0 - chain.exponent[0])
    touch = math.log(2.0 / steepness) + 2.0 * math.log(lowest_pressure / _TOUCH)
    left[0] = max(min(math.log(_ONSET) + min(0.0, right[0]), touch), _LOWEST)
    panels = _Panels(np.arange(right.size), left, right)
    while True:
        s_left = chain.slope_squared(panels.segment, panels.left)
        s_right = chain.slope_squared(panels.segment, panels.right)
        wide = panels.right - panels.left > _PANEL * np.where(panels.segment == 0, 2.0, 1.0)
        wide |= np.log(s_right / s_left) > 2.0 * _PANEL
        # x² - x1² = x1² (ξ1²/ξ² - 1), and x1² reaches 700 before e^{-x²} underflows.
        far, near = (chain.slope_squared_end / s - 1.0 for s in (s_left, s_right))
        wide |= far - near > np.maximum(near, 1e-3)
        if not wide.any():
            return panels
        panels = panels.halved(wide)


def make_quadrature(
    spectrum: Spectrum, lowest_pressure: float = math.inf, halvings: int = 0
) -> Quadrature:
    """Return points and weights for all pressures p/E* from ``lowest_pressure`` on.

    Parameters
    ----------
    spectrum : Spectrum
    lowest_pressure : float
        p/E*; without it the separation's weights serve no pressure.
    halvings : int
        How often to halve all panels once more, for tests of the convergence.

    Raises
    ------
    SurfaceError
        If the spectrum has no power.
    """
    chain = _Chain(spectrum)
    panels = _lay_panels(chain, lowest_pressure)
    for _ in range(halvings):
        panels = panels.halved(np.ones(panels.left.size, bool))
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    half = (panels.right - panels.left)[:, None] / 2.0
    t = (panels.left + panels.right)[:, None] / 2.0 + half * points
    i = np.broadcast_to(panels.segment[:, None], t.shape)
    q = chain.lower[i] * (1.0 + chain.stretch(i, t))
    slope_squared = chain.slope_squared(i, t)
    dq = chain.lower[i] * np.exp(t) * half * weights  # for both meanings of t
    energy = np.pi / 2.0 * chain.power[i] * q ** (2.0 - chain.exponent[i]) * dq
    stiffness = energy * np.sqrt(8.0 / (np.pi * slope_squared))
    # B(q1) - B(q): the panels beyond, and the rest of this one.
    sums = stiffness.sum(axis=1)
    beyond = np.append(np.cumsum(sums[:0:-1])[::-1], 0.0)
    inside = (stiffness / weights) @ _remaining_weights(points, weights).T
    separation = (beyond[:, None] + inside) * 2.0 * q * energy / slope_squared
    return Quadrature(
        slope=np.sqrt(slope_squared).ravel(),
        stiffness=stiffness.ravel(),
        separation=separation.ravel(),
        energy=energy.ravel(),
        slope_end=math.sqrt(chain.slope_squared_end),
        total=float(sums.sum()),
    )


def _remaining_weights(points: FloatArray, weights: FloatArray) -> FloatArray:
    """Return R with R @ f(points) = the integrals of f from each point to 1."""
    legendre = np.polynomial.legendre
    degrees = np.arange(points.size)
    primitives = np.stack(
        [-legendre.legval(points, legendre.legint(k, lbnd=1)) for k in np.eye(points.size)],
        axis=1,
    )
    # Row k turns values at the points into the coefficient of the Legendre polynomial k.
    values = legendre.legvander(points, points.size - 1)
    return np.asarray(primitives @ ((degrees[:, None] + 0.5) * values.T * weights))
