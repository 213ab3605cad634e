"""How the pressures change with the load while the contact stays the same."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.loops import vectors
from roughbench.models.halfspace.working_set import WorkingSet
from roughbench.models.halfspace.workspace import Workspace


class GainSeries:
    """Gains of the steps of conjugate gradients, which fall about geometrically.

    Parameters
    ----------
    before : float
        Gain before the first step.
    """

    def __init__(self, before: float) -> None:
        self._gain = before
        self._rates = 0.9, 0.9

    def rest_after(self, gain: float) -> float:
        """Estimate what is still to gain, after a step that has gained this much."""
        # Of the last two steps the slower one, and never faster than 1/3.
        self._rates = self._rates[1], min(max(gain / self._gain, 1.0 / 3.0), 0.9)
        self._gain = gain
        rate = max(self._rates)
        return gain * rate / (1.0 - rate)


def tangent(
    space: Workspace,
    points: WorkingSet,
    tolerance: float,
    max_iterations: int = 500,
    direct: DirectOperator | None = None,
) -> tuple[float, NDArray[Any], int]:
    r"""Solve G x = const on the contact, x = 0 off it, Σx = number of grid points.

    Preconditioned conjugate gradients from x = M 1. The compliance const = ⟨x·Gx⟩ is
    minimal at the solution, so its error is the square of that of x. What the steps
    lower it by falls about geometrically; the iteration ends when the rest of that
    series is less than ``tolerance`` of it.

    Parameters
    ----------
    space : Workspace
    points : WorkingSet
        The contact is where p > 0; d, s, y, r are overwritten.
    tolerance : float
        Relative error of the compliance, about.
    max_iterations : int
    direct : DirectOperator, optional
        Applies G, instead of transforms.

    Returns
    -------
    (float, ndarray, int)
        Compliance −dū/dp, the pressure x per unit nominal pressure on the points
        (shape of p), and the iterations done.
    """
    number = space.dtype.type
    w = points
    size = space.operator.field.size
    space.open(w, direct)
    team, blocks = space.team, space.tile_blocks
    # Off the contact r is out of reach for α, so these points are never free.
    team.run(vectors.mark_contact, blocks, w.tile_size, w.p, number(1), w.r)
    space.advance(0.0, 0.0, 0.0)
    space.precondition(0.0)
    x = w.s.copy()
    x *= number(size / x.sum(dtype=np.float64))
    work, n_contact, _, sum_y = space.image(x)
    compliance = work / size
    team.run(vectors.mark_contact, blocks, w.tile_size, w.p, number(0), w.r)
    alpha, length = sum_y / n_contact, 1.0
    previous, gains = math.inf, GainSeries(compliance)
    iteration = 1
    while True:
        space.advance(alpha, 0.0, length)
        _, sum_z, sum_r, _, _, z_r, _ = space.precondition(alpha)
        mean_z = sum_z / n_contact
        power = float(z_r - mean_z * sum_r)
        if not power > 0.0 or iteration >= max_iterations:
            break
        space.update_direction(alpha, power / previous, mean_z, 0.0)
        curvature, _, sum_r, sum_y = space.image(w.d)
        if not curvature > 0.0:
            break
        length = power / curvature
        team.run(vectors.add, blocks, w.tile_size, number(length), w.d, x)
        alpha = (sum_r + length * sum_y) / n_contact
        gain = length * power / size
        compliance -= gain
        previous = power
        iteration += 1
        if gains.rest_after(gain) <= tolerance * compliance:
            break
    space.close()
    return compliance, x, iteration
