"""How far a run is, on stderr: a bar on a terminal, else a line every 30 seconds."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import click

from roughbench.text import printable

if TYPE_CHECKING:
    from roughbench.runner import Progress, Report

SECONDS_BETWEEN_LINES = 30.0
_BAR = "{percentage:3.0f}%|{bar:20}| {elapsed}{postfix}"


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


class _Pace:
    """How long the rest takes, by the pace since the first news.

    The loops are compiled before that; to count this time would foretell hours.
    """

    def __init__(self) -> None:
        self.start = time.monotonic()
        self._first: tuple[float, float] | None = None
        self._told = 0

    def note(self, news: Progress) -> None:
        """Take note of news; the first one only says what was there at the start."""
        self._told += 1
        if self._told == 2:
            self._first = time.monotonic(), news.share

    def left(self, share: float) -> str:
        """Return the time left, such as ``", about 12.0 s left"``; empty if unknown."""
        if self._first is None or not self._first[1] < share < 1.0:
            return ""
        elapsed = time.monotonic() - self._first[0]
        return f", about {duration(elapsed * (1.0 - share) / (share - self._first[1]))} left"


@contextlib.contextmanager
def progress_shown(*, quiet: bool, verbose: bool) -> Iterator[Report | None]:
    """Yield what a run should tell its progress; None if nobody wants to know.

    The log of the run goes to stderr meanwhile: its warnings, and with ``verbose`` a line
    for every task.

    Parameters
    ----------
    quiet : bool
        Show warnings only.
    verbose : bool
        Show the log.

    Yields
    ------
    callable or None
    """
    from tqdm import tqdm

    with _log_on_stderr(logging.INFO if verbose else logging.WARNING):
        if quiet:
            yield None
            return
        pace = _Pace()
        latest: list[Progress] = []
        bar = tqdm(total=1.0, disable=None, dynamic_ncols=True, leave=False, bar_format=_BAR)

        def report(news: Progress) -> None:
            pace.note(news)
            latest[:] = [news]
            text = f"{news.done}/{news.total} states{pace.left(news.share)}: {news.text}"
            bar.set_postfix_str(text, refresh=False)
            bar.update(news.share - bar.n)

        def tell() -> None:
            if not bar.disable:
                bar.refresh()
            elif latest:
                click.echo(_line(latest[0], pace), err=True)

        with bar, _every(lambda: SECONDS_BETWEEN_LINES, tell):
            yield report


def _line(news: Progress, pace: _Pace) -> str:
    elapsed = duration(time.monotonic() - pace.start)
    return (
        f"{news.share:.0%} done after {elapsed}{pace.left(news.share)}: "
        f"{news.done} of {news.total} states, {news.text}"
    )


@contextlib.contextmanager
def _every(seconds: Callable[[], float], tell: Callable[[], None]) -> Iterator[None]:
    """Call ``tell`` at intervals, from a thread of its own: also while nothing is new."""
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(seconds()):
            tell()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


class _Stderr(logging.Handler):
    """Log records on stderr, above the bar."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record; its level only where it is more than information."""
        from tqdm import tqdm

        level = f"{record.levelname.lower()}: " if record.levelno > logging.INFO else ""
        with tqdm.external_write_mode():
            click.echo(level + printable(record.getMessage()), err=True)


@contextlib.contextmanager
def _log_on_stderr(level: int) -> Iterator[None]:
    log = logging.getLogger("roughbench.run")
    handler = _Stderr(level)
    before = log.level, log.propagate
    log.addHandler(handler)
    log.setLevel(min(level, log.level or level))
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before[0])
        log.propagate = before[1]
