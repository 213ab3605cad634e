"""Models of installed packages: found by entry points, imported when they are asked for."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import roughbench as rb
from roughbench.models import BUILT_IN, MODELS
from roughbench.models.registry import Catalog, checked, declared, kind_of, kinds
from roughbench.rundir import identity
from roughbench.spec import json_schema
from tests.models.outside import THEORY, install, spec_of, write_theory


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a folder of installed packages, where Python looks."""
    monkeypatch.syspath_prepend(str(tmp_path))
    forget()
    yield tmp_path
    monkeypatch.undo()
    for name in ("mytheory", "helper", "theories", "theories.one", "theories.shared"):
        sys.modules.pop(name, None)
    forget()


def forget() -> None:
    MODELS.look_again()
    declared.cache_clear()


@pytest.mark.parametrize("kind", BUILT_IN)
def test_built_in_models_use_the_same_door(kind: str) -> None:
    model = MODELS[kind]
    assert checked(model, "here") is model
    assert kind_of(model) == kind
    assert (Path(rb.__file__).parents[1] / model.page).is_file()
    assert model.style.colour


def test_an_installed_model_is_one_of_them(site: Path) -> None:
    write_theory(site)
    install(site, "mypackage", "erf09 = mytheory:Erf09")
    assert list(MODELS) == [*BUILT_IN, "erf09"]
    assert "mytheory" not in sys.modules
    results = rb.run(spec_of({"kind": "erf09", "factor": 0.5}, {"kind": "persson"}))
    result = results["main"]["erf09"]
    assert (result.kind, result.title) == ("erf09", "Erf 0.9")
    assert result.attributes["source"] == "mytheory:Erf09"
    assert "source" not in results["main"]["persson"].attributes
    assert "Erf09" in json_schema()["$defs"]
    with pytest.raises(
        rb.SpecError, match=r"models\[0\]\.factr: unknown key \(did you mean 'f"
    ):
        rb.load_spec(spec_of({"kind": "erf09", "factr": 0.5}))
    with pytest.raises(rb.SpecError, match=r"unknown kind 'erf9' \(did you mean 'erf09'"):
        rb.load_spec(spec_of({"kind": "erf9"}))


def test_a_package_that_cannot_be_imported_hurts_nobody_else(site: Path) -> None:
    (site / "mytheory.py").write_text("import nothing_of_this_name\n")
    install(site, "mypackage", "erf09 = mytheory:Erf09")
    rb.load_spec(spec_of({"kind": "persson"}))
    json_schema()
    with pytest.raises(rb.SpecError, match=r"did you mean 'erf09'"):
        rb.load_spec(spec_of({"kind": "erf08"}))
    with pytest.raises(
        rb.SpecError,
        match=r"models\[0\]\.kind: mypackage \(mytheory:Erf09\), declared as 'erf0",
    ) as e:
        rb.load_spec(spec_of({"kind": "erf09"}))
    assert "in roughbench.models, cannot be loaded (ModuleNotFoundError: " in str(e.value)


def test_two_owners_of_a_kind_are_both_named(site: Path) -> None:
    write_theory(site)
    install(site, "one", "erf09 = mytheory:Erf09", "bem = mytheory:Erf09")
    install(site, "two", "erf09 = helper:Erf09")
    assert len(kinds()) == len(BUILT_IN) + 1
    with pytest.raises(
        rb.SpecError, match=r"two \(helper:Erf09\) and one \(mytheory:Erf09\) both decl"
    ):
        rb.load_spec(spec_of({"kind": "erf09"}))
    with pytest.raises(
        rb.SpecError, match=r"roughbench \(.*\) and one \(mytheory:Erf09\) both declare 'bem'"
    ):
        rb.load_spec(spec_of({"kind": "bem"}))
    rb.load_spec(spec_of({"kind": "persson"}))


def test_an_entry_point_of_another_kind(site: Path) -> None:
    write_theory(site)
    install(site, "one", "erf = mytheory:Erf09")
    with pytest.raises(
        rb.SpecError, match=r"declared as 'erf' in roughbench.*, is of kind 'erf09'"
    ):
        rb.load_spec(spec_of({"kind": "erf"}))


def test_the_files_of_a_package_count(site: Path) -> None:
    package = site / "theories"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text(
        THEORY.replace("import helper", "from theories import shared as helper")
    )
    (package / "shared.py").write_text("def scaled(factor):\n    return factor\n")
    (package / "unused.py").write_text("")
    install(site, "theories", "erf09 = theories.one:Erf09")

    def digest() -> str:
        identity._code_of.cache_clear()
        return identity.code_digest(MODELS["erf09"])

    before = digest()
    (package / "unused.py").write_text("x = 1\n")
    assert digest() == before
    (package / "shared.py").write_text("def scaled(factor):\n    return 2.0 * factor\n")
    assert digest() != before


def test_what_a_model_calls_of_roughbench_counts(tmp_path: Path) -> None:
    """A call of the exact solver makes its code part of the model's."""
    write_theory(tmp_path)
    before = identity.code_digest(Catalog(tmp_path).find("mytheory.py:Erf09"))
    text = THEORY + "\n\ndef exact(heights):\n    return rb.solve_contact(heights, 0.1)\n"
    (tmp_path / "mytheory.py").write_text(text)
    seen: list[str] = []
    real = identity._unit
    identity._unit = lambda name: seen.append(name) or real(name)  # type: ignore[func-returns-value]
    try:
        assert identity.code_digest(Catalog(tmp_path).find("mytheory.py:Erf09")) != before
    finally:
        identity._unit = real
    assert "models.halfspace" in seen
