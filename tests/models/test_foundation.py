"""The foundation against exact arithmetic, closed forms, and a published-size ensemble."""

from __future__ import annotations

import itertools
import math
from dataclasses import fields
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError

import roughbench as rb
from roughbench.errors import SolverError, SpecError, SurfaceError
from roughbench.figures.labels import model_names
from roughbench.figures.pressed import pressed_lines
from roughbench.models.base import Curve, Sample, Status
from roughbench.models.foundation import (
    Ends,
    Foundation,
    foundation_curve,
    full_contact_pressure,
)
from roughbench.models.winkler import matched_modulus, winkler_curve
from roughbench.spec import load_spec
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import make_profile, realization_generator, rms_height_and_slope
from roughbench.verdict.onset import foundation_and_theory

FloatArray = NDArray[np.float64]
ENDS: tuple[Ends, ...] = ("periodic", "open")
UNIT = 4.0 / math.pi  # the length for which p = D
EPS = float(np.finfo(float).eps)


def squared_runs(contact: list[bool], ends: Ends) -> int:
    """Σ n² over the runs of True, the obvious way."""
    if ends == "periodic" and not all(contact):
        gap = contact.index(False)
        contact = contact[gap:] + contact[:gap]
    return sum(len(list(run)) ** 2 for key, run in itertools.groupby(contact) if key)


def exact_state(
    heights: FloatArray, pressure: float, length: float, ends: Ends
) -> dict[str, Fraction | float]:
    """Area, separation, stiffness and energy in rational arithmetic, spring by spring."""
    h = [Fraction(float(x)) for x in heights]
    n, pi, side = len(h), Fraction(math.pi), Fraction(length)
    load = n * pi / 4 * side * Fraction(pressure)  # Σδ
    levels = sorted(h, reverse=True)
    for k in range(1, n + 1):
        plane = (sum(levels[:k], Fraction(0)) - load) / k
        if plane <= levels[k - 1] and (k == n or plane > levels[k]):
            break
    contact = [x >= plane for x in h]
    delta = [max(x - plane, Fraction(0)) for x in h]
    c = Fraction(sum(contact), n)
    return {
        "area": Fraction(squared_runs(contact, ends), n * n),
        "separation": plane - sum(h, Fraction(0)) / n + sum(delta, Fraction(0)) / n,
        "stiffness": math.inf if c == 1 else 4 / (pi * side) * c / (1 - c),
        "energy": 2 / (pi * side) * sum((d * d for d in delta), Fraction(0)) / n,
    }


def line(points: int, seed: int = 0) -> FloatArray:
    return np.random.default_rng(seed).standard_normal(points)


