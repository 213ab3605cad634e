"""Models in files: found, loaded with what lies beside them, carried to other processes."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import roughbench as rb
from roughbench.models.base import Model
from roughbench.models.registry import Catalog
from roughbench.source_files import load_reference, origin_of, read_files
from tests.models.outside import THEORY, write_theory

REFERENCE = "mytheory.py:Erf09"


def made(folder: Path, reference: str = REFERENCE) -> Model:
    return Catalog(folder).find(reference)(kind="erf09")


def test_a_file_is_loaded_with_those_beside_it(tmp_path: Path) -> None:
    path = write_theory(tmp_path)
    (tmp_path / "other.py").write_text("raise ZeroDivisionError\n")  # nobody imports it
    model = made(tmp_path)
    assert (model.kind, model.name, model.dimension) == ("erf09", "erf09", 0)
    origin = origin_of(type(model))
    assert origin is not None
    assert [name for name, _ in origin.files.texts] == ["helper.py", "mytheory.py"]
    assert not {"helper", "mytheory"} & set(sys.modules)
    assert type(made(tmp_path)) is type(model)
    path.write_text(THEORY.replace("= 0.9", "= 0.8"))
    assert made(tmp_path).model_dump()["factor"] == 0.8
    assert model.model_dump()["factor"] == 0.9


def test_files_of_one_name_do_not_meet(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_theory(tmp_path / name)
    (tmp_path / "b" / "helper.py").write_text("def scaled(factor):\n    return 0.0\n")
    a, b = (made(tmp_path, f"{name}/{REFERENCE}") for name in ("a", "b"))
    assert type(a) is not type(b)


@pytest.mark.parametrize(
    "statement",
    [
        "import helper.deep\nvalue = helper.deep.value",
        "import helper.deep as d\nvalue = d.value",
        "from helper import deep\nvalue = deep.value",
        "from helper.deep import value",
        "import helper\nvalue = helper.again",
        "from .helper.deep import value",
        "def f():\n    import helper.deep\n    return helper.deep.value\nvalue = f()",
    ],
)
def test_every_way_to_import_a_package_beside(tmp_path: Path, statement: str) -> None:
    helper = tmp_path / "helper"
    helper.mkdir()
    (helper / "__init__.py").write_text("from helper.deep import value as again\n")
    (helper / "deep.py").write_text("from . import base\nvalue = base.one\n")
    (helper / "base.py").write_text("one = 1\n")
    (tmp_path / "m.py").write_text(f"{statement}\nassert value == 1\nclass X: pass\n")
    assert load_reference("m.py:X", tmp_path).__name__ == "X"
    assert len(read_files(tmp_path / "m.py").texts) == 4


def test_a_model_is_carried_to_a_process_without_its_file(tmp_path: Path) -> None:
    there = tmp_path / "there"
    path = write_theory(there)
    model = made(there).model_copy(update={"factor": 0.5}).referred_to(REFERENCE)
    carried = tmp_path / "model.pickle"
    carried.write_bytes(pickle.dumps(model))
    assert pickle.loads(carried.read_bytes()) == model  # noqa: S301
    for file in (path, there / "helper.py"):
        file.unlink()
    code = (
        "import inspect, pickle, sys; model = pickle.load(open(sys.argv[1], 'rb'));"
        "from roughbench.rundir.identity import code_digest;"
        "print(model.factor, model.reference, code_digest(type(model)));"
        "print(inspect.getsource(type(model).curve).split()[1])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, carried], capture_output=True, text=True, check=True
    )
    from roughbench.rundir.identity import code_digest

    assert done.stdout.split() == ["0.5", REFERENCE, code_digest(type(model)), "curve(self,"]


@pytest.mark.parametrize(
    ("before", "after", "reference", "message"),
    [
        (
            "",
            "",
            "mythery.py:Erf09",
            r"no such file: mythery\.py \(did you mean 'mytheory\.py'",
        ),
        ("", "", "no/such.py:Erf09", r"no such file: .*no/such\.py"),
        (
            "",
            "",
            "mytheory.py:Erf9",
            r"mytheory\.py has no class 'Erf9' \(did you mean 'Erf09'",
        ),
        ("", "", "mytheory.py:Zzz", r"has no class 'Zzz'; its models: Erf09"),
        ("", "", "mytheory.py", r"must name a class too, as in mytheory\.py:Erf09"),
        ("", "", "mytheory.py:rb", "has no class 'rb'"),
        ("import helper", "import helpr", REFERENCE, r"mytheory\.py:7: ModuleNotFoundError: "),
        ("class Erf09", "class class", REFERENCE, r"mytheory\.py:11: invalid syntax"),
        ("(rb.Model)", "", REFERENCE, r"mytheory\.py:Erf09 is not a subclass of roughbench"),
        (
            '    kind: Literal["erf09"]',
            "    kind: str",
            REFERENCE,
            r'lacks its kind: Literal\["erf09"\]',
        ),
        (
            '    title: ClassVar[str] = "Erf 0.9"\n',
            "",
            REFERENCE,
            "Erf09 lacks title; see docs",
        ),
        ("def curve", "def curves", REFERENCE, "Erf09 lacks curve, or states; see docs/adding"),
        ('= "spectrum"', '= "heights"', REFERENCE, "needs must be spectrum or line or surface"),
        ("factor: float", "length: float", REFERENCE, "results have an attribute 'length' alr"),
        ('"erf09"] = "erf09"', '"bem"] = "bem"', REFERENCE, "kind 'bem', which roughbench has"),
        (
            '"erf09"] = "erf09"',
            '"a b"] = "a b"',
            REFERENCE,
            "must have a letter or digit first",
        ),
        (
            "import helper\n",
            "import helper\nraise SystemExit(3)\n",
            REFERENCE,
            ":8: SystemExit: 3",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_said(
    tmp_path: Path, before: str, after: str, reference: str, message: str
) -> None:
    path = write_theory(tmp_path)
    assert before in THEORY
    path.write_text(THEORY.replace(before, after) if before else THEORY, encoding="utf-8")
    with pytest.raises(rb.ModelError, match=message):
        Catalog(tmp_path).find(reference)


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "folder.py").mkdir()
    (tmp_path / "latin.py").write_bytes(b"# \xe9\n")
    with pytest.raises(rb.ModelError, match=r"cannot read folder\.py: Is a directory"):
        Catalog(tmp_path).find("folder.py:X")
    with pytest.raises(rb.ModelError, match=r"latin\.py is not UTF-8 text"):
        Catalog(tmp_path).find("latin.py:X")


def test_a_fault_in_a_file_beside_names_it(tmp_path: Path) -> None:
    write_theory(tmp_path)
    (tmp_path / "helper.py").write_text("\n\n1 / 0\n")
    with pytest.raises(rb.ModelError, match=r"^helper\.py:3: ZeroDivisionError"):
        Catalog(tmp_path).find(REFERENCE)
