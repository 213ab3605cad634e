"""How far a run is, for those who call ``run`` from Python: one line of plain text."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

from roughbench.runner.pace import Pace, columns_of_terminal, counts_of, percent_of
from roughbench.runner.progress import Progress, ProgressListener

_BAR = "{desc}|{bar:8}| {elapsed}{postfix}"
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
        True: a bar on standard error, in a notebook as well; False or None: nothing.
    """
    if not isinstance(progress, bool):
        yield progress
        return
    if not progress:
        yield None
        return
    from tqdm import tqdm

    is_terminal = sys.stderr.isatty()
    is_seen_live = is_terminal or "ipykernel" in sys.modules
    width = min(_WIDTH, columns_of_terminal()) if is_terminal else _WIDTH
    pace = Pace()
    with tqdm(
        total=1.0,
        desc="  0%",
        bar_format=_BAR,
        ncols=width,
        mininterval=0.2 if is_seen_live else SECONDS_BETWEEN_LINES,
        file=sys.stderr,
    ) as bar:

        def report(news: Progress) -> None:
            pace.note(news)
            text = counts_of(news, pace, width - _BAR_COLUMNS)
            bar.set_description_str(f"{percent_of(news):3d}%", refresh=False)
            bar.set_postfix_str(text, refresh=False)
            bar.update(news.done / max(news.total, 1) - bar.n)

        yield report
