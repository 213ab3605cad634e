"""How far a run is, for those who call ``run`` from Python: one line of plain text."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

from roughbench.runner.progress import Progress, ProgressListener

_BAR = "{percentage:3.0f}%|{bar:20}| {elapsed}<{remaining}{postfix}"
_WIDTH = 79
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

    is_seen_live = sys.stderr.isatty() or "ipykernel" in sys.modules
    with tqdm(
        total=1.0,
        bar_format=_BAR,
        ncols=_WIDTH,
        mininterval=0.2 if is_seen_live else SECONDS_BETWEEN_LINES,
        file=sys.stderr,
    ) as bar:

        def report(news: Progress) -> None:
            bar.set_postfix_str(f"{news.done}/{news.total} states: {news.text}", refresh=False)
            bar.update(news.done / max(news.total, 1) - bar.n)

        yield report
