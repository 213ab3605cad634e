r"""How much a ratio that should be constant drifts over so many decades of pressure.

A band of slopes cannot tell a law from a drift: a stiffness :math:`\propto p^{1.1}` has the
slope 1 ± 0.15 everywhere, while K/p doubles in three decades. Here the drift itself is
measured: over a window of W decades ln(K/p) is fitted by a parabola in ln p, and the drift is
the largest over the smallest value of the parabola in the window, 1 for a law. Of all windows
that the pressures hold the one of the least drift counts: whatever drifts there drifts
everywhere. The parabola sees a bend as well as a trend, and its three coefficients average over
the scatter of the pressures.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

FEWEST = 4
"""Pressures in a window; three would lie on any parabola."""
_SLACK = 1e-9


def least_drift(x: FloatArray, y: FloatArray, decades: float) -> FloatArray:
    """Return the least drift of e^y over windows of a width.

    Parameters
    ----------
    x : ndarray of float64, shape (P,)
        ln p, ascending.
    y : ndarray of float64, shape (B, P)
        Logarithm of what should be constant; nan where there is none.
    decades : float
        Width W of the windows, which begin at a pressure each.

    Returns
    -------
    ndarray of float64, shape (B,)
        At least 1; nan where no window holds enough values.

    Examples
    --------
    >>> x = np.log(np.logspace(-6, -1, 21))
    >>> least_drift(x, 0.1 * x[None, :], 3.0).round(3).tolist()  # 10**(0.1·3)
    [1.995]
    """
    width = decades * math.log(10.0)
    found = np.full(len(y), math.inf)
    for first in range(x.size):
        reached = np.flatnonzero(x >= x[first] + width - _SLACK)
        if not reached.size:
            break
        part = slice(first, int(reached[0]) + 1)
        if x[part].size >= FEWEST:
            drift = _drift(x[part] - x[first], y[:, part], width)
            found = np.fmin(found, drift)
    return np.where(np.isinf(found), math.nan, found)


def _drift(x: FloatArray, y: FloatArray, width: float) -> FloatArray:
    """Return the drift of the least-squares parabolas over one window, from 0 to its width."""
    basis = np.vander(x / width, 3)
    a, b, c = np.linalg.pinv(basis) @ y.T
    ends = np.stack([c, a + b + c])
    with np.errstate(divide="ignore", invalid="ignore"):
        place = -b / (2.0 * a)
        vertex = c + 0.5 * b * place
    inner = np.isfinite(place) & (place > 0.0) & (place < 1.0)
    values = np.stack([*ends, np.where(inner, vertex, c)])
    return np.asarray(np.exp(values.max(axis=0) - values.min(axis=0)))
