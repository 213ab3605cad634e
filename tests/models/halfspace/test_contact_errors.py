"""Every message of the public functions, and that it names value, bound and remedy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from roughbench.errors import SolverError
from roughbench.models.base import Sample
from roughbench.models.halfspace import HalfSpace
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.spectrum import self_affine

GOOD = np.eye(4)
NAN = np.where(np.arange(16).reshape(4, 4) == 6, np.nan, 0.0)

HEIGHTS: list[tuple[Any, str]] = [
    (GOOD + 1j, r"heights must be real numbers, got dtype complex128"),
    (np.array([["a", "b"], ["c", "d"]]), r"heights must be real numbers, got dtype"),
    (np.array([[None, 1], [2, 3]]), r"heights must be real numbers, got dtype object"),
    (1.0, r"at least 2 points a side, got shape \(\)"),
    (np.zeros((1, 8)), r"at least 2 points a side, got shape \(1, 8\)"),
    (np.zeros((8, 1)), r"at least 2 points a side, got shape \(8, 1\)"),
    (np.zeros(1), r"at least 2 points a side, got shape \(1,\)"),
    (np.zeros((0, 0)), r"at least 2 points a side, got shape \(0, 0\)"),
    (np.zeros((3, 3, 3)), r"a line \(n,\) or a surface \(n, m\)"),
    (NAN, r"heights must be finite, got nan at index \(1, 2\); fill or crop"),
    (np.where(np.isnan(NAN), -np.inf, 0.0), r"got -inf at index \(1, 2\)"),
    (np.array([0.0, np.nan]), r"got nan at index \(1,\)"),
    (NAN.astype(np.float32), r"got nan at index \(1, 2\)"),
]
OPTIONS: list[tuple[str, Any, str]] = [
    *(
        (name, value, rf"{name} must be a positive number, got {value}")
        for name in ("length", "modulus", "tolerance")
        for value in (0.0, -1.0, math.inf, math.nan)
    ),
    ("tolerance", 0.2, r"tolerance must be at most 0.1, got 0.2"),
    ("precision", "single", r"precision must be 'mixed' or 'double', got 'single'"),
    ("threads", 0, r"threads must be at least 1, got 0"),
    ("threads", -2, r"threads must be at least 1, got -2"),
    ("max_iterations", 0, r"max_iterations must be at least 1, got 0"),
]
PRESSURES: list[tuple[Any, str]] = [
    (0.0, r"pressures must be positive and finite, got 0.0"),
    (-1e-3, r"pressures must be positive and finite, got -0.001"),
    (math.nan, r"pressures must be positive and finite, got nan"),
    (math.inf, r"pressures must be positive and finite, got inf"),
]
LISTS: list[tuple[Any, str]] = [
    ([], r"pressures must be a list of numbers, got shape \(0,\)"),
    (0.1, r"pressures must be a list of numbers, got shape \(\)"),
    ([[0.1, 0.2]], r"pressures must be a list of numbers, got shape \(1, 2\)"),
    ([0.1, -0.2], r"pressures must be positive and finite, got -0.2"),
]


@pytest.mark.parametrize(("heights", "message"), HEIGHTS)
def test_heights_that_cannot_be_used(heights: Any, message: str) -> None:
    for solve in (lambda: solve_contact(heights, 0.1), lambda: solve_curve(heights, [0.1])):
        with pytest.raises(SolverError, match=message):
            solve()


@pytest.mark.parametrize(("name", "value", "message"), OPTIONS)
def test_options_out_of_range(name: str, value: Any, message: str) -> None:
    options: dict[str, Any] = {name: value}
    for solve in (
        lambda: solve_contact(GOOD, 0.1, **options),
        lambda: solve_curve(GOOD, [0.1], **options),
    ):
        with pytest.raises(SolverError, match=message):
            solve()


@pytest.mark.parametrize(("pressure", "message"), PRESSURES)
def test_pressure_out_of_range(pressure: Any, message: str) -> None:
    with pytest.raises(SolverError, match=message):
        solve_contact(GOOD, pressure)


@pytest.mark.parametrize(("pressures", "message"), LISTS)
def test_lists_of_pressures_that_are_none(pressures: Any, message: str) -> None:
    with pytest.raises(SolverError, match=message):
        solve_curve(GOOD, pressures)


@pytest.mark.parametrize("heights", [None, np.zeros(8)], ids=["none", "line"])
def test_the_model_needs_a_surface(heights: Any) -> None:
    spectrum = self_affine(hurst=0.7, q_min=1, q_rolloff=1, q_max=4, rms_slope=0.1)
    sample = Sample(heights, 1.0, spectrum)
    with pytest.raises(SolverError, match=r"needs the heights of a surface, shape \(n, m\)"):
        HalfSpace().curve(sample, np.array([0.1]))
