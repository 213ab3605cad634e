r"""Whether a measured spectrum is self-affine, and with which parameters and errors.

The law is that of :func:`roughbench.spectrum.self_affine`: C2D flat below :math:`q_r`,
:math:`\propto q^{-2-2H}` from :math:`q_r` to :math:`q_1`, nothing outside :math:`q_0 … q_1`.

1. *Band.* Logarithmic bins are cut into a lower end, a flat part, a falling one and an upper
   end. The parts in the middle are explained by the law within its statistical error and a
   scatter :math:`\sigma`, each bin of the ends by itself within :data:`FREE`; the cuts, H and
   σ with the largest likelihood are taken. So a tilt's or a step's excess at long waves, the
   noise or the roll-off of an instrument at short ones, and the end of the spectrum are left
   out, and named.
2. *Parameters.* Powers :math:`P` of Gaussian modes are exponentially distributed about
   :math:`C`, so that the likelihood of rings with n independent modes is Whittle's,

   .. math:: \ln\mathcal L = -\sum n\,[P/C + \ln C]

   (P. Whittle, Ark. Mat. 2, 423 (1953)). Under Hann's window C is smeared over the
   neighbouring modes; near the origin, where that matters, the law is smeared likewise.
3. *Errors* come from the Fisher information. Where the bins scatter about the law by more
   than their statistics, the excess σ is added to every bin's variance, and the fit is
   repeated with these weights.

A spectrum is one of a random surface only if the modes of a ring share its power; where few
hold all of it, as of gratings, no law is fitted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.band_ends import BandEnd, lower_end, placed, upper_end
from roughbench.scans.bands import Band, find_band
from roughbench.scans.fit_quality import HIGHEST_HURST, refusal, remarks
from roughbench.scans.law import FittedLaw, Law, Rings
from roughbench.scans.measured_spectrum import BINS_PER_DECADE, MeasuredSpectrum
from roughbench.spectrum import Spectrum, self_affine

FloatArray = NDArray[np.float64]
LARGEST_CROWDING = 12.0
"""Most ⟨P²⟩/⟨P⟩² in rings of a random surface: 2 if it is Gaussian and isotropic. A ridge
that is k times as long as wide has about 2√k."""


@dataclass(frozen=True, slots=True)
class SelfAffineFit:
    """A self-affine law and its errors (one standard deviation).

    Attributes
    ----------
    hurst, hurst_error : float
        H.
    q_min, q_min_error : float
        q0: where the law begins, or the scan's longest wave, 1/length.
    q_rolloff, q_rolloff_error : float
        qr, 1/length; equal to q0 where no roll-off is seen.
    q_max, q_max_error : float
        q1: where the law ends, or what the scan resolves, 1/length.
    rms_slope, rms_slope_error : float
        √M2 between q0 and q1.
    scatter : float
        σ: how far bins lie off the law, in ln C, beyond their statistical error.
    """

    hurst: float
    hurst_error: float
    q_min: float
    q_min_error: float
    q_rolloff: float
    q_rolloff_error: float
    q_max: float
    q_max_error: float
    rms_slope: float
    rms_slope_error: float
    scatter: float

    def spectrum(self) -> Spectrum:
        """Return the law, for the models."""
        return self_affine(
            hurst=self.hurst,
            q_min=self.q_min,
            q_rolloff=self.q_rolloff,
            q_max=self.q_max,
            rms_slope=self.rms_slope,
        )

    def to_dict(self) -> dict[str, float]:
        """Return the parameters by the keys of a spec, and their errors."""
        named = {
            "H": (self.hurst, self.hurst_error),
            "q0": (self.q_min, self.q_min_error),
            "qr": (self.q_rolloff, self.q_rolloff_error),
            "q1": (self.q_max, self.q_max_error),
            "slope": (self.rms_slope, self.rms_slope_error),
        }
        values = {key: value for key, (value, _) in named.items()}
        return values | {f"{key}_error": error for key, (_, error) in named.items()}


@dataclass(frozen=True, slots=True)
class FitOutcome:
    """A fit, or None, and in sentences what was left out or why there is none."""

    fit: SelfAffineFit | None
    remarks: tuple[str, ...]


def fit_self_affine(spectrum: MeasuredSpectrum, unit: str = "") -> FitOutcome:
    """Fit a self-affine law to the spectrum of a surface.

    Parameters
    ----------
    spectrum : MeasuredSpectrum
        Of a surface, in rings as :func:`~roughbench.scans.spectra.surface_spectrum` gives it.
    unit : str
        Of its lengths, "m" or none, for the remarks.

    Returns
    -------
    FitOutcome

    Examples
    --------
    >>> from roughbench.scans.spectra import surface_spectrum
    >>> from roughbench.surface import make_surface, realization_generator
    >>> law = self_affine(hurst=0.8, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
    >>> side = 2 * np.pi
    >>> heights = make_surface(law, 256, side, realization_generator(1, 0))
    >>> outcome = fit_self_affine(surface_spectrum(heights, (side, side), window=False))
    >>> f"{outcome.fit.hurst:.2f} {outcome.fit.q_rolloff:.1f} {outcome.fit.q_max:.0f}"
    '0.80 4.0 64'
    """
    rings = _usable(spectrum)
    bins = rings.binned() if rings.q.size else rings
    band = find_band(bins)
    if band is None:
        return FitOutcome(None, (f"{_NONE}the scan has too few points to show one",))
    crowding = float(np.median(bins.crowding[band.start : band.stop]))
    if crowding > LARGEST_CROWDING:
        crowded = (
            f"{_NONE}of the waves of one length few hold all the power (⟨P²⟩/⟨P⟩² is "
            f"{crowding:.3g} in rings of the spectrum, 2 for random roughness), as in "
            "gratings, lattices and single waves"
        )
        return FitOutcome(None, (crowded,))
    low, high = lower_end(bins, band), upper_end(bins, band)
    found = _fitted(rings, low, high, band)
    high = placed(high, rings, found.law)
    if high.beyond == "cut-off":
        found = _fitted(rings, low, high, band)
        high = placed(high, rings, found.law)
    why = refusal(found, high)
    if why:
        return FitOutcome(None, (f"{_NONE}{why}",))
    fit = _with_errors(found, spectrum, low, high)
    return FitOutcome(fit, tuple(remarks(found, fit, low, high, unit)))


_NONE = "no self-affine law fits: "


def _fitted(spectrum: MeasuredSpectrum, low: BandEnd, high: BandEnd, band: Band) -> FittedLaw:
    """Return the likeliest law, with the scatter that the bins have about it."""
    floor = 0.0
    if high.beyond == "excess":  # the noise's, if it is white
        last = spectrum.q > 0.8 * spectrum.q[-1]
        floor = float(np.mean(spectrum.power[last])) if high.q < 0.8 * spectrum.q[-1] else 0.0
    rings = Rings(spectrum, low.fitted, high.fitted, floor)
    decades = np.log10(rings.q / rings.q[0])
    place = np.floor(decades * BINS_PER_DECADE + 1e-9).astype(np.int64)
    held = np.bincount(place, rings.independent).astype(np.float64)
    hurst = min(max(band.fall / 2.0 - 1.0, -1.0), 2.0)
    level = float(np.log(np.maximum(np.mean(rings.power), 1e-300)))
    law = Law(level, hurst, float(rings.q[0]), rings.pivot)
    scatter = 0.0
    for _ in range(4):
        weights = rings.independent / (1.0 + scatter**2 * held[place])
        law, possible = rings.likeliest(weights, law, high.q / 2.0)
        ratio = rings.power * np.exp(-rings.log_law(law))
        mean = np.bincount(place, rings.independent * ratio)[held > 0.0] / held[held > 0.0]
        before, scatter = scatter, _excess(mean, held[held > 0.0])
        if abs(before - scatter) <= 0.02 * scatter:
            break
    free = slice(0, 2 if possible else 3)
    sensitivity = law.sensitivity(rings.q)[free]
    covariance = np.zeros((3, 3))
    covariance[free, free] = np.linalg.inv((weights * sensitivity) @ sensitivity.T)
    return FittedLaw(law, scatter, covariance, possible)


def _excess(mean: FloatArray, independent: FloatArray) -> float:
    """Return σ, by which means of independent powers scatter more than they should, in ln."""
    from scipy.optimize import brentq
    from scipy.special import polygamma

    # ln of a mean of n exponential powers: expectation ψ(n) − ln n, variance ψ'(n).
    off = np.log(np.maximum(mean, 1e-30)) - polygamma(0, independent) + np.log(independent)
    variance = polygamma(1, independent)
    freedom = max(mean.size - 3, 1)

    def surplus(scatter: float) -> float:
        return float(np.sum(off**2 / (variance + scatter**2))) - freedom

    if surplus(0.0) <= 0.0:
        return 0.0
    return float(brentq(surplus, 0.0, 1.0 + float(np.abs(off).max()) * math.sqrt(mean.size)))


def _with_errors(
    found: FittedLaw, spectrum: MeasuredSpectrum, low: BandEnd, high: BandEnd
) -> SelfAffineFit:
    """Return the parameters with their errors."""
    law = found.law
    if found.highest_rolloff is None:
        q_rolloff = max(law.q_rolloff, low.q)
        rolloff_error = q_rolloff * math.sqrt(found.covariance[2, 2])
    else:
        q_rolloff = low.q
        rolloff_error = max(found.highest_rolloff - low.q, low.error)
    slope, slope_error = _slope(law, spectrum, low, high)
    return SelfAffineFit(
        hurst=min(law.hurst, HIGHEST_HURST),
        hurst_error=math.sqrt(found.covariance[1, 1]),
        q_min=low.q,
        q_min_error=low.error,
        q_rolloff=q_rolloff,
        q_rolloff_error=rolloff_error,
        q_max=high.q,
        q_max_error=high.error,
        rms_slope=slope,
        rms_slope_error=slope_error,
        scatter=found.scatter,
    )


def _slope(
    law: Law, spectrum: MeasuredSpectrum, low: BandEnd, high: BandEnd
) -> tuple[float, float]:
    """Return the rms slope between q0 and q1 and its error: of the power, not of the law.

    So it does not inherit the errors of H and qr. The law only says what the window's smear
    has added near the origin.
    """
    beyond = 2.0 * 2.0 * math.pi / max(spectrum.size) if high.beyond == "cut-off" else 0.0
    rings = Rings(spectrum, low.fitted, high.q + beyond)
    cell = (2.0 * math.pi) ** 2 / (spectrum.size[0] * spectrum.size[1])
    parts = 2.0 * cell * rings.modes * rings.power * rings.q**2 / rings.slope_shown(law)
    total = float(parts.sum())
    # Its level is that of all points, so that all modes count.
    relative = math.sqrt(float(np.sum(parts**2 / rings.modes))) / total
    return math.sqrt(total), math.sqrt(total) * relative / 2.0


def _usable(spectrum: MeasuredSpectrum) -> MeasuredSpectrum:
    """Leave out what a window or the removal of a tilt has changed: the first ring."""
    if not spectrum.windowed:
        return spectrum
    kept = spectrum.q > 1.5 * 2.0 * math.pi / max(spectrum.size)
    return replace(
        spectrum,
        q=spectrum.q[kept],
        power=spectrum.power[kept],
        modes=spectrum.modes[kept],
        independent=spectrum.independent[kept],
        crowding=spectrum.crowding[kept],
    )
