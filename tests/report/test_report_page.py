"""What stands on the page, that it says nothing else, and that it loads nothing."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import roughbench.report
from roughbench import fits
from roughbench.errors import StoreError
from roughbench.fits.laws import fit_laws
from roughbench.numbers import number, with_error
from roughbench.report import make_report, read_sources
from roughbench.report.sources import ReportSource, names_of, places
from roughbench.report.tables import compared
from roughbench.report.text import plotly_text
from roughbench.results import ModelResult, Results
from roughbench.verdict import Outcome, judge
from roughbench.verdict.judging import GROUPS
from tests.report.conftest import (
    EXPERIMENTS,
    LABELS,
    RESAMPLES,
    Change,
    Page,
    a_verdict,
    page_of,
)

TITLES = {"bem": "Exact (BEM)", "foundation": "Popov (1D foundation)", "persson": "Persson"}


@pytest.fixture(scope="module")
def report(results_file: Path) -> str:
    return make_report([results_file], resamples=RESAMPLES)


@pytest.fixture(scope="module")
def page(report: str) -> Page:
    return Page(report)


# -- what it says ------------------------------------------------------------------------


def test_every_verdict_of_the_results_has_a_row(page: Page, small: Results) -> None:
    verdicts = judge([("small.h5", small)], resamples=RESAMPLES)
    rows = [given["id"] for tag, given in page.elements if tag == "tr" and "id" in given]
    contenders = [v for v in verdicts if v.contender]
    claims = [v for v in verdicts if not v.contender]
    untested = [v for v in claims if v.outcome is Outcome.NOT_TESTED]
    assert 0 < len(untested) < len(claims)
    ordered = sorted(
        claims, key=lambda v: (list(GROUPS).index(v.group), v.outcome is Outcome.NOT_TESTED)
    )
    assert rows == [f"claim-{verdict.key}" for verdict in (*contenders, *ordered)]
    links = {given.get("href") for tag, given in page.elements if tag == "a"}
    assert {f"#claim-{verdict.key}" for verdict in claims} <= links


def test_a_verdict_is_told_in_full() -> None:
    outcomes = list(Outcome)
    verdicts = [a_verdict(k, outcome=outcome) for k, outcome in enumerate(outcomes, 1)]
    text = Page(page_of(Results({}, "{}", ""), verdicts=verdicts)).text
    for verdict in verdicts:
        for part in (verdict.place, verdict.claim, verdict.rule, verdict.remedy):
            assert part in text
        assert re.search(rf"[✓✗±?–] {verdict.outcome}", text)  # a word and a symbol
    assert text.count("2.050 ± 0.020") == len(outcomes) - 1  # all but the one not tested
    assert text.count("a note") == len(outcomes) - 1


def test_claims_of_each_group_stand_and_count_apart() -> None:
    """One of the paper's holds; ours fail, which is no count against the paper."""
    groups = ("paper", "explanation", "beyond")
    verdicts = [
        replace(a_verdict(k, outcome=outcome), group=group)
        for k, (group, outcome) in enumerate(
            zip(groups, (Outcome.HOLDS, Outcome.FAILS, Outcome.FAILS), strict=True), 1
        )
    ]
    text = page_of(Results({}, "{}", ""), verdicts=verdicts)
    words = " ".join(Page(text).text.split())
    assert "1 claims on such contacts. On these results 1 hold, 0 fail" in words
    assert "2 more are tests of ours" in words
    places = [words.rindex(GROUPS[group]) for group in groups]
    assert places == sorted(places)
    _, *parts = text.split('<h3 id="h-')
    for part, verdict in zip(parts, verdicts, strict=True):
        assert f'id="claim-{verdict.key}"' in part


