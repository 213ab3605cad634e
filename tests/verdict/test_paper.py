"""Every citation of the paper, in code and documentation, against the table of its places."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from roughbench.verdict.claims import CLAIMS
from roughbench.verdict.paper import CITATION, PASSAGES, SAID_AT, citations, passage_of
from tests.verdict.texts import HERE, KINDS, ROOT, TABLE, files, sentences

KNOWN = {passage.place for passage in PASSAGES}
SUBJECT = re.compile(
    "|".join(
        {*(word for one in PASSAGES for word in one.words), *(word for word, _ in SAID_AT)}
    )
)
_SPELLED = re.compile(
    r"[Ee]q(?:uation|n)?s?\b\.?[\s~]*\(?\d|[Ff]ormul(?:a|ae|as)\b[\s~]*\(?\d"
    r"|[Ss]ec(?:tion)?s?\b\.?[\s~]*\d|[Ff]ig(?:ure)?s?\b\.?[\s~]*\d(?!\d)"
    r"|[Pp]aper['’]s (?:discussion|conclusion|summary)"
    r"|(?:[Dd]iscussion|[Cc]onclusions?|[Ss]ummary) of the paper|§\s*\d[^.]*paper"
)
"""Other ways to cite; places of others are cited in words."""
PAST = {ROOT / "CHANGELOG.md"}
"""It says which citations were wrong."""
BARE = re.compile(r"[\w\s().,–]*")
"""A string that is nothing but places: those of claims, which are tested for themselves."""
_BETWEEN = re.compile(r"[\s,()*]*(?:and|or)?[\s()*]*")


def clauses(text: str) -> Iterator[tuple[list[str], str]]:
    """Yield the places that are cited together, and what is said with them.

    That is what stands before them, back to the places before, if it is about anything in the
    paper; else what comes after them; else all. In a table the cell comes first.
    """
    groups: list[tuple[int, int, list[str]]] = []
    for found in CITATION.finditer(text):
        start, end, places = found.start(), found.end(), citations(found[0])
        if groups and _BETWEEN.fullmatch(text[groups[-1][1] : start]):
            start, _, others = groups.pop()
            places = others + places
        groups.append((start, end, places))
    first = 0
    for k, (start, end, places) in enumerate(groups):
        last = groups[k + 1][0] if k + 1 < len(groups) else len(text)
        before, after = text[first:start], text[end:last]
        cell = (before.rpartition("|")[2], after.partition("|")[0])
        parts = (*cell, before, after)
        yield places, next(filter(SUBJECT.search, parts), CITATION.sub("", text))
        first = end


def faults(text: str) -> Iterator[str]:
    """Yield what is wrong with the citations in a text."""
    for places, clause in clauses(text):
        for place in places:
            if place not in KNOWN:
                yield f"the paper has no {place}: {text}"
            elif not passage_of(place).concerns(clause):
                yield f"{place} is about {passage_of(place).about}, this is not: {clause}"
        for word, homes in SAID_AT:
            elsewhere = set(places) <= KNOWN and not set(places) & set(homes)
            if elsewhere and re.search(word, clause):
                yield f"{' and '.join(homes)} says it, not {' or '.join(places)}: {clause}"
    for found in _SPELLED.finditer(text):
        is_word = not re.match(r"[-\w]", text[found.start() - 1 : found.start()])
        if is_word and not CITATION.match(text, found.start()):
            yield f"not the way to cite: {text[found.start() :][:40]}"


def is_bare(path: Path, text: str) -> bool:
    """Return whether a text is the place of a claim, or what a test compares one with."""
    may_be = path.name.startswith("claims_of") or "tests" in path.parts
    return may_be and BARE.fullmatch(text) is not None and set(citations(text)) <= KNOWN


def test_what_is_cited_stands_there() -> None:
    found, count = [], 0
    for path in files():
        text = path.read_text(encoding="utf-8")
        count += len(citations(text))
        if path not in PAST and (CITATION.search(text) or _SPELLED.search(text)):
            found += [
                f"{path.relative_to(ROOT)}: {fault}"
                for sentence in sentences(path, text)
                if not is_bare(path, sentence)
                for fault in faults(sentence)
            ]
    assert found == []
    assert count > 100


def test_no_file_is_left_out() -> None:
    """Whatever is kept and can be read is looked at, in files of other kinds for a citation."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, check=False)
    if listed.returncode:
        pytest.skip("not a checkout")
    seen = {*files(), *HERE, TABLE}
    for name in listed.stdout.decode().splitlines():
        path = ROOT / name
        if path in seen or not path.is_file() or "plotly" in path.parts:
            continue
        text = path.read_bytes().decode("utf-8", errors="ignore")
        assert "\0" in text or citations(text) == [], name
        assert path.suffix not in KINDS or path.name.startswith("."), name


