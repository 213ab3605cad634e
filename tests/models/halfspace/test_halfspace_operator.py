"""Elasticity against explicit sums over the wavevectors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.threads import ThreadTeam

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference

SHAPES = [(1, 2), (1, 3), (1, 16), (1, 17), (2, 2), (3, 3), (4, 6), (7, 4), (5, 9), (8, 8)]


def make_operator(
    shape: tuple[int, int], dtype: type = np.float64, threads: int = 1
) -> HalfSpaceOperator:
    return HalfSpaceOperator(shape, dtype, ThreadTeam(threads))


def flat_or_line(values: np.ndarray) -> np.ndarray:
    return values[0] if values.shape[0] == 1 else values


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_operator_is_the_dense_matrix(
    shape: tuple[int, int], threads: int, rng: np.random.Generator, reference: type[Reference]
) -> None:
    """Odd, even, non-square and 1D grids; both directions, in grid units."""
    operator = make_operator(shape, threads=threads)
    values = rng.standard_normal(shape)
    own = reference(flat_or_line(values), length=flat_or_line(values).shape[0])
    for apply, power in ((operator.displace, -1.0), (operator.traction, 1.0)):
        operator.field[...] = values
        apply()
        expected = (own.matrix(power) @ values.ravel()).reshape(shape)
        np.testing.assert_allclose(operator.field, expected, rtol=0, atol=1e-13)
    assert operator.pairs == 2


@pytest.mark.parametrize("shape", [(1, 50), (12, 15), (16, 16)], ids=str)
@pytest.mark.parametrize(("dtype", "error"), [(np.float64, 1e-13), (np.float32, 2e-5)])
def test_traction_undoes_displacement(
    shape: tuple[int, int], dtype: type, error: float, rng: np.random.Generator
) -> None:
    operator = make_operator(shape, dtype)
    pressure = rng.standard_normal(shape)
    pressure -= pressure.mean()
    operator.field[...] = pressure
    operator.displace()
    operator.traction()
    assert operator.field.dtype == dtype
    np.testing.assert_allclose(operator.field, pressure, rtol=0, atol=error)


def test_uniform_pressure_displaces_nothing(rng: np.random.Generator) -> None:
    """G(0) = 0: displacements are measured from their mean."""
    operator = make_operator((6, 8))
    operator.field[...] = 3.0
    operator.displace()
    np.testing.assert_allclose(operator.field, 0.0, atol=1e-14)
    operator.field[...] = rng.standard_normal((6, 8))
    operator.displace()
    assert abs(float(operator.field.mean())) < 1e-14


@pytest.mark.parametrize(("n", "m"), [(8, 8), (9, 12)])
def test_one_wave(n: int, m: int) -> None:
    """U(x) = 2p/(E*|q|) for p = cos q·x, the definition of the kernel."""
    qy, qx = 2 * math.pi * 2 / n, 2 * math.pi * 3 / m
    y, x = np.mgrid[:n, :m]
    wave = np.cos(qy * y + qx * x)
    operator = make_operator((n, m))
    operator.field[...] = wave
    operator.displace()
    np.testing.assert_allclose(operator.field, 2 * wave / math.hypot(qx, qy), atol=1e-14)
