"""Valid specs: what they resolve to, their hash, sweeps, overrides, round trips."""

from __future__ import annotations

import hashlib
import math
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from roughbench.errors import Fault, SpecError
from roughbench.models.foundation import Foundation
from roughbench.models.halfspace import HalfSpace
from roughbench.models.persson import Persson
from roughbench.spec import FileSurface, SelfAffineSurface, Spec, load_spec
from roughbench.spec.yaml12 import dump

MINIMAL: dict[str, Any] = {
    "surface": {"H": 0.7, "q0": 2, "q1": 16, "slope": 0.1},
    "pressures": [0.1],
    "models": [{"kind": "bem"}, {"kind": "foundation"}, {"kind": "persson"}],
}


def self_affine(spec: Spec) -> SelfAffineSurface:
    assert isinstance(spec.surface, SelfAffineSurface)
    return spec.surface


def test_the_contracts_example_reads_as_written(valid: str) -> None:
    spec = load_spec(valid)
    surface = self_affine(spec)
    assert (spec.name, spec.realizations, spec.seed) == ("rolloff8", 10, 2013)
    assert (surface.hurst, surface.q_min, surface.q_rolloff, surface.q_max) == (0.7, 1, 8, 128)
    assert (surface.rms_slope, surface.rms_height) == (0.1, None)
    bem, foundation, persson = spec.models
    assert isinstance(bem, HalfSpace)
    assert (bem.grid, bem.tolerance, bem.realizations, bem.name) == (512, 1e-6, None, "bem")
    assert isinstance(foundation, Foundation)
    assert (foundation.springs, foundation.realizations) == (8192, 100)
    assert isinstance(persson, Persson)
    assert (persson.gamma, persson.finite_size) == (0.45, "none")
    assert spec.text == valid


def test_defaults_are_those_of_the_contract() -> None:
    spec = load_spec(MINIMAL)
    surface = self_affine(spec)
    assert (spec.name, spec.realizations, spec.seed) == ("spec", 1, 0)
    assert (surface.kind, surface.below_rolloff, surface.amplitude) == (
        "self-affine",
        "rolloff",
        "fixed",
    )
    assert surface.q_rolloff == 2.0
    assert surface.length == 2.0 * math.pi / 2.0
    bem, foundation, persson = spec.models
    assert isinstance(bem, HalfSpace)
    assert bem.tolerance == 1e-6
    assert isinstance(foundation, Foundation)
    assert (foundation.springs, foundation.undersampled) == (8192, "error")
    assert isinstance(persson, Persson)
    assert (persson.gamma, persson.finite_size) == (0.45, "none")


def test_integers_are_taken_for_floats() -> None:
    surface = self_affine(load_spec(MINIMAL))
    assert type(surface.q_min) is float
    assert type(surface.q_max) is float


def test_the_spectrum_of_the_surface() -> None:
    spectrum = self_affine(load_spec(MINIMAL)).spectrum()
    assert spectrum.rms_slope == pytest.approx(0.1, rel=1e-14)
    assert (spectrum.q_min, spectrum.q_max, spectrum.hurst) == (2.0, 16.0, 0.7)
    tall = MINIMAL["surface"] | {"slope": None, "rms_height": 0.3}
    spectrum = self_affine(load_spec(MINIMAL | {"surface": tall})).spectrum()
    assert spectrum.rms_height == pytest.approx(0.3, rel=1e-14)


def test_surfaces_can_be_made_in_python() -> None:
    surface = SelfAffineSurface(H=0.7, q0=2.0, q1=16.0, slope=0.1)
    assert surface == load_spec(MINIMAL).surface
    assert FileSurface(kind="file", path="h.npy", length=1.0).file == Path("h.npy")


def test_a_length_of_one_wave_may_be_rounded() -> None:
    surface = MINIMAL["surface"] | {"q0": 1, "length": 6.283185307}
    assert self_affine(load_spec(MINIMAL | {"surface": surface})).length == 6.283185307


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ({"min": 0.001, "max": 0.1, "points": 3}, (0.001, 0.01, 0.1)),
        ({"min": 1, "max": 3, "points": 3, "spacing": "linear"}, (1.0, 2.0, 3.0)),
        ([0.3, 0.1, 0.2], (0.1, 0.2, 0.3)),
        ([1], (1.0,)),
        (np.array([2e-3, 1e-3]), (1e-3, 2e-3)),
        ((np.float32(0.5), np.int64(2)), (0.5, 2.0)),
    ],
)
def test_pressures_come_ascending(given: object, values: tuple[float, ...]) -> None:
    pressures = load_spec(MINIMAL | {"pressures": given}).pressures
    assert pressures == pytest.approx(values, rel=1e-15)
    assert all(type(p) is float for p in pressures)


