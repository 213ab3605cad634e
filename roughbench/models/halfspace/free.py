r"""G of a half-space that is not periodic, by convolution on a grid of twice as many points.

The displacement by one pressed rectangle is Love's (:mod:`.love`). The sum over all
rectangles is a convolution without a period; on a grid of twice as many points along each
axis, padded with zeros, it is one with a period (the DC-FFT method of Liu, Wang and Liu,
2000). Displacements count from the undeformed surface far away: G has a mean mode.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray

from roughbench.models.halfspace.kernel import Kernel
from roughbench.models.halfspace.loops import gap
from roughbench.models.halfspace.love import love_influence
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.transform.padded import PaddedConvolution


class FreeOperator(HalfSpaceOperator):
    """Applies G of the free half-space to a field, in place; see :class:`.HalfSpaceOperator`.

    Stored are the field with rows of twice their length, and the transform of G on a
    fourth of the padded grid, which has two mirror lines.
    """

    periodic = False

    def __init__(
        self, shape: tuple[int, int], dtype: DTypeLike, team: ThreadTeam, kernel: Kernel
    ) -> None:
        from scipy.fft import dctn, next_fast_len

        half = next_fast_len(shape[0]), next_fast_len(shape[1])
        period = 2 * half[0], 2 * half[1]
        self.team = team
        self.pairs = 0
        self._convolution = PaddedConvolution(shape, period, dtype, team.threads)
        # Of an even sequence the cosine transform is the Fourier transform.
        influence = love_influence((half[0] + 1, half[1] + 1), kernel.aspect)
        table = dctn(influence, type=1, overwrite_x=True)
        table /= period[0] * period[1]
        self._table: NDArray[np.floating] = table.astype(dtype, copy=False)

    @property
    def field(self) -> NDArray[np.floating]:
        """The dense field, shape (n, m), that is convolved in place."""
        return self._convolution.real

    def displace(self) -> None:
        """field ← G field: displacement from pressure."""
        table = self._table
        self._convolution.apply(
            lambda spectral, first: gap.multiply_by_even_table(spectral, table, first)
        )
        self.pairs += 1

    def traction(self) -> float:
        """Has no meaning here: no pressure flattens the surface without singular edges."""
        raise NotImplementedError("the free half-space has no traction of full contact")

    def unit_response(self) -> None:
        """Has no table for direct sums."""
        raise NotImplementedError("direct sums are those of the periodic half-space")


def make_operator(
    shape: tuple[int, int], dtype: DTypeLike, team: ThreadTeam, kernel: Kernel
) -> HalfSpaceOperator:
    """Return G of a kernel on a grid."""
    made = FreeOperator if kernel.free else HalfSpaceOperator
    return made(shape, dtype, team, kernel)
