"""Every citation of the paper, in code and documentation, against the table of its places."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from roughbench.verdict.claims import CLAIMS
from roughbench.verdict.paper import PASSAGES, citations, passage_of

ROOT = Path(__file__).parents[2]
HERE = {Path(__file__), ROOT / "roughbench/verdict/paper.py"}
FOLDERS = ("roughbench", "docs", "configs", "scripts", "examples", "tests")
_SPELLED = re.compile(
    r"(?<!-)\b(?:[Ee]quations?|[Ee]qn?s?)\.?[ ~]?\(?\d|\bFigures? \d\b|\bSections? \d\b"
    r"|\bsecs?\. ?\d"
)
"""Ways to cite that :func:`citations` would not see; places of others are cited in words."""
FILES = [
    path
    for folder in FOLDERS
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in (".py", ".md", ".yaml", ".j2", ".sh")
    and path not in HERE
    and "plotly" not in path.parts
] + [ROOT / "README.md", ROOT / "Makefile", ROOT / "CONTRIBUTING.md"]
BARE = re.compile(r"[\w\s().,–]*")
"""A string that is nothing but places: those of claims, which are tested for themselves."""


def pieces(path: Path) -> Iterator[str]:
    """Yield texts that belong together: strings and comments of code, paragraphs of pages."""
    text = path.read_text(encoding="utf-8")
    if not citations(text):
        return
    if path.suffix == ".py":
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value
        comments, last = "", -1
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT:
                if token.start[0] != last + 1:
                    yield comments
                    comments = ""
                comments += " " + token.string.lstrip("# ")
                last = token.start[0]
        yield comments
    elif path.suffix in (".yaml", ".sh", "") or path.name == "Makefile":
        yield re.sub(r"\n\s*#", " ", text)
    else:
        yield text


def sentences(path: Path) -> Iterator[str]:
    """Yield the sentences of a file, and the rows of its tables."""
    for piece in pieces(path):
        for paragraph in re.split(r"\n\s*\n|\n(?=\| )|\n\.\. |\n(?=[-=]{3})", piece):
            yield from re.split(r"(?<=[.!?])\s+(?=[A-Z*])", re.sub(r"\s+", " ", paragraph))


def is_bare(path: Path, text: str) -> bool:
    """Return whether a text is the place of a claim, or what a test compares one with."""
    may_be = path.name.startswith("claims") or "tests" in path.parts
    return may_be and BARE.fullmatch(text) is not None


def faults(text: str) -> Iterator[str]:
    """Yield what is wrong with the citations in a text."""
    known = {passage.place for passage in PASSAGES}
    for place in citations(text):
        if place not in known:
            yield f"the paper has no {place}: {text}"
        elif not passage_of(place).concerns(re.sub(re.escape(place), "", text)):
            yield f"{place} is about {passage_of(place).about}, this is not: {text}"


def test_what_is_cited_stands_there() -> None:
    found = [
        f"{path.relative_to(ROOT)}: {fault}"
        for path in FILES
        for text in sentences(path)
        if not is_bare(path, text)
        for fault in faults(text)
    ]
    assert found == []
    assert sum(len(citations(path.read_text(encoding="utf-8"))) for path in FILES) > 50


def test_every_claim_has_a_place_that_says_it() -> None:
    for claim in CLAIMS:
        words = [claim.statement, *(one.text for one in claim.criteria)]
        assert list(faults(f"{claim.place}: {' '.join(words)}")) == [], claim.key


def test_places_are_cited_in_one_way() -> None:
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        for found in _SPELLED.finditer(text):
            rest = text[found.start() :]
            assert citations(rest)[:1], f"{path.name}: {rest[:60]}"


def test_the_papers_places_are_there_once() -> None:
    places = [passage.place for passage in PASSAGES]
    assert len(set(places)) == len(places)
    assert [one for one in places if one.startswith("eq.")] == [
        f"eq. ({number})" for number in range(1, 11)
    ]
    assert [one for one in places if one.startswith("Sec.")] == [
        f"Sec. {number}" for number in range(1, 7)
    ]
    for passage in PASSAGES:
        assert passage.concerns(passage.about), passage.place


@pytest.mark.parametrize(
    "text",
    [
        "The area is A/A₀ = κ p/(E*ξ), eq. (9).",
        "The stiffness K = p/u₀, eq. (3).",
        "The stiffness, eqs. (9) and (11).",
        "The stress correlation of Fig. 4.",
        "The elastic energy of Fig. 3(c).",
        "The contact area of Sec. 7.",
    ],
)
def test_a_wrong_citation_would_be_found(text: str) -> None:
    assert len(list(faults(text))) == 1


def test_the_documentation_has_the_same_table() -> None:
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    rows = [
        line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")
    ]
    found = {cells[0]: cells[1].replace("\\*", "*") for cells in rows if len(cells) > 1}
    for passage in PASSAGES:
        assert found[passage.place] == passage.about
