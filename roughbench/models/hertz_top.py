r"""The highest asperity alone: one Hertz contact in the whole cell.

At low pressure a finite cell carries its load on its highest asperity. If that is round
with the radius R up to the size of the contact, then

.. math::
    pL^2 = \tfrac43 E^*\frac{r^3}{R}, \quad \frac{A}{A_0} = \frac{\pi r^2}{L^2}, \quad
    K = \frac{2E^* r}{L^2}, \quad \bar u = z_{top} - \int_0^p\frac{dp'}{K(p')} .

The roughness has no such R: the larger the contact, the fewer waves shape it. It is
taken from the waves longer than the contact is wide, :math:`q < c/r`, so that R depends on
r and so on the load,

.. math:: \frac1{R(r)} = \tfrac12\sqrt{M_4(c/r)}

from the *spectrum*, as the rms mean curvature of these waves, or from the *heights* as the
mean curvature of their sum at the highest point. On a self-affine spectrum this is the
paper's finite-size law, eq. (10), :math:`K \sim p^{1/(1+H)}`, with the prefactor

.. math:: \theta = 2\,\Bigl[\tfrac32 c^{H-2}\sqrt{(2-H)X/H}\Bigr]^{1/(1+H)}, \qquad
          X = \frac{2H\,h^2}{2\pi C_0 q_r^{-2H}},

(:func:`finite_size_prefactor`). With c = 1.75, the default, that is θ = 2.3 for H = 0.7 and
the rms height of a cell without roll-off, as exact calculations have it; c is a heuristic
and that agreement its only ground. Below r = c/q1 the asperity is a sphere, and the contact
that of Hertz.

**The top.** :math:`z_{top}` is the height of the highest point of the heights. From the
spectrum it is the level above which half of all Gaussian surfaces have no point,
:math:`N(z) = \ln 2`, with the mean number of islands above a high level

.. math:: N(z) = \frac{L^2}{(2\pi)^{3/2}}\frac{M_2}{2M_0}\,\frac{z}{h}\,e^{-z^2/2h^2},

counted as if they came alone. On rough surfaces they come in clusters, and the estimate
is too high.

Source: H. Hertz (1882); R. Pohrt and V. L. Popov (2012) and L. Pastewka, N. Prodanov,
B. Lorenz, M. H. Müser, M. O. Robbins and B. N. J. Persson (2013) for the stiffness of
finite cells; R. J. Adler (1981) for N(z).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from roughbench.errors import SolverError, SurfaceError
from roughbench.models._checks import (
    checked_heights,
    checked_length,
    checked_positive,
    checked_pressures,
)
from roughbench.models._grids import GridOption, HeightsOrSpectrum
from roughbench.models.base import CompleteCurve, FloatArray, Sample, Status
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum, power_integral, wavenumbers

REACH = 1.75
"""Default of c: waves with q < c/r shape a contact of the radius r."""
_STEP = 0.01
"""Of ln r between the points where the load is computed."""


@dataclass(frozen=True, slots=True)
class Asperity:
    """An asperity whose curvature depends on how wide its contact is.

    Attributes
    ----------
    top : float
        Height of its highest point above the mean plane, length.
    radii : ndarray of float64, shape (n,)
        Contact radii r, ascending, length; up to the first it is a sphere.
    curvatures : ndarray of float64, shape (n,)
        1/R for these, 1/length.
    """

    top: float
    radii: FloatArray
    curvatures: FloatArray


def asperity_of_spectrum(
    spectrum: Spectrum,
    length: float,
    reach: float = REACH,
    *,
    nominal_area: float | None = None,
) -> Asperity:
    """Return the typical highest asperity of a Gaussian surface with this spectrum.

    Parameters
    ----------
    spectrum : Spectrum
    length : float
        Side L of the cell, length.
    reach : float
        c > 0.
    nominal_area : float, optional
        A0 of the cell, length²; default: L².
    """
    side, c = checked_length(length), checked_positive(reach, "reach")
    nominal = side**2 if nominal_area is None else checked_positive(nominal_area, "A0")
    radii = _radii(c / spectrum.q_max, c / spectrum.q_min)
    fourth = [spectrum.moment(4, max(c / r, spectrum.q_min)) for r in radii]
    return Asperity(_likely_top(spectrum, nominal), radii, np.sqrt(fourth) / 2.0)


def asperity_of_heights(heights: ArrayLike, length: float, reach: float = REACH) -> Asperity:
    """Return the asperity at the highest point of periodic heights.

    Parameters
    ----------
    heights : array_like of float64, shape (n, m)
        Length; square pixels.
    length : float
        Period along the first axis, length.
    reach : float
        c > 0.

    Raises
    ------
    SolverError
        If the heights are no surface, not finite or flat, or not rounded at their top.
    """
    side, c = checked_length(length), checked_positive(reach, "reach")
    h = checked_heights(heights, "the heights of the surface must be finite")
    if h.ndim != 2 or min(h.shape) < 2:
        raise SolverError(f"the highest asperity needs a surface, got shape {h.shape}")
    x, y = np.unravel_index(int(np.argmax(h)), h.shape)
    modes = np.fft.rfft2(h - h.mean(), norm="forward")
    modes *= np.exp(2j * math.pi * x * np.fft.fftfreq(h.shape[0]))[:, None]
    modes *= np.exp(2j * math.pi * y * np.fft.rfftfreq(h.shape[1]))[None, :]
    share = modes.real
    share[:, 1 : (h.shape[1] + 1) // 2] *= 2.0  # the other half plane
    q = wavenumbers(h.shape, side).ravel()
    held = np.flatnonzero(np.abs(modes).ravel() > 1e-12 * np.abs(modes).max())
    order = held[np.argsort(q[held], kind="stable")]
    if order.size == 0 or not h.max() > h.min():
        raise SolverError("flat heights have no highest asperity")
    bend = np.cumsum(q[order] ** 2 * share.ravel()[order]) / 2.0
    if not bend[-1] > 0.0:
        raise SolverError("the heights are not rounded at their highest point: refine the grid")
    radii = _radii(c / q[order[-1]], c / q[order[0]])
    until = np.searchsorted(q[order], c / radii * (1.0 + 1e-9), side="right")
    curvature = np.where(until > 0, bend[np.maximum(until - 1, 0)], 0.0)
    return Asperity(float(h.max() - h.mean()), radii, curvature)


def hertz_top_curve(
    asperity: Asperity,
    pressures: ArrayLike,
    length: float,
    *,
    nominal_area: float | None = None,
) -> CompleteCurve:
    """Return the curve of a cell that touches with one asperity only.

    Parameters
    ----------
    asperity : Asperity
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.
    length : float
        Side L of the cell, length.
    nominal_area : float, optional
        A0 of the cell, length²; default: L².

    Returns
    -------
    CompleteCurve
        With E* = 1. Where no radius carries the load, because the contact would be as wide
        as the longest wave, all values are nan and the status NOT_FINITE. Where the
        curvature falls so fast that several radii carry the load, it is the smallest.

    Examples
    --------
    A sphere of radius 2 in a cell of side 10:

    >>> sphere = Asperity(1.0, np.array([0.5]), np.array([0.5]))
    >>> curve = hertz_top_curve(sphere, [1e-4], 10.0)
    >>> r = (0.75 * 1e-4 * 100 * 2) ** (1 / 3)
    >>> bool(np.isclose(curve.stiffness[0], 2 * r / 100))
    True
    """
    p = checked_pressures(pressures)
    side = checked_length(length)
    nominal = side * side if nominal_area is None else checked_positive(nominal_area, "A0")
    r = asperity.radii
    load = 4.0 / 3.0 * r**3 * asperity.curvatures
    load = np.maximum.accumulate(load)  # the smallest radius that carries a load
    # From point to point the load is a power of r, up to the first that of a sphere.
    power = np.append(3.0, np.diff(np.log(load)) / np.diff(np.log(r)))
    start_r, start = np.append(r[0], r[:-1]), np.append(load[0], load[:-1])
    first = (0.75 * start[0], 0.3 * start[0] ** 2)  # of ∫dF/2r and ∫F dF/2r, times 1/r
    sunk, work = (
        np.append(0.0, np.cumsum(_integral(start, start_r, power, r / start_r, order)[1:]))
        + first[order - 1] / r[0]
        for order in (1, 2)
    )
    wanted = p * nominal
    at = np.searchsorted(load, wanted, side="left")
    carried = at < r.size
    i = np.minimum(at, r.size - 1)
    growth = np.where(carried, wanted / start[i], 1.0)
    stretch = growth ** (1.0 / np.where(carried, power[i], 1.0))
    radius = start_r[i] * stretch
    begin = np.maximum(i - 1, 0)
    tip = i == 0
    sunk = np.where(
        tip,
        0.75 * wanted / radius,
        sunk[begin] + _integral(start[i], start_r[i], power[i], stretch, 1),
    )
    work = np.where(
        tip,
        0.3 * wanted**2 / radius,
        work[begin] + _integral(start[i], start_r[i], power[i], stretch, 2),
    )
    radius, sunk, work = (np.where(carried, x, math.nan) for x in (radius, sunk, work))
    return CompleteCurve(
        pressure=p,
        area=math.pi * radius**2 / nominal,
        separation=asperity.top - sunk,
        stiffness=2.0 * radius / nominal,
        energy=work / nominal,
        status=np.where(carried, Status.CONVERGED, Status.NOT_FINITE).astype(np.int32),
    )


def _integral(
    start: FloatArray, radius: FloatArray, power: FloatArray, stretch: FloatArray, order: int
) -> FloatArray:
    """∫F^(order−1) dF/2r from ``radius`` on, with F = start (r/radius)^power."""
    rate = start**order * power / (2.0 * radius)
    return np.asarray(
        rate * power_integral(np.ones_like(rate), stretch - 1.0, order * power - 1.0)
    )


def finite_size_prefactor(spectrum: Spectrum, reach: float = REACH) -> float:
    r"""Return θ of the paper's eq. (10) that belongs to c, with the continuum's h_rms.

    Parameters
    ----------
    spectrum : Spectrum
        Self-affine.
    reach : float
        c > 0.

    Raises
    ------
    SurfaceError
        If the spectrum has no Hurst exponent or roll-off, as a measured one.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=8192, rms_slope=0.1)
    >>> round(finite_size_prefactor(spectrum), 2)
    1.99
    """
    c = checked_positive(reach, "reach")
    hurst, q_rolloff = spectrum.hurst, spectrum.q_rolloff
    if hurst is None or q_rolloff is None:
        raise SurfaceError("θ needs a Hurst exponent and a roll-off: a self-affine spectrum")
    x = (
        spectrum.moment(0)
        * hurst
        / (math.pi * spectrum.prefactors[-1])
        * q_rolloff ** (2.0 * hurst)
    )
    inner = 1.5 * c ** (hurst - 2.0) * math.sqrt((2.0 - hurst) * x / hurst)
    return float(2.0 * inner ** (1.0 / (1.0 + hurst)))


def _likely_top(spectrum: Spectrum, nominal: float) -> float:
    """Return the level above which half of all surfaces have no island: N(z) = ln 2."""
    h = spectrum.rms_height
    density = nominal * spectrum.moment(2) / (2.0 * h * h) / (2.0 * math.pi) ** 1.5
    target = math.log(math.log(2.0) / density)
    # ln t - t²/2 falls from its highest value, -1/2 at t = 1, and is concave.
    if target >= -0.5:
        return h
    t = math.sqrt(1.0 - 2.0 * target)
    for _ in range(100):
        change = (math.log(t) - t * t / 2.0 - target) / (t - 1.0 / t)
        t += change
        if abs(change) < 1e-14 * t:
            break
    return h * t


def _radii(smallest: float, largest: float) -> FloatArray:
    """Points in ln r from the widest sphere on."""
    if largest < smallest * (1.0 + 1e-9):  # waves of one length only
        return np.array([smallest])
    count = max(2, math.ceil(math.log(largest / smallest) / _STEP) + 1)
    return np.geomspace(smallest, largest, count)


class HertzTop(HeightsOrSpectrum):
    """One Hertz contact at the highest asperity."""

    iterative: ClassVar[bool] = False
    idle_grid: ClassVar[str] = (
        "has no effect with radius: spectrum; remove it, or choose heights"
    )
    style: ClassVar[Style] = Style("#8C6D31", ((2.5, 1),))
    page: ClassVar[str] = "docs/models/hertz_top.md"

    kind: Literal["hertz_top"] = "hertz_top"
    radius: Literal["heights", "spectrum"] = Field(
        default="heights",
        description="Where height and curvature of the asperity come from: heights takes "
        "them at the highest point of the surfaces that bem is given, spectrum those that "
        "a Gaussian surface typically has.",
    )
    reach: float = Field(
        default=REACH,
        gt=0.0,
        le=100.0,
        description="c: waves with q < c/r shape a contact of the radius r. A heuristic; "
        "1.5 to 2 fit exact calculations.",
    )
    grid: GridOption = Field(
        default=None,
        description="Points per side of the heights; default: as bem, 4 on the shortest "
        "wavelength.",
    )

    @property
    def uses_heights(self) -> bool:
        """Whether it works on the heights of surfaces."""
        return self.radius == "heights"

    @property
    def title(self) -> str:
        """Name in legends and tables."""
        return "Highest asperity" + ("" if self.uses_heights else ", of the spectrum")

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the curve of the top of one surface, or of a typical one."""
        if not self.uses_heights:
            if sample.spectrum is None:
                raise SurfaceError("hertz_top with radius: spectrum needs a spectrum")
            asperity = asperity_of_spectrum(
                sample.spectrum, sample.length, self.reach, nominal_area=sample.area
            )
        else:
            if sample.heights is None:
                raise SolverError("hertz_top with radius: heights needs heights")
            asperity = asperity_of_heights(sample.heights, sample.length, self.reach)
        return hertz_top_curve(
            asperity, pressures, sample.length, nominal_area=sample.nominal_area
        )
