"""One page on what results say: interactive figures, verdicts, fits, warnings, the spec.

The page is a single HTML file that needs nothing else: styles, data and the library that
draws the figures stand inside it, and it loads nothing from anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from roughbench.fits import RESAMPLES
from roughbench.outputs import Kind
from roughbench.report.page import render
from roughbench.report.sources import ReportSource, read_sources
from roughbench.verdict import fit_experiments, judge_experiments

__all__ = ["PAGE", "ReportSource", "make_report", "read_sources"]

PAGE = Kind("report", lambda head, _: b'<meta name="generator" content="roughbench ' in head)


def make_report(
    paths: Sequence[Path], *, reference: str | None = None, resamples: int = RESAMPLES
) -> str:
    """Return the report on results files as an HTML page, the same for the same files.

    Parameters
    ----------
    paths : sequence of Path
        Results files, at least one.
    reference : str, optional
        Label of the model that the others are held against; default, and in files without
        such a model: the first exact solver of each experiment.
    resamples : int
        Draws of the realizations for the errors, at least 2.

    Raises
    ------
    StoreError
        If a file cannot be read as results, is given twice, or no file has a model named
        ``reference``.
    """
    sources = read_sources(paths)
    experiments = fit_experiments(
        [(source.name, source.results) for source in sources], reference, resamples
    )
    verdicts = judge_experiments(experiments, resamples)
    return render(
        sources,
        [verdict for verdict in verdicts if not verdict.contender],
        experiments,
        reference=reference,
        resamples=resamples,
        contenders=[verdict for verdict in verdicts if verdict.contender],
    )
