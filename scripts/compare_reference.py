"""Compare the models with the numbers of an independent prototype.

    python scripts/compare_reference.py [--part persson|foundation|bem|contenders|line]
        [--realizations N]

The reference numbers below come from an independent prototype, written before this
package and sharing no code and no random numbers with it.

Its numbers for Persson's theory hold to about 1e-6, so that some last digits are off by
one; each of ours is therefore also held against a third evaluation, to 1e-8. Other numbers
without randomness agree when the printed digits do, to one in the last. The other models
are averages over random surfaces, so they agree when they differ by few standard errors:
z = (ours - reference)/√(sem² + error²). Where the prototype's error was not noted, it is
taken to be ours, for the same number of realizations of the same ensemble.

Prints Markdown tables; exits with 1 if the third evaluation disagrees, if a state did not
converge, or if any |z| exceeds 3.5 (expected by chance in 2 % of runs).
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from _machine import describe_machine
from bench_persson import adaptive

import roughbench as rb
from roughbench.models.base import Sample
from roughbench.models.gw import gw_curve
from roughbench.models.gw_elliptic import elliptic_curve
from roughbench.models.persson import persson_asymptotes, persson_curve, self_consistent_area
from roughbench.models.winkler import gaussian_winkler_curve, matched_modulus
from roughbench.spectrum import Spectrum, self_affine

SEED = 2013
LARGEST_Z = 3.5
GAMMA = 0.45
THIRD_WAY = 1e-8
"""Largest relative deviation of Persson's theory from a third evaluation."""

PERSSON_PRESSURES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2)
# q1 = 8192, slope 0.1, γ = 0.45; lengths over the continuum's h_rms
PERSSON_AREA = "1.5958e-5 1.5958e-4 1.59577e-3 1.59566e-2 0.158519 0.682690 0.954500 0.999937"
PERSSON = {
    1: {
        "ū/h": "4.41684 3.26612 2.10218 0.868164 4.77756e-2 7.38918e-4 2.24734e-5 5.04697e-9",
        "K h": "2.00301e-6 1.99681e-5 1.94288e-4 1.83495e-3 0.103946 18.7301 619.321 2.01349e6",
        "α, β": "0.499074 6.97746e-3",
    },
    8: {
        "ū/h": "5.06051 3.74420 2.41327 1.10145 0.117933 2.37347e-3 7.33557e-5 1.65468e-8",
        "K h": "1.75353e-6 1.74167e-5 1.72516e-4 1.82123e-3 5.02118e-2 5.89837 190.035"
        " 6.14236e5",
        "α, β": "0.569721 7.21147e-3",
    },
}

FOUNDATION_PRESSURES = (1e-6, 1e-5, 1e-4, 1e-3)
FOUNDATION = {  # 100 lines, 32768 springs, q1 = 8192, periodic ends: value(error)
    1: {
        "area": "1.083(44)e-4 1.522(55)e-3 2.343(88)e-2 0.380(11)",
        "separation": "2.538(50) 2.235(46) 1.518(29) 0.2235(78)",
        "stiffness": "1.346(39)e-5 5.51(16)e-5 2.443(79)e-4 2.292(48)e-3",
    },
    8: {
        "area": "1.014(46)e-4 1.236(28)e-3 1.771(26)e-2 0.99989(11)",
        "separation": "2.176(32) 1.432(14) 0.4387(23)",
        "stiffness": "4.67(14)e-6 2.619(62)e-5 2.469(27)e-4",
    },
}
FOUNDATION_FULL = 99  # lines of 100 in full contact at p/E* = 1e-3, q_r = 8

