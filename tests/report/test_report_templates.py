"""The templates escape what they are given, know every style, and alone make HTML."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from jinja2 import UndefinedError

import roughbench.report
from roughbench.report.page import load_templates, render
from roughbench.report.sources import ReportSource
from roughbench.report.styles import DASHES, SYMBOLS, PageStyle
from roughbench.report.tables import ReportTable
from roughbench.report.text import Span, from_notation
from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome
from tests.report.conftest import LABELS, Page, a_verdict

FOLDER = Path(roughbench.report.__file__).parent
HOSTILE = "<script>alert('x')</script>\"&{{ 7 * 7 }}"


def test_a_table_shows_title_headings_rows_and_notes() -> None:
    given = ReportTable(
        headings=["Model", from_notation("K h_rms"), HOSTILE],
        rows=[["Popov", [Span("1 "), Span("to", "muted"), Span(HOSTILE)], HOSTILE]],
        title=[Span(HOSTILE)],
        notes=["a note", [Span(HOSTILE, "code")]],
    )
    macros = load_templates().get_template("table.html.j2").module
    text = str(macros.table(given))  # type: ignore[attr-defined]
    page = Page(text)
    assert "K h<sub>rms</sub>" in text
    assert 'data-heading="K hrms"' in text
    assert '<span class="muted">to</span>' in text
    assert "a note" in page.text
    assert page.text.count(HOSTILE) == 5
    assert "script" not in page.tags
    assert {g.get("data-heading") for tag, g in page.elements if tag == "td"} == {
        "K hrms",
        HOSTILE,
    }


def test_every_symbol_and_every_dash_has_a_sample() -> None:
    legend = load_templates().get_template("legend.html.j2").module
    symbols = {
        legend.symbol_sample(PageStyle("#123456", name))  # type: ignore[attr-defined]
        for name in SYMBOLS
    }
    dashes = {legend.dash_sample(name) for name in DASHES}  # type: ignore[attr-defined]
    assert (len(symbols), len(dashes)) == (len(SYMBOLS), len(DASHES))
    for sample in symbols | dashes:
        page = Page(str(sample))
        assert page.tags[0] == "svg"
        assert all(given["d"] for tag, given in page.elements if tag == "path")


def test_what_is_missing_is_an_error() -> None:
    with pytest.raises(UndefinedError):
        load_templates().get_template("page.html.j2").render()


def test_only_files_of_the_package_are_not_escaped() -> None:
    templates = {
        path.name: path.read_text(encoding="utf-8")
        for path in FOLDER.glob("templates/*.html.j2")
    }
    assert len(templates) > 5
    unescaped = re.findall(r"\{\{ ([^}]*safe[^}]*) \}\}", "".join(templates.values()))
    assert sorted(unescaped) == [
        'asset("plotly", "plotly-basic.min.js") | safe',
        'asset("templates", "page.css") | safe',
        'asset("templates", "page.js") | safe',
    ]
    assert not any("autoescape" in text for text in templates.values())


def test_no_module_makes_html() -> None:
    """But for plotly's: sub- and superscripts, and line breaks where a curve is hovered."""
    found = {}
    for path in FOLDER.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        texts = [
            str(node.value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and id(node) not in docstrings
        ]
        tags = {tag for text in texts for tag in re.findall(r"(?<!\?P)</?\w*[ >]?", text)}
        if tags - {"<"}:
            found[path.name] = tags - {"<"}
    assert found == {"__init__.py": {"<meta "}, "curves.py": {"<br>"}, "text.py": {"</"}}


def test_models_have_verdicts_of_their_own_before_the_claims() -> None:
    claims = [a_verdict(1), a_verdict(2, outcome=Outcome.NOT_TESTED)]
    text = render([], claims, [], resamples=10, contenders=[a_verdict(3)])
    rows = re.findall(r'<tr id="claim-claim-(\d)"><th scope="row">(\d)</th>', text)
    assert rows == [("3", "3"), ("1", "1"), ("2", "2")]
    assert "Every contender by one rule" in text
    assert "made\n2 claims" in text
    assert "Every contender by" not in render([], claims, [], resamples=10)


def test_a_quantity_that_a_model_has_not_is_not_given(small: Results) -> None:
    def area_only(result: ModelResult) -> ModelResult:
        known = {
            name: values
            for name, values in result.variables.items()
            if not name.startswith(("separation", "stiffness"))
        }
        return ModelResult(result.label, result.kind, result.title, result.attributes, known)

    def page(*without: str) -> str:
        experiments = {
            name: {
                label: area_only(result) if label in without else result
                for label, result in models.items()
            }
            for name, models in small.items()
        }
        results = Results(experiments, small.spec_text, small.spec_sha256, small.name)
        return render([ReportSource("r.h5", results)], [], [], resamples=10)

    assert "Not given" not in page()
    assert "Quantities not given" not in page()
    some = Page(page("foundation"))
    assert some.tags.count("figure") == 5
    assert some.text.count("Not given by Popov (1D foundation).") == 3
    assert "● Quantities not given" in some.text
    assert "r.h5 ū, K by foundation." in some.text
    every = Page(page(*LABELS))
    assert every.tags.count("figure") == 2  # area and κ
    assert f"r.h5 {'; '.join(f'ū, K by {label}' for label in LABELS)}." in every.text
