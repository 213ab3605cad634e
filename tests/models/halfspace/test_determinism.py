"""The same bytes again: in this process, in fresh ones, and for the same threads."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pytest

from roughbench.models.base import State
from roughbench.models.halfspace.contact import solve_contact, solve_curve
from roughbench.models.halfspace.states import solve_states
from roughbench.models.halfspace.working_set import WorkingSet

if TYPE_CHECKING:
    from tests.models.halfspace.conftest import Rough

ROOT = Path(__file__).resolve().parents[3]
CELL = 2 * np.pi
PRESSURES = [2e-2, 1e-4, 1e-3, 0.3]

PROGRAM = """\
import hashlib, sys
import numpy as np
from roughbench.models.halfspace.contact import solve_contact, solve_curve
heights = np.load(sys.argv[1])
for threads in (1, 2):
    curve = solve_curve(heights, [2e-2, 1e-4, 1e-3, 0.3], length=2 * np.pi, threads=threads)
    state = solve_contact(heights, 1e-2, length=2 * np.pi, threads=threads)
    parts = [curve.area, curve.separation, curve.stiffness, curve.energy]
    parts += [state.pressure, state.gap]
    print(hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest())
"""


def digest(heights: np.ndarray, threads: int) -> str:
    """Return what PROGRAM prints for so many threads."""
    curve = solve_curve(heights, PRESSURES, length=CELL, threads=threads)
    state = solve_contact(heights, 1e-2, length=CELL, threads=threads)
    parts = [curve.area, curve.separation, curve.stiffness, curve.energy]
    parts += [state.pressure, state.gap]
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_same_bytes_when_called_again(threads: int, rough: Rough) -> None:
    heights = rough(96, per_wave=2.0)
    first = digest(heights, threads)
    solve_contact(rough(96, seed=9), 3e-3, length=CELL, threads=threads)  # other work between
    assert digest(heights, threads) == first


def test_vectors_of_few_tiles_lie_apart() -> None:
    """Compiled loops add up in another order where two vectors are a few words apart.

    A loop that writes one vector while it sums over another checks, before it takes
    vector instructions, whether the two are closer than one step of these; where the
    allocator puts them must not change the sum.
    """
    for tiles in (1, 2, 5):
        chosen = np.ones((1, tiles), np.uint8)
        sets = [WorkingSet.on((1, 8 * tiles), chosen, np.float32) for _ in range(4)]
        for points in sets:
            points.open_vectors()
            vectors = (points.p, points.r, points.d, points.s, points.y)
            places = np.sort([vector.ctypes.data for vector in vectors])
            assert np.diff(places).min() >= 512


def test_same_bytes_in_fresh_processes(rough: Rough, tmp_path: Path) -> None:
    """Plans measured by the first process are kept for those after it."""
    heights = rough(96, per_wave=2.0)
    np.save(tmp_path / "heights.npy", heights)
    environment = dict(os.environ, ROUGHBENCH_CACHE=str(tmp_path / "cache"))
    environment["PYTHONPATH"] = str(ROOT)
    one, other = (
        subprocess.run(
            [sys.executable, "-c", PROGRAM, str(tmp_path / "heights.npy")],
            check=True,
            capture_output=True,
            text=True,
            env=environment,
        ).stdout.splitlines()
        for _ in range(2)
    )
    assert one == other
    assert [len(line) for line in one] == [64, 64]  # with one thread, and with two


@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_threads_change_only_the_rounding(
    precision: Literal["mixed", "double"], rough: Rough
) -> None:
    """More threads than rows as well."""
    heights = rough(48)
    states = [
        solve_contact(
            heights,
            1e-2,
            length=CELL,
            threads=threads,
            tolerance=1e-10,
            precision=precision,
        )
        for threads in (1, 2, 7, 64)
    ]
    for other in states[1:]:
        assert np.array_equal(other.pressure > 0, states[0].pressure > 0)
        np.testing.assert_allclose(
            other.pressure, states[0].pressure, rtol=0, atol=1e-8 * states[0].pressure.max()
        )
        assert other.mean_separation == pytest.approx(states[0].mean_separation, rel=1e-9)


@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_a_resumed_curve_is_the_same_to_the_bit(precision: str, rough: Rough) -> None:
    """From any state: at low loads, with transforms, in full contact; unsorted pressures."""
    heights = rough(256, per_wave=4.0, q_rolloff=2.0)
    pressures = [0.3, 1e-2, 1e-6, 1e-7, 1e-3, 1e-5]
    options: dict[str, Any] = {"length": CELL, "precision": precision, "threads": 2}
    whole: list[State] = []
    snapshots: list[dict[str, np.ndarray]] = []
    for state in solve_states(heights, pressures, **options):
        assert state.fields is not None
        assert state.snapshot is not None
        if len(snapshots) % 2:  # to look at a state changes nothing
            state.fields()
        snapshots.append({name: np.array(value) for name, value in state.snapshot().items()})
        whole.append(state)
    assert [state.pressure for state in whole] == sorted(pressures)
    alone = solve_curve(heights, pressures, **options)
    order = np.argsort(pressures)
    assert alone.stiffness[order].tolist() == [state.stiffness for state in whole]
    assert alone.separation[order].tolist() == [state.separation for state in whole]
    for done, snapshot in enumerate(snapshots, start=1):
        later = list(solve_states(heights, pressures, finished=snapshot, **options))
        assert values(later) == values(whole[done:])


def values(states: list[State]) -> list[object]:
    return [(state.pressure, state.status, state.given()) for state in states]


def test_a_state_speaks_for_itself_only_until_the_next_one(rough: Rough) -> None:
    """It keeps no vectors; after it, they are those of another state."""
    states = solve_states(rough(64), [1e-3, 1e-2], length=CELL, threads=1)
    first, second = next(states), next(states)
    for late in (first.fields, first.snapshot):
        assert late is not None
        with pytest.raises(RuntimeError, match="ask before the next state"):
            late()
    assert second.fields is not None
    assert second.fields().pressure.mean() == pytest.approx(1e-2)
