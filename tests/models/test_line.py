"""The line on a half-plane: closed forms, the foundation's limits, a prototype."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.errors import SolverError, SurfaceError
from roughbench.models.base import CompleteCurve, FloatArray, Sample
from roughbench.models.line import Line, single_contact_stiffness
from roughbench.spectrum import Spectrum, self_affine
from roughbench.surface import make_profile, realization_generator

SIDE = 2 * math.pi


def spectrum(q_rolloff: float, q_max: float) -> Spectrum:
    return self_affine(hurst=0.7, q_min=1, q_rolloff=q_rolloff, q_max=q_max, rms_slope=0.1)


def curve_of(
    model: Line, heights: FloatArray, length: float, pressures: FloatArray
) -> CompleteCurve:
    return CompleteCurve.from_states(
        model.states(Sample(heights, length), pressures), pressures
    )


def test_a_wave_follows_westergaard() -> None:
    """h0 cos(2πx/λ), P = p/p*, p* = πE*h0/λ: A = (2/π)asin√P, ū = h0(1 - P + P ln P),
    U = h0 p* P²(¼ - ½ ln P), K = p*/(h0 ln(1/P))."""  # noqa: D209, D205
    n, h0, length = 4096, 0.01, 3.0
    heights = h0 * np.cos(2 * np.pi * np.arange(n) / n)
    full = math.pi * h0 / length
    share = np.array([0.02, 0.2, 0.5, 0.9])
    curve = curve_of(Line(precision="double", tolerance=1e-9), heights, length, share * full)
    assert (curve.status == 0).all()
    np.testing.assert_allclose(curve.area, 2 / np.pi * np.arcsin(np.sqrt(share)), atol=1 / n)
    u = h0 * (1 - share + share * np.log(share))
    np.testing.assert_allclose(curve.separation, u, atol=2e-7 * h0)
    energy = h0 * full * share**2 * (0.25 - 0.5 * np.log(share))
    np.testing.assert_allclose(curve.energy, energy, rtol=1e-5)
    stiffness = full / (h0 * np.log(1 / share))
    np.testing.assert_allclose(curve.stiffness, stiffness, rtol=6e-3)


def test_a_single_contact_is_a_flat_punch_whatever_its_shape() -> None:
    """A parabola with a kink beside it: one contact, K by its width alone."""
    n = 4096
    x = (np.arange(n) - n / 2) / n
    heights = np.where(x < 0, -3.0 * x**2, -8.0 * x**2 - 0.1 * x)
    curve = curve_of(Line(), heights, 1.0, np.array([1e-3, 1e-2, 5e-2]))
    assert (curve.status == 0).all()
    assert curve.area_raw is not None
    expected = single_contact_stiffness(curve.area_raw, 1.0)
    # The width is uncertain by a point at either edge.
    lower = single_contact_stiffness(curve.area_raw - 2 / n, 1.0)
    assert (curve.stiffness < expected).all()
    assert (curve.stiffness > lower).all()
    corrected = single_contact_stiffness(curve.area, 1.0)
    np.testing.assert_allclose(curve.stiffness, corrected, rtol=5e-3)


def test_stiffness_of_a_single_contact_is_westergaards() -> None:
    share = np.array([0.01, 0.3, 0.99])
    width = 2 / np.pi * np.arcsin(np.sqrt(share))
    np.testing.assert_allclose(
        single_contact_stiffness(width, 1.0), math.pi / np.log(1 / share), rtol=1e-12
    )
    with pytest.raises(SolverError, match="width of a contact"):
        single_contact_stiffness([1.1], 1.0)


def test_stiffness_falls_logarithmically_at_low_pressure() -> None:
    """Over eight decades K falls by a small factor: no power law p^{1/(1+H)}."""
    spec = spectrum(1, 64)
    heights = make_profile(spec, 1024, SIDE, realization_generator(1, 0))
    curve = curve_of(Line(), heights, SIDE, np.array([1e-10, 1e-2]))
    assert (curve.status == 0).all()
    popov_and_surface = 1e-8 ** (1 / 1.7)
    assert 100 * popov_and_surface < curve.stiffness[0] / curve.stiffness[1] < 0.5


def test_the_area_converges_to_that_of_a_finer_line() -> None:
    """At 4 and 16 points on the shortest wave, against 64: what the correction leaves.

    Found: 16.5 and 4.3 % too many points, of which -1.0 and -0.1 % are left. The finer lines
    are known to 0.1 %: half a point at each of some 70 edges.
    """
    spec, p = spectrum(8, 32), np.array([1e-2])
    coarse, middle, fine = (
        np.mean([_areas(spec, n, seed, p) for seed in range(6)], axis=0)
        for n in (128, 512, 2048)
    )
    (raw, left), (raw_16, left_16) = coarse / fine[1] - 1, middle / fine[1] - 1
    assert raw > 0.15
    assert 0.04 < raw_16 < raw / 3  # first order
    assert abs(left) < 0.015
    assert abs(left_16) < 0.005


def _areas(spec: Spectrum, n: int, seed: int, p: FloatArray) -> list[float]:
    heights = make_profile(spec, n, SIDE, realization_generator(seed, 0))
    curve = curve_of(Line(points=n), heights, SIDE, p)
    assert curve.area_raw is not None
    return [float(curve.area_raw[0]), float(curve.area[0])]


def test_without_the_correction_points_are_counted() -> None:
    spec, p = spectrum(1, 16), np.array([1e-2, 1e-3])
    heights = make_profile(spec, 256, SIDE, realization_generator(0, 0))
    counted, corrected = (
        curve_of(Line(correction=one), heights, SIDE, p) for one in ("none", "perimeter")
    )
    np.testing.assert_array_equal(counted.area, corrected.area_raw)
    np.testing.assert_array_equal(counted.stiffness, corrected.stiffness)
    assert (corrected.area < counted.area).all()
    assert Line().model_dump() == Line(correction="perimeter").model_dump()
    assert "correction" not in Line().model_dump()
    assert Line(correction="none").model_dump()["correction"] == "none"


# PHYSICS §4, 20 lines of fixed amplitude, N = 32768, q1 = 8192, points counted; lengths over
# the continuum's h. Standard errors of those printed without one are taken to be ours.
Column = dict[str, tuple[float, float | None]]
PROTOTYPE: dict[int, dict[float, Column]] = {
    8: {
        1e-3: {
            "area_raw": (2.54e-2, 2e-4),
            "separation": (1.006, 0.010),
            "stiffness": (2.33e-3, 7e-5),
        },
        1e-2: {
            "area_raw": (0.2228, None),
            "separation": (0.1346, 0.0020),
            "stiffness": (0.0490, None),
        },
    },
    1: {
        1e-2: {
            "area_raw": (0.2197, None),
            "separation": (0.0638, None),
            "stiffness": (0.0847, None),
        },
    },
}


@pytest.mark.parametrize("q_rolloff", [1, 8])
def test_ensemble_agrees_with_the_prototype(q_rolloff: int) -> None:
    spec, n = spectrum(q_rolloff, 8192), 20
    pressures = np.array(list(PROTOTYPE[q_rolloff]))
    model = Line(points=32768)
    curves = []
    for r in range(n):
        heights = make_profile(spec, 32768, SIDE, realization_generator(2013, r))
        curves.append(model.curve(Sample(heights, SIDE, spec), pressures))
    assert all((curve.status == 0).all() for curve in curves)
    h = spec.rms_height
    for i, columns in enumerate(PROTOTYPE[q_rolloff].values()):
        for name, (value, noted) in columns.items():
            unit = {"area_raw": 1.0, "separation": 1 / h, "stiffness": h}[name]
            ours = np.array([getattr(curve, name)[i] for curve in curves]) * unit
            error = ours.std(ddof=1) / math.sqrt(n)
            both = math.hypot(error, error if noted is None else noted)
            assert abs(ours.mean() - value) < 3.5 * both, (name, i)


def test_options_and_refusals() -> None:
    spec = spectrum(1, 16)
    assert Line().grid_points(spec, SIDE) == 256
    assert Line(points=40).grid_points(spec, SIDE) == 40
    with pytest.raises(SurfaceError, match="too coarse"):
        Line(points=30).grid_points(spec, SIDE)
    with pytest.raises(SolverError, match="heights of a line"):
        Line().curve(Sample(np.zeros((4, 4)), 1.0), np.array([1.0]))


def test_every_state_comes_without_a_snapshot() -> None:
    spec = spectrum(1, 16)
    sample = Sample(make_profile(spec, 256, SIDE, realization_generator(0, 0)), SIDE, spec)
    states = list(Line().states(sample, np.array([1e-2, 1e-3])))
    assert [(state.pressure, state.snapshot) for state in states] == [
        (1e-3, None),
        (1e-2, None),
    ]
    assert Line().curve(sample, np.array([1e-3])).area.size == 1
