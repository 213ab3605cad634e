"""Which part of a measured spectrum a law explains, and what lies beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.measured_spectrum import MeasuredSpectrum

FloatArray = NDArray[np.float64]

SCATTERS = (0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6)
"""Values of σ that are tried, in ln C."""
FREE = 1.0
"""How far a bin outside of the band may be expected anywhere, in ln C."""
CUT = 3.0
"""What it costs, in -2 ln L, to leave out anything at an end."""
FEWEST = 5
"""Bins that a band, and its falling part, must have."""
SMALLEST_SHARE = 0.01
"""Of the mean square height that a band must hold: what is left of rounding does not."""


@dataclass(frozen=True, slots=True)
class Band:
    """Bins ``start`` … ``stop`` - 1; flat before ``rolloff``, falling from there.

    Attributes
    ----------
    start, rolloff, stop : int
    fall : float
        Exponent of the falling part, 2 + 2H.
    off : ndarray of float64, shape (n,)
        ln C of every bin less that of the law, continued to all of them.
    """

    start: int
    rolloff: int
    stop: int
    fall: float
    off: FloatArray


def find_band(bins: MeasuredSpectrum) -> Band | None:
    r"""Cut logarithmic bins into ends that nothing is said about, a flat and a falling part.

    Minimised is, over the three cuts, the law's level and exponent, and the scatter σ,

    .. math:: \sum_\mathrm{band}\Big[\frac{(y - y_\mathrm{law})^2}{v + \sigma^2}
              + \ln(v + \sigma^2)\Big] + \sum_\mathrm{ends}[1 + \ln(v + s^2)]

    where y = ln C, v is its statistical variance, and s is :data:`FREE`; and :data:`CUT` for
    each end that is not empty.

    Returns
    -------
    Band or None
        None if there are fewer than :data:`FEWEST` bins.
    """
    n = bins.q.size
    power = bins.power
    if n < FEWEST or not power.max() > 0.0:
        return None
    x = np.log(bins.q / bins.q[-1])
    y = np.log(np.maximum(power / power.max(), 1e-40))
    v = 1.0 / bins.independent
    ends = 1.0 + np.log(v + FREE**2)
    share = np.concatenate([[0.0], np.cumsum(power * bins.modes)])
    share /= share[-1]
    best = (math.inf, 0, 0, 0, 0.0, 0.0)
    for scatter in SCATTERS:
        w = 1.0 / (v + scatter**2)
        sums = _sums(w, y, x)
        cost = np.concatenate([[0.0], np.cumsum(-np.log(w) - ends)])
        for start in range(n - FEWEST + 1):
            found = _best_from(start, sums, cost, x, share)
            best = min(best, found)
    _, start, rolloff, stop, level, fall = best
    off = y - level + fall * np.clip(x - _knee(x, rolloff), 0.0, None)
    return Band(start, rolloff, stop, fall, off)


def _knee(x: FloatArray, rolloff: int) -> float:
    """Return ln q between a bin and the one before it."""
    return float(x[rolloff] if rolloff == 0 else (x[rolloff - 1] + x[rolloff]) / 2.0)


def _sums(w: FloatArray, y: FloatArray, x: FloatArray) -> dict[str, FloatArray]:
    """Return cumulative sums, from which those over any range follow."""
    terms = {"1": w, "y": w * y, "yy": w * y * y, "x": w * x, "xx": w * x * x, "xy": w * x * y}
    return {name: np.concatenate([[0.0], np.cumsum(term)]) for name, term in terms.items()}


def _best_from(
    start: int, sums: dict[str, FloatArray], cost: FloatArray, x: FloatArray, share: FloatArray
) -> tuple[float, int, int, int, float, float]:
    """Return the least cost of all bands from one bin on, with its cuts, level and fall."""
    n = x.size
    rolloff = np.arange(start, n)[:, None]
    stop = np.arange(start + 1, n + 1)[None, :]
    knee = np.array([_knee(x, r) if r > start else x[start] for r in range(start, n)])[:, None]

    def over(name: str, first: NDArray[np.int64] | int) -> FloatArray:
        return np.asarray(sums[name][stop] - sums[name][first])

    total, weighed = over("1", start), over("y", start)
    lever = over("x", rolloff) - knee * over("1", rolloff)
    lever2 = over("xx", rolloff) - 2.0 * knee * over("x", rolloff)
    lever2 = lever2 + knee**2 * over("1", rolloff)
    mixed = over("xy", rolloff) - knee * over("y", rolloff)
    allowed = (stop - rolloff >= FEWEST) & (share[stop] - share[start] >= SMALLEST_SHARE)
    determinant = total * lever2 - lever**2
    allowed &= determinant > 1e-12 * total * np.abs(lever2)
    if not allowed.any():
        return (math.inf, 0, 0, 0, 0.0, 0.0)
    determinant = np.where(allowed, determinant, 1.0)
    level = (weighed * lever2 - lever * mixed) / determinant
    fall = (lever * weighed - total * mixed) / determinant
    misfit = over("yy", start) - level * weighed + fall * mixed
    cuts = CUT * (stop < n) + CUT * (start > 0)
    value = np.where(allowed, misfit + cost[stop] - cost[start] + cuts, math.inf)
    row, column = np.unravel_index(int(value.argmin()), value.shape)
    return (
        float(value[row, column]),
        start,
        start + int(row),
        start + 1 + int(column),
        float(level[row, column]),
        float(fall[row, column]),
    )