@pytest.mark.parametrize("outcome", Outcome)
def test_claims_are_counted_by_their_outcome(outcome: Outcome) -> None:
    verdicts = [a_verdict(1, outcome=outcome), a_verdict(2, outcome=outcome)]
    summary = page_of(Results({}, "{}", ""), verdicts=verdicts).partition('<dl class="counts">')
    counts = re.findall(r"<strong>(\d+)</strong>", summary[2])
    assert counts == ["2" if outcome is other else "0" for other in Outcome]


def test_every_model_and_experiment_is_on_the_page(report: str, page: Page) -> None:
    boxes = [given for tag, given in page.elements if given.get("type") == "checkbox"]
    values = {
        name: [b["value"] for b in boxes if b["name"] == name]
        for name in ("model", "experiment")
    }
    assert values == {"model": list(LABELS), "experiment": list(EXPERIMENTS)}
    fits = report.partition('id="fits"')[2].partition('id="warnings"')[0]
    for label in LABELS:
        title = TITLES[label]
        assert fits.count(f'<th scope="row">{title}</th>') >= 2 * len(EXPERIMENTS)
        assert f"{title} {label}" in page.text  # in the legend


def test_the_spec_and_how_to_compute_it_again(page: Page, small: Results) -> None:
    assert small.spec_text.strip() in page.text
    assert small.spec_sha256 in page.text
    assert "roughbench run small.yaml -o small.h5" in page.text
    assert f"roughbench report small.h5 --resamples {RESAMPLES}" in page.text


