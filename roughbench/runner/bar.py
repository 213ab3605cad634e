"""How far a run is, for those who call ``run`` from Python."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from roughbench.runner.pace import Pace, columns_of_terminal, counts_of, percent_of
from roughbench.runner.progress import Progress, ProgressListener

_TEXT = "{desc}|{bar:8}| {elapsed}{postfix}"
_WIDGET = "{desc}|{bar}| {elapsed}{postfix}"
_BAR_COLUMNS = 24
"""Of the percentage, the bar, the time (1:23:45), and what parts them from the text."""
_WIDTH = 79
"""Of a notebook, or a file."""
SECONDS_BETWEEN_LINES = 30.0
"""Where standard error is a file or a pipe, that keeps every line."""


@contextlib.contextmanager
def reported(progress: ProgressListener | bool | None) -> Iterator[ProgressListener | None]:  # noqa: FBT001
    """Yield what a run tells its progress to.

    Parameters
    ----------
    progress : callable, bool or None
        True: a bar, in a notebook with ipywidgets a widget, else a line of text on standard
        error; False or None: nothing.
    """
    if not isinstance(progress, bool):
        yield progress
        return
    if not progress:
        yield None
        return
    pace, width = Pace(), _width()
    with _bar(width) as bar:

        def report(news: Progress) -> None:
            pace.note(news)
            text = counts_of(news, pace, width - _BAR_COLUMNS)
            bar.set_description_str(f"{percent_of(news):3d}%", refresh=False)
            bar.set_postfix_str(text, refresh=False)
            bar.update(news.done / max(news.total, 1) - bar.n)

        yield report


def _width() -> int:
    return min(_WIDTH, columns_of_terminal()) if sys.stderr.isatty() else _WIDTH


def _bar(width: int) -> Any:
    """Return tqdm's bar for the place that this runs in."""
    from tqdm import TqdmWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)  # a notebook without ipywidgets: text does
        from tqdm.auto import tqdm
    if any(base.__module__ == "tqdm.notebook" for base in tqdm.__mro__):
        return tqdm(total=1.0, desc="  0%", bar_format=_WIDGET)
    is_seen_live = sys.stderr.isatty() or "ipykernel" in sys.modules
    return tqdm(
        total=1.0,
        desc="  0%",
        bar_format=_TEXT,
        ncols=width,
        mininterval=0.2 if is_seen_live else SECONDS_BETWEEN_LINES,
        file=sys.stderr,
    )
