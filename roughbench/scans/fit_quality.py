"""Whether a fitted self-affine law says anything, and what is to be said of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from roughbench.scans.band_ends import BandEnd
from roughbench.scans.law import FittedLaw
from roughbench.units import in_words

if TYPE_CHECKING:
    from roughbench.scans.self_affine_fit import SelfAffineFit

SHORTEST = 3.0
"""Least q1/qr that a falling part must have to be called a power law."""
LARGEST_SCATTER = 0.5
"""Largest σ, in ln C, that is called a law: a factor of 1.65 on average."""
LEAST_HURST, LARGEST_HURST = 0.02, 0.93
"""H of spectra that are told from q^-2, and from the q^-4 of edges and spherical caps."""
HIGHEST_HURST = 0.99
"""H that is given where the likeliest is larger, but its error says nothing against less."""
SMOOTH = 0.9
"""An H above :data:`LARGEST_HURST` is one of edges if its error excludes this one."""
LARGEST_ERROR = 0.2
"""Of H, in a fit that says anything."""
WORTH_A_WORD = 0.1
"""Scatter, in ln C, that is worth a remark."""


def refusal(found: FittedLaw, high: BandEnd) -> str:
    """Return why a law is none, or nothing."""
    law = found.law
    fall = 2.0 + 2.0 * law.hurst
    if law.hurst < LEAST_HURST:
        noise = ", as white noise" if abs(fall) < 0.5 else ""
        return f"its spectrum falls as q^{-fall:.2f}{noise}, and q^-2 is the least (H = 0)"
    error = math.sqrt(found.covariance[1, 1])
    if law.hurst > LARGEST_HURST and law.hurst - 2.0 * error > SMOOTH:
        return (
            f"its spectrum falls as q^{-fall:.2f}, and q^-4 is the most (H = 1); so do edges, "
            "caps and what a filter has smoothed"
        )
    if high.q / law.q_rolloff < SHORTEST:
        return (
            f"its spectrum falls as a power law only over a factor of "
            f"{high.q / law.q_rolloff:.2g} in wavevector, and {SHORTEST:g} is the least"
        )
    if error > LARGEST_ERROR:
        return f"its spectrum leaves the exponent open: H = {law.hurst:.2f} ± {error:.2f}"
    if found.scatter > LARGEST_SCATTER:
        return (
            f"its spectrum is a factor of {math.exp(found.scatter):.2g} off a power law, "
            f"typically, and {math.exp(LARGEST_SCATTER):.2g} is the most"
        )
    return ""


def remarks(
    found: FittedLaw, fit: SelfAffineFit, low: BandEnd, high: BandEnd, unit: str
) -> Iterator[str]:
    """Yield what was left out of the band, and how well the law fits."""

    def wave(q: float) -> str:
        length = 2.0 * math.pi / q
        return in_words(length, unit) if unit else f"{length:.3g}"

    begins = f"at wavelengths above {wave(low.q)}"
    if low.beyond == "excess":
        yield (
            f"{begins} the spectrum is {low.factor:.2g} times the law, as of form, tilt or "
            "waviness: left out of the fit; q0 is where the law begins"
        )
    elif low.beyond in ("lack", "cut-off"):
        yield f"{begins} the spectrum has hardly any power ({low.factor:.2g} of the law)"
    ends = f"at wavelengths below {wave(high.q)}"
    if high.beyond == "excess":
        yield (
            f"{ends} the spectrum is {high.factor:.2g} times the law, as of an instrument's "
            "noise: left out of the fit; q1 is where the law ends"
        )
    elif high.beyond == "lack":
        yield (
            f"{ends} the spectrum is {high.factor:.2g} of the law, as of a filter, a tip or "
            "an optical resolution: left out of the fit; q1 is where the law ends"
        )
    elif high.beyond == "nothing":
        yield (
            f"the roughness does not end within the scan: q1 is the shortest wave that its "
            f"points resolve ({wave(high.q)}), and the slope is that of longer waves only"
        )
    if found.highest_rolloff is not None:
        yield (
            f"no roll-off is seen: qr is taken as q0, and may be anywhere up to "
            f"{found.highest_rolloff / low.q:.2g} q0"
        )
    if found.law.hurst > HIGHEST_HURST:
        yield (
            f"H came out as {found.law.hurst:.2f} ± {fit.hurst_error:.2f}, and a self-affine "
            f"surface has less than 1: taken as {HIGHEST_HURST}"
        )
    if found.scatter > WORTH_A_WORD:
        yield (
            f"the spectrum is off the law by {100.0 * math.expm1(found.scatter):.0f} %, "
            "typically; the errors contain that"
        )
