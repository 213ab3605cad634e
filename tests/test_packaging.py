"""What a release consists of: one version, a citation that is one, recipes that build."""

from __future__ import annotations

import datetime as dt
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from roughbench.spec import load_spec

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION: str = PROJECT["version"]
RECIPE = yaml.safe_load((ROOT / "packaging/conda/recipe.yaml").read_text(encoding="utf-8"))
CONDA_NAMES = {"matplotlib": "matplotlib-base"}


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere() -> None:
    assert yaml.safe_load(text_of("CITATION.cff"))["version"] == VERSION
    assert RECIPE["context"]["version"] == VERSION
    assert re.findall(r"^    VERSION=(.+)$", text_of("packaging/roughbench.def"), re.M) == [
        VERSION
    ]
    assert f"\n## [{VERSION}] - " in text_of("CHANGELOG.md")


# -- CITATION.cff --------------------------------------------------------------------------

REQUIRED = {"authors", "cff-version", "message", "title"}
ALLOWED = REQUIRED | {
    *("abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords"),
    *("license", "license-url", "preferred-citation", "references", "repository"),
    *("repository-artifact", "repository-code", "type", "url", "version"),
}
PERSON = {
    *("address", "affiliation", "alias", "city", "country", "email", "family-names", "fax"),
    *("given-names", "name-particle", "name-suffix", "orcid", "post-code", "region", "tel"),
    "website",
}
ENTITY = PERSON - {"family-names", "given-names", "affiliation"} | {
    *("date-end", "date-start", "location", "name"),
}
DOI = r"10\.\d{4,9}(\.\d+)?/[A-Za-z0-9:/_;\-\.\(\)\[\]\\]+"


def faults_of(citation: dict[str, Any]) -> Iterator[str]:
    """Yield what is against the rules of the format, version 1.2.0, as far as we use it."""
    yield from (f"{key} is missing" for key in REQUIRED - citation.keys())
    yield from (f"{key} is unknown" for key in citation.keys() - ALLOWED)
    if citation.get("cff-version") != "1.2.0":
        yield "cff-version is not 1.2.0"
    if citation.get("type", "software") not in ("software", "dataset"):
        yield "type is neither software nor dataset"
    for key in ("abstract", "license", "message", "title", "version"):
        if not (isinstance(citation.get(key, "x"), str) and citation.get(key, "x").strip()):
            yield f"{key} is no text"
    if not isinstance(citation.get("date-released", dt.date.min), dt.date):
        yield "date-released is no date"
    words = citation.get("keywords", ["x"])
    if not words or len(set(words)) < len(words):
        yield "keywords are none, or double"
    for place in [citation, *citation.get("references", [])]:
        yield from _faults_of_work(place)
    for reference in citation.get("references", []):
        yield from (f"a reference has no {key}" for key in {"type"} - reference.keys())


def _faults_of_work(work: dict[str, Any]) -> Iterator[str]:
    yield from (f"a work has no {key}" for key in {"authors", "title"} - work.keys())
    for author in work.get("authors", ()):
        if not author or not (author.keys() <= PERSON or author.keys() <= ENTITY):
            yield f"{author} is neither a person nor an entity"
    if not re.fullmatch(DOI, work.get("doi", "10.1007/x")):
        yield f"{work['doi']} is no DOI"
    for key in ("start", "end", "volume", "year"):
        if not isinstance(work.get(key, 1), int | str):
            yield f"{key} is no number"


def test_the_citation_keeps_the_rules_of_its_format() -> None:
    citation = yaml.safe_load(text_of("CITATION.cff"))
    assert list(faults_of(citation)) == []
    assert citation["license"] == PROJECT["license"]
    assert citation["references"][0]["doi"] == "10.1007/s11249-013-0208-9"


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"authors": [{"surname": "x"}]}, "neither a person nor an entity"),
        ({"cff-version": "1.1.0"}, "is not 1.2.0"),
        ({"licence": "MIT"}, "licence is unknown"),
        ({"version": 0.2}, "version is no text"),
        ({"date-released": "yesterday"}, "is no date"),
        ({"doi": "doi:10.1/x"}, "is no DOI"),
        ({"references": [{"type": "article", "authors": [{"name": "x"}]}]}, "has no title"),
    ],
)
def test_a_fault_of_the_citation_would_be_found(change: dict[str, Any], fault: str) -> None:
    citation = yaml.safe_load(text_of("CITATION.cff")) | change
    assert any(fault in found for found in faults_of(citation))


# -- recipes ---------------------------------------------------------------------------------


def requirements(lines: list[str]) -> dict[str, str]:
    """Return the oldest version of each package that lines such as ``numpy >=1.26`` name."""
    found = [re.fullmatch(r"([\w.-]+)\s*>=\s*([\w.]+)\s*(;.*)?", line) for line in lines]
    return {match[1]: match[2] for match in found if match}


