r"""From asperities to curves: independent summits, each a Hertz contact.

A summit of the height z above the plane's level d is compressed by :math:`x = z - d` and
carries, with the effective curvature g (:math:`1/R` of a sphere),

.. math:: F = \tfrac43 E^* g^{-1/2}x^{3/2}, \quad A = \frac{\pi x}{g}, \quad
          -\frac{dF}{dd} = 2E^* g^{-1/2}x^{1/2}, \quad
          U = \tfrac{8}{15}E^* g^{-1/2}x^{5/2}.

Whether the summits are counted on given heights or integrated over their distribution,
the level that carries a given pressure is found by Newton's method from the side from
which it never overshoots. Without coupling, the summits' compression does not move the
mean planes, and :math:`\bar u = d`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from roughbench.errors import SolverError
from roughbench.models._gaussian_excess import Weight, log_excess
from roughbench.models.base import CompleteCurve, FloatArray, Status

_STEPS = 200
_ENOUGH = 1e-14


@dataclass(frozen=True, slots=True)
class Distribution:
    """Summits of random heights; integrals over (z − d)^n, n = 3/2, 1, 1/2, 5/2.

    Attributes
    ----------
    mean, deviation : float
        Of the heights that are integrated over, length.
    load : float
        Σ g^(-1/2) per nominal area, 1/length^(3/2), times ``load_weight``.
    area : float
        Σ π/g per nominal area, 1/length, times ``area_weight``.
    load_weight, area_weight : callable or None
        V(s) at the height s, in standard deviations from the mean; None: 1.
    """

    mean: float
    deviation: float
    load: float
    area: float
    load_weight: Weight | None = None
    area_weight: Weight | None = None


def integrated_curve(summits: Distribution, p: FloatArray) -> CompleteCurve:
    """Return the curve of summits given by their distribution.

    Parameters
    ----------
    summits : Distribution
    p : ndarray of float64, shape (P,)
        Nominal pressures p/E* > 0.

    Returns
    -------
    CompleteCurve
        With E* = 1.

    Raises
    ------
    SolverError
        If no level carries a pressure.
    """
    sigma = summits.deviation
    prefactor = math.log(4.0 / 3.0 * summits.load) + 1.5 * math.log(sigma)
    target = np.log(p) - prefactor
    t = _level(target, summits.load_weight)
    log_load, log_slope, log_work = log_excess((1.5, 0.5, 2.5), t, summits.load_weight)
    (log_area,) = log_excess((1.0,), t, summits.area_weight)
    if not np.allclose(log_load, target, rtol=1e-9, atol=1e-9):
        worst = p[int(np.argmax(np.abs(log_load - target)))]
        raise SolverError(
            f"no level of the summits carries the pressure p/E* = {worst:g}; lower it"
        )
    with np.errstate(under="ignore"):
        return CompleteCurve(
            pressure=p,
            area=summits.area * sigma * np.exp(log_area),
            separation=summits.mean + sigma * t,
            stiffness=2.0 * summits.load * math.sqrt(sigma) * np.exp(log_slope),
            energy=8.0 / 15.0 * summits.load * sigma**2.5 * np.exp(log_work),
            status=np.full(p.shape, Status.CONVERGED, np.int32),
        )


def _level(target: FloatArray, weight: Weight | None) -> FloatArray:
    """Return t with ln F_{3/2}(t) = ``target``; ln F is concave and falls."""
    t = np.zeros(target.shape)
    for _ in range(_STEPS):  # to the right of the root, where Newton's steps start
        above = log_excess((1.5,), t, weight)[0] > target
        if not above.any():
            break
        t = np.where(above, 1.5 * t + 1.0, t)
    for _ in range(_STEPS):
        value, slope = log_excess((1.5, 0.5), t, weight)
        change = (value - target) * np.exp(value - slope) / 1.5
        t = t + change
        if (np.abs(change) <= _ENOUGH * (1.0 + np.abs(t))).all():
            break
    return t


def counted_curve(
    heights: FloatArray, curvatures: FloatArray, nominal_area: float, p: FloatArray
) -> CompleteCurve:
    """Return the curve of summits given one by one.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,)
        Above the mean plane, length.
    curvatures : ndarray of float64, shape (n,)
        Effective curvatures g > 0, 1/length.
    nominal_area : float
        length².
    p : ndarray of float64, shape (P,)
        Nominal pressures p/E* > 0.

    Returns
    -------
    CompleteCurve
        With E* = 1; ``diagnostics`` has the ``summits_in_contact`` (int64).
    """
    order = np.argsort(-heights, kind="stable")
    top = heights[order[0]]
    depth = top - heights[order]
    bend = curvatures[order]
    yielding = 1.0 / np.sqrt(bend)
    area, separation, stiffness, energy = (np.empty(p.shape) for _ in range(4))
    touching = np.empty(p.shape, np.int64)
    approach = math.inf
    # p is a convex function of the level that falls with it: Newton's steps from a level
    # that carries too much, that of the pressure before or of the first summit alone,
    # never overshoot.
    for i in np.argsort(-p, kind="stable"):
        load = 0.75 * p[i] * nominal_area
        approach = min(approach, (load / yielding[0]) ** (2.0 / 3.0))
        for _ in range(_STEPS):
            n = int(np.searchsorted(depth, approach))
            x, y = approach - depth[:n], yielding[:n]
            root = np.sqrt(x)
            change = (float(y @ (x * root)) - load) / (1.5 * float(y @ root))
            approach -= change
            if abs(change) <= _ENOUGH * approach:
                break
        n = int(np.searchsorted(depth, approach))
        x, y = approach - depth[:n], yielding[:n]
        touching[i] = n
        area[i] = math.pi * float((x / bend[:n]).sum()) / nominal_area
        separation[i] = top - approach
        stiffness[i] = 2.0 * float(y @ np.sqrt(x)) / nominal_area
        energy[i] = 8.0 / 15.0 * float(y @ x**2.5) / nominal_area
    return CompleteCurve(
        pressure=p,
        area=area,
        separation=separation,
        stiffness=stiffness,
        energy=energy,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
        diagnostics={"summits_in_contact": touching},
    )
