"""Observables and fields of a run: taken while it computes, kept through everything."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import roughbench as rb
from roughbench import runner
from roughbench.models import MODELS
from roughbench.models.base import Fields, Model, State, Status
from roughbench.models.halfspace import HalfSpace
from roughbench.models.halfspace import problem as halfspace_problem
from roughbench.models.winkler import Winkler, matched_modulus
from roughbench.observables import (
    OBSERVABLES,
    average,
    exponent,
    of_springs,
    of_state,
    persson_pressure_shares,
    persson_stress_spectrum,
)
from roughbench.planning.plan import plan
from roughbench.planning.resources import memory_of
from roughbench.planning.samples import make_sample
from roughbench.planning.tasks import Task
from roughbench.results import ModelResult, Results
from roughbench.rundir import checkpoint as checkpoints
from roughbench.rundir.identity import identity
from roughbench.rundir.journal import log_task
from roughbench.runner import monitor
from roughbench.spec import SelfAffineSurface, Spec, load_spec

TREE: dict[str, Any] = {
    "name": "seen",
    "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 16.0, "slope": 0.1},
    "pressures": [2e-3, 2e-2, 5.0],
    "realizations": 3,
    "seed": 5,
    "models": [
        {"kind": "bem"},
        {"kind": "line"},
        {"kind": "foundation", "springs": 128, "realizations": 4},
        {"kind": "winkler"},
        {"kind": "winkler", "label": "gaussian", "heights": "gaussian"},
        {"kind": "persson"},
    ],
    "observables": list(OBSERVABLES),
    "save_fields": {"pressures": [2e-3, 5.0], "realizations": [0, 2]},
}
WITH_FIELDS = ["bem", "line", "foundation", "winkler"]
NOTHING = {k: v for k, v in TREE.items() if k not in ("observables", "save_fields")}
SMALL = TREE | {"models": [{"kind": "bem"}, {"kind": "persson"}], "realizations": 1}
SMALL["pressures"] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 5.0]
SMALL["save_fields"] = {"pressures": [3e-3, 5.0]}


@pytest.fixture(scope="module")
def spec() -> Spec:
    return load_spec(TREE)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results file of a run."""
    path = tmp_path_factory.mktemp("seen") / "seen.h5"
    rb.run(TREE, output=path, threads=1)
    return path


