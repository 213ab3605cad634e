"""The table of each contender: where it can be trusted."""

from __future__ import annotations

from roughbench.report.sources import ReportSource
from roughbench.report.text import plain
from roughbench.report.trust import trust_tables
from roughbench.results import Results
from roughbench.verdict import fit_experiments, trust_of
from tests.fits.lawful import collect, make
from tests.fits.test_comparisons import exact_curves
from tests.report.conftest import EXPERIMENTS, RESAMPLES, Page, page_of


def test_every_contender_of_every_experiment_has_a_table(small: Results) -> None:
    trusts = trust_of(fit_experiments([("small.h5", small)], None, RESAMPLES))
    found = list(trust_tables([ReportSource("small.h5", small)], trusts))
    assert [plain(heading) for heading, _ in found] == ["qr/q0\xa0=\xa01", "qr/q0\xa0=\xa04"]
    for _, tables in found:
        foundation, persson = tables
        assert plain(foundation.title).startswith("Popov (1D foundation), 20 lines, against")
        assert plain(persson.title).startswith("Persson, from the spectrum alone, against")
        for table in tables:
            assert [plain(row[0]) for row in table.rows] == [
                "contact area A/A0",
                "mean separation ū",
                "stiffness K",
            ]
            assert [plain(heading) for heading in table.headings[2:]] == [
                "at 0.001 E*",
                "at 0.0063 E*",
                "at 0.1 E*",
            ]


def test_the_sentences_stand_on_the_page(small: Results) -> None:
    text = " ".join(Page(page_of(small)).text.split())
    for one in trust_of(fit_experiments([("small.h5", small)], None, RESAMPLES)):
        assert one.basis in text
        for trust in one.quantities:
            assert trust.range_text in text
            assert all(deviation.text in text for deviation in trust.deviations)
    assert len(EXPERIMENTS) * 2 == text.count("; ± is one standard error")


def test_without_an_exact_solution_it_says_what_to_add(small: Results) -> None:
    theories = {name: {"persson": models["persson"]} for name, models in small.items()}
    results = Results(theories, small.spec_text, small.spec_sha256)
    text = " ".join(Page(page_of(results)).text.split())
    assert "no exact solution to hold the models against: add bem" in text


def test_the_only_experiment_has_no_heading() -> None:
    results = collect(make(exact_curves()), make(exact_curves(), "persson"))
    trusts = trust_of(fit_experiments([("one.h5", results)], None, 2))
    [(heading, [table])] = trust_tables([ReportSource("one.h5", results)], trusts)
    assert heading == []
    assert plain(table.rows[0][1]).endswith("to 0.1 E*, the lowest pressure to the highest")
