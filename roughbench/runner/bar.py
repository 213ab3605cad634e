"""How far a run is, for those who call ``run`` from Python."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from roughbench.runner.pace import Pace
from roughbench.runner.progress import Progress, ProgressListener

_TEXT = "{percentage:3.0f}%|{bar:20}| {elapsed}{postfix}"
_WIDGET = "{percentage:3.0f}%|{bar}| {elapsed}{postfix}"
_WIDTH = 79
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
    pace = Pace()
    with _bar() as bar:

        def report(news: Progress) -> None:
            pace.note(news)
            states = f"{news.done}/{news.total} states{pace.left()}"
            bar.set_postfix_str(f"{states}: {news.text}", refresh=False)
            bar.update(news.done / max(news.total, 1) - bar.n)

        yield report


def _bar() -> Any:
    """Return tqdm's bar for the place that this runs in."""
    from tqdm import TqdmWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)  # a notebook without ipywidgets: text does
        from tqdm.auto import tqdm
    if any(base.__module__ == "tqdm.notebook" for base in tqdm.__mro__):
        return tqdm(total=1.0, bar_format=_WIDGET)
    is_seen_live = sys.stderr.isatty() or "ipykernel" in sys.modules
    return tqdm(
        total=1.0,
        bar_format=_TEXT,
        ncols=_WIDTH,
        mininterval=0.2 if is_seen_live else SECONDS_BETWEEN_LINES,
        file=sys.stderr,
    )