@pytest.fixture(scope="module")
def seen(file: Path) -> Results:
    return rb.load(file)


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of the tasks that are computed from now on."""
    names: list[str] = []

    def spy(task: Any, *rest: Any) -> None:
        names.append(f"{task} at {len(task.pressures)}")
        log_task(task, *rest)

    monkeypatch.setattr(monitor, "log_task", spy)
    return names


# -- what they say -------------------------------------------------------------------------


def test_they_are_those_of_the_states_solved_one_by_one(spec: Spec, seen: Results) -> None:
    assert isinstance(spec.surface, SelfAffineSurface)
    spectrum, side = spec.surface.spectrum(), spec.surface.length
    bem = seen["main"]["bem"]
    for k, p in enumerate(spec.pressures):
        states = []
        for r in range(3):
            heights = make_sample(spec.surface, spec.models[0], 5, r).heights
            assert heights is not None
            solved = rb.solve_contact(heights, p, length=side, threads=1)
            states.append(of_state(solved, side, spectrum))
        for observable in OBSERVABLES.values():
            variable, profiles = observable.variable, [observable(state) for state in states]
            expected = average(profiles)
            # A state that starts from its neighbour has the same points but a few.
            close: dict[str, Any] = {"rtol": 1e-3, "atol": 2e-3 * np.nanmax(expected.mean)}
            for r, profile in enumerate(profiles):
                np.testing.assert_allclose(bem[variable][r, k], profile.values, **close)
            np.testing.assert_allclose(bem[f"{variable}_mean"][k], expected.mean, **close)
            places = bem[f"{variable}_bin"]
            there = ~np.isnan(expected.places)
            np.testing.assert_array_equal(places[there], expected.places[there])
            assert (np.diff(places) > 0.0).all()
            np.testing.assert_array_equal(bem[f"{variable}_edges"], expected.edges)
            for scalar, (mean, _) in expected.scalars.items():
                found = bem[f"{variable}_{scalar}_mean"][k]
                assert found == pytest.approx(mean, rel=1e-3, abs=1e-12, nan_ok=True)
        fitted = exponent([OBSERVABLES["stress_spectrum"](s) for s in states], 4.0, 8.0)
        assert bem["stress_spectrum_exponent_mean"][k] == pytest.approx(fitted[0], rel=1e-3)
        assert bem["stress_spectrum_exponent_sem"][k] == pytest.approx(fitted[1], rel=0.02)
    assert (bem.attributes["exponent_from"], bem.attributes["exponent_to"]) == (4.0, 8.0)


def test_averages_are_over_the_realizations(seen: Results) -> None:
    for label in WITH_FIELDS:
        result = seen["main"][label]
        n = result.n_realizations
        for variable in ("clusters", "gap_pdf", "clusters_number", "stress_spectrum_exponent"):
            values = result[variable]
            np.testing.assert_allclose(result[f"{variable}_mean"], values.mean(0), rtol=1e-12)
            sem = values.std(0, ddof=1) / math.sqrt(n)
            np.testing.assert_allclose(
                result[f"{variable}_sem"], sem, rtol=1e-9, atol=1e-12 * np.nanmax(abs(values))
            )


def test_pressures_carry_the_load_on_the_area(seen: Results) -> None:
    """∫P dσ = A and ∫σP dσ = p, with what is past the bins."""
    for label in WITH_FIELDS:
        result = seen["main"][label]
        p, density = result["pressure"], result["pressure_pdf"]
        sigma, edges = result["pressure_pdf_bin"], result["pressure_pdf_edges"]
        nominal = result["pressure_pdf_nominal"]
        np.testing.assert_allclose(nominal, np.broadcast_to(p / 0.1, nominal.shape), rtol=1e-5)
        area = (density * np.diff(edges)).sum(-1) + result["pressure_pdf_above"]
        np.testing.assert_allclose(area, result["pressure_pdf_contact"], rtol=1e-12)
        inside = result["pressure_pdf_above"] == 0.0
        load = (density * np.diff(edges) * sigma).sum(-1)
        assert (abs(load - nominal) <= 0.0126 * area)[inside].all()  # half a bin
        assert inside.any()
    bem = seen["main"]["bem"]
    np.testing.assert_array_equal(bem["pressure_pdf_contact"], bem["area_raw"])
    gap = bem["gap_pdf_separation"] * bem.attributes["rms_height"]
    np.testing.assert_allclose(gap, bem["separation"], rtol=1e-4, atol=1e-9)


def test_persson_stands_beside_them(spec: Spec, seen: Results) -> None:
    assert isinstance(spec.surface, SelfAffineSurface)
    spectrum = spec.surface.spectrum()
    for label in WITH_FIELDS:
        result = seen["main"][label]
        theory = persson_pressure_shares(2e-2, 0.1)
        np.testing.assert_allclose(result["pressure_pdf_persson"][1], theory, rtol=1e-12)
        assert ("stress_spectrum_persson" in result) == (label in ("bem", "winkler"))
    bem = seen["main"]["bem"]
    q, found = bem["stress_spectrum_bin"], bem["stress_spectrum_persson"]
    held = q > 1.0
    expected = persson_stress_spectrum(spectrum, q[held], 2e-2, 0.45)
    np.testing.assert_array_equal(found[1][held], expected)
    assert np.isnan(found[1][~held]).all()
    assert bem.attributes["persson_gamma"] == 0.45


def test_a_line_has_its_own_units(seen: Results) -> None:
    line, plane = seen["main"]["line"], seen["main"]["bem"]
    assert plane.units("stress_spectrum_mean") == "length^2"
    assert line.units("stress_spectrum_mean") == "length"
    assert plane.units("clusters_perimeter") == "length"
    assert line.units("clusters_perimeter") == "1"
    assert line.long_name("clusters_number_sem").endswith(
        "all sizes, standard error of the mean"
    )


def test_kept_fields_are_the_states_asked_for(seen: Results) -> None:
    for label in WITH_FIELDS:
        result = seen["main"][label]
        assert result["field_realization"].tolist() == [0, 0, 2, 2]
        assert result["field_nominal_pressure"].tolist() == [2e-3, 5.0, 2e-3, 5.0]
        assert result["field_status"].tolist() == [0] * 4
        for k, (r, p) in enumerate([(0, 2e-3), (0, 5.0), (2, 2e-3), (2, 5.0)]):
            sigma, gap = result["field_pressure"][k], result["field_gap"][k]
            assert sigma.mean() == pytest.approx(p, rel=1e-5)
            column = result["pressure"].tolist().index(p)
            separation = result["separation"][r, column]
            mean = gap[sigma == 0.0].sum() / gap.size
            assert mean == pytest.approx(separation, rel=1e-4, abs=1e-12)
            share = np.count_nonzero(sigma) / sigma.size
            assert share == result["pressure_pdf_contact"][r, column]
        if label != "line" and label != "foundation":
            assert result["y"].tolist() == result["x"].tolist()
        assert result["x"][1] * result.attributes["grid_points"] == pytest.approx(2 * np.pi)
    assert seen["main"]["bem"]["field_gap"].shape == (4, 64, 64)
    assert seen["main"]["foundation"]["field_gap"].shape == (4, 128)


def test_fields_of_springs_are_those_of_their_definition(spec: Spec, seen: Results) -> None:
    sample = make_sample(spec.surface, spec.models[3], 5, 2)
    assert sample.heights is not None
    assert sample.spectrum is not None
    modulus = matched_modulus(sample)
    field = of_springs(sample.heights, 2e-3, modulus, sample.length, sample.spectrum)
    found = seen["main"]["winkler"]
    np.testing.assert_allclose(
        found["field_pressure"][2], field.pressure, rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(found["field_gap"][2], field.gap, rtol=1e-9, atol=1e-12)


def test_xarray_opens_all_of_it(file: Path) -> None:
    for label, axes, shape in (("bem", ("y", "x"), (64, 64)), ("line", ("x",), (256,))):
        with xarray.open_dataset(file, group=f"main/{label}", engine="h5netcdf") as data:
            assert data["field_pressure"].dims == ("field", *axes)
            assert data["field_pressure"].shape == (4, *shape)
            assert data["clusters"].dims == ("realization", "pressure", "clusters_bin")
            assert data["clusters_mean"].dims == ("pressure", "clusters_bin")
            assert data["stress_spectrum_edges"].dims == ("stress_spectrum_edges",)
            near = data["stress_spectrum_mean"].sel(stress_spectrum_bin=8.0, method="nearest")
            assert near.shape == (3,)
            assert data["pressure_pdf"].attrs["units"] == "1"


def test_a_run_returns_what_the_file_holds(file: Path, seen: Results) -> None:
    again = rb.run(TREE, output=file, threads=1)  # from its shards
    for label, result in again["main"].items():
        assert list(result) == list(seen["main"][label])
        for name in result:
            np.testing.assert_array_equal(result[name], seen["main"][label][name])


def test_a_file_that_asks_for_nothing_is_of_the_first_version(
    file: Path, tmp_path: Path
) -> None:
    import h5py

    rb.run(NOTHING | {"models": [{"kind": "winkler"}]}, output=tmp_path / "plain.h5")
    for path, version in ((file, 2), (tmp_path / "plain.h5", 1)):
        with h5py.File(path) as data:
            assert data.attrs["format_version"] == version


# -- what they cost and change -------------------------------------------------------------


def test_to_look_changes_no_curve(seen: Results) -> None:
    plain = rb.run(NOTHING, threads=1)
    for label, result in plain["main"].items():
        for name in result:
            np.testing.assert_array_equal(result[name], seen["main"][label][name])
        assert ("clusters" in seen["main"][label]) == (label in WITH_FIELDS)
        assert not {"clusters", "field_gap"} & set(result)
        assert "dimension" not in result.attributes


def test_nobody_is_asked_for_fields_that_nobody_wants(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[float] = []
    real = halfspace_problem.Problem.fields

    def spy(problem: Any, solution: Any, load: float) -> Fields:
        taken.append(load)
        return real(problem, solution, load)

    monkeypatch.setattr(halfspace_problem.Problem, "fields", spy)
    rb.run(NOTHING | {"models": [{"kind": "bem"}]}, threads=1)
    assert not taken
    kept = {"pressures": [2e-2], "realizations": [1]}
    rb.run(NOTHING | {"models": [{"kind": "bem"}], "save_fields": kept}, threads=1)
    assert len(taken) == 1


@pytest.mark.parametrize("kind", MODELS)
def test_models_with_fields_are_those_that_hand_them_out(kind: str, spec: Spec) -> None:
    model: Model = MODELS[kind](kind=kind)
    sample = make_sample(spec.surface, model, 5, 0)
    assert model.has_fields == (kind in WITH_FIELDS)
    pressures = []
    for state in model.states(sample, np.array([1e-3, 1e-2])):
        pressures.append(state.pressure)
        assert (state.fields is not None) == model.has_fields
        if state.fields is not None:
            assert sample.heights is not None
            fields = state.fields()
            assert fields.pressure.shape == fields.gap.shape == sample.heights.shape
            assert (fields.pressure > 0).any()
    assert pressures == [1e-3, 1e-2]
    assert Winkler(heights="gaussian").has_fields is False


def test_memory_counts_what_is_kept() -> None:
    def of(tree: dict[str, Any]) -> int:
        cell = plan(load_spec(tree | {"models": [{"kind": "bem"}], "realizations": 1}))[0]
        return memory_of(Task(cell, range(1), cell.pressures))

    one = {"save_fields": {"pressures": [5.0]}}
    two = {"save_fields": {"pressures": [5.0, 2e-2]}}
    points = 64 * 64
    assert of(NOTHING | two) - of(NOTHING | one) == of(NOTHING | one) - of(NOTHING)
    assert of(NOTHING | one) - of(NOTHING) >= 16 * points
    assert of(NOTHING | {"observables": ["clusters"]}) > of(NOTHING)


# -- identity, resuming --------------------------------------------------------------------


def test_the_identity_of_others_is_blind_to_them(spec: Spec) -> None:
    plain = {str(c): identity(c, 1) for c in plan(load_spec(NOTHING))}
    kept = {k: v for k, v in TREE.items() if k != "observables"}
    for cell in plan(spec):
        own, before = identity(cell, 1), plain[str(cell)]
        if cell.model.name in WITH_FIELDS:
            assert own.keys() - before.keys() == {"observables"}
            assert str(own["observables"]).startswith("pressure_pdf, gap_pdf, stress_spec")
        else:
            assert own == before
    assert {str(c): identity(c, 1) for c in plan(load_spec(kept))} == plain
    turned = load_spec(TREE | {"observables": [*reversed(list(OBSERVABLES))]})
    assert identity(plan(turned)[0], 1) == identity(plan(spec)[0], 1)


def test_the_hash_of_a_spec_counts_them(spec: Spec) -> None:
    hashes = {
        load_spec(tree).sha256
        for tree in (
            TREE,
            NOTHING,
            TREE | {"observables": ["clusters"]},
            NOTHING | {"name": "n"},
        )
    }
    assert len(hashes) == 3
    assert load_spec(spec.text).observables == spec.observables


def test_other_observables_rerun_models_with_fields_only(
    tmp_path: Path, computed: list[str]
) -> None:
    output = tmp_path / "r.h5"
    rb.run(SMALL, output=output)
    more = SMALL | {"observables": ["clusters"]}
    parts = {part.model: part.reason for part in runner.preview(more, output=output)}
    assert parts["main/persson"] == "done"
    assert parts["main/bem"].startswith("changed: observables: pressure_pdf, gap_pdf, ")
    del computed[:]
    rb.run(more, output=output)
    assert computed == ["main/bem at 6"]
    rb.run(SMALL, output=output)  # and back
    assert computed == ["main/bem at 6"]


def test_other_fields_rerun_the_states_concerned_only(
    tmp_path: Path, computed: list[str]
) -> None:
    tree = NOTHING | {"models": [{"kind": "bem"}, {"kind": "winkler"}]}
    output = tmp_path / "r.h5"
    rb.run(tree, output=output, threads=1)
    asked = tree | {"save_fields": {"pressures": [2e-2], "realizations": [1]}}
    assert runner.status(output).state == "complete"
    del computed[:]
    results = rb.run(asked, output=output, threads=1)
    assert sorted(computed) == [
        "main/bem, realization 2 of 3 at 1",
        "main/winkler, realization 2 of 3 at 1",
    ]
    for result in results["main"].values():
        assert result["field_pressure"].mean() == pytest.approx(2e-2, rel=1e-5)
        assert result["field_realization"].tolist() == [1]
    fewer = rb.run(tree, output=output, threads=1)
    assert "field_gap" not in fewer["main"]["bem"]
    assert len(computed) == 2
    assert runner.verify(output) == (5, [])
    assert runner.clean(output, unused=True) == 0


class _Killed(Exception):  # noqa: N818
    """What a kill looks like from the inside."""


@pytest.mark.parametrize("after", [1, 3, 5])
def test_a_killed_run_resumes_to_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    """Killed after some states of the curve, with fields among them and after them."""
    monkeypatch.setattr(checkpoints, "SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(checkpoints, "COST", 1e9)
    whole, killed = tmp_path / "whole.h5", tmp_path / "killed.h5"
    rb.run(SMALL, output=whole, threads=1)

    def kill(news: runner.Progress) -> None:
        if news.done == after:
            raise _Killed

    with pytest.raises(_Killed):
        rb.run(SMALL, output=killed, threads=1, progress=kill)
    kept = list(killed.with_name("killed.h5.rbrun").glob("checkpoints/*.npz"))
    assert len(kept) == 1
    news: list[int] = []
    rb.run(SMALL, output=killed, threads=1, progress=lambda n: news.append(n.done))
    assert news[:2] == [0, after + 1]
    assert whole.read_bytes() == killed.read_bytes()
    # A checkpoint without the fields that are asked for by now is none.
    shutil.rmtree(killed.with_name("killed.h5.rbrun"))
    plain = {k: v for k, v in SMALL.items() if k != "save_fields"}
    with pytest.raises(_Killed):
        rb.run(plain, output=killed, threads=1, progress=kill)
    rb.run(SMALL, output=killed, threads=1)
    assert whole.read_bytes() == killed.read_bytes()


def test_any_number_of_jobs_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    rb.run(TREE, output=tmp_path / "jobs.h5", threads=1, jobs=2)
    assert (tmp_path / "jobs.h5").read_bytes() == file.read_bytes()


def test_only_some_realizations_come_together_again(file: Path, tmp_path: Path) -> None:
    output = tmp_path / "r.h5"
    for some in ("main/foundation:3", "main/bem:2"):
        with pytest.raises(rb.RoughbenchError, match="not written yet"):
            rb.run(TREE, output=output, threads=1, only=[some])
    rb.run(TREE, output=output, threads=1)
    assert output.read_bytes() == file.read_bytes()


# -- odd states ----------------------------------------------------------------------------


@pytest.fixture
def spoil(monkeypatch: pytest.MonkeyPatch) -> Callable[[Status, float], None]:
    """Return a callable that spoils all states past p/E* = 0.01."""

    def do(status: Status, value: float) -> None:
        real = HalfSpace.states

        def spoilt(state: State) -> State:
            assert state.fields is not None
            if state.pressure < 0.01:
                return state
            found = state.fields()
            bad = Fields(np.full_like(found.pressure, value), found.gap)
            return replace(state, status=status, fields=lambda: bad)

        def states(*arguments: Any, **options: Any) -> Iterator[State]:
            return map(spoilt, real(*arguments, **options))

        monkeypatch.setattr(HalfSpace, "states", states)

    return do


@pytest.mark.parametrize("value", [math.nan, 1.0])
def test_states_that_do_not_converge_say_nothing(
    spoil: Callable[[Status, float], None], value: float
) -> None:
    spoil(Status.STAGNATED, value)
    result = rb.run(TREE | {"models": [{"kind": "bem"}]}, threads=1)["main"]["bem"]
    assert result["n_converged"].tolist() == [3, 0, 0]
    for name in ("clusters", "clusters_number", "stress_spectrum_variance"):
        assert np.isfinite(result[name][:, 0]).all()
        assert np.isnan(result[name][:, 1:]).all()
        assert np.isfinite(result[f"{name}_mean"][0]).all()
        assert np.isnan(result[f"{name}_mean"][1:]).all()
        assert np.isnan(result[f"{name}_sem"][1:]).all()
    assert result["field_status"].tolist() == [0, 1, 0, 1]


def test_no_converged_state_still_has_bins(spoil: Callable[[Status, float], None]) -> None:
    spoil(Status.STAGNATED, math.nan)
    tree = TREE | {"models": [{"kind": "bem"}], "pressures": [2e-2, 5.0]}
    tree["save_fields"] = {"pressures": [2e-2]}
    result = rb.run(tree, threads=1)["main"]["bem"]
    for observable in OBSERVABLES.values():
        assert np.isnan(result[observable.variable]).all()
        assert np.isfinite(result[f"{observable.variable}_bin"]).all()


def test_a_converged_state_without_fields_is_an_error(
    spoil: Callable[[Status, float], None],
) -> None:
    spoil(Status.CONVERGED, -1.0)
    with pytest.raises(rb.SolverError, match=r"main/bem, realization 1 of 3: .*negative press"):
        rb.run(TREE | {"models": [{"kind": "bem"}]}, threads=1)


def test_heights_from_a_file_have_no_theory_beside_them(
    tmp_path: Path, rng: np.random.Generator
) -> None:
    np.save(tmp_path / "plane.npy", 0.05 * rng.normal(size=(32, 48)))
    tree = {
        "name": "measured",
        "surface": {"kind": "file", "path": str(tmp_path / "plane.npy"), "length": 1.0},
        "pressures": [0.5],
        "models": [{"kind": "winkler"}],
        "observables": ["pressure_pdf", "stress_spectrum"],
        "save_fields": {"pressures": [0.5]},
    }
    result: ModelResult = rb.run(tree)["main"]["winkler"]
    assert result["field_gap"].shape == (1, 32, 48)
    assert (result["y"][1], result["x"][-1]) == (1 / 32, 47 / 32)
    assert np.isnan(result["pressure_pdf_sem"]).all()
    unwanted = {"pressure_pdf_persson", "stress_spectrum_persson", "stress_spectrum_exponent"}
    assert not unwanted & set(result)
    assert "exponent_from" not in result.attributes


def test_a_pressure_of_a_range_needs_six_digits() -> None:
    tree = SMALL | {"pressures": {"min": 1e-3, "max": 1e-1, "points": 4}}
    kept = load_spec(tree | {"save_fields": {"pressures": [4.641589e-3, 0.1]}})
    assert kept.kept_pressures == (kept.pressures[1], kept.pressures[3])
    with pytest.raises(rb.SpecError, match=r"0\.00464 is none .* nearest, 0\.00464158883"):
        load_spec(tree | {"save_fields": {"pressures": [4.64e-3]}})
