"""Area of a contact on a grid, and of a line, corrected for the points along its edges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughbench.models.halfspace.kernel import HALF_SPACE, Kernel
from roughbench.models.halfspace.loops import tiles
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet

PERIMETER_FACTOR = (math.pi - 1.0 + math.log(2.0)) / 24.0

OBLONG = 0.15
"""How the excess falls with the aspect of the points; see :func:`corrected_area`."""

SCREENED = 3.5, 15.0
"""q_cΔ from which on it falls with the screening, and with its square, as what neighbours
feel of each other does; see there."""


def corrected_area(n_points: float, n_edges: float, kernel: Kernel = HALF_SPACE) -> float:
    """Area in grid points, from the points in contact and the free grid edges around them.

    Too many of the grid points next to a free edge of the contact count as contact; the
    excess is (π − 1 + ln 2)/24 of the grid edges there (Yastrebov, Anciaux and
    Molinari, 2017). The factor is that of edges in all directions on a surface.

    Along straight edges in the direction of either axis a line of points is a line contact:
    the excess is the same number of *points* for each grid edge, whatever the spacings. On
    round ones it falls with the aspect. The factor that stands here was fitted to spheres
    (contact radius of 16 Δ, Δ the geometric mean of both spacings, 80 positions each): the
    excess per edge was 0.099, 0.097, 0.084, 0.075, 0.073 and 0.058 at 1, 2, 4, 8, 16 and 32,
    ± 0.002 to 0.006.

    Independent springs touch where they overlap, and no point too many is counted. Between
    them and the half-space, the excess per edge over that on a grid four times as fine was
    0.064, 0.058, 0.042, 0.014 and 0.004 at q_cΔ = 1, 2, 4, 10 and 30, ± 0.002 to 0.004; the
    factor that stands here makes it 0.070, 0.061, 0.041, 0.012 and 0.000.
    """
    oblong = 1.0 / math.sqrt(1.0 + OBLONG * math.log(kernel.aspect) ** 2)
    screening = kernel.screening * math.sqrt(kernel.aspect)
    once, twice = SCREENED
    screened = 1.0 / math.hypot(1.0, screening / once, (screening / twice) ** 2)
    return n_points - PERIMETER_FACTOR * oblong * screened * n_edges


def corrected_width(n_points: float, n_edges: float, kernel: Kernel = HALF_SPACE) -> float:
    """Width of line contacts in grid points, from their points and their free edges."""
    return n_points - edge_excess(kernel.screening) * n_edges


def edge_excess(screening: float = 0.0) -> float:
    r"""Points that a line contact counts too many at a free edge, on average.

    Exact for edges that lie anywhere between two points, of contacts that are wide against
    their spacing. At a free edge the pressure on points :math:`j \ge 0` and the gap on
    :math:`j < 0` are Fourier series :math:`p_+ = S_+E` and :math:`g_- = E/S_-` with
    :math:`z = e^{i\theta}`, where :math:`S = S_+S_- = \sqrt{\theta^2 + \kappa^2}` is the symbol
    of the half-plane on the grid, :math:`|\theta| \le \pi`, :math:`\kappa = q_c\Delta`, and
    :math:`E = a/(1 - z)^2 + b/(1 - z)` (Wiener and Hopf). Both are positive for
    :math:`-a \le b \le 0`. At :math:`b = 0`, where the next point is about to touch, the edge
    that the pressure seems to have from afar lies :math:`1 - \mu` before the first point,

    .. math::
        \mu = \frac{1}{2\kappa} - \frac{1}{2\pi}\int_0^\pi
              \frac{\theta\cot(\theta/2)}{\theta^2 + \kappa^2}\,d\theta
        \;\to\; \frac{1}{\pi^2} + \frac{1}{2\pi}\int_0^\pi
              \frac{2 - \theta\cot(\theta/2)}{\theta^2}\,d\theta = 0.1900
              \quad (\kappa \to 0).

    From there to the next point the edge moves by one spacing, and the points stay the same: on
    average :math:`\mu` of them are too many.

    Parameters
    ----------
    screening : float
        κ = q_cΔ ≥ 0.

    Examples
    --------
    >>> round(edge_excess(), 6), round(edge_excess(1.0), 6), round(edge_excess(100.0), 6)
    (0.190009, 0.152352, 0.004931)
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    theta = np.pi * (nodes + 1.0) / 2.0
    # 1/2κ and the pole of the integrand cancel; what is left of both is the arc tangent.
    rest = (2.0 - theta / np.tan(theta / 2.0)) / (theta**2 + screening**2)
    pole = math.atan(screening / math.pi) / (math.pi * screening) if screening else math.pi**-2
    return pole + float(weights @ rest) / 4.0


def count_edges(
    points: WorkingSet,
    surface: tuple[NDArray[np.floating], float, float],
    scratch: NDArray[np.floating],
    team: ThreadTeam,
    kernel: Kernel = HALF_SPACE,
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
    kernel : Kernel
        Spacings: Δ is the one across the edge. At the border of a grid that is not periodic
        the heights end, and the edge is prescribed.
    hardness : float, optional
        Pressure of plastic points.
    """
    blocks, _ = team.split(points.rows)
    team.run(tiles.spread_pressure, blocks, points.tiling, points.p, scratch)
    if not kernel.free:
        tiles.wrap_halo(scratch)
    plastic = scratch.dtype.type(math.inf if hardness is None else hardness)
    n_contact, n_free = team.sum(
        tiles.count_edges,
        blocks,
        *(points.tiling, scratch, surface, kernel.aspect, kernel.free, plastic),
    )
    team.run(tiles.clear, blocks, points.tiling, scratch)
    return float(n_contact), float(n_free)
