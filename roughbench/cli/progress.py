"""How far a run is, on stderr: a bar on a terminal, else a line every 30 seconds."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from roughbench.runner import Progress, Report

SECONDS_BETWEEN_LINES = 30.0
_BAR = "{percentage:3.0f}%|{bar:20}| {elapsed}<{remaining}{postfix}"


def duration(seconds: float) -> str:
    """Return a time for people.

    Examples
    --------
    >>> duration(1.234), duration(75), duration(7384)
    ('1.2 s', '1 min 15 s', '2 h 3 min')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


@contextlib.contextmanager
def progress_shown(*, quiet: bool, verbose: bool) -> Iterator[Report | None]:
    """Yield what a run should tell its progress; None if nobody wants to know.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    verbose : bool
        Show a line for every piece of news.

    Yields
    ------
    callable or None
    """
    if quiet:
        yield None
        return
    from tqdm import tqdm

    start = last = time.monotonic()
    with tqdm(total=1.0, disable=None, dynamic_ncols=True, leave=False, bar_format=_BAR) as bar:

        def report(news: Progress) -> None:
            nonlocal last
            bar.set_postfix_str(f"{news.done}/{news.total} states: {news.text}", refresh=False)
            bar.update(news.share - bar.n)
            now = time.monotonic()
            if verbose or (bar.disable and now - last >= SECONDS_BETWEEN_LINES):
                last = now
                with tqdm.external_write_mode():
                    click.echo(_line(news, now - start), err=True)

        yield report


def _line(news: Progress, elapsed: float) -> str:
    left = ""
    if 0 < news.share < 1:
        left = f", about {duration(elapsed / news.share - elapsed)} left"
    return (
        f"{news.share:.0%} done after {duration(elapsed)}{left}: "
        f"{news.done} of {news.total} states, {news.text}"
    )
