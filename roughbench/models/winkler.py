r"""A two-dimensional foundation of independent springs under the surface itself.

Every point of the surface is pressed into a spring of its own. With the modulus
:math:`k_w` (pressure per compression), :math:`\delta = (h - d)_+` at the plane's level d,
its mean :math:`D = \langle\delta\rangle` and the fraction c of points above d,

.. math::
    p = k_w D, \qquad \bar u = d - \langle h\rangle + D, \qquad
    \frac{A}{A_0} = c, \qquad K = -\frac{dp}{d\bar u} = k_w\frac{c}{1-c}.

The area is the bearing area (the overlap of the undeformed bodies), whatever
:math:`k_w` is. By default :math:`k_w = \tfrac12 E^* M_1/M_0` with
:math:`M_k = 2\pi\int q^{1+k}C_{2D}dq`: half of :math:`E^*` times the mean wavevector of
the *heights*. Then the springs hold at full contact what the half-space does,

.. math:: \frac{U}{A_0} = \frac{k_w}{2}\mathrm{Var}\,\delta
          \;\to\; \frac{k_w}{2}M_0 = \frac{E^*}{4}M_1 .

The energy is that of the springs without that of their uniform compression,
:math:`p^2/2k_w`, so that :math:`-dU/d\bar u = pA_0` as it is for the half-space, whose
mean displacement costs nothing.

Between two *events*, in which a point touches, all of it is linear in p: as in
:mod:`.foundation`, nothing is stepped or iterated. In the *Gaussian limit*, a large
surface of normally distributed heights of the standard deviation h, with
:math:`t = d/h` and :math:`Q = \tfrac12\mathrm{erfc}(t/\sqrt2)`,

.. math::
    p = k_w h\,(\varphi - tQ), \quad \bar u = h\,(t + \varphi - tQ), \quad
    \frac{A}{A_0} = Q, \quad
    \mathrm{Var}\,\delta = h^2\{(1+t^2)Q - t\varphi - (\varphi - tQ)^2\}.

Source: E. Winkler (1867) for the foundation, E. J. Abbott and F. A. Firestone (1933) for
the bearing area; the modulus is chosen here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from roughbench.errors import SolverError, SurfaceError
from roughbench.models._checks import (
    checked_heights,
    checked_positive,
    checked_pressures,
    refuse_overflow,
)
from roughbench.models._gaussian_excess import log_excess
from roughbench.models._grids import GridOption, HeightsOrSpectrum
from roughbench.models._springs import make_spring_fields
from roughbench.models.base import CompleteCurve, Fields, FloatArray, Sample, State, Status
from roughbench.models.dimensional import WavevectorOption
from roughbench.models.style import Style
from roughbench.spectrum import mode_power, wavenumbers


@dataclass(frozen=True, slots=True)
class _EventSums:
    """Sums at each event, k = 1 … N points in contact; all terms are non-negative."""

    depth: FloatArray
    """Depth of point k below the highest, shape (N,)."""
    compressed: FloatArray
    """Σδ over the points in contact, shape (N,)."""
    gap: FloatArray
    """Σ(d - h) over the points out of contact, shape (N,)."""
    work: FloatArray
    """∫D dū since the first touch, shape (N,); times k_w the elastic energy."""


def _events(heights: ArrayLike) -> _EventSums:
    from roughbench.models._foundation_loops import accumulate

    h = checked_heights(heights, "the springs need finite heights").ravel()
    if h.size == 0:
        raise SolverError("the springs need finite heights, at least one")
    n = h.size
    level = np.sort(h)[::-1]
    depth = level[0] - level
    step = np.diff(depth)
    k = np.arange(1, n)
    compressed, gap, work = np.empty(n), np.empty(n), np.empty(n)
    accumulate(k * step, compressed)
    accumulate(((n - k) * step)[::-1], gap)
    # While the plane sinks by a step, ū falls by (1 - k/N) of it and D grows linearly.
    accumulate((1.0 - k / n) * step * (compressed[:-1] + compressed[1:]) / (2.0 * n), work)
    return _EventSums(depth, compressed, gap[::-1], work)


def winkler_curve(heights: ArrayLike, pressures: ArrayLike, modulus: float) -> CompleteCurve:
    r"""Return area, separation, stiffness and energy of the springs, exactly.

    The equations stand at the top of this module. A point that just touches (δ = 0)
    counts as in contact; full contact begins at p = k_w(⟨h⟩ − h_min).

    Parameters
    ----------
    heights : array_like of float64, any shape
        Length; only their distribution matters, and their mean does not.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    modulus : float
        k_w/E* of the foundation, 1/length.

    Returns
    -------
    CompleteCurve
        With E* = 1. At full contact the stiffness is inf and the separation exactly 0.

    Raises
    ------
    SolverError
        If the heights are not finite, or a pressure or the modulus is not positive.

    Notes
    -----
    O(N log N) for the events and O(P log N) for the pressures.

    Examples
    --------
    Two of four springs are in contact until the third touches:

    >>> curve = winkler_curve([3.0, 2.0, 0.0, 0.0], [0.5, 1.0], modulus=1.0)
    >>> curve.area.tolist(), curve.separation.tolist(), curve.stiffness.tolist()
    ([0.5, 0.5], [0.75, 0.25], [1.0, 1.0])
    """
    p = checked_pressures(pressures)
    k_w = checked_positive(modulus, "the springs' modulus")
    with np.errstate(all="ignore"):
        return refuse_overflow(_evaluate(_events(heights), p, k_w))


def _evaluate(events: _EventSums, p: FloatArray, k_w: float) -> CompleteCurve:
    n = events.depth.size
    load = n * p / k_w  # Σδ
    k = np.searchsorted(events.compressed, load, side="right")
    last = k - 1
    sink = (load - events.compressed[last]) / k
    following = np.minimum(k, n - 1)
    room = events.depth[following] - events.depth[last] - sink
    gap = np.where(k < n, events.gap[following] + (n - k) * np.maximum(room, 0.0), 0.0)
    work = events.work[last] + (1.0 - k / n) * sink * (events.compressed[last] + load) / (
        2.0 * n
    )
    stiffness = np.full(p.shape, math.inf)
    partial = k < n
    stiffness[partial] = k_w * k[partial] / (n - k[partial])
    return CompleteCurve(
        pressure=p,
        area=k / n,
        separation=gap / n,
        stiffness=stiffness,
        energy=k_w * work,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
    )


def gaussian_winkler_curve(
    rms_height: float, pressures: ArrayLike, modulus: float
) -> CompleteCurve:
    r"""Return the curve of the springs under normally distributed heights.

    Parameters
    ----------
    rms_height : float
        Standard deviation h of the heights, length.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    modulus : float
        k_w/E*, 1/length.

    Returns
    -------
    CompleteCurve
        With E* = 1. There is no full contact: however deep, some points lie deeper.

    Raises
    ------
    SolverError
        If h, a pressure or the modulus is not positive.

    Examples
    --------
    >>> curve = gaussian_winkler_curve(1.0, [1 / np.sqrt(2 * np.pi)], modulus=1.0)
    >>> curve.area.round(12).tolist(), curve.stiffness.round(12).tolist()
    ([0.5], [1.0])
    """
    from scipy.special import log_ndtr

    p = checked_pressures(pressures)
    k_w = checked_positive(modulus, "the springs' modulus")
    h = checked_positive(rms_height, "the rms height")
    load = np.log(p / (k_w * h))
    t = _level(load)
    gap = log_excess((1.0,), -t)[0]  # t + φ - tQ
    with np.errstate(under="ignore", over="ignore"):
        stiffness = k_w * np.exp(log_ndtr(-t) - log_ndtr(t))
        lift, missed = np.exp(log_excess((1.0, 2.0), np.abs(t)))
        # Above the mean plane by definition, below it from Var(h) = 1: nothing cancels.
        depth = np.maximum(-t, 0.0) + lift  # φ - tQ there
        variance = np.where(
            t >= 0.0, missed - lift**2, 1.0 - (missed - lift**2) - 2.0 * lift * depth
        )
    return CompleteCurve(
        pressure=p,
        area=np.exp(log_ndtr(-t)),
        separation=h * np.exp(gap),
        stiffness=stiffness,
        energy=k_w * h * h / 2.0 * variance,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
    )


def _level(load: FloatArray) -> FloatArray:
    """Return t with ln(φ - tQ) = ``load``.

    The left side is a concave function that falls, so that Newton's steps from the right
    of the root never pass it. φ - tQ is below φ above the mean plane, and below
    φ(0) - t underneath it, which gives the starts.
    """
    from scipy.special import log_ndtr

    at_mean = -math.log(2.0 * math.pi) / 2.0
    t = np.where(
        load < at_mean,
        np.sqrt(np.maximum(2.0 * (at_mean - load), 0.0)),
        math.exp(at_mean) - np.exp(np.maximum(load, at_mean)),
    )
    for _ in range(100):
        excess = log_excess((1.0,), t)[0]
        change = (excess - load) * np.exp(excess - log_ndtr(-t))
        t = t + change
        if (np.abs(change) <= 1e-14 * (1.0 + np.abs(t))).all():
            break
    return np.asarray(t)


def matched_modulus(sample: Sample) -> float:
    r"""Return k_w/E* = M_1/(2 M_0), with which the springs hold the full-contact energy.

    Parameters
    ----------
    sample : Sample
        The modes of its heights count where it has any, else its spectrum. Without a
        roll-off the two differ (1.10 and 1.50 for H = 0.7, q1 = 128 q0), and the first
        agrees better with exact curves: ū to 15 % instead of 75 % for p/E* ≤ 0.02.

    Returns
    -------
    float
        1/length.

    Raises
    ------
    SurfaceError
        If there is neither, or the heights are flat.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=8192, rms_slope=0.1)
    >>> round(matched_modulus(Sample(None, 1.0, spectrum)), 4)
    8.8739
    """
    if sample.heights is None:
        if sample.spectrum is None:
            raise SurfaceError("the modulus of the springs needs heights or a spectrum")
        return sample.spectrum.moment(1) / (2.0 * sample.spectrum.moment(0))
    power = mode_power(sample.heights)
    total = float(power.sum())
    if not total > 0.0:
        raise SurfaceError("flat heights choose no modulus for the springs; set modulus")
    q = wavenumbers(sample.heights.shape, sample.length)
    return float((power * q).sum()) / (2.0 * total)


class Winkler(HeightsOrSpectrum):
    """Independent springs under every point of the surface, coupled in the mean at most."""

    iterative: ClassVar[bool] = False
    idle_grid: ClassVar[str] = "has no effect with heights: gaussian; remove it"
    style: ClassVar[Style] = Style("#CC79A7", ((5, 1.5, 1, 1.5),))
    page: ClassVar[str] = "docs/models/winkler.md"

    modifying: ClassVar[tuple[str, ...]] = ("modulus",)

    kind: Literal["winkler"] = "winkler"
    heights: Literal["realized", "gaussian"] = Field(
        default="realized",
        description="realized: the surfaces that bem is given, point by point; gaussian: "
        "the limit of a large surface with normally distributed heights, of the "
        "spectrum's rms height.",
    )
    modulus: WavevectorOption | None = Field(
        default=None,
        description="k_w/E*, 1/length; default: M_1/(2 M_0) of each surface (of the "
        "spectrum in the Gaussian limit), with which the springs hold the elastic energy "
        "of full contact.",
    )
    grid: GridOption = Field(
        default=None,
        description="Points per side of realized heights; default: as bem, 4 on the "
        "shortest wavelength.",
    )

    @property
    def uses_heights(self) -> bool:
        """Whether it works on the heights of surfaces."""
        return self.heights == "realized"

    @property
    def has_fields(self) -> bool:
        """Of realized heights."""
        return self.uses_heights

    @property
    def title(self) -> str:
        """Name in legends and tables."""
        limit = "" if self.uses_heights else ", Gaussian limit"
        return f"Winkler (2D springs{limit})"

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the exact curve of one surface, or that of the Gaussian limit."""
        if not self.uses_heights:
            if sample.spectrum is None:
                raise SurfaceError("the Gaussian limit needs the spectrum of the heights")
            modulus = self.modulus or matched_modulus(sample)
            return gaussian_winkler_curve(sample.spectrum.rms_height, pressures, modulus)
        if sample.heights is None or sample.heights.ndim != 2:
            raise SolverError("the springs need the heights of a surface, shape (n, m)")
        modulus = self.modulus or matched_modulus(sample)
        return winkler_curve(sample.heights, pressures, modulus)

    def make_fields(self, sample: Sample) -> Callable[[State], Fields]:
        """Return what computes them."""
        return make_spring_fields(sample, self.modulus or matched_modulus(sample))