def test_conda_asks_for_what_pip_asks_for() -> None:
    wanted = requirements(PROJECT["dependencies"])
    assert len(wanted) == len(PROJECT["dependencies"])
    recipe = requirements([line for line in RECIPE["requirements"]["run"] if "$" not in line])
    assert recipe == {CONDA_NAMES.get(name, name): least for name, least in wanted.items()}
    python = RECIPE["context"]["python_min"]
    assert PROJECT["requires-python"] == f">={python}"
    assert RECIPE["build"]["python"]["entry_points"] == [
        f"{name} = {target}" for name, target in PROJECT["scripts"].items()
    ]
    for name in RECIPE["about"]["license_file"]:
        assert (ROOT / name).is_file()
    for name in RECIPE["tests"][1]["files"]["recipe"]:
        assert (ROOT / "packaging/conda" / name).is_file()


def test_what_packages_are_tried_with_is_a_spec_of_the_main_models() -> None:
    spec = load_spec(ROOT / "packaging/conda/smoke.yaml")
    assert {model.kind for model in spec.models} == {"bem", "foundation", "persson"}


INSTRUCTIONS = {"FROM", "ARG", "COPY", "RUN", "ENV", "WORKDIR", "ENTRYPOINT", "CMD"}


def test_the_dockerfile_reads() -> None:
    """Known instructions only; what it copies is there or is made by ``make dist``."""
    text = re.sub(r"\\\n", " ", text_of("packaging/Dockerfile"))
    lines = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    assert {line[0] for line in lines} == INSTRUCTIONS
    assert lines[0][0] == "FROM"
    copied = [name for line in lines if line[0] == "COPY" for name in line[1:-1]]
    assert copied == ["dist/roughbench-*.tar.gz", "packaging/conda/smoke.yaml"]
    assert (ROOT / copied[1]).is_file()
    for line in lines:
        if line[0] == "RUN":
            script = " ".join(line[1:])
            subprocess.run(["sh", "-n", "-c", script], check=True)


def test_the_apptainer_file_reads() -> None:
    """Its sections are those of the format, their scripts are a shell's, its files there."""
    text = text_of("packaging/roughbench.def")
    parts = re.split(r"^%(\w+)\n", text, flags=re.MULTILINE)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    assert list(sections) == ["arguments", "files", "post", "test", "runscript", "labels"]
    assert re.search(r"^Bootstrap: docker\nFrom: python:3\.\d+-slim$", parts[0], re.MULTILINE)
    base = re.search(r"^FROM (.*)$", text_of("packaging/Dockerfile"), re.MULTILINE)
    assert base is not None
    assert f"From: {base[1]}\n" in parts[0]
    given = dict(line.split("=") for line in sections["arguments"].split())
    assert set(re.findall(r"\{\{ (\w+) \}\}", text)) == set(given)
    for name in ("post", "test", "runscript"):
        script = re.sub(r"\{\{ (\w+) \}\}", lambda found: given[found[1]], sections[name])
        subprocess.run(["sh", "-n", "-c", script], check=True)
    files = sections["files"].strip().splitlines()
    archive, spec = (line.rsplit(maxsplit=1)[0].strip() for line in files)
    assert archive == "dist/roughbench-{{ VERSION }}.tar.gz"
    assert (ROOT / spec).is_file()


def test_scripts_are_those_of_a_shell() -> None:
    for script in sorted((ROOT / "scripts").glob("*.sh")):
        first = script.read_text(encoding="utf-8").splitlines()[0]
        shell = "bash" if first.endswith("bash") else "sh"
        subprocess.run([shell, "-n", script], check=True)


# -- built where the tools are -----------------------------------------------------------


def docker_works() -> bool:
    if shutil.which("docker") is None:
        return False
    asked = subprocess.run(["docker", "info"], capture_output=True, check=False)
    return asked.returncode == 0


def builder(tool: str) -> Callable[[], bool]:
    return lambda: shutil.which(tool) is not None


BUILDS: dict[str, tuple[Callable[[], bool], list[str]]] = {
    "docker": (
        docker_works,
        ["docker", "build", "-f", "packaging/Dockerfile", "-t", "roughbench:test", "."],
    ),
    "apptainer": (
        builder("apptainer"),
        ["apptainer", "build", "dist/roughbench.sif", "packaging/roughbench.def"],
    ),
    "rattler-build": (
        builder("rattler-build"),
        [
            *("rattler-build", "build", "--recipe", "packaging/conda/recipe.yaml"),
            *("-c", "conda-forge", "--output-dir", "dist/conda"),
        ],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("tool", list(BUILDS))
def test_a_package_is_built_and_tries_itself(tool: str, tmp_path: Path) -> None:
    works, command = BUILDS[tool]
    if not works():
        pytest.skip(f"{tool} cannot build here")
    copy = tmp_path / "checkout"
    leave_out = shutil.ignore_patterns(".venv*", ".git", "results", "figures", "dist", "*.h5")
    shutil.copytree(ROOT, copy, ignore=leave_out)
    subprocess.run([sys.executable, "-m", "build", "--sdist"], cwd=copy, check=True)
    subprocess.run(command, cwd=copy, check=True)
