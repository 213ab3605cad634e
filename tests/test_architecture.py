"""The way of the data, and one owner for each package: kept by parsing the imports."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import roughbench
from roughbench.models import BUILT_IN

LAYERS = (
    "system",
    "text",
    "program",
    "errors",
    "public",
    "notation",
    "numbers",
    "units",
    "registry",
    "quantities",
    "ensemble",
    "locks",
    "memory",
    "inputs",
    "labelled",
    "neighbours",
    "publish",
    "outputs",
    "seal",
    "signals",
    "sink",
    "spectrum",
    "surface",
    "heights_file",
    "transform",
    "scans",
    "source_files",
    "models",
    "observables",
    "spec",
    "variables",
    "surface_record",
    "results",
    "field_files",
    "fits",
    "verdict",
    "store",
    "planning",
    "rundir",
    "engines",
    "runner",
    "figures",
    "__init__",
    "report",
    "bundle",
    "cli",
    "__main__",
)
"""What a module imports stands in its own layer or in one before it."""

APART = {
    "models": {"heights_file", "scans"},  # models know no files
}
"""Layers that stand before another and are yet none of its business."""

OWNERS = {
    "SurfaceTopography": {"scans"},
    "click": {"cli"},
    "dask": {"engines"},
    "dask_jobqueue": {"engines"},
    "distributed": {"engines"},
    "filelock": {"locks"},
    "h5py": {"heights_file", "scans", "store"},
    "jinja2": {"report"},
    "matplotlib": {"figures"},
    "numba": {"models"},
    "pandas": {"labelled"},
    "pint": {"units"},
    "psutil": {"system"},
    "pydantic": {"models", "spec"},
    "pydantic_core": {"models", "spec"},
    "pyfftw": {"transform"},
    "scipy": {"fits", "models", "observables", "scans", "transform"},
    "threadpoolctl": {"engines"},
    "tqdm": {"cli", "runner"},
    "xarray": {"labelled"},
    "yaml": {"spec"},
}
"""Third-party package → the layers that may import it. NumPy is everybody's."""

SAME_NAMES = {"Scales": ["figures.spectrum", "observables.fields"]}
"""Classes whose name stands for two things; let there be no more."""

ROOT = Path(roughbench.__file__).parent


def modules(root: Path) -> Iterator[tuple[str, str]]:
    """Yield the dotted name within the package, and the text, of every module."""
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        yield ".".join(parts), path.read_text(encoding="utf-8")


