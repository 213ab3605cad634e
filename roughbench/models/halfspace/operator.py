r"""The periodic half-space: u = G p with G(q) = 2/(E*|q|), and S = G⁻¹ = E*|q|/2.

On a screened one |q| is √(q² + q_c²), and where points are no squares their spacings say
what q is: see :mod:`.kernel`.

Inside the solver everything is dimensionless: lengths along the surface in grid spacings
Δ of the first axis, heights and displacements in the rms height h_s of the given heights,
and pressures in E* h_s/Δ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import gap
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.transform import RealTransform


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
    kernel : Kernel
        Spacings and screening.
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: DTypeLike,
        team: ThreadTeam,
        kernel: Kernel = HALF_SPACE,
    ) -> None:
        self.transform = RealTransform(shape, dtype, team.threads)
        self.team = team
        self.pairs = 0
        """Transform pairs done so far, not counting :meth:`unit_response`."""
        n, m = shape
        self._blocks = team.even(n)
        # q_c² stands with the first axis.
        qy, qx = 2 * math.pi * np.fft.fftfreq(n), 2 * math.pi * np.fft.rfftfreq(m)
        self._qy_squared = (qy**2 + kernel.screening**2).astype(dtype)
        self._qx_squared = ((qx / kernel.aspect) ** 2).astype(dtype)
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
