"""Where the band of a law begins and ends, and what lies beyond."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.bands import Band
from roughbench.scans.law import Law
from roughbench.scans.measured_spectrum import BINS_PER_DECADE, MeasuredSpectrum

FloatArray = NDArray[np.float64]
Beyond = Literal["nothing", "cut-off", "excess", "lack"]

HARDLY = -3.0
"""ln C less that of the law, below which there is no roughness: a factor of 20."""
_HALF = 10.0 ** (0.5 / BINS_PER_DECADE)


@dataclass(frozen=True, slots=True)
class BandEnd:
    """One end of a band.

    Attributes
    ----------
    q, error : float
        Where it is, 1/length, and how far off it may be (one standard deviation).
    beyond : str
        "nothing": the scan ends there; "cut-off": hardly any power follows; "excess" or
        "lack": more or less power than the law.
    factor : float
        Power over that of the law, typical of what follows; 1 if nothing does.
    fitted : float
        Wavevector up to which rings are whole within the band, 1/length.
    """

    q: float
    error: float
    beyond: Beyond
    factor: float
    fitted: float


def lower_end(bins: MeasuredSpectrum, band: Band) -> BandEnd:
    """Return where a band begins."""
    ring = 2.0 * math.pi / max(bins.size)
    if band.start == 0:
        return BandEnd(ring, ring / math.sqrt(12.0), "nothing", 1.0, 0.0)
    q = float(bins.q[band.start]) / _HALF
    beyond, factor = _beyond(band.off[: band.start][::-1])
    return BandEnd(q, _half_a_bin(q), beyond, factor, q)


def upper_end(bins: MeasuredSpectrum, band: Band) -> BandEnd:
    """Return where a band ends."""
    if band.stop == bins.q.size:
        ring = 2.0 * math.pi / max(bins.size)
        q = float(bins.q[-1]) * _HALF
        q = min(q, math.pi / max(bins.spacing))
        return BandEnd(q, ring / math.sqrt(12.0), "nothing", 1.0, math.inf)
    q = float(bins.q[band.stop - 1]) * _HALF
    beyond, factor = _beyond(band.off[band.stop :])
    # The last bin may hold a part of the cut-off.
    fitted = q / _HALF**2 if beyond == "cut-off" else q
    return BandEnd(q, _half_a_bin(q), beyond, factor, fitted)


def placed(end: BandEnd, rings: MeasuredSpectrum, law: Law) -> BandEnd:
    """Return an upper end that is a cut-off, placed by the power of the rings about it."""
    ring = 2.0 * math.pi / max(rings.size)
    about = (rings.q > end.fitted) & (rings.q < end.fitted * _HALF**6)
    if end.beyond != "cut-off" or not about.any():
        return end
    q = rings.q[about]
    share = np.minimum(rings.power[about] * np.exp(-law.log_power(q)), 2.0)
    first = (np.floor(q[0] / ring + 0.5) - 0.5) * ring
    place = float(first + ring * share.sum())
    blur = 2.0 * ring if rings.windowed else ring
    return replace(end, q=place, error=ring / 2.0, fitted=max(place - blur, end.fitted))


def _beyond(off: FloatArray) -> tuple[Beyond, float]:
    """Say what lies beyond a band, given ln C less that of the law, outwards."""
    typical = float(np.median(off[:5]))
    factor = math.exp(min(max(typical, -60.0), 60.0))
    # The nearest bin may hold the end itself.
    if float(np.median(off[min(1, off.size - 1) : 4])) < HARDLY:
        return "cut-off", factor
    return ("excess" if typical > 0.0 else "lack"), factor


def _half_a_bin(q: float) -> float:
    """Return the standard deviation of what may be anywhere within half a bin."""
    return q * (_HALF - 1.0) / math.sqrt(3.0)
