"""Time Persson's theory, and check its quadrature against SciPy's adaptive one.

    python scripts/bench_persson.py

A, ū, K and U at 100 pressures p/E* from 1e-8 to 0.5. The first call is timed apart from
the import of SciPy. The check integrates over q adaptively, with Φ and J from
exponential integrals: J(x) = (2/π)∫_0^1 [E1(x²) - E1(x²(2 + s²))]/(1 + s²) ds.
"""

from __future__ import annotations

import itertools
import math
import time

import numpy as np
from _machine import describe_machine

from roughbench.models.persson import persson_asymptotes, persson_curve
from roughbench.spectrum import Spectrum, measured_spectrum, self_affine
from roughbench.surface import make_surface, realization_generator

GAMMA, REPEATS = 0.45, 20
PRESSURES = np.geomspace(1e-8, 0.5, 100)


def adaptive(spectrum: Spectrum, p: float) -> tuple[float, float]:
    """Return ū and K of a self-affine spectrum."""
    from scipy.integrate import quad
    from scipy.special import erf, exp1

    start = spectrum.q_min
    n, c = 4 - spectrum.exponents[0], spectrum.prefactors[0]
    points, weights = np.polynomial.legendre.leggauss(30)
    s2 = ((points + 1) / 2) ** 2

    def slope_squared(z: float) -> float:
        if start + z <= spectrum.edges[1]:
            return 2 * math.pi * c * start**n * math.expm1(n * math.log1p(z / start)) / n
        return spectrum.moment(2, start + z)

    def phi(x: float) -> float:
        u = x * x
        j = float(np.sum(weights * (exp1(u) - exp1(u * (2 + s2))) / (1 + s2))) / math.pi
        return float(GAMMA * exp1(u) / 2 + 3 * (1 - GAMMA) * j)

    def g(x: float) -> float:
        return float((GAMMA + 3 * (1 - GAMMA) * erf(x) ** 2) * math.exp(-x * x))

    def measure(t: float) -> tuple[float, float]:
        z = math.exp(t)
        q, w = start + z, math.sqrt(2 / slope_squared(z))
        psd = float(spectrum.psd_2d(q))
        return w * p, math.sqrt(math.pi) * q * q * psd * w * z

    ends = [*np.geomspace(1e-22, 1, 23), *(e - start for e in spectrum.edges[1:])]
    reach = spectrum.q_max - start
    ends += [reach * f for f in (1e-3, 1e-2, 0.1, 0.5, 0.8, 0.95)]
    totals = []
    for kernel in (phi, g):

        def integrand(t: float, kernel=kernel) -> float:
            x, weight = measure(t)
            return kernel(x) * weight if x < 26 else 0.0

        totals.append(
            sum(
                quad(integrand, math.log(a), math.log(b), epsabs=0, epsrel=1e-12, limit=200)[0]
                for a, b in itertools.pairwise(sorted(ends))
            )
        )
    return totals[0], p / totals[1]


def timed(spectrum: Spectrum) -> str:
    """Return the time of the best call."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        persson_curve(spectrum, PRESSURES, GAMMA)
        times.append(time.perf_counter() - start)
    return f"{1e3 * min(times):.1f} ms"


def main() -> None:
    """Print machine, times and errors."""
    print(describe_machine("numpy", "scipy"))
    start = time.perf_counter()
    import scipy.special  # noqa: F401 - to time it

    loaded = time.perf_counter()
    cases = {
        "q_rolloff 1": {"q_rolloff": 1.0},
        "q_rolloff 8": {"q_rolloff": 8.0},
        "cut-off 8": {"q_rolloff": 8.0, "below_rolloff": "cutoff"},
    }
    spectra = {
        name: self_affine(hurst=0.7, q_min=1, q_max=8192, rms_slope=0.1, **options)
        for name, options in cases.items()
    }
    first = time.perf_counter()
    persson_curve(spectra["q_rolloff 1"], PRESSURES, GAMMA)
    print(
        f"import of scipy.special {1e3 * (loaded - start):.0f} ms; "
        f"first call {1e3 * (time.perf_counter() - first):.1f} ms"
    )
    for name, spectrum in spectra.items():
        errors = np.zeros(2)
        for p in PRESSURES[::9]:
            curve = persson_curve(spectrum, [p], GAMMA)
            u, k = adaptive(spectrum, float(p))
            errors = np.maximum(
                errors, [abs(curve.separation[0] / u - 1), abs(curve.stiffness[0] / k - 1)]
            )
        constants = persson_asymptotes(spectrum, GAMMA)
        print(
            f"{name}: {PRESSURES.size} pressures in {timed(spectrum)}; largest relative "
            f"deviation from adaptive quadrature: separation {errors[0]:.1e}, "
            f"K {errors[1]:.1e}; alpha {constants.alpha:.6f}, beta {constants.beta:.6e}"
        )
    rough = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=256, rms_slope=0.1)
    for points in (512, 1024):
        heights = make_surface(rough, points, 2 * math.pi, realization_generator(0, 0))
        heights += 1e-9 * np.random.default_rng(0).standard_normal(heights.shape)
        measured = measured_spectrum(heights, 2 * math.pi)
        print(f"measured, {len(measured.prefactors)} shells: {timed(measured)}")


if __name__ == "__main__":
    main()