BEM_PRESSURES = (1e-5, 1e-4, 1e-3, 1e-2, 5e-2)
BEM_REALIZATIONS = 12
BEM_RMS_HEIGHT = "5.0356e-3"
BEM = {  # q_r = 8, q1 = 128, slope 0.1, 512²; lengths over the realized h_rms
    # value, relative standard error (None: not noted)
    "area": (
        ("2.39e-4", None),
        ("2.25e-3", None),
        (".02195", None),
        (".1980", None),
        (".7316", None),
    ),
    "separation": (
        ("3.281", 0.018),
        ("2.501", None),
        ("1.561", 0.003),
        (".497", 0.003),
        (".0398", 0.003),
    ),
    "stiffness": (
        ("3.79e-5", 0.08),
        ("2.69e-4", None),
        ("2.25e-3", 0.01),
        (".0236", 0.01),
        (".447", 0.01),
    ),
}
# The contenders on the surfaces of BEM, lengths over the realized h_rms.
CONTENDERS = {
    "winkler": {
        "area": "1.14e-3 8.76e-3 .0675 .410 .926",
        "separation": "3.095 2.387 1.527 .523 .0325",
        "stiffness": "3.87e-5 2.99e-4 2.45e-3 .0235 .423",
    },
    "line": {
        "area": "1.23e-3 4.80e-3 .0318 .233 .756",
        "separation": "2.575 2.258 1.501 .505 .0424",
    },
    "foundation": {
        "area": "4.06e-4 4.50e-3 .0861",
        "separation": "1.881 1.010 .109",
        "stiffness": "3.57e-5 2.33e-4 4.34e-3",
    },
}
# 20 lines of 32768 points, q1 = 8192; lengths over the continuum's h_rms
LINE = {
    1: {
        "pressures": (1e-3, 1e-2, 0.05, 0.1),
        "area": "2.42(3)e-2 .2197 .7681 .9717",
        "separation": "1.113(27) .0638 1.2e-3",
        "stiffness": "1.48(12)e-3 .0847 12.7",
    },
    8: {
        "pressures": (1e-4, 1e-3, 1e-2, 0.05),
        "area": "2.84(8)e-3 2.54(2)e-2 .2228 .7691",
        "separation": "1.94(5) 1.006(10) .1346(20) 3.7e-3",
        "stiffness": "3.3(2)e-4 2.33(7)e-3 .0490 4.19",
    },
}
# Without randomness: name, pressures, printed values
EXACT: dict[str, tuple[tuple[float, ...], str]] = {
    "k_w/E*, q_r = 1": ((), "1.7024"),
    "k_w/E*, q_r = 8": ((), "8.8739"),
    "Winkler, Gaussian limit, K h, q_r = 8, q1 = 8192": (
        (1e-4, 1e-3, 1e-2),
        "2.74e-4 2.26e-3 3.71e-2",
    ),
    "elliptic, A ξ/p, q_r = 1, q1 = 8192": (
        (1e-6, 1e-4, 1e-3, 1e-2),
        "0.38 0.35 0.33 0.31",
    ),
    "Greenwood-Williamson, A ξ/p, q_r = 1, q1 = 8192": ((1e-6, 1e-2), "0.32 0.25"),
    "Persson, area_gamma 0.5, A, ξ = 0.1": (
        (1e-3, 0.01, 0.0316, 0.05, 0.1),
        ".0225 .209 .531 .715 .956",
    ),
    "Persson, A, q_r = 8, q1 = 128": (BEM_PRESSURES, "1.60e-4 1.60e-3 .01596 .1585 .6827"),
    "Persson, ū/h_cont, q_r = 8, q1 = 128": (BEM_PRESSURES, "4.261 2.991 1.711 .504 .0307"),
    "Persson, K h_cont, q_r = 8, q1 = 128": (
        BEM_PRESSURES,
        "1.82e-5 1.80e-4 1.81e-3 .0218 .513",
    ),
}
NAMES = {"area": "A/A0", "separation": "ū/h", "stiffness": "K h"}


