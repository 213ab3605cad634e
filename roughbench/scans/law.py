"""The self-affine law on the rings of a measured spectrum, and its likelihood."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.measured_spectrum import HANN_SMEAR, MeasuredSpectrum

FloatArray = NDArray[np.float64]

SMEARED = 24
"""Rings near the origin on which the law is smeared by Hann's window: beyond, by less than
0.4 %."""
WORTH = 1.0
"""What a further parameter must add to ln L (Akaike)."""
_STEPS = 50


@dataclass(frozen=True, slots=True)
class Law:
    """ln C = level - (2 + 2H) ln(max(q, qr)/pivot)."""

    level: float
    hurst: float
    q_rolloff: float
    pivot: float

    def log_power(self, q: FloatArray) -> FloatArray:
        """ln C2D, C in length⁴ and q in 1/length."""
        fall = 2.0 + 2.0 * self.hurst
        return self.level - fall * np.log(np.maximum(q, self.q_rolloff) / self.pivot)

    def sensitivity(self, q: FloatArray) -> FloatArray:
        """Return the derivatives of ln C by level, H and ln qr, shape (3, n)."""
        flat = -(2.0 + 2.0 * self.hurst) * (q < self.q_rolloff)
        slope = -2.0 * np.log(np.maximum(q, self.q_rolloff) / self.pivot)
        return np.stack([np.ones_like(q), slope, flat])


@dataclass(frozen=True, slots=True)
class FittedLaw:
    """A law, σ, and the covariance of level, H and ln qr.

    Without a roll-off, ``highest_rolloff`` says up to where one would go unnoticed.
    """

    law: Law
    scatter: float
    covariance: FloatArray
    highest_rolloff: float | None


class Rings:
    """Rings of a spectrum within a band, and the law as they would show it.

    Parameters
    ----------
    spectrum : MeasuredSpectrum
    low, high : float
        Of the band, 1/length.
    floor : float
        Power of white noise, which is subtracted.
    """

    def __init__(
        self, spectrum: MeasuredSpectrum, low: float, high: float, floor: float = 0.0
    ) -> None:
        inside = (spectrum.q >= low) & (spectrum.q <= high)
        self.q = spectrum.q[inside]
        self.power = spectrum.power[inside]
        self.modes = spectrum.modes[inside]
        self.independent = spectrum.independent[inside]
        if floor:
            with np.errstate(divide="ignore"):
                share = np.clip(1.0 - floor / self.power, 0.05, 1.0)
            self.power = np.maximum(self.power - floor, 0.0)
            self.independent = self.independent * share**2
        self.pivot = float(np.exp(np.mean(np.log(self.q)))) if self.q.size else 1.0
        self._near = _neighbours(spectrum, self.q)

    def log_law(self, law: Law) -> FloatArray:
        """ln C of the law in each ring, averaged over its modes, smeared as by the window."""
        values = law.log_power(self.q)
        near = self._near
        smeared = near.share * np.exp(law.log_power(near.q) - law.level)
        total = np.bincount(near.ring, smeared, near.count.size)
        values[: total.size] = law.level + np.log(total / near.count)
        return values

    def slope_shown(self, law: Law) -> FloatArray:
        """Return q²C of rings, as :meth:`log_law` shows it, over that of their modes.

        Modes of a ring have different q and C, and smear is no roughness.
        """
        shown = np.exp(self.log_law(law) - law.log_power(self.q))
        near = self._near
        own = near.own
        q = near.q[own]
        parts = near.once[own] * q**2 * np.exp(law.log_power(q) - law.level)
        total = np.bincount(near.ring[own], parts, near.count.size) / near.count
        mean = self.q[: total.size] ** 2
        unit = law.log_power(self.q[: total.size]) - law.level
        shown[: total.size] *= mean * np.exp(unit)
        shown[: total.size] /= total
        return shown

    def fitted(self, q_rolloff: float, weights: FloatArray, guess: Law) -> Law:
        """Return the likeliest law of a given roll-off.

        Parameters
        ----------
        q_rolloff : float
        weights : ndarray of float64, shape (n,)
            Independent modes, or less.
        guess : Law
        """
        law = Law(guess.level, guess.hurst, q_rolloff, self.pivot)
        for _ in range(_STEPS):
            with np.errstate(over="ignore"):
                ratio = np.minimum(self.power / np.exp(self.log_law(law)), 1e6)
            g = law.sensitivity(self.q)[:2]
            information = (weights * g) @ g.T
            step = np.linalg.solve(information, (weights * g) @ (ratio - 1.0))
            step *= min(1.0, 1.0 / max(abs(step[0]), 2.0 * abs(step[1])))
            level, hurst = law.level + float(step[0]), law.hurst + float(step[1])
            law = Law(level, hurst, q_rolloff, self.pivot)
            if max(abs(step)) < 1e-9:
                break
        return law

    def likeliest(
        self, weights: FloatArray, guess: Law, highest: float
    ) -> tuple[Law, float | None]:
        """Return the likeliest law of all roll-offs up to one.

        Where a roll-off would not raise ln L by more than :data:`WORTH`, it is the law
        without one (qr is the first ring's q); and the largest qr that would lower ln L by
        less than 1/2, one standard deviation.
        """
        from scipy.optimize import minimize_scalar

        first = float(self.q[0])
        none = self.fitted(first, weights, guess)
        plain = self.deviance(none, weights)
        steps = max(2, int(16 * math.log10(max(highest / first, 1.2))))
        tried = np.geomspace(first, highest, steps + 1)[1:]

        def deviance(log_q: float) -> float:
            return self.deviance(self.fitted(math.exp(log_q), weights, guess), weights)

        values = [deviance(math.log(q)) for q in tried]
        best = int(np.argmin(values))
        around = (tried[max(best - 1, 0)] if best else first, tried[min(best + 1, steps - 1)])
        found = minimize_scalar(
            deviance, bounds=tuple(np.log(around)), method="bounded", options={"xatol": 1e-4}
        )
        least = min(found.fun, values[best])
        if plain - least < 2.0 * WORTH:
            likely = [q for q, value in zip(tried, values, strict=True) if value < least + 1.0]
            return none, float(max(likely, default=first))
        return self.fitted(math.exp(found.x), weights, guess), None

    def deviance(self, law: Law, weights: FloatArray) -> float:
        """-2 ln L, up to a constant."""
        log_law = self.log_law(law)
        with np.errstate(over="ignore"):
            return float(2.0 * np.sum(weights * (self.power * np.exp(-log_law) + log_law)))


@dataclass(frozen=True, slots=True)
class _Near:
    """What is mixed into the modes of the first rings: each mode itself and its neighbours.

    Attributes
    ----------
    ring : ndarray of int
        Of the mode that it is mixed into.
    q, share : ndarray of float64
        Its wavevector, 1/length, and how much of its power is.
    once : ndarray of float64
        1, or 1/2 where ±q are both there.
    own : ndarray of bool
        Whether it is that mode itself.
    count : ndarray of float64
        Modes of each ring.
    """

    ring: NDArray[np.int64]
    q: FloatArray
    share: FloatArray
    once: FloatArray
    own: NDArray[np.bool_]
    count: FloatArray


def _neighbours(spectrum: MeasuredSpectrum, q: FloatArray) -> _Near:
    """Return the modes of the first rings with what a window mixes into them."""
    unit_y, unit_x = (2.0 * math.pi / side for side in spectrum.size)
    width = min(unit_y, unit_x)
    rings = np.floor(q / width + 0.5).astype(np.int64)
    rings = rings[rings < SMEARED]
    n, m = (int(SMEARED * width / unit) + 2 for unit in (unit_y, unit_x))
    y, x = (part.ravel() for part in np.mgrid[-n : n + 1, 0 : m + 1])
    ring = np.floor(np.hypot(y * unit_y, x * unit_x) / width + 0.5).astype(np.int64)
    held = np.isin(ring, rings) & ((y != 0) | (x != 0))
    y, x, place = y[held], x[held], np.searchsorted(rings, ring[held])
    once = np.where(x == 0, 0.5, 1.0)
    smear = HANN_SMEAR if spectrum.windowed else (0.0, 1.0, 0.0)
    steps = [
        (dy, dx, smear[dy + 1] * smear[dx + 1])
        for dy in (-1, 0, 1)
        for dx in (-1, 0, 1)
        if smear[dy + 1] * smear[dx + 1] > 0.0
    ]
    near = np.concatenate(
        [np.hypot((y + dy) * unit_y, (x + dx) * unit_x) for dy, dx, _ in steps]
    )
    there = near > 0.0  # heights have no mean
    return _Near(
        ring=np.tile(place, len(steps))[there],
        q=near[there],
        share=np.concatenate([share * once for *_, share in steps])[there],
        once=np.tile(once, len(steps))[there],
        own=np.repeat([dy == dx == 0 for dy, dx, _ in steps], y.size)[there],
        count=np.bincount(place, once, rings.size).astype(np.float64),
    )