def test_two_files_have_charts_and_fits_each(results_file: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.h5"
    other.write_bytes(results_file.read_bytes())
    page = Page(make_report([results_file, other], resamples=RESAMPLES))
    sections = [given for tag, given in page.elements if given.get("class") == "file"]
    assert [given["aria-label"] for given in sections] == ["small.h5", "other.h5"]
    assert page.tags.count("figure") == 10
    assert "other.h5: main" not in page.text
    for name in ("small.h5", "other.h5"):
        assert f"{name}: qr/q0\xa0=\xa04" in page.text


def test_a_place_is_named_as_in_the_figures(results_file: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.h5"
    other.write_bytes(results_file.read_bytes())
    sources = read_sources([results_file, other])
    place = places(sources)["other.h5: surface.qr=4.0/bem"]
    experiment = "q<sub>r</sub>/q<sub>0</sub>\xa0=\xa04"
    assert place.model == "Exact (BEM)"
    assert plotly_text(place.details) == f"{experiment}, other.h5"
    assert plotly_text(place.full) == f"other.h5, {experiment}, Exact (BEM)"
    page = make_report([results_file, other], resamples=RESAMPLES)
    assert f'Exact (BEM), <span class="muted">{experiment}, other.h5</span>' in page
    verdicts = judge([(s.name, s.results) for s in sources], resamples=RESAMPLES)
    named = {m.where for verdict in verdicts for m in verdict.measurements}
    assert named
    assert named <= set(places(sources))
    alone = judge([("small.h5", sources[0].results)], resamples=RESAMPLES)
    assert {m.where for v in alone for m in v.measurements} <= set(places(sources[:1]))


def test_files_of_the_same_name_are_told_apart(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("a/x/r.h5", "b/x/r.h5", "b/s.h5")]
    assert names_of(paths) == ["a/x/r.h5", "b/x/r.h5", "s.h5"]
    with pytest.raises(StoreError, match="given twice"):
        names_of([tmp_path / "r.h5", tmp_path / "." / "r.h5"])


def test_an_unknown_reference_is_refused(results_file: Path) -> None:
    with pytest.raises(StoreError, match="no model is named 'exact'"):
        make_report([results_file], reference="exact", resamples=RESAMPLES)


def test_a_reference_is_used_where_it_is_named(results_file: Path) -> None:
    page = Page(make_report([results_file], reference="persson", resamples=RESAMPLES))
    assert "agrees with Persson" in page.text
    assert "--reference persson" in page.text


def test_figures_and_trust_stand_before_the_claims(page: Page) -> None:
    sections = [
        given["id"] for tag, given in page.elements if tag == "section" and "id" in given
    ]
    assert sections == [
        "surface",
        "figures",
        "trust",
        "warnings",
        "fits",
        "provenance",
        "verdicts",
    ]


def test_what_cannot_be_tested_is_one_line() -> None:
    outcomes = [Outcome.HOLDS, Outcome.NOT_TESTED, Outcome.FAILS, Outcome.NOT_TESTED]
    verdicts = [a_verdict(k, outcome=outcome) for k, outcome in enumerate(outcomes, 1)]
    text = page_of(Results({}, "{}", ""), verdicts=verdicts)
    shown, fold, folded = text.partition('<details class="untested">')
    assert fold
    rows = re.compile(r'<tr id="claim-claim-(\d)"')
    assert rows.findall(shown) == ["1", "3"]
    assert rows.findall(folded) == ["2", "4"]
    assert "2 claims cannot be tested on these results (No. 2, 4)" in Page(text).text
    assert (
        "1 hold, 1 fail, 0 depend on the surface, 0 are undecided, 2 cannot be tested"
        in Page(text).text
    )


def test_what_a_spec_needs_is_set_as_in_a_spec(page: Page, report: str) -> None:
    del page
    assert "a spec with <code>bem</code> and <code>winkler</code>" in report
    assert "<code>sweep: {surface.below_qr: [rolloff, cutoff]}</code>" in report


def test_every_model_is_fitted_once(
    results_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def counted(*given: Any) -> Any:
        calls.append(len(calls))
        return fit_laws(*given)

    monkeypatch.setattr(fits, "fit_laws", counted)
    make_report([results_file], resamples=RESAMPLES)
    assert len(calls) == len(LABELS) * len(EXPERIMENTS)


def test_a_page_has_at_most_two_megabytes(report: str) -> None:
    """And most of it is plotly.js: what is unused of it is left out."""
    assert len(report.encode()) < 1.5e6


def test_plotly_is_the_version_that_its_notes_say() -> None:
    folder = Path(roughbench.report.__file__).parent / "plotly"
    script = (folder / "plotly-basic.min.js").read_text(encoding="utf-8")
    version = re.search(r"^\* plotly\.js \(basic - minified\) v([\d.]+)$", script, re.MULTILINE)
    assert version is not None
    assert f"plotly.js {version[1]}," in (folder / "README.md").read_text(encoding="utf-8")
    assert "Plotly" in (folder / "LICENSE").read_text(encoding="utf-8")
    assert "</script" not in script.lower()


# -- that it says nothing else -----------------------------------------------------------


def test_the_same_file_gives_the_same_bytes(results_file: Path, report: str) -> None:
    assert make_report([results_file], resamples=RESAMPLES) == report


def test_no_folder_of_the_writer_is_told(
    results_file: Path, report: str, small: Results, change: Change
) -> None:
    for folder in results_file.resolve().parents[:-1]:
        assert str(folder) not in report
    spec = small.spec_text + "\n# from /home/annika/rough/heights.npy and ~/b/c.h5:/z"
    for label in LABELS:
        small = change(small, label, {"surface": "file", "heights": "/home/annika/h.npy"})
    changed = Results(small.experiments, spec, "", "small")
    page = page_of(changed)
    assert "annika" not in Page(page).text
    assert "from …/heights.npy and …/c.h5" in page
    assert "heights of h.npy" in page


@pytest.mark.parametrize("surface", ["self-affine", "file"])
def test_an_option_is_no_heights_file(small: Results, surface: str) -> None:
    """Springs with heights: realized were pressed on heights of realized."""
    experiments = {}
    for name, models in small.items():
        bem = models["bem"]
        known = dict(bem.attributes) | {"surface": surface, "heights": "/home/annika/h.npy"}
        springs = ModelResult(
            "winkler", "winkler", "Winkler", known | {"heights": "realized"}, bem.variables
        )
        file = ModelResult("bem", "bem", bem.title, known, bem.variables)
        experiments[name] = {"bem": file, "winkler": springs}
    source = ReportSource("r.h5", Results(experiments, "", "", "small"))
    (row,) = compared([source]).rows
    words = "".join(span.text for cell in row if not isinstance(cell, str) for span in cell)
    assert ("heights of h.npy" in words) == (surface == "file")
    assert "realized" not in words


HOSTILE = "</script><script>alert(1)</script><img src=x onerror='a'>\"&$title ${names}"


def test_hostile_text_changes_no_element(small: Results) -> None:
    def named(word: str) -> Page:
        models = {
            f"{label}{word}": ModelResult(
                f"{label}{word}",
                result.kind,
                result.title + word,
                dict(result.attributes) | {"heights": word},
                result.variables,
            )
            for label, result in small["surface.qr=1.0"].items()
        }
        results = Results({f"a{word}": models}, small.spec_text + word, word, word)
        verdicts = [a_verdict(k, word, o) for k, o in enumerate(Outcome)]
        return Page(page_of(results, verdicts=verdicts, name=f"{word}.h5"))

    plain, hostile = named("harmless"), named(HOSTILE)
    assert hostile.tags == plain.tags
    assert hostile.text.count(HOSTILE) > 20
    for mine, theirs in zip(hostile.elements, plain.elements, strict=True):
        assert mine[1].keys() == theirs[1].keys()
    for script in hostile.scripts:
        if script != plain.scripts[hostile.scripts.index(script)]:
            assert "<" not in script  # data: no tag can end or begin there


# -- that it loads nothing ---------------------------------------------------------------


def test_nothing_is_loaded_from_anywhere(page: Page) -> None:
    for tag, given in page.elements:
        assert tag not in ("link", "iframe", "object", "embed", "base", "form[action]")
        assert tag != "img" or (given["src"] or "").startswith("data:image/png;base64,")
        assert tag == "img" or "src" not in given
        assert not {"srcset", "data", "action", "poster", "background"} & set(given)
        href = given.get("href") or "#"
        assert href.startswith("#") or (tag == "a" and href.startswith("https://doi.org/"))
        assert "http-equiv" not in given or given["http-equiv"] == "Content-Security-Policy"
    for style in page.styles:
        assert "url(" not in style
        assert "@import" not in style
        assert "@font-face" not in style


def test_browsers_are_told_to_load_nothing(page: Page) -> None:
    policies = [given["content"] for _, given in page.elements if "http-equiv" in given]
    (policy,) = policies
    assert policy == (
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
        "img-src data: blob:"
    )


def test_tables_need_no_script_and_have_headings(report: str, page: Page) -> None:
    assert report.count("<table") >= 10
    assert "<noscript>" in report
    headings = [given for tag, given in page.elements if tag == "th"]
    assert headings
    assert all(given.get("scope") in ("row", "col") for given in headings)
    assert dict(page.elements)["html"] == {"lang": "en"}
    pictures = [given for _, given in page.elements if given.get("class") == "plot"]
    assert all(given["role"] == "img" and given["aria-label"] for given in pictures)


# -- numbers -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.001, "0.001"), (99950.0, "10⁵"), (-2.5e-7, "−2.5·10⁻⁷"), (1e-5, "10⁻⁵"), (0.0, "0")],
)
def test_a_number_has_three_digits(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (2.0, 13.0, "2 ± 13"),
        (-0.5, 0.031, "−0.500 ± 0.031"),
        (12345.0, 67.0, "(1.2345 ± 0.0067)·10⁴"),
        (1.5, 0.0, "1.5"),
        (float("inf"), float("nan"), "∞"),
        (0.25, 1e-17, "0.25"),
    ],
)
def test_an_error_has_two_digits_and_the_value_as_many(
    value: float, error: float, text: str
) -> None:
    assert with_error(value, error) == text


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no such file"):
        read_sources([tmp_path / "none.h5"])
