"""The one loop of the foundation that NumPy cannot do: springs touch, one by one.

Numba compiles it on the first call and keeps the machine code beside this file, or in
the user's cache where this folder is read-only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughbench.models._compiled import compiled


@compiled(nogil=True)
def grow_regions(
    order: NDArray[np.int64],
    periodic: bool,  # noqa: FBT001 - numba knows no keyword-only arguments
    regions: NDArray[np.int64],
    squares: NDArray[np.int64],
) -> None:
    """Let the springs touch in ``order``; count the connected regions after each.

    A union-find for a line: of a region only its two end springs are ever asked, and
    each of them knows the size of the region, so that a union takes constant time.

    Parameters
    ----------
    order : ndarray of int64, shape (N,)
        Indices of the springs, highest first.
    periodic : bool
        Whether the last spring is a neighbour of the first.
    regions, squares : ndarray of int64, shape (N + 1,)
        Output: number of regions and Σ n_i² over them, with k springs in contact.
    """
    n = order.size
    size = np.zeros(n, np.int64)  # 0: not in contact
    regions[0] = 0
    squares[0] = 0
    for k in range(n):
        i = order[k]
        before, after = i - 1, i + 1
        if periodic:
            before, after = before % n, after % n
        left = size[before] if before >= 0 else 0
        right = size[after] if after < n else 0
        if k == n - 1:  # on a ring the last spring would join a region to itself
            regions[n] = 1
            squares[n] = n * n
            return
        joined = left + 1 + right
        regions[k + 1] = regions[k] + 1 - (left > 0) - (right > 0)
        squares[k + 1] = squares[k] + joined * joined - left * left - right * right
        # Only the ends of the new region matter from now on (modulo n on a ring).
        size[i] = joined
        size[(i - left) % n] = joined
        size[(i + right) % n] = joined


@compiled(nogil=True)
def accumulate(steps: NDArray[np.float64], sums: NDArray[np.float64]) -> None:
    """Write the running sums of ``steps``, compensated (Neumaier 1974).

    Parameters
    ----------
    steps : ndarray of float64, shape (n,)
    sums : ndarray of float64, shape (n + 1,)
        Output; the first is zero.
    """
    total = 0.0
    lost = 0.0
    sums[0] = 0.0
    for k in range(steps.size):
        step = steps[k]
        new = total + step
        lost += (total - new) + step if abs(total) >= abs(step) else (step - new) + total
        total = new
        sums[k + 1] = total + lost
