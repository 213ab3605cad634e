r"""Where the stiffness of the foundation starts to deviate: the dashed lines of Fig. 4.

The paper does not say how it found them. Here eq. (10) gets the prefactor θ that the
foundation has at its lowest pressures, since it is printed with "≈" and none, and is joined
with the stiffness of the bulk,

.. math:: K_\theta(p) = [(\theta K_\mathrm{fs})^m + K_\mathrm{P}^m]^{1/m}, \quad
          m \to \infty: \max(\theta K_\mathrm{fs}, K_\mathrm{P}).

θ is the geometric mean of :math:`K/K_\mathrm{fs}` over the pressures at which
:math:`\theta K_\mathrm{fs} \ge 4 K_\mathrm{P}` and a single contact of this stiffness is at
least as wide as the shortest wave, as for :func:`roughbench.fits.fit`. Above them the
foundation starts to deviate at the first pressure at which
:math:`|\ln(K/K_\theta)| > \ln 1.2` (:data:`DEVIATES`). The linear region of the theory starts
where :math:`\theta K_\mathrm{fs} = K_\mathrm{P}`. Between the pressures of the results
logarithms are linear in ln p.

How both are joined decides the answer, since the stiffness of the foundation bends smoothly
from one to the other and K_θ with a large m has a corner there. With the paper's surfaces and
100 lines (configs/paper/fig4.yaml) it starts to deviate at p/E* = 9.6e-5 (68 %: 7.1e-5 to
9.8e-4; m → ∞) or 1.05e-3 (m = 2) for q_r = q0, where the linear region starts at 1.12e-4, and
at 1.6e-6 or 6.4e-5 for q_r = 8 q0, where it starts at 8.9e-6.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.fits import Estimate
from roughbench.fits.laws import FEWEST, FINITE_SIZE_EXCESS
from roughbench.fits.resampling import draw_counts, estimate, n_random, resampled_means
from roughbench.models.persson import finite_size_stiffness, persson_curve
from roughbench.models.registry import is_modified
from roughbench.results import Attribute, ModelResult
from roughbench.spectrum import Spectrum, self_affine

FloatArray = NDArray[np.float64]

DEVIATES = 1.2
"""Ratio of two stiffnesses, or its inverse, from which on they deviate."""
_MOST_ROUNDS = 20


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """Persson's stiffness of a spectrum in a cell, with the finite-size law apart.

    Attributes
    ----------
    pressure : ndarray of float64, shape (P,)
        p/E*, ascending.
    bulk : ndarray of float64, shape (P,)
        K_P/E*, 1/length.
    few : ndarray of float64, shape (P,)
        K_fs/E* of eq. (10) with θ = 1.
    narrowest : float
        K/E* of a single contact as wide as the shortest wave.
    """

    pressure: FloatArray
    bulk: FloatArray
    few: FloatArray
    narrowest: float

    def stiffness(self, theta: float, m: float = math.inf) -> FloatArray:
        """Return both joined, the finite-size law with a prefactor θ; for m = ∞ the larger."""
        low, high = np.sort([theta * self.few, self.bulk], axis=0)
        if math.isinf(m):
            return np.asarray(high)
        with np.errstate(under="ignore"):
            return np.asarray(high * (1.0 + (low / high) ** m) ** (1.0 / m))


@dataclass(frozen=True, slots=True)
class Onset:
    """Where a stiffness starts to deviate, and where the linear region of the theory starts.

    Attributes
    ----------
    theta : Estimate
        θ that eq. (10) has to have to be the stiffness at the lowest pressures.
    deviates : Estimate
        p/E* of the first deviation; nan where there is none.
    linear : Estimate
        p/E* at which the linear region of the theory starts, for this θ.
    ratio : Estimate
        ``deviates`` over ``linear``.
    """

    theta: Estimate
    deviates: Estimate
    linear: Estimate
    ratio: Estimate


def theory_of(result: ModelResult, gamma: float) -> Theory | None:
    """Return the theory for the surfaces of a model, at its pressures.

    Parameters
    ----------
    result : ModelResult
        Without units.
    gamma : float
        γ of the theory.

    Returns
    -------
    Theory or None
        None if its surfaces have no self-affine spectrum.
    """
    spectrum = _spectrum(result.attributes)
    if spectrum is None:
        return None
    pressure = np.sort(np.asarray(result["pressure"], float))
    length = float(result.attributes["length"])
    return Theory(
        pressure,
        np.asarray(persson_curve(spectrum, pressure, gamma).stiffness),
        finite_size_stiffness(spectrum, pressure, length),
        2.0 * math.pi / (float(result.attributes["q_max"]) * length**2),
    )


def _spectrum(known: Mapping[str, Attribute]) -> Spectrum | None:
    names = ("hurst", "q_min", "q_rolloff", "q_max", "below_rolloff", "rms_height", "length")
    if any(name not in known for name in names):
        return None
    return self_affine(
        hurst=float(known["hurst"]),
        q_min=float(known["q_min"]),
        q_rolloff=float(known["q_rolloff"]),
        q_max=float(known["q_max"]),
        rms_height=float(known["rms_height"]),
        below_rolloff="cutoff" if known["below_rolloff"] == "cutoff" else "rolloff",
    )


def onset(
    result: ModelResult,
    theory: Theory,
    *,
    m: float = math.inf,
    resamples: int = 200,
    seed: int = 0,
) -> Onset:
    """Return where a model's stiffness starts to deviate from the theory, with errors.

    Parameters
    ----------
    result : ModelResult
        Without units, with a stiffness.
    theory : Theory
        At its pressures.
    m : float
        How the two laws of the theory are joined.
    resamples, seed : int
        Of the bootstrap over its realizations.
    """
    counts = draw_counts(result.n_realizations, resamples, seed)
    order = np.argsort(result["pressure"], kind="stable")
    means = resampled_means(result, "stiffness", counts)[:, order]
    found = np.array([onset_of(theory, stiffness, m) for stiffness in means])
    theta, deviates, linear = found.T
    count = n_random(result)
    return Onset(
        *(estimate(one, count=count) for one in (theta, deviates, linear, deviates / linear))
    )


def onset_of(
    theory: Theory, stiffness: FloatArray, m: float = math.inf
) -> tuple[float, float, float]:
    """Return θ, and p/E* of the first deviation and of the start of the linear region.

    Parameters
    ----------
    theory : Theory
    stiffness : ndarray of float64, shape (P,)
        K/E*, 1/length, at its pressures; may be inf.
    m : float

    Returns
    -------
    (float, float, float)
        nan where fewer than three pressures show the law of few contacts, where there is no
        deviation, and where the linear region starts beyond the pressures.
    """
    x = np.log(theory.pressure)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(stiffness / theory.few)
    known = np.isfinite(ratio) & (stiffness >= theory.narrowest)
    theta, chosen = 1.0, np.zeros(x.shape, bool)
    for _ in range(_MOST_ROUNDS):
        now = known & (theta * theory.few >= FINITE_SIZE_EXCESS * theory.bulk)
        if now.sum() < FEWEST:
            return math.nan, math.nan, math.nan
        theta = math.exp(ratio[now].mean())
        if np.array_equal(now, chosen):
            break
        chosen = now
    linear = _first(x, np.log(theory.bulk / (theta * theory.few)), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.abs(np.log(stiffness / theory.stiffness(theta, m)))
    start = int(np.flatnonzero(chosen)[-1])
    deviates = _first(x[start:], distance[start:], math.log(DEVIATES))
    return theta, deviates, linear


def _first(x: FloatArray, y: FloatArray, level: float) -> float:
    """Return e^x where y first rises through a level; nan if it does not, or lies above it."""
    above = np.flatnonzero(y > level)
    if not above.size or above[0] == 0:
        return math.nan
    k = int(above[0])
    part = (level - y[k - 1]) / (y[k] - y[k - 1])
    return math.exp(x[k - 1] + part * (x[k] - x[k - 1]))


def foundation_and_theory(
    models: Mapping[str, ModelResult],
) -> tuple[ModelResult | None, ModelResult | None]:
    """Return the first foundation as published and the first of Persson's theories."""
    own = [one for one in models.values() if not is_modified(one.kind, one.attributes)]
    kinds = ("foundation", "persson")
    foundation, theory = (
        next((one for one in own if one.kind == kind), None) for kind in kinds
    )
    return foundation, theory