def imports(name: str, text: str) -> Iterator[str]:
    """Yield every imported name, in functions and for type checking as well."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield f"relative import in {name}"
            elif node.module == "roughbench":
                yield from (f"roughbench.{alias.name}" for alias in node.names)
            else:
                yield node.module or ""


def faults(name: str, text: str) -> Iterator[str]:
    """Yield what a module imports against the rules."""
    layer = name.partition(".")[0]
    if layer not in LAYERS:
        yield f"{name}: in no known layer; give it a place in LAYERS"
        return
    everybodys = sys.stdlib_module_names | {"numpy"}
    before = set(LAYERS[: LAYERS.index(layer) + 1]) - APART.get(layer, set())
    for target in imports(name, text):
        package, _, inner = target.partition(".")
        if package == "roughbench":
            found = inner.partition(".")[0]
            wanted = found if found in LAYERS else "__init__"
            if wanted not in before:
                yield f"{name}: imports {target}, which stands behind it"
        elif package not in everybodys and layer not in OWNERS.get(package, set()):
            yield f"{name}: imports {target}, which has another owner"


@pytest.mark.parametrize(("name", "text"), [pytest.param(n, t, id=n) for n, t in modules(ROOT)])
def test_imports_follow_the_way_of_the_data(name: str, text: str) -> None:
    assert list(faults(name, text)) == []


@pytest.mark.parametrize(
    ("name", "text", "fault"),
    [
        ("models.new", "from roughbench.spec import Spec", "stands behind it"),
        ("models.new", "def f():\n    from roughbench import store", "stands behind it"),
        ("spectrum", "import roughbench", "stands behind it"),
        ("store", "import roughbench.planning.plan", "stands behind it"),
        ("runner.new", "from roughbench import figures", "stands behind it"),
        ("models.new", "if TYPE_CHECKING:\n    import h5py", "another owner"),
        ("runner.new", "from click import echo", "another owner"),
        ("spec.new", "import pandas as pd", "another owner"),
        ("cli.new", "from ..store import load", "another owner"),
        ("helpers", "", "no known layer"),
    ],
)
def test_a_fault_would_be_found(name: str, text: str, fault: str) -> None:
    assert [fault in found for found in faults(name, text)] == [True]


KINDS_ELSEWHERE = {
    ("figures.__init__", "foundation"): "the name of a figure, the paper's first",
    ("figures.agreement", "foundation"): "the stiffness of these two is the paper's Fig. 4",
    ("figures.agreement", "persson"): "the stiffness of these two is the paper's Fig. 4",
    ("figures.pressed", "foundation"): "the paper's Fig. 1 shows this foundation",
    ("figures.spectrum", "line"): "what a model needs",
    ("report.observables", "persson"): "the end of a variable's name",
    ("report.tables", "line"): "a word",
    ("runner.comparison", "line"): "what a model needs",
    ("cli.results_csv", "persson"): "the end of a variable's name",
}
"""Words that are also kinds of models, and why they stand where they do."""


def kinds_in(name: str, text: str) -> Iterator[str]:
    """Yield the kinds of built-in models that a module outside of models names."""
    if name.partition(".")[0] in ("models", "verdict"):  # verdicts are on the paper's models
        return
    for node in ast.walk(ast.parse(text)):
        word = node.value if isinstance(node, ast.Constant) else None
        if isinstance(word, str) and word in BUILT_IN and (name, word) not in KINDS_ELSEWHERE:
            yield f"{name}: names the kind {word!r}"


def test_no_kind_is_special_outside_of_models() -> None:
    assert [fault for module in modules(ROOT) for fault in kinds_in(*module)] == []


@pytest.mark.parametrize(
    ("name", "found"),
    [("report.new", 1), ("figures.agreement", 0), ("models.new", 0), ("verdict.new", 0)],
)
def test_a_kind_would_be_found(name: str, found: int) -> None:
    text = '"""Of bem."""\nif model.kind == "persson":\n    special = True\n'
    assert len([*kinds_in(name, text)]) == found


def classes(root: Path) -> dict[str, list[str]]:
    """Return the modules that define each class of a name, whether private or not."""
    places: dict[str, list[str]] = {}
    for name, text in modules(root):
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name.lstrip("_"), []).append(name)
    return places


def test_a_type_name_has_one_meaning(tmp_path: Path) -> None:
    places = classes(ROOT)
    assert {name: found for name, found in places.items() if len(found) > 1} == SAME_NAMES
    (tmp_path / "one.py").write_text("class Curve: ...\n", encoding="utf-8")
    (tmp_path / "two.py").write_text("class _Curve: ...\n", encoding="utf-8")
    assert classes(tmp_path) == {"Curve": ["one", "two"]}  # would be found


def test_nothing_is_parsed_twice_or_missed() -> None:
    names = [name for name, _ in modules(ROOT)]
    assert {"__init__", "errors", "models.base", "cli.run"} <= set(names)
    assert len(names) == len(set(names))
    seen = {target.partition(".")[0] for module in modules(ROOT) for target in imports(*module)}
    assert set(OWNERS) <= seen  # no owner of nothing


def rooms(page: str) -> list[str]:
    """Return the names in the table of docs/architecture.md, in its order."""
    table = page.partition("| room |")[2].partition("\n\n")[0]
    return re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)


def test_the_page_on_architecture_lists_the_folders_as_they_are() -> None:
    page = (ROOT.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    there = {name.partition(".")[0] for name, _ in modules(ROOT)}
    assert rooms(page) == list(LAYERS)
    assert set(LAYERS) == there


def test_no_module_hides_a_public_name() -> None:
    """Importing ``roughbench.x`` binds x in the package, over a function of that name."""
    inner = {name.partition(".")[0] for name, _ in modules(ROOT)}
    assert not inner & set(roughbench.__all__)
