"""Moments against the design notes' tables, the 1D mapping, and measured spectra."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.spectrum import (
    Spectrum,
    measured_spectrum,
    mode_power,
    power_integral,
    self_affine,
    wavenumbers,
)
from roughbench.surface import make_profile, make_surface, realization_generator

FloatArray = NDArray[np.float64]


def paper(q_rolloff: float, **options: Any) -> Spectrum:
    return self_affine(
        hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=8192, rms_slope=0.1, **options
    )


CASES = {
    "no roll-off": paper(1),
    "roll-off": paper(8),
    "cut-off": paper(8, below_rolloff="cutoff"),
}

# The design notes' §1: C0, h_cont, h_lat2D, h_lat1D, M_1, α_N and M_1/4, as printed there,
# but for the C0 with a cut-off, 0.006/(2π(2^7.8 - 2^1.8)) = 4.3528815e-6, there 4.352882e-6.
NOTES = {
    "no roll-off": (
        *("4.304181e-6", "4.395117e-3", "5.60372e-3", "6.11645e-3"),
        *("6.57706e-5", "45076", "1.644265e-5"),
    ),
    "roll-off": (
        *("4.342545e-6", "1.338290e-3", "1.34158e-3", "1.34434e-3"),
        *("3.17866e-5", "4216.5", "7.946656e-6"),
    ),
    "cut-off": (
        *("4.352881e-6", "1.030951e-3", "1.04576e-3", "1.07726e-3"),
        *("2.79018e-5", "2508", "6.97545e-6"),
    ),
}


def assert_digits(value: float, printed: str, units: float = 0.51) -> None:
    """Within half a unit of the last printed digit."""
    mantissa, _, exponent = printed.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    assert abs(value - float(printed)) <= units * unit, (value, printed)


def lattice_height_2d(spectrum: Spectrum, direct: int = 512) -> float:
    """√ΣΣ C(q) over the modes of a cell 2π; beyond ``direct`` the integral.

    The number of lattice points in a circle deviates from its area by some R^(2/3), so
    the remainder is direct^(2/3 - 3.4) = 4e-8 of C(1), against a sum of several C(1).
    """
    n = np.arange(-direct, direct + 1)
    q = np.hypot(n[:, None], n[None, :])
    inside = (q > 0) & (q <= direct)
    return math.sqrt(
        float(spectrum.psd_2d(q[inside]).sum())
        + spectrum.moment(0)
        - spectrum.moment(0, direct)
    )


def lattice_height_1d(spectrum: Spectrum) -> float:
    return math.sqrt(2 * float(spectrum.psd_1d(np.arange(1, 8193)).sum()))


# Closed forms ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_moments_of_the_notes_to_the_printed_digits(name: str) -> None:
    spectrum = CASES[name]
    prefactor, height, lattice_2d, lattice_1d, first, nayak, quarter = NOTES[name]
    assert_digits(spectrum.prefactors[-1], prefactor)
    assert_digits(spectrum.rms_height, height)
    assert_digits(lattice_height_2d(spectrum), lattice_2d)
    assert_digits(lattice_height_1d(spectrum), lattice_1d)
    assert_digits(spectrum.moment(1), first)
    assert_digits(spectrum.nayak, nayak)
    assert_digits(spectrum.moment(1) / 4, quarter)
    assert spectrum.rms_slope == pytest.approx(0.1, rel=1e-14)
    assert (spectrum.hurst, spectrum.q_max) == (0.7, 8192)


def test_lattice_over_continuum_of_the_notes() -> None:
    """1.6256 in 2D, and 2H ζ(1+2H) = 1.9367 in 1D, for the variances without roll-off."""
    from scipy.special import zeta

    spectrum = CASES["no roll-off"]
    assert_digits(lattice_height_2d(spectrum) ** 2 / spectrum.moment(0), "1.6256")
    assert_digits(1.4 * float(zeta(2.4)), "1.9367")
    # q1 is finite: what the sums lack is (1/8192)^1.4 = 3e-6 of the integral.
    ratio = lattice_height_1d(spectrum) ** 2 / spectrum.moment(0)
    assert ratio == pytest.approx(1.4 * float(zeta(2.4)), rel=1e-5)


@pytest.mark.parametrize("order", [-1.0, 0.0, 0.5, 1.0, 1.4, 2.0, 4.0])
@pytest.mark.parametrize("name", CASES)
def test_moments_are_the_integrals_of_the_spectrum(name: str, order: float) -> None:
    """In 2D and, two-sided, in 1D: 2π∫q^{1+k}C2D dq = ∫|q|^k C1D dq. k = 1.4 is a logarithm."""
    from scipy.integrate import quad

    spectrum = CASES[name]
    limit = 700.0

    def surface(t: float) -> float:
        q = math.exp(t)
        return float(2 * math.pi * q ** (2 + order) * spectrum.psd_2d(q))

    def line(t: float) -> float:
        q = math.exp(t)
        return float(q ** (1 + order) * (spectrum.psd_1d(q) + spectrum.psd_1d(-q)))

    for integrand in (surface, line):
        value = sum(
            quad(integrand, math.log(a), math.log(b), epsabs=0, epsrel=1e-11)[0]
            for a, b in ((1.0, 8.0 * (1 - 1e-15)), (8.0, limit))
        )
        assert spectrum.moment(order, limit) == pytest.approx(value, rel=1e-9)


def test_moments_up_to_a_wavevector() -> None:
    spectrum = CASES["roll-off"]
    assert spectrum.moment(2, 0.5) == 0.0
    assert spectrum.moment(2, 1.0) == 0.0
    assert spectrum.moment(0, 4.0) == pytest.approx(
        math.pi * spectrum.prefactors[0] * (4.0**2 - 1), rel=1e-14
    )
    assert spectrum.moment(2, 1e9) == spectrum.moment(2)


def test_moments_near_the_smallest_wavevector_do_not_cancel() -> None:
    """ξ² of the first 1e-12 of the spectrum: 2πC q0⁴ x (1 + …)."""
    spectrum = CASES["no roll-off"]
    x = 2.0**-40
    expected = 2 * math.pi * spectrum.prefactors[0] * x * (1 - 0.2 * x)
    assert spectrum.moment(2, 1.0 + x) == pytest.approx(expected, rel=1e-14)


@given(
    st.floats(0.1, 10.0),
    st.floats(0.0, 5.0, allow_subnormal=False),
    st.floats(-4.0, 4.0).map(lambda n: round(n, 2)),
)
def test_power_integral_is_its_closed_form(a: float, x: float, n: float) -> None:
    b = a * (1 + x)
    exact = math.log1p(x) if n == 0 else (b**n - a**n) / n
    scale = (a**n + b**n) / max(abs(n), 1.0)  # the closed form cancels, to this
    assert float(power_integral(a, x, n)) == pytest.approx(exact, rel=1e-9, abs=1e-12 * scale)


# The spectrum itself ----------------------------------------------------------------------


def test_flat_or_nothing_below_the_roll_off() -> None:
    q = np.array([0.5, 1.0, 3.0, 8.0, 16.0, 8192.0, 8193.0])
    flat, none = CASES["roll-off"], CASES["cut-off"]
    c = flat.prefactors[-1]
    plateau = c * 8**-3.4
    np.testing.assert_allclose(
        flat.psd_2d(q), [0, plateau, plateau, plateau, c * 16**-3.4, c * 8192**-3.4, 0]
    )
    assert none.psd_2d(q).tolist()[:3] == [0.0, 0.0, 0.0]
    assert (none.psd_2d(q)[3:6] > 0).all()
    np.testing.assert_array_equal(flat.psd_1d(-q), flat.psd_1d(q))
    np.testing.assert_allclose(flat.psd_1d(q), np.pi * q * flat.psd_2d(q))


def test_wavevectors_that_miss_an_edge_by_rounding_are_inside() -> None:
    length = 2 * math.pi / 0.1
    spectrum = self_affine(hurst=0.5, q_min=0.1, q_rolloff=0.3, q_max=0.7, rms_slope=1.0)
    q = 2 * math.pi / length * np.arange(1, 8)
    assert (spectrum.psd_2d(q) > 0).all()
    assert spectrum.psd_2d(0.1 * (1 - 1e-9)) == 0.0
    assert spectrum.psd_2d(0.7 * (1 + 1e-9)) == 0.0


def test_scaling_by_height_is_scaling_by_slope() -> None:
    by_slope = CASES["roll-off"]
    by_height = self_affine(
        hurst=0.7, q_min=1, q_rolloff=8, q_max=8192, rms_height=by_slope.rms_height
    )
    np.testing.assert_allclose(by_height.prefactors, by_slope.prefactors, rtol=1e-13)
    assert by_height.rms_slope == pytest.approx(0.1, rel=1e-13)


@given(st.floats(0.05, 0.95), st.floats(1.0, 50.0), st.floats(1.1, 1e4), st.floats(1e-3, 10.0))
@settings(max_examples=50)
def test_lengths_scale_out(hurst: float, rolloff: float, reach: float, slope: float) -> None:
    """All wavevectors times 3: heights a third, the same slope and α_N."""
    one, three = (
        self_affine(
            hurst=hurst,
            q_min=f,
            q_rolloff=f * rolloff,
            q_max=f * rolloff * reach,
            rms_slope=slope,
        )
        for f in (1.0, 3.0)
    )
    assert three.rms_height == pytest.approx(one.rms_height / 3, rel=1e-10)
    assert three.rms_slope == pytest.approx(slope, rel=1e-12)
    assert three.nayak == pytest.approx(one.nayak, rel=1e-9)
    assert one.nayak >= 1.5 - 1e-9  # the bound of an isotropic surface


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hurst": 0.0}, "between 0 and 1, got 0.0"),
        ({"hurst": 1.0}, "between 0 and 1, got 1.0"),
        ({"hurst": math.nan}, "between 0 and 1"),
        ({"q_min": 0.0}, "0 < q0 <= qr < q1"),
        ({"q_min": 9.0}, "got q0 = 9.0, qr = 8.0"),
        ({"q_max": 8.0}, "0 < q0 <= qr < q1"),
        ({"q_max": math.inf}, "0 < q0 <= qr < q1"),
        ({"rms_height": 1.0}, "exactly one"),
        ({"rms_slope": None}, "exactly one"),
        ({"rms_slope": 0.0}, "must be positive, got 0.0"),
        ({"rms_slope": math.nan}, "must be positive"),
        ({"rms_slope": None, "rms_height": -1.0}, "must be positive, got -1.0"),
    ],
)
def test_parameters_out_of_range_are_refused(change: dict[str, Any], message: str) -> None:
    good = {"hurst": 0.7, "q_min": 1.0, "q_rolloff": 8.0, "q_max": 64.0, "rms_slope": 0.1}
    with pytest.raises(SurfaceError, match=message):
        self_affine(**(good | change))


@pytest.mark.parametrize(
    ("edges", "prefactors", "exponents", "message"),
    [
        ((1.0, 2.0), (), (), "n segments has n"),
        ((1.0,), (1.0,), (0.0,), r"got 1, 1 and 1"),
        ((1.0, 2.0), (1.0,), (0.0, 1.0), "n segments"),
        ((0.0, 2.0), (1.0,), (0.0,), "positive and increase"),
        ((2.0, 2.0), (1.0,), (0.0,), "positive and increase"),
        ((1.0, math.inf), (1.0,), (0.0,), "finite"),
        ((1.0, 2.0), (math.nan,), (0.0,), "finite"),
        ((1.0, 2.0), (-1.0,), (0.0,), "must not be negative"),
    ],
)
def test_a_chain_that_is_none_is_refused(
    edges: tuple[float, ...],
    prefactors: tuple[float, ...],
    exponents: tuple[float, ...],
    message: str,
) -> None:
    with pytest.raises(SurfaceError, match=message):
        Spectrum(edges, prefactors, exponents)


# Measured spectra ---------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(32,), (33,), (24, 24), (25, 25), (24, 36), (30, 21)])
def test_measured_spectra_keep_the_mean_square(shape: tuple[int, ...]) -> None:
    heights = np.random.default_rng(0).standard_normal(shape) + 3.0
    spectrum = measured_spectrum(heights, 1.7)
    assert spectrum.moment(0) == pytest.approx(heights.var(), rel=1e-13)
    assert mode_power(heights).sum() == pytest.approx(heights.var(), rel=1e-13)
    # Shells of width 2π/(longest side), centred on its multiples, up to the corner.
    width = 2 * math.pi / (1.7 * max(shape) / shape[0])
    np.testing.assert_allclose(np.diff(spectrum.edges), width, rtol=1e-9)
    assert spectrum.q_min == pytest.approx(width / 2)
    assert spectrum.q_max >= wavenumbers(shape, 1.7).max()


@pytest.mark.parametrize("dimension", [1, 2])
def test_measured_spectra_return_the_theory(dimension: int) -> None:
    """C2D of every shell of fixed-amplitude heights, from surfaces and from lines.

    A line has one mode a shell: exact but for C on the width of the shell. A surface
    has 2πn of them, give or take n^(2/3): 10 % at n = 8.
    """
    theory = self_affine(hurst=0.7, q_min=1, q_rolloff=4, q_max=64, rms_slope=0.1)
    make = make_profile if dimension == 1 else make_surface
    heights = make(theory, 160, 2 * math.pi, realization_generator(1, 0))
    measured = measured_spectrum(heights, 2 * math.pi)
    assert measured.q_max == pytest.approx(64.5)
    n = np.arange(8, 64)  # a surface's last shell is cut in half by q1
    found = np.asarray(measured.prefactors)[n - 1] / theory.psd_2d(n)
    np.testing.assert_allclose(found, 1.0, rtol=1e-9 if dimension == 1 else 0.25)
    assert np.mean(found) == pytest.approx(1.0, abs=0.01)


def test_one_wave_fills_one_shell() -> None:
    x = np.linspace(0, 1, 20, endpoint=False)
    heights = np.cos(2 * np.pi * (3 * x[:, None] + 4 * x[None, :]))  # |n| = 5
    spectrum = measured_spectrum(heights, 2 * math.pi)
    np.testing.assert_allclose(spectrum.edges, (4.5, 5.5), rtol=1e-14)
    # M_0 = 1/2, and M_2 on average at n² + 1/4.
    assert spectrum.moment(0) == pytest.approx(0.5)
    assert spectrum.moment(2) == pytest.approx(0.5 * 25.25)


def test_the_highest_wave_of_an_even_line_counts_once() -> None:
    heights = np.tile([1.0, -1.0], 8)
    spectrum = measured_spectrum(heights, 2 * math.pi)
    np.testing.assert_allclose(spectrum.edges, (7.5, 8.5))
    assert spectrum.moment(0) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("heights", "length", "message"),
    [
        (np.zeros((4, 4, 4)), 1.0, "got shape"),
        (np.zeros(1), 1.0, "got shape"),
        (np.array([0.0, math.nan, 1.0]), 1.0, "finite heights"),
        (np.array([0.0, 1.0]), 0.0, "length of the cell"),
        (np.zeros(8), 1.0, "heights are constant"),
        (np.full((8, 8), 0.1), 1.0, "heights are constant"),
    ],
)
def test_heights_without_a_spectrum_are_refused(
    heights: FloatArray, length: float, message: str
) -> None:
    with pytest.raises(SurfaceError, match=message):
        measured_spectrum(heights, length)