def test_every_claim_has_a_place_that_says_it() -> None:
    for claim in CLAIMS:
        places = set(citations(claim.place))
        statement = CITATION.sub("", claim.statement)
        said = " ".join([statement, *(CITATION.sub("", one.text) for one in claim.criteria)])
        assert all(passage_of(place).concerns(said) for place in places), claim.key
        for word, homes in SAID_AT:
            if places and re.search(word, statement):
                assert set(homes) & places, (claim.key, word)


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
    for _, homes in SAID_AT:
        assert set(homes) <= KNOWN


@pytest.mark.parametrize(
    "text",
    [
        "The area is A/A₀ = κ p/(E*ξ), eq. (9).",
        "The stiffness K = p/u₀, eq. (3).",
        "The stiffness, eqs. (9) and (11).",
        "The stress correlation of Fig. 4.",
        "The elastic energy of Fig. 3(c).",
        "The contact area of Sec. 7.",
        "The contact area, eq. (9), and K = p/u₀.",
        "Eq. (9) gives the area and eq. (9) the stiffness.",
        "K ∼ p over three decades, Sec. 5.",
        "The area of Fig. 12.",
        "The area of Fig. 3a.",
        "The area of Sec. 3.1.",
        "The stiffness, equation (9), and so eq. (9).",
        "The stiffness of eqn. (9).",
        "The stiffness (eq. 9).",
        "The area, Equation\n(3).",
        "The area, section 3.",
        "The area, § 3 of the paper.",
        "The area, figure 3.",
        "The linear region, in the paper's discussion.",
        "The neglect of coupling, abstract as published.",
    ],
)
def test_a_wrong_citation_would_be_found(text: str) -> None:
    assert list(faults(text))


NOTEBOOK = '{"cells": [{"cell_type": "markdown", "source": ["TEXT"]}]}'


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("page.md", "\nThe stiffness, eq. (3).\n"),
        ("page.md", "- one\n- the stiffness, eq. (3)\n- the area\n"),
        ("page.md", "| a | b |\n|---|---|\n| area | K, eq. (3) |\n"),
        ("code.py", '"""The stiffness, eq.\n(3).\n"""\n'),
        ("code.py", "# The stiffness,\n# eq. (3).\n"),
        ("code.py", 'print(f"The stiffness {1} of eq. (3)")\n'),
        ("spec.yaml", "# The stiffness,\n# eq. (3).\na: 1\n"),
        ("spec.yaml", "area: 1\n# The stiffness,\n# eq. (3).\n"),
        ("page.js", "// The stiffness,\n// eq. (3).\n"),
        ("spec.yaml.txt", "# The stiffness,\n# eq. (3).\n"),
        ("model.py.txt", 'class @CLASS@:\n    """The stiffness, eq. (3)."""\n'),
        ("page.txt", "The stiffness, eq. (3).\n"),
        ("page.html.j2", "<p>The stiffness, eq. (3).</p>\n"),
        ("book.ipynb", NOTEBOOK.replace("TEXT", "The stiffness,\\neq. (3).")),
        ("book.ipynb", NOTEBOOK.replace("TEXT", "# K of eq. (3)").replace("markdown", "code")),
    ],
)
def test_it_would_be_found_in_every_kind_of_file(name: str, text: str) -> None:
    found = [fault for one in sentences(Path(name), text) for fault in faults(one)]
    assert len(found) == 1
    right = text.replace("(3)", "(9)")
    assert not [fault for one in sentences(Path(name), right) for fault in faults(one)]


def test_the_documentation_has_the_same_table() -> None:
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    rows = [
        line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")
    ]
    found = {cells[0]: cells[1].replace("\\*", "*") for cells in rows if len(cells) > 1}
    for passage in PASSAGES:
        assert found[passage.place] == passage.about
