r"""The periodic half-space: u = G p with G(q) = 2/(E*|q|), and S = G⁻¹ = E*|q|/2.

Inside the solver everything is dimensionless: lengths along the surface in grid
spacings Δ, heights and displacements in the rms height h_s of the given heights, and
pressures in E* h_s/Δ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.loops import gap
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.transform import RealTransform

FloatArray = NDArray[np.float64]


class HalfSpaceOperator:
    """Applies G, or S, to the field in a transform's buffer, in place.

    Parameters
    ----------
    shape : (int, int)
        Grid; (1, m) is a line on a half-plane.
    dtype : dtype
        float32 or float64: precision of the transforms.
    team : ThreadTeam
        Threads of the loops and transforms.
    """

    def __init__(self, shape: tuple[int, int], dtype: DTypeLike, team: ThreadTeam) -> None:
        self.transform = RealTransform(shape, dtype, team.threads)
        self.team = team
        self.pairs = 0
        """Transform pairs done so far, not counting :meth:`unit_response`."""
        n, m = shape
        self._blocks = team.even(n)
        self._qy_squared = ((2 * math.pi * np.fft.fftfreq(n)) ** 2).astype(dtype)
        self._qx_squared = ((2 * math.pi * np.fft.rfftfreq(m)) ** 2).astype(dtype)
        size = n * m
        self._compliance = self.transform.dtype.type(2.0 / size)
        self._stiffness = self.transform.dtype.type(0.5 / size)

    @property
    def field(self) -> NDArray[np.floating]:
        """The dense field, shape (n, m), that is transformed in place."""
        return self.transform.real

    def displace(self) -> None:
        """field ← G field: displacement of zero mean from pressure."""
        self._apply(self._compliance, -1)
        self.pairs += 1

    def traction(self) -> float:
        """field ← S field: pressure of zero mean from displacement; Σ of their products."""
        self.pairs += 1
        return self._apply(self._stiffness, 1)

    def unit_response(self) -> None:
        """field ← G in real space: displacement by a unit pressure on the first point."""
        self.field[...] = 0.0
        self.field[0, 0] = 1.0
        self._apply(self._compliance, -1)

    def _apply(self, factor: np.floating, exponent: int) -> float:
        self.transform.forward()
        work = self.team.run(
            gap.multiply_by_kernel,
            self._blocks,
            self.transform.spectral,
            self._qy_squared,
            self._qx_squared,
            factor,
            exponent,
            self.transform.real.shape[1],
        )
        self.transform.backward()
        return float(sum(work))


def kernel_on(size: tuple[int, int]) -> FloatArray:
    """G in real space, for offsets 0 … size − 1 along each axis; shape ``size``.

    Taken from a periodic grid of 256 points per side (a line: 4096); its zero mean shifts
    all values by the same small constant.
    """
    if size[0] == 1:
        q = 2 * math.pi * np.abs(np.fft.fftfreq(4096))[None, :]
    else:
        q1d = 2 * math.pi * np.fft.fftfreq(256)
        q = np.hypot(q1d[:, None], q1d)
    q[0, 0] = math.inf
    kernel: FloatArray = np.fft.ifftn(2.0 / q).real[: size[0], : size[1]]
    return kernel


def stiffness_stencil(shape: tuple[int, int], dtype: DTypeLike) -> NDArray[np.floating]:
    """Weights (centre, along rows, across rows, diagonal) of |q|/2 in real space.

    The nearest values of the inverse transform of |q|/2 on the grid: positive in the
    centre, negative off it. Restricted to the working set they precondition G there
    without a transform.
    """
    if shape[0] == 1:
        q = 2 * math.pi * np.abs(np.fft.fftfreq(256))
        line = np.fft.ifft(q / 2).real
        weights = [line[0], line[1], 0.0, 0.0]
    else:
        q1d = 2 * math.pi * np.fft.fftfreq(256)
        cell = np.fft.ifft2(np.hypot(q1d[:, None], q1d) / 2).real
        weights = [cell[0, 0], cell[0, 1], cell[1, 0], cell[1, 1]]
    return np.array(weights, dtype=dtype)
