r"""Popov's one-dimensional foundation of independent springs, exact and event-driven.

A line of N springs with the free lengths :math:`h_i`, each of stiffness
:math:`k = aE^*` with :math:`a = L/N`, is pressed by a rigid plane at the level d. With
:math:`\delta_i = (h_i - d)_+`, their mean :math:`D = \langle\delta\rangle` and the
nominal area :math:`A_0 = (\pi/4)L^2` of the method,

.. math::
    p = \frac{4}{\pi}\frac{E^* D}{L}, \quad
    \bar u = d - \langle h\rangle + D, \quad
    \frac{A}{A_0} = \sum_i \frac{n_i^2}{N^2}, \quad
    K = -\frac{dp}{d\bar u} = \frac{4}{\pi}\frac{E^*}{L}\frac{c}{1 - c},

where :math:`n_i` are the sizes of the connected regions in contact and :math:`c` is the
fraction of springs in contact. Between two *events*, in which a spring touches, all of
it is linear in p, so nothing is stepped or iterated: sorting the heights and summing
them up gives every event, and a binary search the state at any pressure.

**Energy.** The springs hold

.. math:: \frac{U}{A_0 E^*} = \frac{aE^*}{2}\frac{\sum_i\delta_i^2}{A_0 E^*}
                            = \frac{2}{\pi L}\langle\delta^2\rangle,
          \qquad -\frac{dU}{dd} = p A_0 .

The work is done at the *plane*: since :math:`d\bar u = (1 - c)\,dd`, it is
:math:`-dU/d\bar u = pA_0/(1 - c)`. The identity :math:`-dU'/d\bar u = pA_0` of the
half-space, whose mean displacement costs nothing, holds for the part
:math:`U' = U - (\pi/8)\,A_0 L p^2/E^*`, i.e. :math:`(2/\pi L)\,\mathrm{Var}(\delta)`;
compare that with the exact solver's energy.

**Other springs.** With a modulus :math:`k_w` of its own (pressure per compression) in place of
:math:`4E^*/\pi L`, as :mod:`.winkler` has,

.. math:: p = k_w D, \quad K = k_w\frac{c}{1-c}, \quad
          \frac{U}{A_0} = \frac{k_w}{2}\langle\delta^2\rangle,

and with the area counted in points :math:`A/A_0 = c`. Both together are ``winkler`` on a
line, and what is left between the two is the dimension.

Source: V. L. Popov and A. E. Filippov (2008) for the method, with the areas and
pressures as in I. A. Lyashenko, L. Pastewka and B. N. J. Persson (2013).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from roughbench.errors import SolverError
from roughbench.models._checks import (
    checked_heights,
    checked_length,
    checked_positive,
    checked_pressures,
    refuse_overflow,
)
from roughbench.models._springs import ModulusOption, make_spring_fields
from roughbench.models.base import (
    CompleteCurve,
    Fields,
    FloatArray,
    Model,
    Needs,
    Sample,
    State,
    Status,
)
from roughbench.models.style import Style
from roughbench.models.winkler import matched_modulus
from roughbench.spectrum import Spectrum
from roughbench.surface import Undersampled, check_grid

Ends = Literal["periodic", "open"]
AreaRule = Literal["regions", "points"]


@dataclass(frozen=True, slots=True)
class _Events:
    """The state at each event, k = 0 … N springs in contact (k = 0: none, p < 0).

    Depths count downwards from the highest spring. All sums run over non-negative
    terms only: nothing cancels, from the first spring to full contact.
    """

    pressure: FloatArray
    """p/E* at which spring k touches, shape (N,), k = 1 … N."""
    compressed: FloatArray
    """Σδ over the springs in contact, shape (N,)."""
    depth: FloatArray
    """Depth of spring k below the highest, shape (N,)."""
    squared: FloatArray
    """Σδ² over the springs in contact, shape (N,)."""
    gap: FloatArray
    """Σ(d - h) over the springs out of contact, shape (N,)."""
    regions: NDArray[np.int64]
    """Number of connected regions, shape (N + 1,)."""
    squares: NDArray[np.int64]
    """Σ n_i² over them, shape (N + 1,)."""


def _events(heights: ArrayLike, length: float, ends: Ends) -> _Events:
    from roughbench.models._foundation_loops import accumulate, grow_regions

    h = checked_heights(heights, "the heights of the line must be finite")
    if h.ndim != 1 or h.size == 0:
        raise SolverError(f"the foundation needs the heights of a line, got shape {h.shape}")
    n = h.size
    order = np.argsort(-h, kind="stable")
    depth = h[order[0]] - h[order]
    step = np.diff(depth)
    k = np.arange(1, n)
    # Lowering the plane by one step compresses k springs, and lowers it towards N - k.
    compressed, squared, gap = np.empty(n), np.empty(n), np.empty(n)
    accumulate(k * step, compressed)
    accumulate(step * (2.0 * compressed[:-1] + k * step), squared)
    accumulate(((n - k) * step)[::-1], gap)
    regions, squares = np.empty(n + 1, np.int64), np.empty(n + 1, np.int64)
    grow_regions(order, ends == "periodic", regions, squares)
    return _Events(
        pressure=(4.0 / math.pi) * compressed / (n * length),
        compressed=compressed,
        depth=depth,
        squared=squared,
        gap=gap[::-1],
        regions=regions,
        squares=squares,
    )


def full_contact_pressure(heights: ArrayLike, length: float) -> float:
    r"""Return p_f/E* = (4/π)(⟨h⟩ − h_min)/L, from which on every spring is in contact.

    Parameters
    ----------
    heights : array_like of float64, shape (N,)
        Length.
    length : float
        Length L of the line.

    Examples
    --------
    >>> full_contact_pressure([0.0, 1.0, 0.0, -1.0], length=4 / np.pi)
    1.0
    """
    return float(_events(heights, checked_length(length), "open").pressure[-1])


def foundation_curve(
    heights: ArrayLike,
    pressures: ArrayLike,
    length: float,
    ends: Ends = "periodic",
    *,
    modulus: float | None = None,
    area: AreaRule = "regions",
) -> CompleteCurve:
    r"""Return area, separation, stiffness and energy of the foundation, exactly.

    The equations stand at the top of this module. A spring that just touches (δ = 0)
    counts as in contact, so at its event the stiffness is that of the next interval,
    and full contact begins exactly at p_f.

    Parameters
    ----------
    heights : array_like of float64, shape (N,)
        Heights of the line, length; their mean is immaterial.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    length : float
        Length L of the line; the nominal area is (π/4)L².
    ends : {"periodic", "open"}
        Whether regions connect through the ends of the line. Force, separation and
        stiffness do not depend on it.
    modulus : float, optional
        k_w/E* of the foundation, 1/length; default: 4/(πL), as published.
    area : {"regions", "points"}
        Σ n_i²/N², the area of round contacts as wide as the regions, or the share of the
        springs in contact.

    Returns
    -------
    CompleteCurve
        With E* = 1; ``diagnostics`` holds the numbers of ``springs_in_contact`` and of
        connected ``regions`` (int64). At full contact the stiffness is inf and the
        separation exactly 0.

    Raises
    ------
    SolverError
        If the heights are not a line of finite numbers or a pressure is not positive.

    Notes
    -----
    O(N log N) for the events and O(P log N) for the pressures. All sums have terms of
    one sign, so each value carries a relative error of some 1e-15, however small.

    Examples
    --------
    Two of four springs are in contact until the third touches:

    >>> curve = foundation_curve([3.0, 2.0, 0.0, 0.0], [0.5, 1.0], length=4 / np.pi)
    >>> curve.diagnostics["springs_in_contact"].tolist()
    [2, 2]
    >>> curve.area.tolist(), curve.separation.tolist(), curve.stiffness.tolist()
    ([0.25, 0.25], [0.75, 0.25], [1.0, 1.0])

    Springs four times as stiff, and points counted:

    >>> curve = foundation_curve([3.0, 2.0, 0.0, 0.0], [2.0], 1.0, modulus=4.0, area="points")
    >>> curve.area.tolist(), curve.separation.tolist(), curve.stiffness.tolist()
    ([0.5], [0.75], [4.0])
    """
    p = checked_pressures(pressures)
    side = checked_length(length)
    if modulus is not None:
        # The line that has this modulus as published: its length counts for nothing else.
        side = 4.0 / (math.pi * checked_positive(modulus, "the springs' modulus"))
    with np.errstate(all="ignore"):
        curve = _evaluate(_events(heights, side, ends), p, side)
        if area == "points":
            n = np.size(heights)
            curve = replace(curve, area=curve.diagnostics["springs_in_contact"] / n)
        return refuse_overflow(curve)


def _evaluate(events: _Events, p: FloatArray, length: float) -> CompleteCurve:
    n = events.depth.size
    k = np.searchsorted(events.pressure, p, side="right")
    last = k - 1  # the event before p; the first one is at p = 0
    # From there on k springs take up the load, and the plane goes down by `sink`.
    compressed = (math.pi / 4.0) * n * length * (p - events.pressure[last])
    sink = compressed / k
    following = np.minimum(k, n - 1)  # at full contact there is none, and n - k = 0
    room = events.depth[following] - events.depth[last] - sink
    gap = np.where(k < n, events.gap[following] + (n - k) * np.maximum(room, 0.0), 0.0)
    squared = events.squared[last] + sink * (2.0 * events.compressed[last] + compressed)
    stiffness = np.full(p.shape, math.inf)
    partial = k < n
    stiffness[partial] = (4.0 / (math.pi * length)) * k[partial] / (n - k[partial])
    return CompleteCurve(
        pressure=p,
        area=events.squares[k] / float(n) ** 2,
        separation=gap / n,
        stiffness=stiffness,
        energy=2.0 / (math.pi * length) * squared / n,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
        diagnostics={
            "springs_in_contact": k.astype(np.int64),
            "regions": events.regions[k],
        },
    )


class Foundation(Model):
    """Popov's foundation: independent springs on a line with C1D = π q C2D."""

    needs: ClassVar[Needs] = "line"
    style: ClassVar[Style] = Style("#0072B2", ((), (9, 1.5), (6, 1, 1, 1)), order=3)
    page: ClassVar[str] = "docs/models/foundation.md"
    sampling: ClassVar[tuple[str, ...]] = ("springs", "undersampled")
    iterative: ClassVar[bool] = False
    has_fields: ClassVar[bool] = True
    modifying: ClassVar[tuple[str, ...]] = ("modulus", "area")
    later: ClassVar[tuple[str, ...]] = ("modulus", "area")

    kind: Literal["foundation"] = "foundation"
    springs: int = Field(
        default=8192,
        ge=2,
        description="Springs on the line; at least 2 for the shortest wavelength, "
        "q1 length / π.",
    )
    ends: Ends = Field(
        default="periodic",
        description="Whether contact regions connect through the ends of the line. It "
        "matters for the area alone, and near full contact: at p/E* = 1e-3 the paper's "
        "line without roll-off has A/A0 = 0.38 with periodic and 0.30 with open ends.",
    )
    undersampled: Undersampled = Field(
        default="error",
        description="With fewer than 2 springs for the shortest wavelength: error refuses, "
        "truncate leaves the waves beyond q = π springs / length out, alias samples them "
        "as they are. The paper's 8192 springs with q1 = 8192 q0 need one of the two: the "
        "slope of the line falls from 0.100 to 0.081 (truncate) or 0.086 (alias), the "
        "area changes by at most +4 %, separation and stiffness by 0.1 %.",
    )

    modulus: ModulusOption = Field(
        default="published",
        description="Of the springs, k_w/E*: published, 4/(πL) from k = aE*; matched, "
        "M_1/(2 M_0) of each line, the half-space's response at the mean wavevector, as "
        "winkler takes it; or a number, 1/length.",
    )
    area: AreaRule = Field(
        default="regions",
        description="regions: the sum of the squares, Σ n²/N² over regions of n springs, as "
        "published; points: the share of the springs in contact, as winkler counts.",
    )

    @property
    def title(self) -> str:
        """Name in legends and tables; Popov's is the foundation as published."""
        if self.modulus == "published" and self.area == "regions":
            return "Popov (1D foundation)"
        springs = {"published": "", "matched": ", matched modulus"}
        named = self.modulus if isinstance(self.modulus, str) else ""
        counted = ", area in points" * (self.area == "points")
        return f"1D foundation{springs.get(named, ', own modulus')}{counted}"

    @classmethod
    def legend(cls, attributes: Mapping[str, Any], quantity: str) -> Sequence[str]:
        """Return the modulus of the springs, where it is a number and there are no units."""
        del quantity
        modulus = attributes.get("modulus", "published")
        if isinstance(modulus, str) or "contact_modulus" in attributes:
            return []
        return [rf"$k_w = {modulus:.3g}\,E\!^*$"]

    @property
    def undersampling(self) -> Undersampled:
        """What happens to waves that the springs are too few for."""
        return self.undersampled

    def grid_points(self, spectrum: Spectrum, length: float) -> int:
        """Return the number of springs, if it carries the spectrum.

        Raises
        ------
        SurfaceError
            If the springs are too few for q1 and ``undersampled`` is "error".
        """
        if self.undersampled == "error":
            check_grid(
                self.springs,
                spectrum,
                length,
                remedy="; set springs, or choose undersampled: truncate or alias, "
                "at the price of slope",
            )
        return self.springs

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the exact curve of one line."""
        if sample.heights is None:
            raise SolverError("the foundation needs the heights of a line")
        return foundation_curve(
            sample.heights,
            pressures,
            sample.length,
            self.ends,
            modulus=self._own_modulus(sample),
            area=self.area,
        )

    def make_fields(self, sample: Sample) -> Callable[[State], Fields]:
        """Return what computes them; the pressure is that per nominal area, k_w δ."""
        modulus = self._own_modulus(sample)
        return make_spring_fields(sample, modulus or 4.0 / (math.pi * sample.length))

    def _own_modulus(self, sample: Sample) -> float | None:
        """Return k_w/E*, None as published."""
        if self.modulus == "matched":
            return matched_modulus(sample)
        return None if isinstance(self.modulus, str) else self.modulus
