"""The direct sum over few points, against transforms and against states solved without it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from roughbench.models.halfspace import evaluation
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.loops import TILE
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.options import Precision
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Reference, Rough

CELL = 2 * math.pi


def on_tiles(field: np.ndarray, chosen: np.ndarray, dtype: type) -> WorkingSet:
    """Working set with p = ``field``, zero beyond the grid."""
    points = WorkingSet.on(field.shape, chosen, dtype)
    n, m = field.shape
    tops, lefts = points.corners
    for tile, (top, left) in enumerate(zip(tops, lefts, strict=True)):
        block: np.ndarray = np.zeros((points.height, TILE), dtype)
        part = field[top : top + points.height, left : left + TILE]
        block[: part.shape[0], : part.shape[1]] = part
        points.p.reshape(-1, points.tile_size)[tile] = block.ravel()
    assert n * m >= np.count_nonzero(points.p)
    return points


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize(("dtype", "error"), [(np.float64, 1e-13), (np.float32, 2e-5)])
@pytest.mark.parametrize(
    "shape",
    [(1, 9), (1, 200), (2, 2), (7, 21), (16, 16), (33, 50), (40, 72), (64, 31)],
    ids=str,
)
def test_it_is_the_operator(
    *, shape: tuple[int, int], dtype: type, error: float, threads: int, rng: np.random.Generator
) -> None:
    """Any grid, tiles that reach beyond it, neighbours across the periodic edge."""
    operator = HalfSpaceOperator(shape, np.float64, ThreadTeam(threads))
    direct = DirectOperator(operator)
    tiles = tile_grid(shape)
    pressure = np.where(rng.random(shape) < 0.3, rng.random(shape), 0.0)
    loaded = (rng.random(tiles) < 0.5).astype(np.uint8)
    loaded[0, 0] = loaded[-1, -1] = 1
    sources = on_tiles(pressure, loaded, dtype)
    targets = WorkingSet.on(shape, np.ones(tiles, np.uint8), dtype)
    direct.apply(sources, sources.p, targets, targets.p)

    operator.field[...] = 0.0
    n, m = shape
    for top, left, block in zip(
        *sources.corners, sources.p.reshape(-1, sources.height, TILE), strict=True
    ):
        operator.field[top : top + sources.height, left : left + TILE] = block[
            : n - top, : m - left
        ]
    operator.displace()
    expected = on_tiles(np.array(operator.field), np.ones(tiles, np.uint8), dtype)
    inside = on_tiles(np.ones(shape), np.ones(tiles, np.uint8), dtype).p > 0
    np.testing.assert_allclose(targets.p[inside], expected.p[inside], rtol=0, atol=error)


def test_no_displacement_is_lower_than_the_bound(rng: np.random.Generator) -> None:
    """What the evaluation leaves out rests on this bound."""
    operator = HalfSpaceOperator((48, 40), np.float64, ThreadTeam(1))
    lowest = DirectOperator(operator).lowest
    for share in (0.002, 0.05, 1.0):
        pressure = np.where(rng.random((48, 40)) < share, rng.random((48, 40)), 0.0)
        operator.field[...] = pressure
        operator.displace()
        assert operator.field.min() >= pressure.sum() * lowest - 1e-12


@pytest.mark.parametrize("precision", ["mixed", "double"])
@pytest.mark.parametrize("shape", [(256, 256), (181, 250)], ids=str)
def test_same_states_as_with_transforms(
    shape: tuple[int, int], precision: Precision, rough: Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = rough(256, per_wave=4.0, q_rolloff=2.0)[: shape[0], : shape[1]]
    loads = np.geomspace(1e-7, 3e-5, 6)
    sums = solve_curve(heights, loads, length=CELL, precision=precision, tolerance=1e-9)
    monkeypatch.setattr(evaluation, "DIRECT_SUM_MAX_FRACTION", 0.0)
    transforms = solve_curve(heights, loads, length=CELL, precision=precision, tolerance=1e-9)
    assert (sums.status == 0).all()
    assert sums.diagnostics is not None
    assert transforms.diagnostics is not None
    fewer = sums.diagnostics["transform_pairs"] < transforms.diagnostics["transform_pairs"] / 2
    assert fewer[:3].all(), "the direct sum was not used"
    np.testing.assert_array_equal(sums.area_raw, transforms.area_raw)
    for name in ("separation", "stiffness", "energy"):
        np.testing.assert_allclose(getattr(sums, name), getattr(transforms, name), rtol=1e-7)


def test_certificate_holds_on_all_points(rough: Rough, reference: type[Reference]) -> None:
    """Also on those that the evaluation left out: held against a gap computed everywhere."""
    heights = rough(128, per_wave=4.0, q_rolloff=2.0)
    own = reference(heights, length=CELL)
    for pressure in (1e-8, 1e-6, 1e-5):
        own.verify(solve_contact(heights, pressure, length=CELL), pressure)


@pytest.mark.parametrize("threads", [1, 2])
def test_deterministic(threads: int, rough: Rough) -> None:
    heights = rough(128, per_wave=4.0)
    states = [
        solve_contact(heights, 1e-6, length=CELL, threads=threads).pressure.tobytes()
        for _ in range(3)
    ]
    assert len(set(states)) == 1