def test_the_ends_of_a_range_are_exact(valid: str) -> None:
    pressures = load_spec(valid).pressures
    assert (len(pressures), pressures[0], pressures[-1]) == (20, 1e-5, 0.2)


def test_specs_are_frozen(valid: str) -> None:
    spec = load_spec(valid)
    with pytest.raises(ValidationError, match="frozen"):
        spec.seed = 1
    with pytest.raises(ValidationError, match="frozen"):
        self_affine(spec).hurst = 0.8


def test_labels_tell_models_of_one_kind_apart() -> None:
    models = [{"kind": "persson"}, {"kind": "persson", "label": "gamma-1", "gamma": 1}]
    spec = load_spec(MINIMAL | {"models": models})
    assert [model.name for model in spec.models] == ["persson", "gamma-1"]


def test_specs_survive_pickling(valid: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(valid + "sweep: {surface.qr: [1, 8]}\n")
    spec = load_spec(path)
    again = pickle.loads(pickle.dumps(spec))  # noqa: S301
    assert again == spec
    assert again.text == spec.text
    assert [name for name, _ in again.experiments()] == ["surface.qr=1.0", "surface.qr=8.0"]


class TestSources:
    def test_a_file_names_its_spec(self, tmp_path: Path) -> None:
        path = tmp_path / "my spec.v2.yaml"
        path.write_text(dump(MINIMAL))
        assert load_spec(path).name == "my_spec.v2"
        assert load_spec(str(path)) == load_spec(MINIMAL)
        hidden = tmp_path / "_.yaml"
        hidden.write_text(dump(MINIMAL))
        assert load_spec(hidden).name == "spec"

    def test_a_byte_order_mark_is_no_fault(self, tmp_path: Path) -> None:
        path = tmp_path / "bom.yaml"
        path.write_bytes(b"\xef\xbb\xbf" + dump(MINIMAL).encode())
        assert load_spec(path) == load_spec(MINIMAL)

    def test_text_in_one_line(self) -> None:
        text = (
            "{surface: {H: 0.7, q0: 1, q1: 9, slope: 1}, pressures: [1], models: [{kind: bem}]}"
        )
        assert self_affine(load_spec(text)).q_max == 9.0

    def test_a_spec_passes_through(self, valid: str) -> None:
        spec = load_spec(valid)
        assert load_spec(spec) is spec
        assert load_spec(spec, ["seed=3"]).seed == 3
        assert spec.seed == 2013

    def test_heights_are_found_from_the_folder_of_the_spec(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        folder = tmp_path / "inner"
        folder.mkdir()
        np.save(folder / "h.npy", np.zeros((4, 4)))
        np.save(tmp_path / "g.npy", np.zeros((4, 4)))
        (folder / "a.h5").touch()
        text = dump(MINIMAL | {"surface": {"kind": "file", "path": "h.npy", "length": 1}})
        (folder / "a.yaml").write_text(text)
        spec = load_spec(folder / "a.yaml")
        assert isinstance(spec.surface, FileSurface)
        assert (spec.surface.folder, spec.surface.path) == (folder, "h.npy")
        assert spec.surface.file == folder / "h.npy"
        again = pickle.loads(pickle.dumps(load_spec(spec, ["seed=1"])))  # noqa: S301
        assert again.surface.file == folder / "h.npy"
        for path, file in (
            (tmp_path / "g.npy", tmp_path / "g.npy"),
            ("a.h5:/x/y", folder / "a.h5"),
        ):
            other = load_spec(folder / "a.yaml", [f"surface.path='{path}'"]).surface
            assert isinstance(other, FileSurface)
            assert other.file == file
        monkeypatch.chdir(tmp_path)
        with pytest.raises(SpecError, match=r"^spec:1:29: .*: no such file: h\.npy$"):
            load_spec(text)

    def test_a_sweep_over_files_keeps_the_folder(self, tmp_path: Path) -> None:
        for name in ("a", "b"):
            np.save(tmp_path / f"{name}.npy", np.zeros((4, 4)))
        surface = {"kind": "file", "path": "a.npy", "length": 1}
        sweep = {"surface.path": ["a.npy", "b.npy"]}
        (tmp_path / "s.yaml").write_text(dump(MINIMAL | {"surface": surface, "sweep": sweep}))
        experiments = load_spec(tmp_path / "s.yaml").experiments()
        files = [e.surface.file for _, e in experiments if isinstance(e.surface, FileSurface)]
        assert files == [tmp_path / "a.npy", tmp_path / "b.npy"]

    def test_python_objects_that_mean_the_same(self, tmp_path: Path) -> None:
        np.save(tmp_path / "h.npy", np.zeros((4, 4)))
        surface = {"kind": "file", "path": tmp_path / "h.npy", "length": np.float64(1)}
        spec = load_spec(MINIMAL | {"surface": surface, "seed": np.uint8(3)})
        assert isinstance(spec.surface, FileSurface)
        assert (spec.surface.file, spec.seed) == (tmp_path / "h.npy", 3)
        with pytest.raises(SpecError, match="seed: must be an integer, got true"):
            load_spec(MINIMAL | {"seed": np.True_})


class TestHash:
    def test_formatting_order_and_written_defaults_do_not_count(self) -> None:
        tree = MINIMAL
        surface = {"slope": 0.1, "q1": 16.0, "qr": 2, "q0": 2, "H": 0.7, "length": math.pi}
        other = {
            "seed": 0,
            "models": [
                {"tolerance": 1e-6, "kind": "bem"},
                {"kind": "foundation", "springs": 8192},
                {"gamma": 0.45, "kind": "persson"},
            ],
            "pressures": [1e-1],
            "surface": surface,
            "name": "other",
        }
        one, two = load_spec(tree), load_spec("# a comment\n" + dump(other))
        assert one.sha256 == two.sha256
        assert one == two
        assert hash(one) == hash(two)

    @pytest.mark.parametrize(
        "override",
        [
            "surface.H=0.8",
            "surface.qr=3",
            "surface.below_qr=cutoff",
            "pressures=[0.2]",
            "realizations=2",
            "seed=1",
            "models.bem.grid=64",
            "models.bem.realizations=3",
            "models.persson.label=theory",
            "sweep.seed=[0]",
        ],
    )
    def test_everything_that_is_computed_counts(self, override: str) -> None:
        spec = load_spec(MINIMAL)
        changed = load_spec(MINIMAL, [override])
        assert changed.sha256 != spec.sha256
        assert changed != spec

    def test_values_in_a_sweep_count_as_what_they_mean(self) -> None:
        one = load_spec(MINIMAL | {"sweep": {"surface.qr": [2, 8]}})
        two = load_spec(MINIMAL | {"sweep": {"surface.qr": [2.0, 8.0]}})
        assert one.sha256 == two.sha256
        assert one != 3

    def test_it_is_that_of_the_canonical_json(self) -> None:
        # The identity of stored results: a change of its form makes all of them foreign.
        models = [{"kind": "persson"}]
        spec = load_spec(
            MINIMAL | {"surface": MINIMAL["surface"] | {"q0": 1}, "models": models}
        )
        canonical = (
            '{"main":{"models":[{"finite_size":"none","gamma":0.45,"kind":"persson","m":2.0,'
            '"theta":1.0}],"pressures":[0.1],"realizations":1,"seed":0,"surface":{"H":0.7,'
            '"amplitude":"fixed","below_qr":"rolloff","kind":"self-affine",'
            '"length":6.283185307179586,"q0":1.0,"q1":16.0,"qr":1.0,"slope":0.1}}}'
        )
        assert spec.sha256 == hashlib.sha256(canonical.encode()).hexdigest()


class TestSweep:
    def test_none_is_one_experiment(self, valid: str) -> None:
        spec = load_spec(valid)
        assert spec.experiments() == [("main", spec)]

    def test_every_combination_in_the_order_written(self, valid: str) -> None:
        sweep = "sweep: {surface.qr: [8, 1], models.persson.gamma: [0.33, 1]}\n"
        experiments = load_spec(valid + sweep).experiments()
        assert [name for name, _ in experiments] == [
            "surface.qr=8.0,models.persson.gamma=0.33",
            "surface.qr=8.0,models.persson.gamma=1.0",
            "surface.qr=1.0,models.persson.gamma=0.33",
            "surface.qr=1.0,models.persson.gamma=1.0",
        ]
        for (name, spec), (q, gamma) in zip(
            experiments, [(8, 0.33), (8, 1), (1, 0.33), (1, 1)], strict=True
        ):
            model = spec.models[2]
            assert isinstance(model, Persson)
            assert (self_affine(spec).q_rolloff, model.gamma) == (q, gamma)
            assert spec.sweep == {}
            assert (spec.name, spec.seed) == ("rolloff8", 2013)
            assert spec.experiments()[0] == ("main", spec), name

    def test_defaults_follow_the_swept_values(self) -> None:
        spec = load_spec(MINIMAL | {"sweep": {"surface.q0": [1, 2]}})
        lengths = [self_affine(one).length for _, one in spec.experiments()]
        assert lengths == [2 * math.pi, math.pi]

    def test_models_by_number_and_by_label_with_dots(self) -> None:
        models = [{"kind": "persson", "label": "p"}, {"kind": "persson", "label": "p.gamma"}]
        sweep = {"models[0].gamma": [0.5], "models.p.gamma.gamma": [0.6], "seed": [1, 2]}
        (name, spec), _ = load_spec(MINIMAL | {"models": models, "sweep": sweep}).experiments()
        assert name == "models[0].gamma=0.5,models.p.gamma.gamma=0.6,seed=1"
        gammas = [model.gamma for model in spec.models if isinstance(model, Persson)]
        assert gammas == [0.5, 0.6]

    def test_names_are_safe_and_differ(self, tmp_path: Path) -> None:
        surface = {"kind": "file", "path": "a/b.npy", "length": 1}
        paths = ["a/b.npy", "a b.npy", "a_b.npy", "a.h5:/b c"]
        (tmp_path / "a").mkdir()
        for file in ("a/b.npy", "a b.npy", "a_b.npy", "a.h5"):
            (tmp_path / file).touch()
        (tmp_path / "s.yaml").write_text(
            dump(MINIMAL | {"surface": surface, "sweep": {"surface.path": paths}})
        )
        assert [name for name, _ in load_spec(tmp_path / "s.yaml").experiments()] == [
            "surface.path=a_b.npy",
            "surface.path=a_b.npy_2",
            "surface.path=a_b.npy_3",
            "surface.path=a.h5__b_c",
        ]

    def test_a_default_may_be_swept_to(self) -> None:
        spec = load_spec(MINIMAL | {"sweep": {"models.bem.grid": [None, 64]}})
        assert [name for name, _ in spec.experiments()] == [
            "models.bem.grid=null",
            "models.bem.grid=64",
        ]


class TestOverrides:
    def test_values_are_yaml(self, valid: str) -> None:
        spec = load_spec(
            valid,
            [
                "surface.H=0.8",
                "surface.q1=1e2",
                "pressures=[0.2, 1e-3]",
                "models.bem.grid=600",
                "models[2].label=theory",
                "models.theory.finite_size=max",
                "sweep.surface.qr=[1, 8]",
            ],
        )
        bem, _, persson = spec.models
        assert isinstance(bem, HalfSpace)
        assert isinstance(persson, Persson)
        assert (self_affine(spec).hurst, self_affine(spec).q_max, bem.grid) == (0.8, 100, 600)
        assert spec.pressures == (1e-3, 0.2)
        assert (persson.name, persson.finite_size) == ("theory", "max")
        assert len(spec.experiments()) == 2

    def test_null_takes_a_value_back(self, valid: str) -> None:
        spec = load_spec(
            valid, ["surface.slope=null", "surface.rms_height=1", "models.bem.grid="]
        )
        bem = spec.models[0]
        assert isinstance(bem, HalfSpace)
        assert (self_affine(spec).rms_slope, bem.grid) == (None, None)

    def test_the_text_says_what_was_overridden(self, valid: str) -> None:
        spec = load_spec(valid, ["surface.H=0.8", "pressures.points=5"])
        assert "H: 0.8" in spec.text
        assert load_spec(spec.text) == spec

    def test_a_whole_model_can_be_replaced(self, valid: str) -> None:
        spec = load_spec(valid, ["models.bem={kind: persson, label: old, gamma: 1}"])
        assert [model.name for model in spec.models] == ["old", "foundation", "persson"]

    def test_a_sweep_can_be_dropped(self, valid: str) -> None:
        spec = load_spec(valid + "sweep: {surface.qr: [1, 8]}\n", ["sweep={}", "surface.qr=2"])
        assert spec.experiments() == [("main", spec)]
        assert self_affine(spec).q_rolloff == 2


def test_loading_a_spec_imports_nothing_heavy() -> None:
    program = (
        "import sys, roughbench.spec as s; s.json_schema();"
        "s.load_spec('{surface: {H: 0.7, q0: 1, q1: 9, slope: 1}, pressures: [1],"
        " models: [{kind: bem}, {kind: foundation}, {kind: persson}]}');"
        "print(*sorted({'numba', 'scipy', 'matplotlib', 'pyfftw', 'h5py'} & {*sys.modules}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "\n"


positive = st.floats(1e-3, 1e3)


@st.composite
def specs(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the tree of a valid spec."""
    q0 = draw(positive)
    qr = q0 * draw(st.floats(1, 4))
    q1 = qr * draw(st.floats(1.1, 8))
    surface: dict[str, Any] = {"H": draw(st.floats(0.01, 0.99)), "q0": q0, "q1": q1}
    surface[draw(st.sampled_from(["slope", "rms_height"]))] = draw(positive)
    optional = {
        "kind": st.just("self-affine"),
        "qr": st.just(qr),
        "length": st.floats(1.0, 3.0).map(lambda n: n * 2 * math.pi / q0),
        "below_qr": st.sampled_from(["rolloff", "cutoff"]),
        "amplitude": st.sampled_from(["fixed", "gaussian"]),
    }
    surface |= draw(st.fixed_dictionaries({}, optional=optional))
    low = draw(positive)
    high = low * draw(st.floats(1.5, 1e3))
    ends = {"min": low, "max": high, "points": draw(st.integers(2, 9))}
    spacing = draw(st.sampled_from([{}, {"spacing": "log"}, {"spacing": "linear"}]))
    pressures = draw(
        st.just(ends | spacing) | st.lists(positive, min_size=1, max_size=5, unique=True)
    )
    labels = st.from_regex(r"\A[A-Za-z0-9][A-Za-z0-9_.+-]{0,8}\Z")
    kind = st.sampled_from(["bem", "foundation", "persson"])
    kinds = draw(st.lists(kind, min_size=1, max_size=4))
    names = draw(st.lists(labels, min_size=len(kinds), max_size=len(kinds), unique=True))
    models = [{"kind": kind, "label": name} for kind, name in zip(kinds, names, strict=True)]
    tree = {"surface": surface, "pressures": pressures, "models": models}
    counts = {
        "name": labels,
        "realizations": st.integers(1, 1000),
        "seed": st.integers(0, 2**63 - 1),
        "sweep": st.fixed_dictionaries(
            {},
            optional={
                "seed": st.lists(st.integers(0, 99), min_size=1, max_size=3, unique=True)
            },
        ),
    }
    return tree | draw(st.fixed_dictionaries({}, optional=counts))


@settings(deadline=None)  # speed is measured, not asserted: other programs run beside the tests
@given(specs())
def test_valid_specs_make_the_round_trip(tree: dict[str, Any]) -> None:
    spec = load_spec(tree)
    for again in (load_spec(spec.text), load_spec(dump(tree)), load_spec(spec.as_given())):
        assert again == spec
        assert again.sha256 == spec.sha256
        assert again.name == spec.name
        assert again.pressures == spec.pressures
        assert again.text == spec.text or again.text == dump(tree)


WORDS = """
name surface pressures realizations seed models sweep kind H q0 qr q1 slope rms_height below_qr
amplitude length path min max points spacing grid tolerance springs gamma theta m finite_size
label surface.qr models[0].gamma models.bem.grid self-affine file bem foundation persson log
none heights.npy x
"""
KEYS = st.sampled_from(WORDS.split())
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 600)
    | st.floats(allow_nan=False, allow_infinity=False)
    | KEYS,
    lambda node: st.lists(node, max_size=4) | st.dictionaries(KEYS, node, max_size=6),
    max_leaves=25,
)


@given(st.dictionaries(KEYS, VALUES, max_size=7), st.lists(st.tuples(KEYS, VALUES), max_size=2))
def test_nothing_but_spec_errors_for_any_tree(
    tree: dict[str, Any], overrides: list[tuple[str, Any]]
) -> None:
    told(dump(MINIMAL | tree), [f"{key}={value!r}" for key, value in overrides])


@given(specs(), st.data())
def test_nothing_but_spec_errors_for_spoilt_specs(
    tree: dict[str, Any], data: st.DataObject
) -> None:
    for part in (tree, tree["surface"], tree["models"][0]):
        if data.draw(st.booleans()):
            part[data.draw(KEYS)] = data.draw(VALUES)
    told(dump(tree), [])


@given(st.text(), st.lists(st.text(), max_size=2))
def test_nothing_but_spec_errors_for_any_text(text: str, overrides: list[str]) -> None:
    told(text + "\n", overrides)
    told(dump(MINIMAL) + text, overrides)


@given(st.text().filter(lambda text: len(text) > 3))
def test_nothing_but_spec_errors_for_any_file_name(text: str) -> None:
    told(text, [])


def told(source: str, overrides: list[str]) -> None:
    faults: tuple[Fault, ...] = ()
    try:
        load_spec(source, overrides)
    except SpecError as error:
        faults = error.faults
        assert faults, "an error without faults"
    for fault in faults:
        assert fault.message
        assert len(str(fault).splitlines()) == 1
