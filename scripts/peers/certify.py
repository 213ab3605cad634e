"""What a returned pressure violates, recomputed in float64 with NumPy alone."""

from __future__ import annotations

import math
import resource

import numpy as np
from numpy.typing import ArrayLike


def certify(heights: ArrayLike, pressure: ArrayLike, length: float) -> dict[str, float]:
    """Return the certificate of a state on a periodic half-space with E* = 1.

    complementarity Σ|p g|/(Σp h_rms), penetration max(−g)/h_rms, area (points with p > 0
    / all), separation ū.
    """
    h = np.asarray(heights, dtype=np.float64)
    p = np.asarray(pressure, dtype=np.float64).reshape(h.shape)
    h = h - h.mean()
    n, m = h.shape
    spacing = length / n
    qy = 2 * math.pi * np.fft.fftfreq(n, spacing)
    qx = 2 * math.pi * np.fft.rfftfreq(m, spacing)
    q = np.hypot(qy[:, None], qx)
    q[0, 0] = math.inf
    gap = np.fft.irfft2(np.fft.rfft2(p) * (2.0 / q), s=h.shape) - h
    gap -= (p * gap).sum() / p.sum()
    rms = h.std()
    return {
        "complementarity": float(np.abs(p * gap).sum() / (p.sum() * rms)),
        "penetration": float(-gap.min() / rms),
        "load": float(p.mean()),
        "area": float((p > 0).mean()),
        "separation": float(gap.mean()),
    }


def peak_memory() -> float:
    """Largest resident memory of this process so far, in GB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
