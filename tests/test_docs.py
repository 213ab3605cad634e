"""The documentation says what there is: commands, options, keys, links, specs."""

from __future__ import annotations

import importlib
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
import yaml

import roughbench as rb
from roughbench.cli import COMMANDS, main
from roughbench.figures import FIGURES
from roughbench.models import MODELS
from roughbench.models.base import Model
from roughbench.observables import OBSERVABLES
from roughbench.runner import check, plan
from roughbench.spec import FileSurface, SelfAffineSurface, Spec, load_spec
from roughbench.spec.fields import SavedFields
from roughbench.spec.pressures import PressureRange
from roughbench.variables import FIELD_VARIABLES

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([a-z0-9-]+):", MAKEFILE, re.MULTILINE))


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: Path, language: str) -> list[str]:
    found = re.findall(rf"^```{language}\n(.*?)^```", text_of(name(page)), re.S | re.M)
    return [str(block) for block in found]


def command(word: str) -> click.Command:
    found = importlib.import_module(f"roughbench.cli.{word}").command
    assert isinstance(found, click.Command)
    return found


def options(word: str) -> set[str]:
    return {o for p in command(word).params if isinstance(p, click.Option) for o in p.opts}


# -- commands ----------------------------------------------------------------------------


def shell_lines() -> Iterator[tuple[Path, str]]:
    for page in PAGES:
        for block in blocks(page, "sh"):
            for line in block.splitlines():
                yield page, line


OTHERS = {"python", "pip", "git", "cd", "pipx", "docker", "apptainer", "rattler-build"}
LINES = [pytest.param(line, id=f"{name(page)}: {line}") for page, line in shell_lines()]


@pytest.mark.parametrize("line", LINES)
def test_a_documented_line_can_be_run(line: str) -> None:
    words = shlex.split(line.partition(" > ")[0], comments=True)
    for word in words:
        if word.startswith(("configs/", "packaging/", "scripts/")):
            assert (ROOT / word).is_file()
    if words[:1] == ["make"]:
        assert set(words[1:]) <= TARGETS
    elif words[:1] == ["roughbench"]:
        assert words[1] in COMMANDS
        # Parses the arguments without running the command.
        command(words[1]).make_context(words[1], words[2:])
    else:
        assert words[0] in OTHERS, "what should this run?"


@pytest.mark.parametrize("word", COMMANDS)
def test_every_command_and_option_is_documented(word: str) -> None:
    heading = f"## `roughbench {word}`"
    page = text_of("docs/cli.md")
    assert heading in page
    section = page.partition(heading)[2].partition("\n## ")[0]
    for option in options(word) - {"--debug", "--help", "-h"}:
        assert f"`{option}`" in section or f"{option} " in section, option


def test_no_command_is_documented_that_is_none() -> None:
    headings = re.findall(r"^## `roughbench (\w+)`", text_of("docs/cli.md"), re.MULTILINE)
    assert headings == list(COMMANDS) == main.list_commands(click.Context(main))


@pytest.mark.parametrize("word", COMMANDS)
def test_the_example_of_every_help_text_can_be_run(word: str) -> None:
    epilog = command(word).epilog or ""
    lines = [line.split(" | ")[0].split(" > ")[0] for line in epilog.splitlines()[2:]]
    assert lines
    for line in lines:
        words = shlex.split(line)
        assert words[:2] == ["roughbench", word]
        command(word).make_context(word, words[2:])


def test_every_target_of_make_is_explained_by_make_help() -> None:
    internal = {"setup", "setup-dev", "setup-docs", "python"}
    explained = set(re.findall(r"^([a-z0-9-]+):.*## ", MAKEFILE, re.MULTILINE))
    assert explained == TARGETS - internal
    phony = re.search(r"^\.PHONY: ((?:.*\\\n)*.*)", MAKEFILE, re.MULTILINE)
    assert phony is not None
    assert set(phony[1].replace("\\", " ").split()) == TARGETS


# -- links -------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)", text_of(name(page)), re.MULTILINE)
    plain = (re.sub(r"[^\w\s-]", "", heading.lower()).strip() for heading in headings)
    return {heading.replace(" ", "-") for heading in plain}


def links() -> Iterator[tuple[Path, str]]:
    for page in PAGES:
        prose = re.sub(r"^```.*?^```", "", text_of(name(page)), flags=re.S | re.M)
        for target in re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", prose):
            yield page, target[0] or target[1]


LINKS = [
    pytest.param(page, target, id=f"{name(page)} -> {target}")
    for page, target in links()
    if not target.startswith("https://")
]


@pytest.mark.parametrize(("page", "target"), LINKS)
def test_a_link_leads_somewhere(page: Path, target: str) -> None:
    path, _, anchor = target.partition("#")
    where = (page.parent / path).resolve() if path else page
    assert where.is_file()
    if anchor:
        assert anchor in anchors(where)


