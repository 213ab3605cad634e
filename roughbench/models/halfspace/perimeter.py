"""Area of a contact on a grid, corrected for the points along its edges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.loops import tiles
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet

PERIMETER_FACTOR = (math.pi - 1.0 + math.log(2.0)) / 24.0


def corrected_area(n_points: float, n_edges: float) -> float:
    """Area in grid points, from the points in contact and the free grid edges around them.

    Too many of the grid points next to a free edge of the contact count as contact; the
    excess is (π − 1 + ln 2)/24 of the grid edges there (Yastrebov, Anciaux and
    Molinari, 2017). The factor is that of edges in all directions on a surface.
    """
    return n_points - PERIMETER_FACTOR * n_edges


def count_edges(
    points: WorkingSet,
    surface: tuple[NDArray[np.floating], float, float],
    scratch: NDArray[np.floating],
    team: ThreadTeam,
    hardness: float | None = None,
) -> tuple[float, float]:
    r"""Points in contact, and grid edges around it that the solution has found.

    At a *free* edge the pressure vanishes like the square root of the distance. Where
    the heights end the contact, by a step or a kink, it does not. An edge counts as
    prescribed if the pressure p there is more than ``PRESCRIBED_RATIO`` of that of the point
    behind it (away from the edge) and the heights bend down at that point by

    .. math:: 2h - h_{behind} - h_{outside} > c\, p_{max} \Delta / E^*,

    with the largest pressure of the point, its neighbours and the next point behind.
    A contact two points wide has no next one: c is ``EDGE_BEND``,
    there ``NARROW_EDGE_BEND``.
    A single point tells nothing; its edges are free. Edges of plastic points count as
    prescribed: the pressure does not vanish there.

    Parameters
    ----------
    points : WorkingSet
        With p, in E* h_s/Δ.
    surface : tuple
        Heights, with any mean, and their scale 1/h_s, for the loops.
    scratch : ndarray
        Zero, with a halo of one point around the grid; zero again afterwards.
    hardness : float, optional
        Pressure of plastic points.
    """
    blocks, _ = team.split(points.rows)
    team.run(tiles.spread_pressure, blocks, points.tiling, points.p, scratch)
    tiles.wrap_halo(scratch)
    plastic = scratch.dtype.type(math.inf if hardness is None else hardness)
    n_contact, n_free = team.sum(
        tiles.count_edges, blocks, points.tiling, scratch, surface, plastic
    )
    team.run(tiles.clear, blocks, points.tiling, scratch)
    return float(n_contact), float(n_free)
