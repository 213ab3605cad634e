"""Runs with a model in a file: named in the spec, here, in workers, again after an edit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import roughbench as rb
from roughbench import figures
from roughbench.figures.rebuild import spec_fault
from roughbench.models.style import Style
from roughbench.report import make_report
from roughbench.runner import Progress
from tests.models.outside import THEORY, spec_of, write_theory

ERF = {"kind": "mytheory.py:Erf09", "factor": 0.8}


def write_spec(folder: Path, *models: dict[str, Any], **more: Any) -> Path:
    write_theory(folder)
    path = folder / "outside.yaml"
    path.write_text(yaml.safe_dump(spec_of(*models) | more, sort_keys=False))
    return path


def computed(spec: Path, output: Path) -> list[str]:
    """Run; returns the models of which something was computed."""
    news: list[Progress] = []
    rb.run(spec, output=output, progress=news.append)
    log = (output.parent / f"{output.name}.rbrun" / "run.log").read_text()
    last = log.rpartition("tasks to compute")[2] if "tasks to compute" in log else ""
    return [kind for kind in ("erf09", "persson", "foundation") if f"main/{kind}: done" in last]


def test_it_is_called_by_its_own_kind(tmp_path: Path) -> None:
    sweep = {"models.erf09.factor": [0.8, 0.9]}
    spec = write_spec(tmp_path, ERF, {"kind": "persson"}, sweep=sweep)
    loaded = rb.load_spec(spec, ["models.persson.gamma=0.5"])
    assert [model.name for model in loaded.models] == ["erf09", "persson"]
    assert loaded.as_given()["models"][0] == ERF
    assert rb.load_spec(loaded) is loaded
    results = rb.run(spec, threads=1)
    one, other = (results[f"models.erf09.factor={f}"]["erf09"] for f in (0.8, 0.9))
    assert (one.attributes["factor"], other.attributes["factor"]) == (0.8, 0.9)
    assert (one.kind, one.attributes["source"]) == ("erf09", "mytheory.py:Erf09")
    assert (one["area"] < other["area"]).all()
    with pytest.raises(rb.SpecError, match=r"models has no 'erf9' \(did you mean 'erf09'"):
        rb.load_spec(spec, ["models.erf9.factor=1.0"])
    set_there = rb.load_spec(write_spec(tmp_path, ERF), ["models.erf09.factor=0.7"])
    assert set_there.as_given()["models"][0]["factor"] == 0.7


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"factor": "a"}, "9:11: error: models[0].factor: must be a number, got 'a'"),
        ({"factr": 1.0}, "10:3: error: models[0].factr: unknown key (did you mean 'factor'?)"),
        (
            {"kind": "mytheory.py:Erf9"},
            "8:9: error: models[0].kind: mytheory.py has no class 'Erf9' (did you mean 'Erf09'",
        ),
        (
            {"kind": "mytheori.py:Erf09"},
            "8:9: error: models[0].kind: no such file: mytheori.py (did you mean 'mytheory.py'",
        ),
        (
            {"realizations": 5},
            "10:17: error: models[0].realizations: erf09 works on the spectrum",
        ),
    ],
)
def test_faults_have_their_place(tmp_path: Path, change: dict[str, Any], fault: str) -> None:
    write_theory(tmp_path)
    text = (
        "name: outside\nsurface: {H: 0.7, q0: 1.0, q1: 32.0, slope: 0.1}\n"
        "pressures:\n- 0.0001\n- 0.001\n\nmodels:\n"
    )
    entries = [f"{key}: {value}" for key, value in (ERF | change).items()]
    spec = tmp_path / "outside.yaml"
    spec.write_text(text + "- " + "\n  ".join(entries) + "\n")
    with pytest.raises(rb.SpecError) as caught:
        rb.load_spec(spec)
    assert str(caught.value.faults[0]).partition("outside.yaml:")[2].startswith(fault)


def test_an_edit_computes_its_results_again_and_no_others(tmp_path: Path) -> None:
    springs = {"kind": "foundation", "springs": 128}
    spec = write_spec(tmp_path, ERF, {"kind": "persson"}, springs)
    output = tmp_path / "o.h5"
    assert computed(spec, output) == ["erf09", "persson", "foundation"]
    before = rb.load(output)["main"]
    theory, helper = tmp_path / "mytheory.py", tmp_path / "helper.py"
    theory.write_text(THEORY.replace("class Erf09", "# as fitted\nclass Erf09"))
    assert computed(spec, output) == []
    theory.write_text(THEORY.replace("#123456", "#654321"))
    assert computed(spec, output) == []
    helper.write_text(helper.read_text().replace("2.0", "3.0"))
    assert computed(spec, output) == ["erf09"]
    after = rb.load(output)["main"]
    assert (after["erf09"]["area"] > before["erf09"]["area"]).all()
    assert np.array_equal(after["persson"]["area"], before["persson"]["area"])


def test_worker_processes_have_it(tmp_path: Path) -> None:
    spec = write_spec(tmp_path, ERF, ERF | {"label": "other", "factor": 1.0})
    rb.run(spec, output=tmp_path / "one.h5", jobs=1, threads=1)
    rb.run(spec, output=tmp_path / "two.h5", jobs=2, threads=1)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "two.h5").read_bytes()


def test_an_error_of_it_comes_back(tmp_path: Path) -> None:
    spec = write_spec(tmp_path, ERF)
    (tmp_path / "helper.py").write_text(
        "class OddError(Exception):\n    pass\n\n\ndef scaled(factor):\n    raise OddError(3)\n"
    )
    for jobs in (1, 2):
        with pytest.raises(rb.ModelError, match=r"^main/erf09: helper\.py:6: OddError: 3$"):
            rb.run(spec, output=tmp_path / "o.h5", jobs=jobs, threads=1)


def test_results_are_read_without_the_file(tmp_path: Path) -> None:
    """And without running it, which nobody who draws a figure asks for."""
    spec = write_spec(tmp_path, ERF, {"kind": "persson"}, sweep={"models.erf09.factor": [0.8]})
    results = rb.run(spec, output=tmp_path / "o.h5", threads=1)
    (tmp_path / "mytheory.py").write_text("raise ZeroDivisionError\n")
    assert spec_fault(results) is None
    assert {"spectrum", "area", "separation"} <= set(figures.available(results))
    text = make_report([tmp_path / "o.h5"], resamples=10)
    assert "Erf 0.9" in text
    assert "is in the spec, but not in the file" not in text
    style = Style("#123456", ((4.0, 2.0),))
    assert results["models.erf09.factor=0.8"]["erf09"].attributes["style"] == style.as_text()