def paper_spectrum(q_rolloff: float, q_max: float = 8192.0) -> Spectrum:
    return self_affine(hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


# Cross-checks ---------------------------------------------------------------------------


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("decimals", [1, 17])  # with ties and without
@pytest.mark.parametrize("points", [1, 2, 3, 4, 7, 64])
def test_every_value_agrees_with_rational_arithmetic(
    points: int, decimals: int, ends: Ends
) -> None:
    heights = np.round(line(points), decimals)
    length = 1.7
    top = max(full_contact_pressure(heights, length), 0.1)
    pressures = np.concatenate([np.geomspace(1e-9, 1.5, 37) * top, [top / 3]])
    curve = foundation_curve(heights, pressures, length, ends)
    for i, p in enumerate(pressures):
        exact = exact_state(heights, float(p), length, ends)
        assert curve.area[i] == float(exact["area"])
        assert curve.stiffness[i] == pytest.approx(float(exact["stiffness"]), rel=4 * EPS)
        assert curve.energy[i] == pytest.approx(float(exact["energy"]), rel=40 * EPS)
        # The heights are differences from the highest, each rounded once: 4 ε h_rms.
        assert abs(curve.separation[i] - float(exact["separation"])) <= 4 * EPS


@pytest.mark.parametrize("ends", ENDS)
def test_long_lines_agree_with_bisection(ends: Ends) -> None:
    length = 2 * math.pi
    heights = make_profile(paper_spectrum(8, 512), 2048, length, realization_generator(5, 0))
    pressures = np.geomspace(1e-7, 1e-3, 9)
    curve = foundation_curve(heights, pressures, length, ends)
    for i, p in enumerate(pressures):
        low, high = heights.min() - 4 * length * p, heights.max()
        for _ in range(80):
            plane = (low + high) / 2
            mean = math.fsum(np.maximum(heights - plane, 0.0)) / heights.size
            low, high = (plane, high) if 4 / math.pi * mean / length > p else (low, plane)
        contact = heights >= plane
        separation = plane - math.fsum(heights) / heights.size + mean
        assert curve.area[i] == squared_runs(contact.tolist(), ends) / heights.size**2
        assert curve.diagnostics["springs_in_contact"][i] == contact.sum()
        assert abs(curve.separation[i] - separation) < 1e-17 + 4 * EPS * np.abs(heights).max()


# Special states -------------------------------------------------------------------------


def test_the_first_spring_carries_all_until_the_second_touches() -> None:
    curve = foundation_curve([1.0, 0.0, 0.5, 0.0], [0.1, 0.124, 0.126], UNIT)
    assert curve.diagnostics["springs_in_contact"].tolist() == [1, 1, 2]
    assert curve.area.tolist() == [1 / 16, 1 / 16, 2 / 16]
    assert curve.diagnostics["regions"].tolist() == [1, 1, 2]
    np.testing.assert_allclose(curve.stiffness, [1 / 3, 1 / 3, 1.0], rtol=4 * EPS)


@pytest.mark.parametrize("points", [1, 2, 5])
def test_constant_heights_are_in_full_contact_at_once(points: int) -> None:
    curve = foundation_curve(np.full(points, 0.3), [1e-100, 1e-3, 10.0], UNIT)
    assert curve.area.tolist() == [1.0] * 3
    assert curve.separation.tolist() == [0.0] * 3
    assert np.isposinf(curve.stiffness).all()
    assert full_contact_pressure(np.full(points, 0.3), UNIT) == 0.0
    np.testing.assert_allclose(curve.energy, curve.pressure**2 / 2, rtol=4 * EPS)


def test_full_contact_begins_exactly_at_its_pressure() -> None:
    heights = line(1000)
    p_full = full_contact_pressure(heights, 2.0)
    closed_form = 4 / math.pi * (math.fsum(heights) / 1000 - heights.min()) / 2.0
    assert p_full == pytest.approx(closed_form, rel=4 * EPS)
    below, at, above = np.nextafter(p_full, 0), p_full, 2 * p_full
    curve = foundation_curve(heights, [above, below, at], 2.0)
    assert curve.stiffness.tolist() == [math.inf, curve.stiffness[1], math.inf]
    assert curve.stiffness[1] == pytest.approx(2 / math.pi * 999, rel=4 * EPS)
    assert curve.separation[[0, 2]].tolist() == [0.0, 0.0]
    assert curve.area.tolist() == [1.0, (999 / 1000) ** 2, 1.0]


def test_separation_keeps_its_relative_accuracy_up_to_full_contact() -> None:
    """One spring is out of contact, by 2^-40 of the height of the others."""
    heights = np.array([1.0, 1.0, 0.0, -(2.0**-40)])
    p = 0.5 + 2.0**-42  # all but the last are in contact, its gap is 2^-40 / 3 on
    curve = foundation_curve(heights, [p], UNIT)
    exact = exact_state(heights, p, UNIT, "periodic")
    assert curve.separation[0] == pytest.approx(float(exact["separation"]), rel=1e-3)
    assert curve.separation[0] > 0


def test_springs_of_equal_height_touch_together() -> None:
    curve = foundation_curve([0.0, 1.0, 0.0, 1.0, 1.0], [1e-12, 0.6, 0.59], UNIT)
    assert curve.diagnostics["springs_in_contact"].tolist() == [3, 5, 3]
    assert curve.area.tolist() == [(1 + 4) / 25, 1.0, (1 + 4) / 25]


@pytest.mark.parametrize(
    ("ends", "share"),
    [("periodic", 1.0), ("open", 0.5)],
)
def test_a_crest_on_the_ends_is_one_region_only_if_they_are_periodic(
    ends: Ends, share: float
) -> None:
    """A wave with its crest at the ends: A/A0 = c², or two regions of c/2."""
    x = (np.arange(1024) + 0.5) * 2 * np.pi / 1024
    curve = foundation_curve(np.cos(x), np.geomspace(1e-4, 0.1, 5), 2 * np.pi, ends)
    c = curve.diagnostics["springs_in_contact"] / 1024
    assert (c < 1).all()
    np.testing.assert_allclose(curve.area, share * c**2, rtol=4 * EPS)
    assert (curve.diagnostics["regions"] == 1 / share).all()


# Closed forms ---------------------------------------------------------------------------


def test_cosine_profile_converges_at_second_order() -> None:
    """With d = cos φ, D = (sin φ - φ cos φ)/π, c = φ/π, ⟨δ²⟩ in closed form; order N^-2."""
    phi = np.linspace(0.3, 2.8, 11)
    mean = (np.sin(phi) - phi * np.cos(phi)) / np.pi
    square = (phi * (1 + 2 * np.cos(phi) ** 2) - 1.5 * np.sin(2 * phi)) / (2 * np.pi)
    points = np.array([256, 1024, 4096, 16384])
    errors: dict[str, list[float]] = {"separation": [], "energy": []}
    for n in points:
        x = (np.arange(n) + 0.3) * 2 * np.pi / n
        curve = foundation_curve(np.cos(x), mean, UNIT)
        errors["separation"].append(
            float(np.abs(curve.separation - (np.cos(phi) + mean)).max())
        )
        errors["energy"].append(float(np.abs(curve.energy - square / 2).max()))
    expected_order = {"separation": 2.0, "energy": 2.0}
    for name, error in errors.items():
        order = -np.polyfit(np.log(points), np.log(error), 1)[0]
        assert order > expected_order[name] - 0.25, name
        assert error[-1] < 1e-8


def test_parabola_follows_hertz() -> None:
    """MDR: -x²/R gives a = √(Rδ), F = (4/3)E*√R δ^{3/2}, U = (8/15)E*√R δ^{5/2}."""
    length, radius, n = 2.0, 3.0, 1 << 15
    x = (np.arange(n) + 0.5) * length / n - length / 2
    delta = np.geomspace(1e-3, 0.2, 9)
    area_0 = math.pi / 4 * length**2
    force = 4 / 3 * math.sqrt(radius) * delta**1.5
    curve = foundation_curve(-(x**2) / radius, force / area_0, length, "open")
    a = np.sqrt(radius * delta)
    c = 2 * a / length
    np.testing.assert_allclose(curve.area, np.pi * a**2 / area_0, rtol=2e-3)
    np.testing.assert_allclose(curve.stiffness, 2 * a / area_0 / (1 - c), rtol=2e-3)
    np.testing.assert_allclose(
        curve.energy, 8 / 15 * math.sqrt(radius) * delta**2.5 / area_0, rtol=1e-5
    )
    mean = length**2 / 12 / radius  # of x²/R
    np.testing.assert_allclose(
        curve.separation, mean - delta + math.pi / 4 * length * curve.pressure, rtol=1e-6
    )


def test_gaussian_heights_follow_the_gaussian_limit() -> None:
    """Stratified normal heights: p = (4/π)(φ - tQ)h/L and ū/h = t + φ - tQ."""
    from scipy.special import erfc, ndtri

    n, h, length = 1 << 18, 0.01, 6.0
    edges = ndtri(np.arange(1, n) / n)
    density = np.exp(-edges * edges / 2) / math.sqrt(2 * math.pi)
    heights = -h * n * np.diff(density, prepend=0.0, append=0.0)  # the means of the strata
    t = np.linspace(-2.0, 3.0, 11)
    phi, q = np.exp(-t * t / 2) / math.sqrt(2 * math.pi), erfc(t / math.sqrt(2)) / 2
    pressures = UNIT * (phi - t * q) * h / length
    curve = foundation_curve(heights, pressures, length)
    # One stratum of probability 1/N lies across the plane; Q N = 354 are above t = 3.
    np.testing.assert_allclose(curve.separation / h, t + phi - t * q, rtol=1e-6)
    np.testing.assert_allclose(curve.stiffness, UNIT / length * q / (1 - q), rtol=1 / 354)


def test_number_of_regions_follows_rice() -> None:
    """n_c = (L/2π)(ξ/h)e^{-t²/2}, with t from the Gaussian limit at the same pressure."""
    from scipy.optimize import brentq
    from scipy.special import erfc

    length, n = 16 * 2 * math.pi, 1 << 15  # 16 points on the shortest wave
    spectrum = paper_spectrum(8, 128)
    pressure, runs = 3e-5, 40
    counts, scales = [], []
    for r in range(runs):
        heights = make_profile(spectrum, n, length, realization_generator(3, r))
        curve = foundation_curve(heights, [pressure], length)
        counts.append(int(curve.diagnostics["regions"][0]))
        scales.append(rms_height_and_slope(heights, length))
    h, slope = np.mean(scales, axis=0)

    def excess(t: float) -> float:
        phi, q = math.exp(-t * t / 2) / math.sqrt(2 * math.pi), erfc(t / math.sqrt(2)) / 2
        return float(UNIT * (phi - t * q) * h / length - pressure)

    t = brentq(excess, -3, 6)
    rice = length / (2 * math.pi) * slope / h * math.exp(-t * t / 2)
    # Springs a apart see 1 - a²M_4/(24 M_2) of the crossings (arccos formula, at t = 0).
    rice *= 1 - (length / n) ** 2 * spectrum.moment(4) / spectrum.moment(2) / 24
    error = np.std(counts, ddof=1) / math.sqrt(runs)
    assert abs(np.mean(counts) - rice) < 4 * error
    assert error < 0.03 * rice  # it is a test


# Scale and area rule, one at a time ------------------------------------------------------


def test_a_modulus_changes_the_scale_of_the_pressure_alone() -> None:
    """p = k_w D: states at pressures in the ratio of the moduli are the same."""
    heights, length, k_w = line(300), 1.7, 9.0
    p = np.geomspace(1e-6, 30.0, 15)
    published = foundation_curve(heights, p, length)
    own = foundation_curve(heights, k_w * length / UNIT * p, length, modulus=k_w)
    ratio = k_w * length / UNIT
    assert (own.diagnostics["springs_in_contact"] < 300).any()
    assert np.isinf(own.stiffness[-1])
    np.testing.assert_array_equal(own.area, published.area)
    np.testing.assert_allclose(own.separation, published.separation, rtol=1e-12)
    np.testing.assert_allclose(own.stiffness, ratio * published.stiffness, rtol=1e-12)
    np.testing.assert_allclose(own.energy, ratio * published.energy, rtol=1e-12)


def test_with_modulus_and_points_it_is_winkler_on_a_line() -> None:
    """What is left between the two is the dimension, and p²/2k_w in the energy."""
    spectrum, length = paper_spectrum(4, 32), 2 * math.pi
    heights = make_profile(spectrum, 512, length, realization_generator(2, 0))
    sample = Sample(heights, length, spectrum)
    p = np.geomspace(1e-5, 1.0, 12)
    model = Foundation(springs=512, modulus="matched", area="points")
    curve, k_w = model.curve(sample, p), matched_modulus(sample)
    springs = winkler_curve(heights, p, k_w)
    np.testing.assert_array_equal(curve.area, springs.area)
    assert curve.area[0] < 0.02
    assert curve.area[-1] == 1.0
    np.testing.assert_allclose(curve.separation, springs.separation, rtol=1e-11)
    np.testing.assert_allclose(curve.stiffness, springs.stiffness, rtol=1e-11)
    np.testing.assert_allclose(curve.energy - p**2 / (2 * k_w), springs.energy, rtol=1e-9)
    fields = model.make_fields(sample)(next(iter(curve.states())))
    assert fields.pressure.mean() == pytest.approx(p[0], rel=1e-9)
    assert fields.modulus == k_w
    # M_1/2M_0 of the line: sums over its waves, |h_q|² = q0 C1D.
    q = np.arange(1, 33)
    c_1d = np.where(q < 4, q * 4.0**-3.4, q**-2.4)
    assert k_w == pytest.approx(float((q * c_1d).sum() / c_1d.sum() / 2), rel=1e-9)


def test_points_of_gaussian_heights_are_the_share_above_the_plane() -> None:
    from scipy.special import ndtri

    n, t = 1 << 16, 1.5
    heights = ndtri((np.arange(n) + 0.5) / n)
    density = math.exp(-t * t / 2) / math.sqrt(2 * math.pi)
    share = math.erfc(t / math.sqrt(2)) / 2
    curve = foundation_curve(heights, [2.0 * (density - t * share)], 1.0, modulus=2.0)
    points = foundation_curve(heights, curve.pressure, 1.0, modulus=2.0, area="points")
    assert points.area[0] == pytest.approx(share, rel=2e-4)
    assert curve.area[0] == pytest.approx(share**2, rel=4e-4)  # sorted: one region
    # Midpoints stand for the means of the strata; the outermost are off by most.
    assert points.separation[0] == pytest.approx(t + density - t * share, rel=2e-5)


def test_only_the_published_foundation_is_the_papers() -> None:
    tree = {
        "name": "scales",
        "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
        "pressures": [1e-5, 1e-4],
        "realizations": 2,
        "save_fields": {"pressures": [1e-5], "realizations": [0]},
        "models": [
            {"kind": "foundation", "label": "stiff", "springs": 64, "modulus": "matched"},
            {"kind": "foundation", "label": "points", "springs": 64, "area": "points"},
            {"kind": "foundation", "label": "own", "springs": 64, "modulus": 8.9},
            {"kind": "foundation", "springs": 64},
        ],
    }
    results = rb.run(tree)
    models = results["main"]
    assert foundation_and_theory(models)[0] is models["foundation"]
    assert len([*pressed_lines(results)]) == 1
    assert models["stiff"].title == "1D foundation, matched modulus"
    assert models["points"].title == "1D foundation, area in points"
    assert model_names(results, ["main"], "area")["own"] == (
        r"1D foundation, own modulus, $k_w = 8.9\,E\!^*$, $n = 2$"
    )
    assert models["stiff"].attributes["modulus"] == "matched"
    assert "modulus" not in models["foundation"].attributes
    for name in ("separation", "stiffness", "energy"):
        np.testing.assert_array_equal(models["points"][name], models["foundation"][name])
    first = load_spec({**tree, "models": tree["models"][3:]})  # type: ignore[index]
    named = {"kind": "foundation", "springs": 64, "modulus": "published", "area": "regions"}
    assert load_spec({**tree, "models": [named]}).sha256 == first.sha256


@pytest.mark.parametrize(
    ("modulus", "message"),
    [
        ("popov", "must be published, matched, or k_w/E[*], 1/length, got 'popov'"),
        (0.0, "models.0..modulus: must be greater than 0, got 0.0"),
        (True, "must be a number, got true"),
        ("3 /um", "has a unit"),
    ],
)
def test_a_wrong_modulus_is_refused(modulus: object, message: str) -> None:
    tree = {
        "surface": {"H": 0.7, "q0": 1.0, "q1": 32.0, "slope": 0.1},
        "pressures": [1e-5],
        "models": [{"kind": "foundation", "modulus": modulus}],
    }
    with pytest.raises(SpecError, match=message):
        load_spec(tree)


def test_a_modulus_may_have_a_unit() -> None:
    tree = {
        "surface": {"H": 0.7, "q0": "1 /um", "q1": "8 /um", "slope": 0.1},
        "modulus": {"E*": "1 GPa"},
        "pressures": ["1 MPa"],
        "models": [{"kind": "foundation", "springs": 64, "modulus": "3 /um"}],
    }
    assert load_spec(tree).models[0].modulus == pytest.approx(3e6)  # type: ignore[attr-defined]
    tree["models"] = [{"kind": "foundation", "springs": 64, "modulus": "matched"}]
    assert load_spec(tree).models[0].modulus == "matched"  # type: ignore[attr-defined]


# Derivatives and work -------------------------------------------------------------------


def between_events(heights: FloatArray, length: float) -> tuple[FloatArray, float]:
    """Pressures in mid-interval of some wide intervals, and half of a step within."""
    curve = foundation_curve(heights, np.geomspace(1e-6, 1, 4000), length)
    k = curve.diagnostics["springs_in_contact"]
    same = np.flatnonzero((k[:-2] == k[2:]) & np.isfinite(curve.stiffness[2:])) + 1
    return curve.pressure[same], 1e-4


def test_stiffness_is_the_slope_between_events() -> None:
    heights, length = line(200), 1.3
    p, step = between_events(heights, length)
    assert p.size > 50
    up, down = (foundation_curve(heights, p * (1 + s), length) for s in (step, -step))
    slope = -(up.pressure - down.pressure) / (up.separation - down.separation)
    np.testing.assert_allclose(foundation_curve(heights, p, length).stiffness, slope, rtol=1e-8)


def test_work_of_the_plane_and_of_the_mean_separation() -> None:
    """-dU/dd = p, -dU/dū = p/(1-c), and -dU'/dū = p for U' = U - (π/8)Lp²."""
    heights, length = line(200), 1.3
    p, step = between_events(heights, length)
    middle, up, down = (
        foundation_curve(heights, p * (1 + s), length) for s in (0.0, step, -step)
    )
    c = middle.diagnostics["springs_in_contact"] / 200
    # d = ū + ⟨h⟩ - D, with D = (π/4)Lp.
    d = [x.separation - math.pi / 4 * length * x.pressure for x in (up, down)]
    work = -(up.energy - down.energy)
    np.testing.assert_allclose(work / (d[0] - d[1]), p, rtol=1e-8)
    np.testing.assert_allclose(work / (up.separation - down.separation), p / (1 - c), rtol=1e-8)
    rest = [x.energy - math.pi / 8 * length * x.pressure**2 for x in (up, down)]
    np.testing.assert_allclose(
        -(rest[0] - rest[1]) / (up.separation - down.separation), p, rtol=1e-7
    )


# Properties -----------------------------------------------------------------------------

lines = st.lists(
    st.floats(-1, 1, allow_subnormal=False).map(lambda x: round(x, 3)), min_size=1, max_size=30
).map(np.array)
loads = st.lists(st.floats(1e-6, 4.0), min_size=1, max_size=8).map(np.array)
ends_of = st.sampled_from(ENDS)


def assert_same(a: Curve, b: Curve) -> None:
    for item in fields(Curve):
        x, y = getattr(a, item.name), getattr(b, item.name)
        if isinstance(x, np.ndarray):
            np.testing.assert_array_equal(x, y, err_msg=item.name)
    for name, x in a.diagnostics.items():
        np.testing.assert_array_equal(x, b.diagnostics[name], err_msg=name)


@given(lines, loads, ends_of)
def test_lengths_scale_out(heights: FloatArray, p: FloatArray, ends: Ends) -> None:
    """All lengths times 4: exact in binary."""
    one = foundation_curve(heights, p, 1.5, ends)
    four = foundation_curve(4 * heights, p, 6.0, ends)
    np.testing.assert_array_equal(four.area, one.area)
    np.testing.assert_array_equal(four.separation, 4 * one.separation)
    np.testing.assert_array_equal(four.stiffness, one.stiffness / 4)
    np.testing.assert_array_equal(four.energy, 4 * one.energy)


@given(lines, loads, ends_of)
def test_heights_and_modulus_scale_the_pressure(
    heights: FloatArray, p: FloatArray, ends: Ends
) -> None:
    """Heights times 2 at twice p/E*; the same as half the modulus at the same p."""
    one = foundation_curve(heights, p, 1.5, ends)
    two = foundation_curve(2 * heights, 2 * p, 1.5, ends)
    np.testing.assert_array_equal(two.area, one.area)
    np.testing.assert_array_equal(two.separation, 2 * one.separation)
    np.testing.assert_array_equal(two.stiffness, one.stiffness)
    np.testing.assert_array_equal(two.energy, 4 * one.energy)


@given(lines, loads, ends_of)
def test_curves_are_monotone_and_bounded(
    heights: FloatArray, p: FloatArray, ends: Ends
) -> None:
    curve = foundation_curve(heights, np.sort(p), 1.5, ends)
    assert (np.diff(curve.area) >= 0).all()
    assert (np.diff(curve.separation) <= 0).all()
    assert (curve.stiffness[1:] >= curve.stiffness[:-1]).all()
    assert (np.diff(curve.energy) >= 0).all()
    assert (curve.area > 0).all()
    assert (curve.area <= 1).all()
    assert (curve.separation >= 0).all()
    full = np.isinf(curve.stiffness)
    np.testing.assert_array_equal(full, curve.separation == 0)
    np.testing.assert_array_equal(full, curve.area == 1)


@given(lines, loads, st.integers(-40, 40), st.randoms(use_true_random=False))
def test_shifts_reversals_and_the_order_of_pressures_do_not_matter(
    heights: FloatArray, p: FloatArray, shift: int, random: object
) -> None:
    del random
    curve = foundation_curve(heights, p, 1.5)
    assert_same(curve, foundation_curve(np.roll(heights, shift), p, 1.5))
    assert_same(curve, foundation_curve(heights[::-1], p, 1.5))
    assert_same(
        foundation_curve(heights, p, 1.5, "open"),
        foundation_curve(heights[::-1], p, 1.5, "open"),
    )
    back = foundation_curve(heights, p[::-1], 1.5)
    np.testing.assert_array_equal(back.separation[::-1], curve.separation)
    np.testing.assert_array_equal(back.area[::-1], curve.area)


@given(lines, loads)
@settings(max_examples=50)
def test_only_the_area_depends_on_the_ends(heights: FloatArray, p: FloatArray) -> None:
    periodic, open_ = (foundation_curve(heights, p, 1.5, ends) for ends in ENDS)
    for name in ("separation", "stiffness", "energy"):
        np.testing.assert_array_equal(getattr(periodic, name), getattr(open_, name))
    assert (periodic.area >= open_.area).all()


# Ensemble of the published size ----------------------------------------------------------

PRESSURES = np.array([1e-6, 1e-5, 1e-4, 1e-3])
# 100 fixed-amplitude realizations of an independent prototype (design notes, §3): 32768
# springs, all modes up to 8192, periodic ends; value and standard error, lengths in the
# continuum's h. The state in which nearly all realizations are in full contact is left
# out where its mean is no normal variable.
PROTOTYPE: dict[int, dict[str, list[tuple[float, float]]]] = {
    1: {
        "area": [(1.083e-4, 4.4e-6), (1.522e-3, 5.5e-5), (2.343e-2, 8.8e-4), (0.380, 0.011)],
        "separation": [(2.538, 0.050), (2.235, 0.046), (1.518, 0.029), (0.2235, 0.0078)],
        "stiffness": [
            (1.346e-5, 3.9e-7),
            (5.51e-5, 1.6e-6),
            (2.443e-4, 7.9e-6),
            (2.292e-3, 4.8e-5),
        ],
    },
    8: {
        "area": [(1.014e-4, 4.6e-6), (1.236e-3, 2.8e-5), (1.771e-2, 2.6e-4)],
        "separation": [(2.176, 0.032), (1.432, 0.014), (0.4387, 0.0023)],
        "stiffness": [(4.67e-6, 1.4e-7), (2.619e-5, 6.2e-7), (2.469e-4, 2.7e-6)],
    },
}
FULL_CONTACT = {1: (2.43e-3, 3.8e-5), 8: (7.58e-4, 1.0e-5)}  # mean; s.e. of our own runs


def ensemble(
    q_rolloff: int, springs: int, realizations: int, *, rescale: bool = False
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Values (realization, pressure) with lengths in h, and the full-contact pressures."""
    spectrum, length = paper_spectrum(q_rolloff), 2 * math.pi
    h = spectrum.rms_height
    values: dict[str, list[FloatArray]] = {"area": [], "separation": [], "stiffness": []}
    full = []
    for r in range(realizations):
        heights = make_profile(
            spectrum,
            springs,
            length,
            realization_generator(2013, r),
            undersampled="truncate",
        )
        if rescale:
            heights = heights * (0.1 / rms_height_and_slope(heights, length)[1])
        curve = foundation_curve(heights, PRESSURES, length)
        values["area"].append(curve.area)
        values["separation"].append(curve.separation / h)
        values["stiffness"].append(curve.stiffness * h)
        full.append(full_contact_pressure(heights, length))
    return {name: np.array(rows) for name, rows in values.items()}, np.array(full)


def deviations(q_rolloff: int, values: dict[str, FloatArray]) -> FloatArray:
    """(ours - prototype) / √(s² + s'²): the random streams differ, both errors count."""
    z = []
    for name, reference in PROTOTYPE[q_rolloff].items():
        for column, (mean, error) in enumerate(reference):
            ours = values[name][:, column]
            own = ours.std(ddof=1) / math.sqrt(len(ours))
            z.append((ours.mean() - mean) / math.hypot(own, error))
    return np.array(z)


@pytest.mark.parametrize("q_rolloff", [1, 8])
def test_ensemble_agrees_with_the_prototype(q_rolloff: int) -> None:
    """Within four standard errors, both ensembles' together: 99.9 % of the seeds pass.

    The mean square of the 12 (or 9) deviates is 1 on average; since they are correlated,
    nearly as spread as that of a single one, which is below 4 in 95 % of the seeds.
    """
    values, full = ensemble(q_rolloff, 32768, 100)
    z = deviations(q_rolloff, values)
    assert np.abs(z).max() < 4.0
    assert np.mean(z**2) < 4.0
    mean, error = FULL_CONTACT[q_rolloff]
    own = full.std(ddof=1) / 10
    assert abs(full.mean() - mean) < 4 * math.hypot(own, error)
    if q_rolloff == 8:  # 99 of the prototype's 100 are in full contact at 1e-3
        assert np.isinf(values["stiffness"][:, 3]).sum() >= 93
        assert values["area"][:, 3].mean() > 0.999


def test_rescaled_slopes_do_not_agree_with_the_prototype() -> None:
    """Negative control: renormalising the slope after truncation shifts K and ū by > 10 %."""
    values, _ = ensemble(8, 8192, 100, rescale=True)
    assert np.abs(deviations(8, values)).max() > 6.0


def test_truncation_hardly_matters_to_separation_and_stiffness() -> None:
    """The paper's 8192 springs against 32768 with the same phases (20 realizations)."""
    fine, _ = ensemble(8, 32768, 20)
    coarse, _ = ensemble(8, 8192, 20)
    for name in ("separation", "stiffness"):
        ratio = coarse[name][:, :3].mean(0) / fine[name][:, :3].mean(0)
        np.testing.assert_allclose(ratio, 1.0, atol=3e-3, err_msg=name)
    area = coarse["area"][:, :3].mean(0) / fine["area"][:, :3].mean(0)
    assert (area > 0.99).all()
    assert (area < 1.08).all()


# The model and its errors ---------------------------------------------------------------


def test_the_model_computes_the_curve_of_its_ends() -> None:
    heights = np.cos(np.arange(16) * 2 * np.pi / 16 + 0.1)
    sample = Sample(heights=heights, length=2.0)
    p = np.array([0.05, 0.01])
    for ends in ENDS:
        model = Foundation(springs=16, ends=ends)
        curve = model.curve(sample, p)
        assert_same(curve, foundation_curve(heights, p, 2.0, ends))
        assert curve.pressure.tolist() == p.tolist()
        assert (curve.status == Status.CONVERGED).all()
        assert curve.status.dtype == np.int32
    assert Foundation().name == "foundation"
    assert Foundation().dimension == 1


def test_the_springs_must_carry_the_spectrum_unless_told_otherwise() -> None:
    spectrum, length = paper_spectrum(1), 2 * math.pi
    with pytest.raises(SurfaceError, match=r"16384 points.*undersampled: truncate or alias"):
        Foundation().grid_points(spectrum, length)
    assert Foundation(springs=16384).grid_points(spectrum, length) == 16384
    assert Foundation(undersampled="alias").grid_points(spectrum, length) == 8192
    assert Foundation(undersampled="truncate", springs=100).grid_points(spectrum, length) == 100


@pytest.mark.parametrize(
    "options",
    [{"springs": 1}, {"ends": "free"}, {"spring": 3}, {"area": "squares"}],
)
def test_wrong_options_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Foundation.model_validate(options)


def test_every_option_is_described() -> None:
    for name in ("springs", "ends", "undersampled", "modulus", "area"):
        assert Foundation.model_fields[name].description


@pytest.mark.parametrize(
    ("heights", "pressures", "length", "message"),
    [
        (np.zeros((4, 4)), [0.1], 1.0, r"heights of a line, got shape \(4, 4\)"),
        ([], [0.1], 1.0, "heights of a line"),
        ([0.0, math.nan], [0.1], 1.0, "must be finite"),
        ([0.0, 1.0], [0.1, 0.0], 1.0, "positive and finite .*got 0.0 at index 1"),
        ([0.0, 1.0], [-0.1], 1.0, "positive and finite"),
        ([0.0, 1.0], [math.inf], 1.0, "positive and finite"),
        ([0.0, 1.0], [math.nan], 1.0, "positive and finite"),
        ([0.0, 1.0], 0.1, 1.0, "list of numbers"),
        ([0.0, 1.0], [0.1], 0.0, "length of the cell"),
        ([0.0, 1.0], [0.1], math.nan, "length of the cell"),
    ],
)
def test_unusable_input_is_refused(
    heights: FloatArray, pressures: list[float], length: float, message: str
) -> None:
    with pytest.raises(SolverError, match=message):
        foundation_curve(heights, pressures, length)


def test_a_sample_without_heights_is_refused() -> None:
    with pytest.raises(SolverError, match="needs the heights"):
        Foundation().curve(Sample(heights=None, length=1.0), np.array([0.1]))


def test_no_pressures_give_an_empty_curve() -> None:
    assert foundation_curve([0.0, 1.0], [], 1.0).area.shape == (0,)
