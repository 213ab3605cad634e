"""One page on what results say: verdicts, interactive figures, fits, warnings, provenance.

The page is a single HTML file that needs nothing else: styles, data and the library that
draws the figures stand inside it, and it loads nothing from anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from roughbench.errors import StoreError
from roughbench.fits import RESAMPLES, fit
from roughbench.report.page import Content, render
from roughbench.report.sources import Source, read_sources
from roughbench.report.tables import Fits
from roughbench.verdict import judge

__all__ = ["Source", "make_report", "read_sources"]


def make_report(
    paths: Sequence[Path], *, reference: str | None = None, resamples: int = RESAMPLES
) -> str:
    """Return the report on results files as an HTML page.

    Parameters
    ----------
    paths : sequence of Path
        Results files, at least one.
    reference : str, optional
        Label of the model that the others are held against; default: the first exact
        solver of each experiment.
    resamples : int
        Draws of the realizations for the errors, at least 2.

    Returns
    -------
    str
        The same for the same files.

    Raises
    ------
    StoreError
        If a file cannot be read as results, is given twice, or an experiment has no model
        named ``reference``.
    """
    sources = read_sources(paths)
    fits = [_fit(source, reference, resamples) for source in sources]
    verdicts = judge(
        [(source.name, source.results) for source in sources],
        reference=reference,
        resamples=resamples,
    )
    return render(Content(sources, verdicts, fits, reference, resamples))


def _fit(source: Source, reference: str | None, resamples: int) -> Fits:
    try:
        return fit(source.results, reference=reference, resamples=resamples)
    except StoreError as error:
        raise StoreError(f"{source.name}: {error}") from error
