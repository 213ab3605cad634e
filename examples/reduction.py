"""The method of reduction of dimensionality beside the exact solution, on single indenters.

    python examples/reduction.py

An axisymmetric indenter r^k pressed into a half-space is mapped exactly onto a row of
springs of stiffness E* dx under the profile κ_k |x|^k (Heß, 2011): force, approach, stiffness
and contact radius are those of the half-space. With roughness on it the rule of the method
takes a rough line with C1D = π q C2D instead, and A = (π/4)Σℓ² of the pieces of length ℓ that
touch. Then nothing makes it exact any more, and the second table says what becomes of it:
the stiffness stays near, the area does not.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import roughbench as rb
from roughbench.spectrum import self_affine
from roughbench.surface import make_profile, make_surface, realization_generator

POINTS, SPRINGS, LINES = 129, 8192, 20  # an odd number has a point under the tip
RADIUS = 0.25  # of the contact, on a patch of the side 1; E* = 1
POWERS = {"cone": 1, "sphere": 2, "fourth power": 4}
X = (np.arange(SPRINGS) + 0.5) / SPRINGS - 0.5
FloatArray = NDArray[np.float64]


def stretch(k: int) -> float:
    """κ_k: how much steeper the profile of the springs is than the indenter r^k."""
    return math.sqrt(math.pi) * k * math.gamma(k / 2) / (2 * math.gamma((k + 1) / 2))


def springs(profile: FloatArray, force: float) -> tuple[float, float, float]:
    """Approach from the first contact, stiffness and area of the row of springs."""
    depth = profile.max() - profile

    def excess(approach: float) -> float:
        return float(np.maximum(approach - depth, 0.0).sum() / SPRINGS) - force

    approach = brentq(excess, 0.0, float(depth.max()) + force, xtol=1e-14)
    touching = np.concatenate(([0], depth < approach, [0])).astype(int)
    starts, ends = (np.flatnonzero(np.diff(touching) == sign) for sign in (1, -1))
    pieces = (ends - starts) / SPRINGS
    return approach, float(pieces.sum()), math.pi / 4 * float((pieces**2).sum())


def half_space(heights: FloatArray, force: float) -> tuple[float, float, float]:
    """Return the same of the exact solution."""
    state = rb.solve_contact(heights, force=force, boundary="free", tolerance=1e-7)
    return -state.mean_separation, state.stiffness(), state.area_fraction


def main() -> None:
    """Print both tables."""
    x = (np.arange(POINTS) - POINTS // 2) / POINTS
    r = np.hypot(x[:, None], x)
    print(
        "indenter        F        approach: exact springs   K: exact springs   A: exact springs"
    )
    for name, k in POWERS.items():
        shape = 0.05 / RADIUS**k  # a slope of some 0.1 at the edge
        force = 2 * k / (k + 1) * RADIUS * stretch(k) * 0.05
        exact = half_space(-shape * r**k, force)
        row = springs(-shape * stretch(k) * np.abs(X) ** k, force)
        print(
            f"{name:13}",
            f"{force:.5f}",
            *(f"{v:.5f}" for p in zip(exact, row, strict=True) for v in p),
        )

    # Force and sphere stay; the roughness has 8 to 32 waves on the side of the patch.
    force, k = 4 / 3 * RADIUS * 0.05, 2
    shape = 0.05 / RADIUS**k
    print("rms height / approach   springs / half-space: approach   K     A")
    for share in (0.0, 0.003, 0.01, 0.03, 0.1):
        rough: FloatArray | float = 0.0
        lines: list[FloatArray | float] = [0.0]
        if share:
            spectrum = self_affine(
                hurst=0.7,
                q_min=16 * math.pi,
                q_rolloff=16 * math.pi,
                q_max=64 * math.pi,
                rms_height=share * 0.1,
            )
            rough = make_surface(spectrum, POINTS, 1.0, realization_generator(1, 0))
            lines = [
                make_profile(spectrum, SPRINGS, 1.0, realization_generator(1, i))
                for i in range(LINES)
            ]
        exact = half_space(rough - shape * r**k, force)
        row = np.mean([springs(y - shape * stretch(k) * X**k, force) for y in lines], axis=0)
        ratios = np.array(row) / np.array(exact)
        print(f"{share:8.3f}", *(f"{ratio:9.3f}" for ratio in ratios))


if __name__ == "__main__":
    main()
