"""Results of a small run, changed where a test needs it, and pages made of them."""

from __future__ import annotations

from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughbench as rb
from roughbench.report.page import render
from roughbench.report.sources import ReportSource
from roughbench.results import ModelResult, Results
from roughbench.verdict import Measurement, Outcome, Verdict, fit_experiments

SPEC: dict[str, Any] = {
    "name": "small",
    "surface": {"H": 0.7, "q0": 1.0, "q1": 16.0, "slope": 0.1},
    "pressures": {"min": 1e-3, "max": 0.1, "points": 6},
    "realizations": 5,
    "seed": 7,
    "models": [
        {"kind": "bem", "grid": 64},
        {"kind": "foundation", "springs": 128, "realizations": 20},
        {"kind": "persson"},
    ],
    "sweep": {"surface.qr": [1.0, 4.0]},
}
EXPERIMENTS = ("surface.qr=1.0", "surface.qr=4.0")
LABELS = ("bem", "foundation", "persson")
RESAMPLES = 10
"""Enough for a page; what the errors are worth is tested with the fits."""

Change = Callable[..., Results]


@pytest.fixture(scope="session")
def results_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the results file of a run of two experiments with three models."""
    path = tmp_path_factory.mktemp("small") / "small.h5"
    rb.run(SPEC, output=path, threads=1)
    return path


@pytest.fixture(scope="session")
def small(results_file: Path) -> Results:
    """Return the content of that file."""
    return rb.load(results_file)


@pytest.fixture(scope="session")
def change() -> Change:
    """Return a callable that replaces variables and attributes of models in results."""

    def build(
        results: Results,
        label: str = "bem",
        attributes: dict[str, Any] | None = None,
        **variables: Any,
    ) -> Results:
        def changed(result: ModelResult) -> ModelResult:
            if result.label != label:
                return result
            arrays = {name: np.asarray(values) for name, values in variables.items()}
            return ModelResult(
                result.label,
                result.kind,
                result.title,
                dict(result.attributes) | (attributes or {}),
                dict(result.variables) | arrays,
            )

        experiments = {
            name: {key: changed(result) for key, result in models.items()}
            for name, models in results.items()
        }
        return Results(experiments, results.spec_text, results.spec_sha256, results.name)

    return build


def a_verdict(number: int, text: str = "", outcome: Outcome = Outcome.HOLDS) -> Verdict:
    """Return a verdict with two measurements, one of them without value and error."""
    measurements: tuple[Measurement, ...] = (
        Measurement(
            f"main/bem{text}",
            f"κ{text}",
            2.05,
            0.02,
            "",
            outcome,
            f"a note{text}",
            (),
            2.03,
            2.07,
        ),
        Measurement("main/persson", "κ", np.nan, np.nan, "≤", Outcome.UNDECIDED, ""),
    )
    if outcome is Outcome.NOT_TESTED:
        measurements = ()
    return Verdict(
        key=f"claim-{number}{text}",
        place=f"eq. ({number}){text}",
        claim=f"Claim number {number}.{text}",
        rule=f"Rule number {number}.{text}",
        measurements=measurements,
        outcome=outcome,
        remedy=f"remedy {number}{text}" if outcome is Outcome.NOT_TESTED else "",
    )


def page_of(
    *results: Results, verdicts: list[Verdict] | None = None, name: str = "small.h5"
) -> str:
    """Return the page on results, under the names small.h5, 2-small.h5 and so on."""
    sources = [
        ReportSource(f"{number}-{name}" if number > 1 else name, content)
        for number, content in enumerate(results, 1)
    ]
    experiments = fit_experiments(
        [(source.name, source.results) for source in sources], None, RESAMPLES
    )
    given = [a_verdict(1)] if verdicts is None else verdicts
    return render(sources, given, experiments, resamples=RESAMPLES)


class Page(HTMLParser):
    """The elements of a page, its text, and what stands in its scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.scripts: list[str] = []
        self.styles: list[str] = []
        self._inside = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        self.elements.append((tag, dict(attrs)))
        self._inside = tag
        if tag == "script":
            self.scripts.append("")
        if tag == "style":
            self.styles.append("")

    def handle_endtag(self, tag: str) -> None:
        """Note that a script or a style ends."""
        if tag == self._inside:
            self._inside = ""

    def handle_data(self, data: str) -> None:
        """Add text to where it belongs."""
        if self._inside == "script":
            self.scripts[-1] += data
        elif self._inside == "style":
            self.styles[-1] += data
        else:
            self.text += data

    @property
    def tags(self) -> list[str]:
        """Names of all elements, in order."""
        return [tag for tag, _ in self.elements]
