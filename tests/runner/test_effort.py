"""What planning, resuming and the assembly of results cost: no more than the work there is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench import runner
from roughbench.errors import RoughbenchError
from roughbench.planning.plan import plan
from roughbench.planning.resources import assembly_memory
from roughbench.rundir import former, shards
from roughbench.rundir.collected import Collected, Coverage
from roughbench.runner import publication
from roughbench.spec import load_spec

Tree = dict[str, Any]


@pytest.fixture
def output(tmp_path: Path) -> Path:
    return tmp_path / "r.h5"


def counted(monkeypatch: pytest.MonkeyPatch, place: Any, name: str) -> list[object]:
    """Return a list that gets an entry at every call of a function."""
    calls: list[object] = []
    real = getattr(place, name)

    def spy(*arguments: Any) -> Any:
        calls.append(arguments)
        return real(*arguments)

    monkeypatch.setattr(place, name, spy)
    return calls


@pytest.mark.parametrize("count", [5, 20])
def test_what_changed_is_found_without_comparing_all_with_all(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    slopes = [0.1 + 0.01 * number for number in range(count)]
    tree = small_spec | {"models": [{"kind": "persson"}], "sweep": {"surface.slope": slopes}}
    rb.run(tree, output=output)
    read = counted(monkeypatch, shards, "read_shard")
    monkeypatch.setattr("roughbench.rundir.folder.read_shard", shards.read_shard)
    looked = counted(monkeypatch, shards, "read_identity")
    monkeypatch.setattr("roughbench.rundir.folder.read_identity", shards.read_identity)
    compared = counted(monkeypatch, former, "changes")
    parts = runner.preview(tree | {"pressures": [1e-3]}, output=output)
    assert {part.reason[:31] for part in parts} == {"changed: pressures: 3 from 0.00"}
    assert (len(read), len(looked), len(compared)) == (0, count, count)


def test_a_cell_without_a_likely_predecessor_looks_at_a_few(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(former, "_MOST_COMPARED", 3)
    slopes = [0.1 + 0.01 * number for number in range(10)]
    tree = small_spec | {"models": [{"kind": "persson"}], "sweep": {"surface.slope": slopes}}
    rb.run(tree, output=output)
    compared = counted(monkeypatch, former, "changes")
    changed = {"pressures": [1e-3], "surface": tree["surface"] | {"H": 0.8}}
    parts = runner.preview(tree | changed, output=output)
    assert len(compared) == 3 * 10
    assert all("surface.H: 0.7 → 0.8" in part.reason for part in parts)


def test_what_is_finished_is_not_put_together_again(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rb.run(small_spec, output=output)
    made = counted(monkeypatch, publication, "assemble")
    before = output.read_bytes()
    again = rb.run(small_spec, output=output)
    assert again["main"]["foundation"].n_realizations == 20
    assert output.read_bytes() == before
    assert made == []
    for spoil in (output.unlink, lambda: output.write_bytes(before[:-1] + b"x")):
        del made[:]
        spoil()
        rb.run(small_spec, output=output)
        assert len(made) == 2
        assert output.read_bytes() == before
    del made[:]
    rb.run(small_spec | {"name": "other"}, output=output)
    assert len(made) == 2
    assert rb.load(output).name == "other"


def test_other_assembling_code_is_a_reason(
    small_spec: Tree, output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rb.run(small_spec, output=output)
    made = counted(monkeypatch, publication, "assemble")
    monkeypatch.setattr("roughbench.runner.provenance.assembly_digest", lambda: "other")
    rb.run(small_spec, output=output)
    assert len(made) == 2


# -- memory --------------------------------------------------------------------------------


def kept(n_pressures: int, n_realizations: int, grid: int = 64) -> Tree:
    pressures = np.geomspace(1e-3, 1e-1, n_pressures).tolist()
    return {
        "surface": {"H": 0.7, "q0": 1.0, "q1": 8.0, "slope": 0.1},
        "pressures": pressures,
        "realizations": n_realizations,
        "models": [{"kind": "winkler", "grid": grid}],
        "save_fields": {"pressures": pressures, "realizations": [*range(n_realizations)]},
    }


def test_the_assembly_is_counted() -> None:
    (cell,) = plan(load_spec(kept(4, 8, grid=1024)))
    of_fields = 4 * 8 * 16 * 1024**2
    assert of_fields < assembly_memory(cell) < 2.2 * of_fields
    (few,) = plan(load_spec(kept(4, 8)))
    assert assembly_memory(few) < 0.4e9


def test_results_that_could_not_be_put_together_are_refused_before(
    output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree = kept(2, 3)
    monkeypatch.setattr("roughbench.planning.resources.assembly_memory", lambda _: 10 * 2**30)
    with pytest.raises(RoughbenchError, match=r"put its results together takes about 10\.7 GB"):
        rb.run(tree, output=output, max_memory="4G")
    monkeypatch.undo()
    rb.run(tree, output=output)
    data = output.read_bytes()
    output.unlink()
    rb.run(tree, output=output, max_memory="1M")  # all is computed: it must be written
    assert output.read_bytes() == data


def test_the_plan_tells_the_larger_of_task_and_assembly() -> None:
    tree = kept(1, 60, grid=2048)
    (part,) = runner.preview(tree, jobs=1, max_memory="40G")
    (cell,) = plan(load_spec(tree))
    assert part.memory == assembly_memory(cell) > 4e9


# -- the same values, whatever the blocks --------------------------------------------------


def test_shards_are_read_one_variable_at_a_time(output: Path) -> None:
    tree = kept(3, 2)
    rb.run(tree, output=output)
    folder = runner.folder_of(output)
    (path,) = folder.glob("shards/*/*")
    shard = shards.read_shard(path)
    asked: list[str] = []
    (cell,) = plan(load_spec(tree))
    with shard.opened() as variables:

        class Spy(Mapping[str, Any]):
            def __getitem__(self, name: str) -> Any:
                asked.append(name)
                return variables[name]

            def __iter__(self) -> Iterator[str]:
                return iter(variables)

            def __len__(self) -> int:
                return len(variables)

        collected = Collected(cell)
        collected.add(shard.realizations, shard.pressures, Spy(), shard.kept)
    assert len(asked) == len(set(asked))
    block = collected.block()
    assert block["field_gap"].shape == (6, 64, 64)
    np.testing.assert_array_equal(block["field_gap"], shard.block["field_gap"])


def test_a_block_of_other_variables_is_refused(output: Path) -> None:
    (cell,) = plan(load_spec(kept(3, 2)))
    coverage = Coverage(cell)
    pressures = cell.pressure_array()
    places = [(0, p) for p in cell.pressures]
    assert coverage.take(range(1), pressures, ["area", "status"], places) is not None
    with pytest.raises(ValueError, match="has no area, status and has gap"):
        coverage.take(range(1, 2), pressures, ["gap"], [])
    assert coverage.take(range(1, 2), pressures, ["area", "status"], []) is None  # no fields
    assert coverage.missing() == [(range(1, 2), cell.pressures)]
    assert coverage.take(range(5, 6), pressures, ["area", "status"], []) is None
    assert not output.exists()
