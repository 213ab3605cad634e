"""Pages that the site makes from the code leave nothing out; tutorials name real commands."""

from __future__ import annotations

import importlib.util
import io
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import h5py
import pytest

import roughbench as rb
from roughbench.cli import COMMANDS, main
from roughbench.public import MODULES
from roughbench.store.writing import image

ROOT = Path(__file__).parents[1]


def loaded(path: str) -> ModuleType:
    found = importlib.util.spec_from_file_location(Path(path).stem, ROOT / path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[found.name] = module  # where dataclasses look for it
    found.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def reference() -> ModuleType:
    return loaded("website/reference.py")


def rows(page: str, heading: str) -> set[str]:
    """Return the names in the first column of all tables of a part of a page."""
    part = page.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return set(re.findall(r"^\| `(\w+)` \|", part, re.M))


def test_the_page_of_the_results_file_names_all_that_a_file_holds(
    small_spec: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    results_file = loaded("website/results_file.py")
    few = [{"kind": "foundation", "springs": 64, "realizations": 1}, {"kind": "persson"}]
    monkeypatch.setitem(results_file.SPEC, "models", few)
    page = results_file.results_file_page()
    assert rows(page, "Quantities") >= {"pressure", "area", "stiffness_harmonic"}
    small_spec |= {"observables": ["clusters"], "save_fields": {"pressures": [1e-2]}}
    with h5py.File(io.BytesIO(image(rb.run(small_spec)))) as file:
        assert rows(page, "Attributes of the file") == set(file.attrs)
        own = rows(page, "Attributes of a group")
        named = set(re.findall(r"^\| `(\w+)` \|", page, re.M))
        for group in file["main"].values():
            assert own >= set(group.attrs)
            for variable in group:
                base = re.sub(r"_(mean|sem|median|q16|q84)$", "", variable)
                assert base in named, variable


def test_the_page_of_python_has_every_public_name(reference: ModuleType) -> None:
    page = reference.python_page()
    named = re.findall(r"^\.\. auto(?:class|exception|function|data):: (\w+)", page, re.M)
    assert set(named) >= {name for name in rb.__all__ if not name.startswith("__")}
    assert len(named) == len(set(named))


def test_the_page_of_the_commands_has_every_option(reference: ModuleType) -> None:
    page = reference.commands_page()
    parent = click.Context(main, info_name="roughbench")
    assert re.findall(r"^## roughbench (\w+)$", page, re.M) == list(COMMANDS)
    for name in COMMANDS:
        command = main.get_command(parent, name)
        assert command is not None
        part = page.partition(f"## roughbench {name}\n")[2].partition("\n## ")[0]
        for option in command.params:
            assert not isinstance(option, click.Option) or option.opts[-1] in part


@pytest.mark.parametrize("page", ["docs/first-run.md", "docs/scans.md"])
def test_a_tutorial_has_commands_that_there_are(page: str) -> None:
    console = loaded("scripts/_console.py")
    blocks = re.findall(
        r"^```console\n(.*?)^```", (ROOT / page).read_text("utf-8"), re.S | re.M
    )
    words = [line.split() for block in blocks for line, _ in console.commands_of(block)]
    assert len(words) > 5
    assert {word[1] for word in words if word[0] == "roughbench"} <= set(COMMANDS)


@pytest.mark.parametrize(
    ("printed", "said"),
    [("A 2.1e-03\n", "A 2.000e-03\n"), ("2.0 m\n", "2.0 mm\n"), ("1\n2\n3\n", "1\n2\n")],
)
def test_another_output_is_found(printed: str, said: str) -> None:
    assert not loaded("scripts/_console.py").agree(printed, said)


def test_outputs_agree_but_for_the_last_digits() -> None:
    assert loaded("scripts/_console.py").agree("A 2.001e-03 n 5\n", "A 2.000e-03 n 5\n")


def test_lines_that_a_page_leaves_out_are_not_compared() -> None:
    console = loaded("scripts/_console.py")
    assert console.shortened("a\nb\nc\nd\n", "a\n…\nd\n") == "a\n…\nd\n"
    assert console.shortened("a\nb\n", "a\nb\n") == "a\nb\n"


def test_what_pages_name_of_modules_is_described(reference: ModuleType) -> None:
    """``from roughbench.fits import fit``, ``roughbench.fits.fit``: both are on a page."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").iterdir()]
    text = "\n".join(page.read_text("utf-8") for page in pages if page.is_file())
    named = set(re.findall(r"`roughbench\.([a-z_.]+)\.(\w+)", text))
    for module, names in re.findall(r"from roughbench\.([\w.]+) import ([\w, ]+)", text):
        named |= {(module, name.strip()) for name in names.split(",")}
    assert ("fits", "fit") in named
    described = {
        (module, name) for module, names in reference.MODULES.items() for name in names.split()
    }
    modules = {tuple(module.rpartition(".")[::2]) for module in reference.MODULES}
    public = set(rb.__all__)
    assert {one for one in named - described - modules if one[1] not in public} == set()
    page = reference.modules_page()
    assert {f"rb.{name}" for name in MODULES} <= set(re.findall(r"rb\.\w+", page))


def test_modules_for_users_are_there_without_another_import() -> None:
    code = "import roughbench as rb; print(rb.neighbours.__name__, rb.figures.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["roughbench.neighbours", "roughbench.figures"]


@pytest.mark.parametrize(
    ("link", "fault"),
    [
        ("b.html", ""),
        ("b.html#there", ""),
        ("#here", ""),
        ("", ""),
        ("data:image/png;base64,AA", ""),
        ("https://doi.org/10.1007/s11249-013-0208-9", ""),
        ("c.html", "there is no such file"),
        ("b.html#here", "there is no such anchor"),
        ("#there", "there is no such anchor"),
        ("http://example.org", "not of the form https://host/path"),
        ("https://example org/", "not of the form https://host/path"),
        ("https://doi.org/s11249-013-0208-9", "no DOI: https://doi.org/10.PREFIX/SUFFIX"),
        ("https://doi.org/10.1007/s11249.", "no DOI: https://doi.org/10.PREFIX/SUFFIX"),
    ],
)
def test_a_link_that_leads_nowhere_is_found(link: str, fault: str, tmp_path: Path) -> None:
    links = loaded("website/links.py")
    (tmp_path / "a.html").write_text(f'<h1 id="here">A</h1><a href="{link}">x</a>')
    (tmp_path / "b.html").write_text('<a name="there">B</a>')
    pages = links.pages_of(tmp_path)
    found = list(links.faults_of(pages))
    assert found == ([f"{tmp_path / 'a.html'}: {link}: {fault}"] if fault else [])
    assert list(links.outside_of(pages)) == ([link] if link.startswith("http") else [])
