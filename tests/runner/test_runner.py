"""Runs: what they compute, leave out, report, and that the jobs do not show in the bytes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.engines.compute import compute
from roughbench.models.base import Status
from roughbench.models.foundation import foundation_curve
from roughbench.models.persson import Persson, persson_curve
from roughbench.planning.cells import Cell
from roughbench.planning.samples import make_sample
from roughbench.planning.tasks import Task, cut
from roughbench.runner import Progress, check, plan, preparation
from roughbench.runner.assemble import assemble
from roughbench.spec import load_spec
from tests.engines.fakes import AtOnce, Fake, Misdeed


@pytest.fixture
def cell(small_spec: dict[str, Any]) -> Cell:
    spec = load_spec(small_spec)
    return Cell("main", Fake(), spec.surface, spec.pressures, 6, spec.seed)


def computed(cell: Cell, misdeed: Misdeed) -> rb.ModelResult:
    cell = replace(cell, model=Fake(misdeed=misdeed))
    return assemble(cell, compute(whole(cell)))


def whole(cell: Cell) -> Task:
    return Task(cell, range(cell.n_realizations), cell.pressures)


# -- what is computed ----------------------------------------------------------------------


def test_results_are_those_of_the_models(small_spec: dict[str, Any]) -> None:
    spec = load_spec(small_spec)
    results = rb.run(small_spec)
    found = results["main"]["foundation"]
    assert found["area"].shape == (20, 3)
    for realization in (0, 17):
        sample = make_sample(spec.surface, spec.models[0], 7, realization)
        assert sample.heights is not None
        curve = foundation_curve(sample.heights, spec.pressures, sample.length)
        for name in ("area", "separation", "stiffness", "energy"):
            np.testing.assert_array_equal(found[name][realization], getattr(curve, name))
    persson = results["main"]["persson"]
    assert persson["area"].shape == (1, 3)
    curve = persson_curve(sample_spectrum(spec), spec.pressures, 0.45)
    np.testing.assert_array_equal(persson["separation_mean"], curve.separation)
    np.testing.assert_allclose(found["area_mean"], found["area"].mean(axis=0), rtol=1e-13)
    assert found.attributes["seed"] == 7
    assert (results.name, results.spec_sha256) == ("small", spec.sha256)


def sample_spectrum(spec: rb.Spec) -> Any:
    return make_sample(spec.surface, Persson(), 0, 0).spectrum


def test_a_sweep_makes_several_experiments(small_spec: dict[str, Any]) -> None:
    results = rb.run({**small_spec, "realizations": 2, "sweep": {"surface.qr": [8.0, 2.0]}})
    assert len(results) == 2
    one, other = results.values()
    assert [m["foundation"].attributes["q_rolloff"] for m in (one, other)] == [8.0, 2.0]
    assert one["foundation"]["separation_mean"][0] < other["foundation"]["separation_mean"][0]


def test_a_model_may_override_the_realizations(small_spec: dict[str, Any]) -> None:
    results = rb.run(small_spec, overrides=["models.foundation.realizations=3"])
    assert results["main"]["foundation"].n_realizations == 3


def test_heights_from_a_file(tmp_path: Path, rng: np.random.Generator) -> None:
    line = 0.1 * rng.normal(size=64)
    np.save(tmp_path / "line.npy", line)
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: line.npy, length: 3.0}\n"
        "pressures: [0.1, 0.5]\n"
        "models: [{kind: foundation}, {kind: persson}]\n"
    )
    results = rb.run(tmp_path / "spec.yaml")
    found = results["main"]["foundation"]
    expected = foundation_curve(line - line.mean(), [0.1, 0.5], 3.0)
    np.testing.assert_array_equal(found["area"], [expected.area])
    assert found.attributes["rms_height"] == pytest.approx(line.std())
    assert found["rms_height"].tolist() == [found.attributes["rms_height"]]
    assert results["main"]["persson"]["area_mean"][0] > 0.0


def test_heights_of_a_wrong_dimension_are_refused_before_anything_is_computed(
    tmp_path: Path,
) -> None:
    np.save(tmp_path / "line.npy", 0.01 * np.cos(np.arange(64.0)))
    (tmp_path / "spec.yaml").write_text(
        "surface: {kind: file, path: line.npy, length: 3.0}\n"
        "pressures: [0.1]\n"
        "models: [{kind: persson}, {kind: bem}]\n"
    )
    with pytest.raises(rb.SurfaceError, match=r"main/bem: line\.npy: its shape is"):
        rb.run(tmp_path / "spec.yaml", output=tmp_path / "r.h5")
    assert not (tmp_path / "r.h5").exists()


# -- states that do not count --------------------------------------------------------------


def test_unconverged_states_are_left_out_and_counted(cell: Cell) -> None:
    found = computed(cell, "unconverged")
    bad = found["status"][:, 1] != 0
    assert 0 < bad.sum() < 6  # both kinds of realizations
    assert found.n_unconverged == 2 * bad.sum()
    assert found["n_converged"].tolist() == [6, 6 - bad.sum(), 6 - bad.sum()]
    assert found["area_mean"][1] == pytest.approx(found["area"][~bad, 1].mean())
    assert found["area_mean"].max() < 200.0  # not 1e9
    assert set(found["status"][bad, 2]) == {Status.MAX_ITERATIONS}


def test_what_is_not_finite_never_passes_as_converged(cell: Cell) -> None:
    found = computed(cell, "nan area")
    assert found["status"].tolist() == [[3, 0, 3]] * 6
    assert np.isnan(found["area_mean"]).tolist() == [True, False, True]
    assert computed(cell, "nan stiffness")["status"].tolist() == [[3, 3, 3]] * 6


def test_infinite_stiffness_is_full_contact(cell: Cell) -> None:
    found = computed(cell, "none")
    assert found.n_unconverged == 0
    assert found["stiffness_mean"].tolist() == [1e-4, 1e-3, np.inf]
    assert np.isnan(found["stiffness_sem"][2])
    assert found["stiffness_harmonic"].tolist() == pytest.approx([1e-4, 1e-3, np.inf])


def test_optional_variables_and_diagnostics_are_kept(cell: Cell, tmp_path: Path) -> None:
    found = computed(cell, "none")
    assert found["area_raw_mean"].tolist() == [0.5] * 3
    assert found["threads"].dtype == np.int64
    assert found["even"].tolist() == [[0, 0, 1]] * 6
    assert found.attributes["flag"] == "true"
    results = rb.Results({"main": {"fake": found}}, "", "")
    from roughbench.store import write_results

    loaded = rb.load(write_results(results, tmp_path / "r.h5"))["main"]["fake"]
    assert loaded["even"].tolist() == [[0, 0, 1]] * 6


def test_a_curve_of_another_shape_is_an_error(cell: Cell) -> None:
    with pytest.raises(rb.SolverError, match=r"energy has shape \(2,\), the pressures \(3,\)"):
        compute(whole(replace(cell, model=AtOnce(misdeed="shape"))))
    with pytest.raises(rb.SolverError, match="not of the pressures that were asked for"):
        compute(whole(replace(cell, model=AtOnce(misdeed="pressures"))))


def test_a_model_gives_the_same_quantities_of_all_realizations(
    small_spec: dict[str, Any], cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def one_by_one(
        cell: Cell, rows: range, pressures: tuple[float, ...], **_: Any
    ) -> list[Task]:
        return [Task(cell, range(row, row + 1), pressures) for row in rows]

    fickle = replace(cell, model=AtOnce(misdeed="fickle"), n_realizations=8)
    message = r"main/at_once, realization . of 8: has .*energy, unlike the realizations before"
    with pytest.raises(rb.SolverError, match=message):
        compute(whole(fickle))
    # The same where each realization is a task, with a run directory and without.
    monkeypatch.setattr(preparation, "plan", lambda _: [fickle])
    monkeypatch.setattr("roughbench.runner.scan.cut", one_by_one)
    for output in (None, tmp_path / "r.h5"):
        with pytest.raises(rb.RoughbenchError, match="energy, unlike the realizations before"):
            rb.run(small_spec, output=output)


# -- tasks and processes -------------------------------------------------------------------


def test_every_realization_is_in_one_task(cell: Cell) -> None:
    tasks = cut(cell, range(3, 40), cell.pressures, parts=4)
    assert [i for task in tasks for i in task.realizations] == list(range(3, 40))
    many = replace(cell, n_realizations=37)
    assert str(Task(many, range(16), cell.pressures)) == "main/fake, realizations 1 to 16 of 37"
    assert str(Task(many, range(4, 5), cell.pressures)) == "main/fake, realization 5 of 37"
    assert str(whole(replace(cell, n_realizations=1))) == "main/fake"


def test_small_realizations_share_a_task_and_large_ones_do_not(
    small_spec: dict[str, Any],
) -> None:
    models = [{"kind": "bem", "grid": 2048}, {"kind": "foundation", "springs": 8192}]
    exact, foundation = plan(load_spec({**small_spec, "models": models}))
    sizes = [len(task.realizations) for task in cut(exact, range(20), exact.pressures)]
    assert sizes == [1] * 20
    lines = cut(foundation, range(10_000), foundation.pressures, parts=4)
    assert {len(task.realizations) for task in lines[:-1]} == {329}  # a second
    few = cut(foundation, range(40), foundation.pressures, parts=4)
    assert [len(task.realizations) for task in few] == [33, 7]  # a tenth of one at least


def test_check_names_every_fault(small_spec: dict[str, Any]) -> None:
    cells = plan(load_spec(small_spec))
    check(cells)
    coarse = cells[0].model.model_copy(update={"springs": 8})
    with pytest.raises(rb.SurfaceError, match="main/foundation: 8 points per side are too"):
        check([replace(cells[0], model=coarse), cells[1]])


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_file_is_the_same_to_the_byte_for_any_number_of_jobs(
    small_spec: dict[str, Any], tmp_path: Path, jobs: int
) -> None:
    # Gaussian amplitudes, several tasks per cell, and full contact in some of them.
    surface = {**small_spec["surface"], "amplitude": "gaussian"}
    spec = {**small_spec, "surface": surface, "realizations": 40, "pressures": [1e-4, 3e-3]}
    one, other = tmp_path / "one.h5", tmp_path / "other.h5"
    rb.run(spec, output=one, threads=1)
    rb.run(spec, output=other, threads=1, jobs=jobs)
    assert one.read_bytes() == other.read_bytes()
    results = rb.run(spec)
    loaded = rb.load(one)
    for name in results["main"]["foundation"]:
        memory, disk = (r["main"]["foundation"][name] for r in (results, loaded))
        np.testing.assert_array_equal(memory, disk)


@pytest.mark.parametrize("jobs", [1, 2])
def test_progress_counts_every_state_once(small_spec: dict[str, Any], jobs: int) -> None:
    news: list[Progress] = []
    rb.run(small_spec, jobs=jobs, threads=1, progress=news.append)
    assert [n.total for n in news] == [63] * len(news)
    done = [n.done for n in news]
    assert done == sorted(set(done))
    assert (done[0], done[-1]) == (0, 63)
    shares = [n.share for n in news]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    texts = {n.text for n in news}
    assert {"main/persson", "main/foundation, realization 20 of 20"} <= texts


@pytest.mark.parametrize("jobs", [1, 2])
def test_progress_of_the_exact_solver_goes_by_pressures(jobs: int) -> None:
    news: list[Progress] = []
    surface = {"H": 0.7, "q0": 1.0, "q1": 64.0, "slope": 0.1}
    models = [{"kind": "bem", "grid": 256}]
    pressures = [1e-3, 1e-2, 0.03, 0.1]
    spec = {"surface": surface, "pressures": pressures, "models": models, "realizations": 2}
    rb.run(spec, jobs=jobs, threads=1, progress=news.append)
    assert news[-1].done == 8
    texts = [n.text for n in news]
    assert any("realization 1 of 2, pressure" in text for text in texts) or jobs == 2
    assert texts[-1] in {f"main/bem, realization {i} of 2" for i in (1, 2)}


def test_nothing_is_written_when_a_task_fails(
    cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small_spec: dict[str, Any]
) -> None:
    from roughbench.runner import driver

    cells = [replace(cell, model=Fake(misdeed="refuse"))]
    monkeypatch.setattr(preparation, "plan", lambda _: cells)
    with pytest.raises(rb.SolverError, match="refused"):
        driver.run(small_spec, output=tmp_path / "r.h5")
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.h5.rbrun"]


@pytest.mark.parametrize(("jobs", "threads"), [(0, None), (1, 0), (-1, 1)])
def test_refuses_no_jobs_and_no_threads(
    small_spec: dict[str, Any], jobs: int, threads: int | None
) -> None:
    with pytest.raises(rb.RoughbenchError, match="must be at least 1, got"):
        rb.run(small_spec, jobs=jobs, threads=threads)


def test_refuses_a_bad_output_before_it_computes(
    small_spec: dict[str, Any], tmp_path: Path
) -> None:
    news: list[Progress] = []
    with pytest.raises(rb.StoreError, match="it is a folder; give a file name in it"):
        rb.run(small_spec, output=tmp_path, progress=news.append)
    assert news == []


def test_the_exact_solver_weighs_most(small_spec: dict[str, Any]) -> None:
    models = [{"kind": "bem", "grid": 512}, {"kind": "foundation", "springs": 8192}]
    exact, foundation = plan(load_spec({**small_spec, "models": models}))
    assert exact.work == 0.7 * (3 + 1) * (512**2 + 12500)
    assert foundation.work == 1e3 + 0.25 * 8192


def test_heights_from_a_file_weigh_as_they_are(tmp_path: Path) -> None:
    np.save(tmp_path / "line.npy", np.arange(5000.0))
    surface = {"kind": "file", "path": str(tmp_path / "line.npy"), "length": 1.0}
    tree = {"surface": surface, "pressures": [0.1], "models": [{"kind": "foundation"}]}
    cell = plan(load_spec(tree))[0]
    assert cell.n_points == 5000
    np.save(tmp_path / "line.npy", np.arange(60_000.0))
    assert cell.n_points == 5000  # what is planned stays so
    assert plan(load_spec(tree))[0].n_points == 60_000
