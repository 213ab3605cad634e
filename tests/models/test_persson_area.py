"""The self-consistent area of Persson's theory: limits, its differential equation, a solver."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughbench.errors import SolverError
from roughbench.models.base import Sample
from roughbench.models.persson import Persson, self_consistent_area
from roughbench.spectrum import self_affine


def test_gamma_one_is_the_error_function() -> None:
    from scipy.special import erf

    x = np.geomspace(1e-12, 10, 30)
    np.testing.assert_array_equal(self_consistent_area(x, 1.0), erf(math.sqrt(2) * x))


@pytest.mark.parametrize("gamma", [0.05, 0.5, 0.9])
def test_small_pressures_have_the_slope_of_gamma(gamma: float) -> None:
    area = self_consistent_area([1e-12, 1e-6], gamma)
    slope = math.sqrt(8 / (math.pi * gamma))
    np.testing.assert_allclose(area / [1e-12, 1e-6], slope, rtol=1e-7)


@pytest.mark.parametrize("gamma", [0.1, 0.5])
def test_it_solves_its_differential_equation(gamma: float) -> None:
    """dV/dV_fc = γ + (1-γ)erf²(p/√2V), marched in V_fc from full contact on."""
    from scipy.integrate import solve_ivp
    from scipy.special import erf

    for ratio in (0.03, 0.3, 1.0):  # p/ξ, with p = 1: V_fc = ξ²/4
        end = 0.25 / ratio**2

        def rate(_: float, v: np.ndarray) -> np.ndarray:
            return gamma + (1 - gamma) * erf(1 / np.sqrt(2 * v)) ** 2

        start = 1e-3  # erf(22) is 1: V = V_fc up to here
        marched = solve_ivp(rate, (start, end), [start], rtol=1e-11, atol=1e-13)
        expected = math.erf(1 / math.sqrt(2 * marched.y[0, -1]))
        assert self_consistent_area([ratio], gamma)[0] == pytest.approx(expected, rel=1e-8)


def test_values_of_the_notes() -> None:
    """PHYSICS §4, γ = 0.5, ξ = 0.1; p = .0316 is 10^-1.5."""
    p = np.array([1e-3, 0.01, 0.0316, 0.05, 0.1])
    found = self_consistent_area(p / 0.1, 0.5)
    np.testing.assert_allclose(found, [0.0225, 0.209, 0.531, 0.715, 0.956], atol=5.1e-4)


def test_large_pressures_and_order() -> None:
    area = self_consistent_area([1e3, 1e-3, 1.0], 0.5)
    assert area[0] == 1.0
    assert area[1] < area[2] < 1.0
    with pytest.raises(SolverError, match="gamma"):
        self_consistent_area([1.0], 0.0)


def test_the_option_changes_the_area_alone() -> None:
    spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=8, q_max=64, rms_slope=0.1)
    sample, p = Sample(None, 1.0, spectrum), np.array([1e-3, 1e-2])
    bulk, own = Persson().curve(sample, p), Persson(area_gamma=0.5).curve(sample, p)
    np.testing.assert_array_equal(own.area, self_consistent_area(p / 0.1, 0.5))
    assert (own.area > bulk.area).all()
    for name in ("separation", "stiffness", "energy"):
        np.testing.assert_array_equal(getattr(own, name), getattr(bulk, name))
