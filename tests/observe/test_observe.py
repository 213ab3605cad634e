"""Observables of a spec: every state once, averages of them, files."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.errors import SpecError, StoreError, SurfaceError
from roughbench.models.base import Sample, Status
from roughbench.models.foundation import foundation_curve
from roughbench.models.persson import Persson
from roughbench.models.winkler import Winkler
from roughbench.observables import (
    OBSERVABLES,
    average,
    of_state,
    persson_pressure_shares,
    persson_stress_spectrum,
)
from roughbench.observe import Observations, has_field, observe, solve_field, write_observations
from roughbench.runner.samples import make_sample
from roughbench.spec import SelfAffineSurface, Spec, load_spec

TREE: dict[str, Any] = {
    "name": "seen",
    "surface": {"H": 0.7, "q0": 1.0, "qr": 2.0, "q1": 16.0, "slope": 0.1},
    "pressures": [2e-3, 2e-2],
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
    "save_fields": {"pressures": [2e-3, 5e-3], "realizations": [0, 7]},
}


@pytest.fixture(scope="module")
def spec() -> Spec:
    return load_spec(TREE)


@pytest.fixture(scope="module")
def seen(spec: Spec) -> Observations:
    calls: list[tuple[int, int]] = []
    found = observe(spec, told=lambda done, total: calls.append((done, total)))
    total = calls[-1][1]
    assert calls == [(k, total) for k in range(1, total + 1)]
    # Each model: its realizations at 2 pressures, one more pressure and one more of both.
    assert total == 3 * (3 * 2 + 1 + 2) + (4 * 2 + 1 + 2)
    return found


def test_averages_are_those_of_the_states(spec: Spec, seen: Observations) -> None:
    assert isinstance(spec.surface, SelfAffineSurface)
    spectrum, side = spec.surface.spectrum(), spec.surface.length
    states = []
    for r in range(3):
        heights = make_sample(spec.surface, spec.models[0], 5, r).heights
        assert heights is not None
        states.append(
            of_state(rb.solve_contact(heights, 2e-2, length=side, threads=1), side, spectrum)
        )
    bem = seen.experiments["main"]["bem"]
    assert (bem.count, list(bem.unconverged), bem.pressures) == (3, [0, 0], (2e-3, 2e-2))
    for name, observable in OBSERVABLES.items():
        expected = average([observable(state) for state in states])
        found = bem.averages[name][1]
        assert found is not None
        np.testing.assert_array_equal(found.mean, expected.mean)
        np.testing.assert_array_equal(found.sem, expected.sem)
        assert found.scalars == expected.scalars
    theory = persson_pressure_shares(2e-2, 0.1)
    np.testing.assert_allclose(bem.persson["pressure_pdf"][1], theory, rtol=1e-12)
    places = bem.averages["stress_spectrum"][1]
    assert places is not None
    held = np.flatnonzero(places.places > 1.0)
    np.testing.assert_array_equal(
        bem.persson["stress_spectrum"][1][held],
        persson_stress_spectrum(spectrum, places.places[held], 2e-2),
    )
    assert bem.wavevectors == (4.0, 8.0)


def test_every_model_with_a_field_carries_its_load(seen: Observations) -> None:
    models = seen.experiments["main"]
    assert list(models) == ["bem", "line", "foundation", "winkler"]
    assert seen.without_fields == ["main/gaussian", "main/persson"]
    for model in models.values():
        columns = model.averages["pressure_pdf"]
        for pressure, column in zip(model.pressures, columns, strict=True):
            assert column is not None
            assert column.scalars["mean"][0] == pytest.approx(pressure / 0.1, rel=1e-5)
            assert column.count == model.count
    # Lines have a spectrum of their own kind, without Persson's of the surface beside it.
    assert "stress_spectrum" not in models["line"].persson
    assert "pressure_pdf" in models["line"].persson


def test_fields_of_springs_are_those_of_their_curves(spec: Spec) -> None:
    line = make_sample(spec.surface, spec.models[2], 5, 0)
    assert line.heights is not None
    assert line.spectrum is not None
    for p in (1e-4, 1e-3, 1e-2):
        field, status = solve_field(spec.models[2], line, p, line.spectrum)
        curve = foundation_curve(line.heights, [p], line.length)
        assert status is Status.CONVERGED
        assert field.contact.sum() == curve.diagnostics["springs_in_contact"][0]
        assert field.nominal == pytest.approx(p, rel=1e-12)
        assert field.gap.mean() == pytest.approx(curve.separation[0], abs=1e-16)


def test_saved_states_are_those_asked_for(seen: Observations) -> None:
    places = [(s.label, s.realization, s.pressure) for s in seen.saved]
    assert places == [
        (label, r, p)
        for label in ("bem", "line", "foundation", "winkler")
        for r in (0, 7)
        for p in (2e-3, 5e-3)
    ]
    for saved in seen.saved:
        assert saved.status is Status.CONVERGED
        assert saved.state.nominal == pytest.approx(saved.pressure, rel=1e-5)


def test_files_hold_all_of_it(seen: Observations, tmp_path: Path) -> None:
    paths = write_observations(seen, tmp_path / "new" / "folder")
    assert all(path.is_file() for path in paths)

    def refuse(name: str) -> float:
        raise AssertionError(f"{name} is no JSON")

    content = json.loads(paths[0].read_text(), parse_constant=refuse)
    assert content["spec_sha256"] == seen.spec_sha256
    for label, model in seen.experiments["main"].items():
        written = content["experiments"]["main"][label]
        assert written["pressures"] == list(model.pressures)
        assert list(written["observables"]) == list(OBSERVABLES)
        for name, columns in model.averages.items():
            for k, column in enumerate(columns):
                assert column is not None
                values = written["observables"][name]["mean"][k]
                expected = [None if math.isnan(x) else x for x in column.mean.tolist()]
                assert values == expected
        assert len(written["observables"]["stress_spectrum"]["exponent"]["mean"]) == 2
    with np.load(tmp_path / "new/folder/main-bem-realization7-p0.005.npz") as field:
        saved = next(s for s in seen.saved if (s.label, s.realization) == ("bem", 7))
        assert saved.pressure == 2e-3
        assert field["pressure"].shape == field["gap"].shape == (64, 64)
        assert float(field["nominal_pressure"]) == 5e-3
        assert float(field["pressure"].mean()) == pytest.approx(5e-3, rel=1e-5)
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="cannot make the folder"):
        write_observations(seen, tmp_path / "file" / "below")


def test_fields_alone_need_no_ensemble() -> None:
    tree = {key: value for key, value in TREE.items() if key != "observables"}
    found = observe(load_spec(tree | {"models": [{"kind": "winkler"}]}))
    assert len(found.saved) == 4
    assert found.experiments == {"main": {}}


def test_heights_from_a_file_have_one_realization(
    tmp_path: Path, rng: np.random.Generator
) -> None:
    np.save(tmp_path / "plane.npy", rng.normal(size=(32, 32)))
    tree = {
        "name": "measured",
        "surface": {"kind": "file", "path": str(tmp_path / "plane.npy"), "length": 1.0},
        "pressures": [0.5],
        "models": [{"kind": "winkler"}],
        "observables": ["pressure_pdf", "stress_spectrum"],
        "save_fields": {"pressures": [0.5], "realizations": [0]},
    }
    found = observe(load_spec(tree))
    model = found.experiments["main"]["winkler"]
    assert model.count == 1
    assert model.persson == {}
    assert model.wavevectors is None
    assert len(found.saved) == 1


def test_states_that_do_not_converge_are_counted_and_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from roughbench.observe import driver

    solve = driver.solve_field

    def fail_sometimes(model: Any, sample: Sample, pressure: float, *rest: Any) -> Any:
        field, _ = solve(model, sample, pressure, *rest)
        return field, Status.STAGNATED if pressure > 0.01 else Status.CONVERGED

    monkeypatch.setattr(driver, "solve_field", fail_sometimes)
    found = observe(load_spec(TREE | {"models": [{"kind": "winkler"}]}))
    model = found.experiments["main"]["winkler"]
    assert list(model.unconverged) == [0, 3]
    assert model.averages["clusters"][1] is None
    assert model.averages["clusters"][0] is not None
    assert math.isnan(model.exponents["stress_spectrum"][1][0])


def test_refuses_what_has_no_field(spec: Spec) -> None:
    assert [has_field(model) for model in spec.models] == [True] * 4 + [False] * 2
    with pytest.raises(SurfaceError, match="has no field"):
        solve_field(Persson(), Sample(None, 1.0), 1.0, spec.surface.spectrum())  # type: ignore[union-attr]
    with pytest.raises(SurfaceError, match="has no field"):
        solve_field(Winkler(), Sample(None, 1.0), 1.0, spec.surface.spectrum())  # type: ignore[union-attr]
    nothing = {k: v for k, v in TREE.items() if k not in ("observables", "save_fields")}
    with pytest.raises(SpecError, match="asks for nothing of the fields"):
        observe(load_spec(nothing))


def test_what_is_asked_of_fields_does_not_change_the_curves_identity(spec: Spec) -> None:
    nothing = {k: v for k, v in TREE.items() if k not in ("observables", "save_fields")}
    assert load_spec(nothing).sha256 == spec.sha256
    assert load_spec(spec.text).observables == spec.observables
