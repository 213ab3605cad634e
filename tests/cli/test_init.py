"""Files to start from: they are valid, complete, and never written over others."""

from __future__ import annotations

import errno
import runpy
from pathlib import Path

import numpy as np
import pytest

import roughbench as rb
from roughbench.models.registry import Catalog
from roughbench.runner import check, plan
from tests.cli.conftest import Invoke


def test_a_spec_to_start_from_is_valid(folder: Path, invoke: Invoke) -> None:
    done = invoke("init", "rough")
    assert (done.exit_code, done.stdout) == (0, "rough.yaml\n")
    spec = rb.load_spec("rough.yaml")
    check(plan(spec))
    assert (spec.name, len(spec.models)) == ("rough", 3)
    again = invoke("init", "rough")
    assert again.exit_code == 1
    assert "error: rough.yaml is there already; choose another name" in again.stderr
    assert invoke("init", "rough.yaml").stderr == again.stderr
    assert invoke("init", "other.yml").stdout == "other.yaml\n"
    (folder / "spec.yaml").symlink_to("nowhere")
    assert invoke("init").exit_code == 1


@pytest.mark.usefixtures("folder")
def test_where_nothing_can_be_written_the_remedy_is_one(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr("roughbench.publish.publish", refuse)
    done = invoke("init", "rough")
    assert (done.exit_code, done.stderr) == (
        1,
        "error: cannot write rough.yaml: Read-only file system; begin in another folder\n",
    )


@pytest.mark.parametrize(
    ("template", "models"), [("synthetic", 3), ("scan", 6), ("cluster", 3)]
)
def test_every_spec_to_start_from_is_valid(
    folder: Path, invoke: Invoke, template: str, models: int
) -> None:
    done = invoke("init", "--template", template)
    assert (done.exit_code, done.stdout) == (0, f"{template}.yaml\n")
    heights = np.random.default_rng(1).normal(size=(32, 32)).cumsum(0).cumsum(1)
    np.savetxt(folder / "scan.txt", heights)
    cells = plan(rb.load_spec(f"{template}.yaml"))
    check(cells)
    assert len(cells) == models


def test_a_model_to_start_from_computes(folder: Path, invoke: Invoke) -> None:
    done = invoke("init", "--template", "model", "my-theory")
    assert done.exit_code == 0
    made = [folder / line for line in done.stdout.splitlines()]
    assert [path.name for path in made] == [
        "pyproject.toml",
        "my_theory.py",
        "test_my_theory.py",
        "my_theory.yaml",
    ]
    for path in made:
        assert "@" not in path.read_text(encoding="utf-8")
    model = Catalog(folder / "my-theory").find("my_theory.py:MyTheory")
    assert model.model_fields["kind"].default == "my_theory"
    spec = folder / "my-theory" / "my_theory.yaml"
    text = spec.read_text().replace("kind: my_theory", 'kind: "my_theory.py:MyTheory"')
    spec.write_text(text)  # as it is not installed here
    test = runpy.run_path(str(folder / "my-theory" / "test_my_theory.py"))
    test["test_few_contacts_grow_with_the_pressure"]()
    again = invoke("init", "--template", "model", "my-theory")
    assert (again.exit_code, again.stdout) == (1, "")
    assert "error: my-theory is there already" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("../x",), "NAME: must have letters"),
        (("--template", "model", "1st"), "NAME: must have letters"),
        (("--template", "model", "persson"), "there is a model 'persson' already"),
        (("--template", "modle"), "is not one of 'spec', 'synthetic', 'scan'"),
    ],
)
def test_names_that_will_not_do(
    folder: Path, invoke: Invoke, arguments: tuple[str, ...], message: str
) -> None:
    done = invoke("init", *arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert [path.name for path in folder.iterdir()] == ["small.yaml"]
