r"""What G is: the spacings of the grid, and how far waves couple.

A pressure wave q makes the displacement G(q) = 2/(E*√(q² + q_c²)) of the same wave. With
q_c = 0 that is the half-space. Waves longer than 2π/q_c do not feel the coupling: for
q_c far beyond the largest wavevector of the grid, every point is a spring of its own, of
the modulus k_w = E* q_c/2.

G(0) = 0 for any q_c. A uniform displacement moves no point against another: at a given
load it changes neither pressure nor gap, and the mean separation is the mean of the gap,
as it is for the half-space and for springs (:mod:`roughbench.models.winkler`). The wall's
distance from the *undeformed* plane is less than that by 2p̄/(E* q_c).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.love import FloatArray, love_influence


@dataclass(frozen=True, slots=True)
class Kernel:
    """G between the points of a grid, in units of the spacing Δ along the first axis.

    Attributes
    ----------
    aspect : float
        Spacing along the second axis, in Δ.
    screening : float
        q_c Δ.
    free : bool
        Whether the half-space is not periodic: G(r) = 1/(πE*r), averaged over one point.
    """

    aspect: float = 1.0
    screening: float = 0.0
    free: bool = False

    def wavenumber(self, qy: FloatArray, qx: FloatArray) -> FloatArray:
        """√(q² + q_c²), with qx in radians per point of the second axis."""
        q: FloatArray = np.hypot(np.hypot(qy, qx / self.aspect), self.screening)
        return q

    def near(self, size: tuple[int, int]) -> FloatArray:
        """G in real space, for offsets 0 … size − 1 along each axis; shape ``size``.

        Taken from a periodic grid of 256 points per side (a line: 4096); its zero mean
        shifts all values by the same small constant. That of a free half-space is exact.
        """
        if self.free:
            return love_influence(size, self.aspect)
        if size[0] == 1:
            q = self.wavenumber(np.zeros(1)[:, None], _waves(4096))
        else:
            q = self.wavenumber(_waves(256)[:, None], _waves(256))
        q[0, 0] = math.inf
        return np.asarray(np.fft.ifftn(2.0 / q).real[: size[0], : size[1]], np.float64)

    def stencil(self, shape: tuple[int, int], dtype: DTypeLike) -> NDArray[np.floating]:
        """Weights (centre, along rows, across rows, diagonal) of G⁻¹ in real space.

        The nearest values of the inverse transform of √(q² + q_c²)/2 on the grid: positive
        in the centre, negative off it. Restricted to the working set they precondition G
        there without a transform.
        """
        if self.free:
            stiffness = 1.0 / self._spectrum((256, 256))
            stiffness[0, 0] = 0.0
        else:
            stiffness = self.wavenumbers(shape) / 2
        return nearest_values(stiffness).astype(dtype)

    def wavenumbers(self, shape: tuple[int, int]) -> FloatArray:
        """√(q² + q_c²) on a periodic grid of 256 points per side, or line of as many."""
        if shape[0] == 1:
            return self.wavenumber(np.zeros(1), _waves(256))
        return self.wavenumber(_waves(256)[:, None], _waves(256))

    def _spectrum(self, period: tuple[int, int]) -> FloatArray:
        """G of a free half-space on a periodic grid of even size, up to half of it."""
        rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in period)
        near = self.near((period[0] // 2 + 1, period[1] // 2 + 1))
        return np.asarray(np.fft.fft2(near[np.ix_(rows, columns)]).real, np.float64)


HALF_SPACE = Kernel()
"""The half-space on square points."""


def nearest_values(symbol: FloatArray) -> FloatArray:
    """Values in real space: at the origin, next to it along rows, across them, diagonally."""
    values = np.fft.ifftn(symbol).real
    if values.ndim == 1:
        return np.array([values[0], values[1], 0.0, 0.0])
    return np.array([values[0, 0], values[0, 1], values[1, 0], values[1, 1]])


def _waves(n: int) -> FloatArray:
    return np.asarray(2 * math.pi * np.fft.fftfreq(n), np.float64)
