r"""Moments of what stands out above a level of normally distributed heights.

.. math:: F_n(t) = \int_t^\infty (s-t)^n\, \varphi(s)\, V(s)\, ds, \qquad
          \varphi(s) = \frac{e^{-s^2/2}}{\sqrt{2\pi}},

with :math:`V = 1`, or a slowly varying weight that an asperity model brings along. With
:math:`s = t + y^2` the integrand is smooth down to :math:`y = 0` for all half-integer n,
and 64 Gauss-Legendre points over the range where it is not negligible leave an error of
rounding only. The exponential :math:`e^{-t^2/2}` of a high level is kept apart, so that
the smallest pressures do not underflow.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
Weight = Callable[[FloatArray], FloatArray]

_POINTS = 64
_REACH = 40.0
"""The integrand ends where it has fallen by e^-40."""
_BLOCK = 256
"""Levels at once: a weight may take a hundred points at each of the 64."""


def log_excess(
    orders: tuple[float, ...], t: ArrayLike, weight: Weight | None = None
) -> FloatArray:
    """Return ln F_n(t) of several orders.

    Parameters
    ----------
    orders : tuple of float
        Orders n > -1/2, multiples of 1/2.
    t : array_like of float64, shape (P,)
        Levels, in standard deviations.
    weight : callable, optional
        V(s) > 0, elementwise; default 1.

    Returns
    -------
    ndarray of float64, shape (len(orders), P)

    Examples
    --------
    >>> np.exp(log_excess((1.0,), [0.0])).round(12).tolist()  # 1/√(2π)
    [[0.398942280401]]
    """
    level = np.atleast_1d(np.asarray(t, float))
    blocks = range(0, level.size, _BLOCK)
    return np.concatenate(
        [_log_excess(orders, level[start : start + _BLOCK], weight) for start in blocks]
        or [np.empty((len(orders), 0))],
        axis=1,
    )


def _log_excess(
    orders: tuple[float, ...], level: FloatArray, weight: Weight | None
) -> FloatArray:
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    width = math.sqrt(2.0 * _REACH)
    above = np.maximum(level, 0.0)
    # t x + x²/2 = REACH above the mean; within ± width of the mean below it.
    far = np.where(
        level > 0.0,
        2.0 * _REACH / (above + np.sqrt(above**2 + 2.0 * _REACH)),
        width - level,
    )
    near = np.sqrt(np.maximum(-level - width, 0.0))
    half = (np.sqrt(far) - near)[:, None] / 2.0
    y = near[:, None] + half * (1.0 + points)
    x = y * y
    s = level[:, None] + x
    with np.errstate(under="ignore"):
        density = np.exp((above[:, None] ** 2 - s * s) / 2.0) * (2.0 * y) * half * weights
    if weight is not None:
        density = density * weight(s)
    with np.errstate(under="ignore"):
        sums = np.stack([(density * y ** (2.0 * n)).sum(axis=1) for n in orders])
    return np.asarray(np.log(sums) - above**2 / 2.0 - math.log(2.0 * math.pi) / 2.0)
