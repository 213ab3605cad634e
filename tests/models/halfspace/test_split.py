"""The split sum against the direct one, and states solved with it against those without."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from roughbench.models.halfspace import workspace
from roughbench.models.halfspace.contact import solve_curve
from roughbench.models.halfspace.direct import DirectOperator
from roughbench.models.halfspace.loops import TILE
from roughbench.models.halfspace.operator import HalfSpaceOperator
from roughbench.models.halfspace.split import REACH, SplitOperator
from roughbench.models.halfspace.threads import ThreadTeam
from roughbench.models.halfspace.working_set import WorkingSet, tile_grid

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Rough

SHAPES = [(512, 512), (317, 250), (251, 517)]


def scattered(
    shape: tuple[int, int], rng: np.random.Generator, *, smooth: bool
) -> tuple[WorkingSet, WorkingSet]:
    """Few loaded tiles, those at the periodic edge among them; float32 and float64."""
    chosen = (rng.random(tile_grid(shape)) < 0.05).astype(np.uint8)
    chosen[0, 0] = chosen[-1, -1] = chosen[0, -1] = chosen[1, 1] = 1
    exact = WorkingSet.on(shape, chosen, np.float64)
    if smooth:
        # No part of it near the Nyquist wavevector: a narrow bump within each tile.
        x = np.arange(TILE) - (TILE - 1) / 2
        bump = np.exp(-(x**2) / 3.0)
        exact.p[:] = np.tile(np.outer(bump, bump).ravel(), exact.tiles.size)
        exact.p *= np.repeat(rng.random(exact.tiles.size), TILE * TILE)
    else:
        exact.p[:] = rng.random(exact.p.size) * (rng.random(exact.p.size) < 0.3)
    tops, lefts = exact.corners
    partial = (tops + TILE > shape[0]) | (lefts + TILE > shape[1])
    exact.p[np.repeat(partial, TILE * TILE)] = 0.0  # points beyond the grid
    single = WorkingSet.on(shape, chosen, np.float32)
    single.p[:] = exact.p
    return exact, single


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize(
    ("smooth", "error"),
    # Random pressures feel the alternating tail of G beyond the reach, which is left out:
    # per row and direction 0.044/x², from two directions along rows and columns.
    [(True, 3e-6), (False, None)],
    ids=["smooth", "random"],
)
def test_it_is_the_operator(
    *,
    shape: tuple[int, int],
    smooth: bool,
    error: float | None,
    threads: int,
    rng: np.random.Generator,
) -> None:
    team = ThreadTeam(threads)
    exact, single = scattered(shape, rng, smooth=smooth)
    expected, found = np.empty_like(exact.p), np.empty_like(single.p)
    DirectOperator(HalfSpaceOperator(shape, np.float64, team)).apply(
        exact, exact.p, exact, expected
    )
    split = SplitOperator(shape, team)
    assert split.open(single)
    split.apply(single, single.p, single, found)
    inside = np.repeat(
        exact.p.reshape(-1, TILE * TILE).max(axis=1) > 0, TILE * TILE
    )  # not the tiles that reach beyond the grid
    if error is None:
        power = (exact.p**2).sum() / math.prod(shape)
        error = 2.0 * math.sqrt(power * 4 * 0.044**2 / (3 * REACH**3))
    difference = (found - expected)[inside]
    assert math.sqrt(np.square(difference).mean()) < error * (
        np.abs(expected[inside]).max() if smooth else 1.0
    )


def test_same_states_as_without(rough: Rough, monkeypatch: pytest.MonkeyPatch) -> None:
    heights = rough(512, per_wave=4.0, q_rolloff=4.0)
    loads = np.array([3e-5, 1e-4, 1.5e-4])
    curves = []
    for share in (workspace.SPLIT_MAX_FRACTION, 0.0):
        monkeypatch.setattr(workspace, "SPLIT_MAX_FRACTION", share)
        curves.append(solve_curve(heights, loads, length=2 * math.pi))
    split, usual = curves
    assert (split.status == 0).all()
    assert split.diagnostics is not None
    assert usual.diagnostics is not None
    few, many = (c.diagnostics["transform_pairs"][1:] for c in (split, usual))
    assert (few < many / 2).all(), "the split sum was not used"
    for name, error in {"area_raw": 1e-3, "separation": 1e-6, "stiffness": 1e-5}.items():
        np.testing.assert_allclose(getattr(split, name), getattr(usual, name), rtol=error)