def test_every_page_is_reached_from_the_readme() -> None:
    seen: set[Path] = set()
    waiting = [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        seen.add(page)
        for origin, target in links():
            path = (origin.parent / target.partition("#")[0]).resolve()
            if origin == page and path.suffix == ".md" and path not in seen:
                waiting.append(path)
    assert seen >= set(PAGES)


# -- specs and results -------------------------------------------------------------------


def specs() -> Iterator[Any]:
    for page in PAGES:
        for number, block in enumerate(blocks(page, "yaml")):
            tree = yaml.safe_load(block)
            in_a_file = any(".py:" in str(model) for model in tree.get("models", ()))
            if {"surface", "pressures", "models"} <= set(tree) and not in_a_file:
                yield pytest.param(block, id=f"{name(page)}-{number}")


@pytest.mark.parametrize("block", list(specs()))
def test_a_spec_in_the_documentation_is_valid(block: str) -> None:
    check(plan(load_spec(block)))


@pytest.mark.parametrize("path", sorted((ROOT / "configs").rglob("*.yaml")), ids=name)
def test_a_config_is_valid_and_documented(path: Path) -> None:
    check(plan(load_spec(path)))
    folder = path.parent.name
    target = path.stem if folder == "configs" else f"{folder}-{path.stem}"
    known = {"quick": "demo"}.get(target, target)
    assert known in TARGETS


def rows(page: str) -> dict[str, str]:
    """Return the first two cells of every row of a page's tables: names → next cell."""
    found: dict[str, str] = {}
    for line in text_of(page).splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if line.startswith("| `") and len(cells) > 1:
            found |= dict.fromkeys(re.findall(r"`([^`]+)`", cells[0]), cells[1])
    return found


@pytest.mark.parametrize(
    "owner", [Spec, SelfAffineSurface, FileSurface, PressureRange, SavedFields]
)
def test_every_key_of_a_spec_is_documented(owner: Any) -> None:
    page = text_of("docs/spec.md")
    for key, field in owner.model_fields.items():
        assert f"`{field.alias or key}`" in page or f"{field.alias or key}: " in page


@pytest.mark.parametrize("kind", MODELS)
def test_every_option_of_a_model_is_documented_with_its_default(kind: str) -> None:
    shared = rows("docs/spec.md")
    own = rows(f"docs/models/{kind}.md")
    for key, field in MODELS[kind].model_fields.items():
        if key in ("kind", "label", "realizations"):
            assert key in shared
        elif field.default is None:
            assert key in own
        else:
            text = own[key].strip("`")
            default = field.default
            assert (float(text) if isinstance(default, float) else text) in (
                default,
                str(default),
            )


def test_the_model_of_the_documentation_computes(tmp_path: Path) -> None:
    """The page's model in its spec, as both stand there."""
    page = ROOT / "docs" / "adding-a-model.md"
    (tmp_path / "mytheory.py").write_text(blocks(page, "python")[0], encoding="utf-8")
    (spec,) = blocks(page, "yaml")
    results = rb.run(load_spec(spec, folder=tmp_path))
    ours, persson = (results["main"][label]["area"] for label in ("erf09", "persson"))
    assert (ours < persson).all()
    assert "separation" not in results["main"]["erf09"]


def test_every_declaration_of_a_model_is_documented() -> None:
    page = text_of("docs/adding-a-model.md")
    own = {name for name in vars(Model) if not name.startswith(("_", "model_"))}
    internal = {"name", "reference", "referred_to", "dimension", "label", "realizations"}
    internal |= {"is_reference", "undersampling", "is_vectorized", "make_fields", "grid_points"}
    for name in own - internal:
        assert f"`{name}" in page, name


def test_every_figure_is_documented() -> None:
    described = rows("docs/figures.md")
    assert [figure for figure in described if figure in FIGURES] == list(FIGURES)
    assert set(re.findall(r"`(\w+)`", text_of("docs/cli.md"))) >= set(FIGURES)


def test_every_variable_of_a_results_file_is_documented(small_spec: dict[str, Any]) -> None:
    small_spec["models"].append({"kind": "bem", "grid": 64, "realizations": 1})
    small_spec["surface"]["q1"] = 16.0
    page = text_of("docs/results.md")
    described = set(re.findall(r"`(\w+)`", page))
    for _, result in rb.run(small_spec).models():
        for variable in result:
            base = re.sub(r"_(mean|sem|median|q16|q84)$", "", variable)
            assert base in described, variable


def test_every_variable_of_the_fields_is_documented() -> None:
    described = set(re.findall(r"`(\w+)`", text_of("docs/observables.md")))
    for name, observable in OBSERVABLES.items():
        assert {name, observable.variable, *observable.scalars} <= described
    assert {*FIELD_VARIABLES, "x", "y", "dimension", "exponent_from"} <= described


# -- one version -------------------------------------------------------------------------


def test_all_files_name_the_same_version() -> None:
    project = tomllib.loads(text_of("pyproject.toml"))["project"]
    citation = yaml.safe_load(text_of("CITATION.cff"))
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"] == "BSD-3-Clause"
    assert citation["title"] == project["name"]
    changes = re.findall(r"^## \[(.*?)\]", text_of("CHANGELOG.md"), re.MULTILINE)
    assert changes[0] == "Unreleased" or changes[0] == project["version"]
    assert "### Numerics" in text_of("CHANGELOG.md")