@dataclass(frozen=True)
class Number:
    """A printed number: its value, standard error (nan: none) and half its last digit."""

    text: str
    value: float
    error: float
    rounding: float

    @classmethod
    def read(cls, text: str) -> Number:
        """Read ``1.083(44)e-4`` or ``2.39e-4``."""
        mantissa, _, exponent = text.partition("e")
        digits, _, error = mantissa.rstrip(")").partition("(")
        unit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
        return cls(
            text,
            float(f"{digits}e{exponent or 0}"),
            int(error) * unit if error else math.nan,
            unit / 2,
        )


def spectrum(q_rolloff: float, q_max: float) -> Spectrum:
    """Return the spectrum of all comparisons: H = 0.7, q0 = 1, rms slope 0.1."""
    return self_affine(hurst=0.7, q_min=1.0, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def row(*cells: object) -> None:
    """Print one row of a table."""
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def header(*cells: str) -> None:
    """Print the head of a table."""
    print()
    row(*cells)
    print("|" + "-|" * len(cells))


def adaptive_constants(spec: Spectrum) -> tuple[float, float]:
    """Return α and β by adaptive quadrature, as functions of ln(q - q0)."""
    from scipy.integrate import quad

    start = spec.q_min
    j0 = 0.4071249346  # ∫erf²(t) exp(-t²) dt/t from 0 to infinity

    def stiffness(t: float) -> tuple[float, float]:
        q, w, weight = start + math.exp(t), *measure(spec, math.exp(t))
        return math.log(w), GAMMA * math.sqrt(math.pi) * q * q * weight

    def constant(t: float) -> float:
        log_w, weight = stiffness(t)
        return weight * (-log_w - np.euler_gamma / 2 + 3 * (1 / GAMMA - 1) * j0)

    reach = spec.q_max - start
    inner = [edge - start for edge in spec.edges[1:-1]]
    ends = sorted([*np.geomspace(1e-26, 1, 14), *inner, *(reach * f for f in (0.01, 0.1, 1))])
    u0, logarithm = (
        sum(
            quad(f, math.log(a), math.log(b), epsabs=0, epsrel=1e-12, limit=400)[0]
            for a, b in itertools.pairwise(ends)
        )
        for f in (lambda t: stiffness(t)[1], constant)
    )
    return u0 / spec.rms_height, math.exp(logarithm / u0)


def measure(spec: Spectrum, z: float) -> tuple[float, float]:
    """Return w(q0 + z) and C(q0 + z) w z, ξ² being summed from small z without loss."""
    n = 4 - spec.exponents[0]
    if spec.q_min + z <= spec.edges[1]:
        c = 2 * math.pi * spec.prefactors[0] * spec.q_min**n
        slope_squared = c * math.expm1(n * math.log1p(z / spec.q_min)) / n
    else:
        slope_squared = spec.moment(2, spec.q_min + z)
    w = math.sqrt(2 / slope_squared)
    return w, float(spec.psd_2d(spec.q_min + z)) * w * z


def compare_persson() -> Iterator[bool]:
    """Yield for each number whether the printed digits, or else a third way, agree."""
    print(
        "\n### Persson's theory (q1 = 8192, γ = 0.45)\n\nThe third way is the closed form "
        "of A and, for the integrals, SciPy's adaptive quadrature (see "
        "`scripts/bench_persson.py`). Lengths over h_cont."
    )
    header("q_r", "quantity", "p/E*", "roughbench", "reference", "digits", "third way")
    for q_rolloff in (1, 8):
        spec = spectrum(q_rolloff, 8192.0)
        h = spec.rms_height
        curve = persson_curve(spec, PERSSON_PRESSURES, GAMMA)
        constants = persson_asymptotes(spec, GAMMA)
        third = [adaptive(spec, p) for p in PERSSON_PRESSURES]
        columns: dict[str, tuple[str, Iterable[float], Iterable[float]]] = {
            "A/A0": (
                PERSSON_AREA,
                curve.area,
                [math.erf(math.sqrt(2) * p / 0.1) for p in PERSSON_PRESSURES],
            ),
            "ū/h": (
                PERSSON[q_rolloff]["ū/h"],
                curve.separation / h,
                [u / h for u, _ in third],
            ),
            "K h": (PERSSON[q_rolloff]["K h"], curve.stiffness * h, [k * h for _, k in third]),
            "α, β": (
                PERSSON[q_rolloff]["α, β"],
                (constants.alpha, constants.beta),
                adaptive_constants(spec),
            ),
        }
        for name, (texts, values, checks) in columns.items():
            places: Sequence[object] = PERSSON_PRESSURES
            if name == "α, β":
                places = ("α", "β")
            for place, text, value, check in zip(
                places, texts.split(), values, checks, strict=True
            ):
                number = Number.read(text)
                same = abs(value - number.value) <= number.rounding * (1 + 1e-6)
                confirmed = abs(value / check - 1) <= THIRD_WAY
                row(
                    *(q_rolloff, name, place, f"{value:.8g}", text),
                    "same" if same else f"{value / number.value - 1:+.0e}",
                    f"{value / check - 1:+.0e}" if confirmed else f"**{check:.8g}**",
                )
                yield confirmed


def z_score(ours: float, sem: float, reference: Number, error: float) -> float:
    """Deviation in combined standard errors, rounding of the printed number included."""
    own = error if math.isfinite(error) else sem
    return (ours - reference.value) / math.sqrt(sem**2 + own**2 + reference.rounding**2 / 3)


def report(
    place: object, p: float, name: str, ours: float, sem: float, z: float, ref: str
) -> None:
    """Print one row of a statistical comparison."""
    row(place, f"{p:g}", NAMES[name], f"{ours:.5g} ± {sem:.2g}", ref, f"{z:+.1f}")


def compare_foundation() -> Iterator[bool]:
    """Yield for each number whether it agrees within the standard errors."""
    print("\n### Popov's foundation (q1 = 8192, 32768 springs, 100 lines); h = h_cont")
    header("q_r", "p/E*", "quantity", "roughbench", "reference", "z")
    for q_rolloff, columns in FOUNDATION.items():
        results = rb.run(
            {
                "name": "foundation",
                "surface": {"H": 0.7, "q0": 1.0, "qr": float(q_rolloff), "q1": 8192.0}
                | {"slope": 0.1},
                "pressures": list(FOUNDATION_PRESSURES),
                "realizations": 100,
                "seed": SEED,
                "models": [{"kind": "foundation", "springs": 32768}],
            }
        )["main"]["foundation"]
        h = spectrum(q_rolloff, 8192.0).rms_height
        for name, texts in columns.items():
            unit = {"area": 1.0, "separation": 1 / h, "stiffness": h}[name]
            for i, text in enumerate(texts.split()):
                number = Number.read(text)
                ours, sem = (results[f"{name}_{kind}"][i] * unit for kind in ("mean", "sem"))
                z = z_score(ours, sem, number, number.error)
                report(q_rolloff, FOUNDATION_PRESSURES[i], name, ours, sem, z, text)
                yield abs(z) <= LARGEST_Z
        if q_rolloff == 8:
            full = int(np.isinf(results["stiffness"][:, -1]).sum())
            expected = 100 - FOUNDATION_FULL
            # Counts of rare lines out of full contact: Poisson errors.
            z = (100 - full - expected) / math.sqrt(max(1, 100 - full) + expected)
            row(8, "0.001", "lines in full contact", full, FOUNDATION_FULL, f"{-z:+.1f}")
            yield abs(z) <= LARGEST_Z


def compare_bem(realizations: int) -> Iterator[bool]:
    """Yield for each number whether it agrees within the standard errors."""
    start = time.perf_counter()
    results = rb.run(
        {
            "name": "bem",
            "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 128.0, "slope": 0.1},
            "pressures": list(BEM_PRESSURES),
            "realizations": realizations,
            "seed": SEED,
            "models": [{"kind": "bem", "grid": 512}],
        }
    )["main"]["bem"]
    seconds = time.perf_counter() - start
    heights = results["rms_height"]
    h = float(heights.mean())
    print(
        f"\n### Exact solver (q_r = 8, q1 = 128, 512², {realizations} surfaces of fixed "
        f"amplitude, seed {SEED}); h = h_lat\n\n{results['status'].size} states in "
        f"{seconds:.0f} s, {int((results['status'] != 0).sum())} not converged; "
        f"rms height of the surfaces {h:.5g}, reference {BEM_RMS_HEIGHT}."
    )
    number = Number.read(BEM_RMS_HEIGHT)
    yield bool((results["status"] == 0).all())
    yield bool((np.abs(heights - number.value) <= number.rounding).all())
    header("q_r", "p/E*", "quantity", "roughbench", "reference", "z")
    for name, column in BEM.items():
        unit = {"area": 1.0, "separation": 1 / h, "stiffness": h}[name]
        for i, (text, relative) in enumerate(column):
            number = Number.read(text)
            ours, sem = (results[f"{name}_{kind}"][i] * unit for kind in ("mean", "sem"))
            error = (
                sem * math.sqrt(realizations / BEM_REALIZATIONS)
                if relative is None
                else relative * number.value
            )
            z = z_score(ours, sem, number, error)
            noted = text if relative is None else f"{text} ± {100 * relative:g} %"
            report(8, BEM_PRESSURES[i], name, ours, sem, z, noted)
            yield abs(z) <= LARGEST_Z


def exact_values() -> Iterator[tuple[str, Sequence[float]]]:
    """Yield the values of the contenders that know no randomness, in the order of EXACT."""
    for q_rolloff in (1, 8):
        yield (
            f"k_w/E*, q_r = {q_rolloff}",
            [matched_modulus(Sample(None, 1.0, spectrum(q_rolloff, 8192.0)))],
        )
    places = {name: np.array(pressures) for name, (pressures, _) in EXACT.items()}
    rolled, smooth, coarse = spectrum(8, 8192.0), spectrum(1, 8192.0), spectrum(8, 128.0)
    name = "Winkler, Gaussian limit, K h, q_r = 8, q1 = 8192"
    h = rolled.rms_height
    modulus = matched_modulus(Sample(None, 1.0, rolled))
    yield name, gaussian_winkler_curve(h, places[name], modulus).stiffness * h
    for name, curve_of in (
        ("elliptic, A ξ/p, q_r = 1, q1 = 8192", elliptic_curve),
        ("Greenwood-Williamson, A ξ/p, q_r = 1, q1 = 8192", gw_curve),
    ):
        yield name, curve_of(smooth, places[name]).area * 0.1 / places[name]
    name = "Persson, area_gamma 0.5, A, ξ = 0.1"
    yield name, self_consistent_area(places[name] / 0.1, 0.5)
    curve, h = persson_curve(coarse, BEM_PRESSURES, GAMMA), coarse.rms_height
    yield "Persson, A, q_r = 8, q1 = 128", curve.area
    yield "Persson, ū/h_cont, q_r = 8, q1 = 128", curve.separation / h
    yield "Persson, K h_cont, q_r = 8, q1 = 128", curve.stiffness * h


def compare_contenders(realizations: int) -> Iterator[bool]:
    """Yield for each number of the other contenders whether it agrees."""
    print("\n### Contenders without randomness")
    header("quantity", "p/E*", "roughbench", "reference", "digits")
    for name, values in exact_values():
        pressures, texts = EXACT[name]
        places: Sequence[object] = pressures or ("-",)
        for place, text, value in zip(places, texts.split(), values, strict=True):
            number = Number.read(text)
            # A last digit that was cut instead of rounded is off by one.
            same = abs(value - number.value) <= 2 * number.rounding * (1 + 1e-6)
            row(name, place, f"{value:.6g}", text, "same" if same else "**differ**")
            yield same
    print(
        f"\n### Contenders on the surfaces and lines of the exact solver's table (q_r = 8, "
        f"q1 = 128, {realizations} surfaces, seed {SEED}; line: 16 points on the shortest "
        f"wave; foundation: 8192 springs); h = h_lat, {BEM_RMS_HEIGHT}"
    )
    results = rb.run(
        {
            "name": "contenders",
            "surface": {"H": 0.7, "q0": 1.0, "qr": 8.0, "q1": 128.0, "slope": 0.1},
            "pressures": list(BEM_PRESSURES),
            "realizations": realizations,
            "seed": SEED,
            "models": [
                {"kind": "winkler", "grid": 512},
                {"kind": "line", "realizations": 10 * realizations},
                {"kind": "foundation", "realizations": 10 * realizations},
            ],
        }
    )["main"]
    h = Number.read(BEM_RMS_HEIGHT).value
    header("model", "p/E*", "quantity", "roughbench", "reference", "z")
    for kind, columns in CONTENDERS.items():
        yield bool((results[kind]["status"] == 0).all())
        for name, texts in columns.items():
            unit = {"area": 1.0, "separation": 1 / h, "stiffness": h}[name]
            for i, text in enumerate(texts.split()):
                number = Number.read(text)
                ours, sem = (results[kind][f"{name}_{k}"][i] * unit for k in ("mean", "sem"))
                n = results[kind].n_realizations
                z = z_score(ours, sem, number, sem * math.sqrt(n / BEM_REALIZATIONS))
                report(kind, BEM_PRESSURES[i], name, ours, sem, z, text)
                yield abs(z) <= LARGEST_Z


def compare_line() -> Iterator[bool]:
    """Yield for each number of the line at the paper's cut-off whether it agrees."""
    print("\n### Line on a half-plane (q1 = 8192, 32768 points, 20 lines); h = h_cont")
    header("q_r", "p/E*", "quantity", "roughbench", "reference", "z")
    for q_rolloff, columns in LINE.items():
        results = rb.run(
            {
                "name": "line",
                "surface": {"H": 0.7, "q0": 1.0, "qr": float(q_rolloff), "q1": 8192.0}
                | {"slope": 0.1},
                "pressures": list(columns["pressures"]),
                "realizations": 20,
                "seed": SEED,
                "models": [{"kind": "line", "points": 32768}],
            }
        )["main"]["line"]
        yield bool((results["status"] == 0).all())
        h = spectrum(q_rolloff, 8192.0).rms_height
        for name in NAMES:
            unit = {"area": 1.0, "separation": 1 / h, "stiffness": h}[name]
            for i, text in enumerate(str(columns[name]).split()):
                number = Number.read(text)
                ours, sem = (results[f"{name}_{kind}"][i] * unit for kind in ("mean", "sem"))
                z = z_score(ours, sem, number, number.error)
                report(q_rolloff, results["pressure"][i], name, ours, sem, z, text)
                yield abs(z) <= LARGEST_Z


def main() -> None:
    """Print the comparisons; exit with 1 where they fail."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "--part", choices=("persson", "foundation", "bem", "contenders", "line")
    )
    parser.add_argument(
        "--realizations", type=int, default=BEM_REALIZATIONS, help="surfaces of the solver"
    )
    arguments = parser.parse_args()
    print(describe_machine("numpy", "numba", "pyfftw", "scipy"))
    parts: dict[str, Any] = {
        "persson": compare_persson,
        "foundation": compare_foundation,
        "bem": lambda: compare_bem(arguments.realizations),
        "contenders": lambda: compare_contenders(arguments.realizations),
        "line": compare_line,
    }
    agree = [
        good
        for name, part in parts.items()
        if arguments.part in (None, name)
        for good in part()
    ]
    print(f"\n{sum(agree)} of {len(agree)} checks agree.")
    sys.exit(0 if all(agree) else 1)


if __name__ == "__main__":
    main()
