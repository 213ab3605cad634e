"""Projected conjugate gradients for the pressure of a working set."""

from __future__ import annotations

import math
from collections.abc import Callable

from roughbench.models.halfspace.certificate import PENETRATION_SLACK
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.working_set import WorkingSet
from roughbench.models.halfspace.workspace import Workspace

PATIENCE, PATIENCE_LINE = 40, 400
"""Iterations without progress that end a relaxation. Long lines may pause for longer than
surfaces do: with 40, a line of 2^18 points started once more, 16 % more transform pairs."""

FIRST_STEP = 0.5
"""τ of the first trial step, on the scale set by the preconditioner; 0.2 and 1 cost 2 %."""

SHORTEST_STEP = 0.3
"""A trial step is repeated, shorter, where the exact step is below this part of it.
0.5 repeats more steps (3 % more transform pairs in all), 0.15 gains nothing more."""

LONGEST_STEP = 10.0
"""Longest step, in trial steps. Rounding errors of the load grow by as much, and where
nothing is left to gain, the exact step is a quotient of rounding errors: 1e7 was seen."""


def minimise(
    space: Workspace,
    points: WorkingSet,
    total: float,
    target: float,
    max_iterations: int,
    direct: DirectOperator | None = None,
    record: Callable[[float], None] | None = None,
) -> tuple[int, bool]:
    r"""Lower ½⟨p·Gp⟩ − ⟨p·h⟩ over p ≥ 0, Σp = ``total``, on ``points``, in place.

    Each iteration is one transform pair:

    1. α = mean of r over the contact; ρ = r − α on the free points
       (p > 0 or ρ < 0). Stop when Σp|ρ|/Σp and −min ρ are small enough.
    2. z = M ρ, mean free; d ← −z + β d on the free points, mean free, with
       Polak-Ribière β ≥ 0. Points that stay free keep their part of d: conjugacy
       is never reset because the contact changes.
    3. Trial step s of the expected length τ, to a pressure near max(p + τd, 0). What
       clipping adds is taken from the other points of the same tile: a surplus
       left in place would be one of long waves, which only a short step can bear.
       y = G s, and t = −⟨s,ρ⟩/⟨s,y⟩ is exact along s.
    4. p ← p + min(t, largest feasible) s, r ← r + the same of y. Where the exact
       step is far below the trial step, that one bent too far: shorten it and
       repeat 3.

    Every step lowers the energy: it is exact along a descent direction. Where a
    clipped step does not descend, conjugacy is dropped, then the preconditioner,
    then τ shortened.

    Parameters
    ----------
    space : Workspace
    points : WorkingSet
        With p and r set; changed in place.
    total : float
        Σp.
    target : float
        Largest Σp|ρ|/Σp to stop at; −min ρ may be ``PENETRATION_SLACK`` times more.
    max_iterations : int
    direct : DirectOperator, optional
        Applies G, instead of transforms.
    record : callable, optional
        Called with the error of each iteration.

    Returns
    -------
    (int, bool)
        Iterations done, and whether the target was reached.
    """
    w = points
    space.open(w, direct)
    search = _StepSearch(space, total)
    alpha = space.plane(*space.contact_sums())
    patience = PATIENCE_LINE if space.shape[0] == 1 else PATIENCE
    previous_power = 0.0
    length = 0.0
    best = math.inf
    since_best = 0
    iteration = 0
    while True:
        # 4. of the last iteration, and 1. of this one
        parts = space.advance(alpha, length, length)
        complementarity = sum(part[0] for part in parts) / total
        penetration = -min(part[1] for part in parts)
        error = max(complementarity, penetration / PENETRATION_SLACK)
        if record is not None:
            record(error)
        reached = error <= target
        if error < 0.9 * best:
            best, since_best = error, 0
        else:
            since_best += 1
        if reached or iteration >= max_iterations or since_best > patience:
            break
        # 2. direction
        n_free, sum_z, sum_rho, sum_y, sum_d, z_rho, z_y = space.precondition(alpha)
        space.choose_operator(int(n_free))
        mean_z = sum_z / n_free
        power = z_rho - mean_z * sum_rho
        # ρ changed by length·y on the points that were free before.
        change = length * (z_y - mean_z * sum_y)
        beta = max(0.0, change / previous_power) if previous_power > 0.0 else 0.0
        shift = mean_z - beta * sum_d / n_free
        # 3. step
        found = search.descend(alpha, beta, shift)
        if found is None:
            break
        length, alpha = found
        previous_power = power
        iteration += 1
    # What is left of pressures on their way to zero must not count as contact.
    space.drop_residues(alpha)
    space.close()
    return iteration, reached


class _StepSearch:
    """Finds steps along which the energy falls; τ of the last is the first try of the next."""

    def __init__(self, space: Workspace, total: float) -> None:
        self._space = space
        self._total = total
        self._tau = FIRST_STEP

    def descend(self, alpha: float, beta: float, shift: float) -> tuple[float, float] | None:
        """Find a step along which the energy falls, and set s and y = G s for it.

        Returns how far to go along s and α after that step, or None where no step of
        this precision descends.
        """
        space = self._space
        tau = self._tau
        for attempt in range(8):
            if attempt == 1:  # without conjugacy
                n_free, sum_z, *_ = space.precondition(alpha)
                beta, shift = 0.0, sum_z / n_free
            elif attempt > 1:  # along the residual itself, ever shorter
                n_free, sum_z = space.use_residual(alpha)
                shift = sum_z / n_free
                tau *= 0.25
            trial = space.update_direction(alpha, beta, shift, tau)
            for _ in range(8):
                if not 0.0 < trial < math.inf:
                    return None
                slope, clipped = space.trial_step(alpha, tau, trial, self._total)
                if not slope < 0.0:
                    break
                curvature, n_contact, sum_r, sum_y = space.image_of_step()
                if not 0.0 < curvature < math.inf:
                    return None
                exact = -slope / curvature
                if exact >= SHORTEST_STEP or clipped == 0:
                    self._tau = min(max(tau * min(exact, 3.0), 1e-6), 1e6)
                    length = exact
                    if exact > 1.0:
                        length = min(exact, LONGEST_STEP, space.largest_step())
                    return length, space.plane(n_contact, sum_r, length, sum_y)
                tau *= exact
                trial = space.trial_load(tau)
        return None
