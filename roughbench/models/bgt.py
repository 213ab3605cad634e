r"""The line of Bush, Gibson and Thomas: where all asperity models of a surface end.

As the plane recedes, the summits that it still touches are high, their curvatures tend to
:math:`\kappa = td\!{}\,m_2/m_0` with no scatter, and their heights above the plane to an
exponential distribution of the mean :math:`h/t`, with :math:`t = d/h`. Each patch covers
half of the overlap of the undeformed bodies, so that

.. math::
    \frac{A}{A_0} \to \frac{\varphi(t)}{2t}, \qquad
    p \to \frac{E^*\xi}{\sqrt{2\pi}}\,\frac{A}{A_0}, \qquad \bar u = th .

The second is the well-known line :math:`A/A_0 = \sqrt{2\pi}\,p/(E^*\xi)`. From the three,
with Euler's exponential integral :math:`E_1`,

.. math::
    K = -\frac{dp}{d\bar u} = \frac{p}{h}\Bigl(t + \frac1t\Bigr), \qquad
    \frac{U}{A_0} = \int_{\bar u}^\infty p\,d\bar u'
                  = \frac{E^*\xi h}{8\pi}\,E_1(t^2/2).

Source: A. W. Bush, R. D. Gibson and T. R. Thomas (1975) for the line; the separation that
belongs to it is the leading order of any model with Nayak's summits.
"""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from roughbench.errors import SolverError, SurfaceError
from roughbench.models._checks import checked_pressures
from roughbench.models.base import CompleteCurve, FloatArray, Model, Needs, Sample, Status
from roughbench.models.style import Style
from roughbench.spectrum import Spectrum

_STEPS = 200


def bgt_curve(spectrum: Spectrum, pressures: ArrayLike) -> CompleteCurve:
    """Return the asymptotic curve of Bush, Gibson and Thomas, at any pressure.

    Parameters
    ----------
    spectrum : Spectrum
        Only its rms height and rms slope matter.
    pressures : array_like of float64, shape (P,)
        Nominal pressures p/E* > 0, in any order.

    Returns
    -------
    CompleteCurve
        With E* = 1. The area is a straight line and exceeds one at p > 0.4 E*ξ.

    Raises
    ------
    SolverError
        If a pressure is not positive, or so small that ū leaves the range of float64.

    Examples
    --------
    >>> from roughbench.spectrum import self_affine
    >>> spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=64, rms_slope=0.1)
    >>> bgt_curve(spectrum, [1e-4, 1e-3]).area.round(6).tolist()
    [0.002507, 0.025066]
    """
    from scipy.special import exp1

    p = checked_pressures(pressures)
    slope, height = spectrum.rms_slope, spectrum.rms_height
    area = math.sqrt(2.0 * math.pi) * p / slope
    t = _level(np.log(2.0 * area))
    with np.errstate(under="ignore"):
        energy = slope * height / (8.0 * math.pi) * exp1(t * t / 2.0)
    return CompleteCurve(
        pressure=p,
        area=area,
        separation=height * t,
        stiffness=p / height * (t + 1.0 / t),
        energy=energy,
        status=np.full(p.shape, Status.CONVERGED, np.int32),
    )


def _level(target: FloatArray) -> FloatArray:
    """Return t > 0 with ln[φ(t)/t] = ``target``.

    In y = ln t the left side, −e^{2y}/2 − y − ln√(2π), is concave and falls: Newton's
    steps from the right of the root never pass it.
    """
    rest = target + math.log(2.0 * math.pi) / 2.0
    # t < 1: the root is left of e^-rest; else left of √(-2 rest).
    y = np.where(rest > 0.0, -rest, np.log(np.sqrt(np.maximum(-2.0 * rest, 0.0)) + 1.0))
    for _ in range(_STEPS):
        square = np.exp(2.0 * y)
        change = (-square / 2.0 - y - rest) / (square + 1.0)
        y = y + change
        if (np.abs(change) <= 1e-15).all():
            return np.exp(y)
    if not (np.abs(change) <= 1e-12).all():
        raise SolverError("no level carries these pressures; choose larger ones")
    return np.exp(y)


class BushGibsonThomas(Model):
    """The low-pressure line of the asperity models."""

    needs: ClassVar[Needs] = "spectrum"
    title: ClassVar[str] = "Bush–Gibson–Thomas line"
    style: ClassVar[Style] = Style("#7F7F7F", ((12, 3),))
    page: ClassVar[str] = "docs/models/bgt.md"
    iterative: ClassVar[bool] = False

    kind: Literal["bgt"] = "bgt"

    def curve(self, sample: Sample, pressures: FloatArray) -> CompleteCurve:
        """Return the line of the sample's spectrum; heights are not looked at."""
        if sample.spectrum is None:
            raise SurfaceError("the line of Bush, Gibson and Thomas needs a spectrum")
        return bgt_curve(sample.spectrum, pressures)
