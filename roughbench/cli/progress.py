"""How far a run is, on stderr: a bar on a terminal, else a line every 30 seconds."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import click

from roughbench.text import printable

if TYPE_CHECKING:
    from roughbench.runner import Progress, ProgressListener

SECONDS_BETWEEN_LINES = 30.0
_COLUMNS = 60
_BAR = "{bar:8}| {elapsed}{postfix}"
_BAR_COLUMNS = 20
"""Of the bar, the time (up to an hour: 1:23:45), and what parts them from the text."""
_NEWS_TO_SETTLE = 3
_SECONDS_TO_SETTLE = 2.0


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

    Loops are compiled before that; to count this time would foretell hours. Between news the
    time left counts down, and it is shown only when it has begun to settle.
    """

    def __init__(self) -> None:
        self.start = time.monotonic()
        self._begin: tuple[float, float] | None = None  # when, and what share was done
        self._end: float | None = None
        self._started = False
        self._monitored = 0

    def note(self, news: Progress) -> None:
        """Take note of news; the first one only says what was there at the start."""
        now = time.monotonic()
        if not self._started or news.text.startswith("compiling"):
            self._started, self._begin, self._monitored = True, None, 0
            return
        if self._begin is None:
            self._begin = now, news.share
            return
        self._monitored += 1
        since, share = self._begin
        if news.share > share:
            self._end = now + (now - since) * (1.0 - news.share) / (news.share - share)

    def left(self) -> str:
        """Return the time left, such as ``", 12 s left"``; empty if nobody can tell yet."""
        now = time.monotonic()
        if self._end is None or self._begin is None or self._monitored < _NEWS_TO_SETTLE:
            return ""
        if now - self._begin[0] < _SECONDS_TO_SETTLE:
            return ""
        return f", {_roughly(max(1.0, self._end - now))} left"


def _roughly(seconds: float) -> str:
    """Return a time to two digits or so: nobody knows it better.

    Examples
    --------
    >>> _roughly(1.2), _roughly(38.4), _roughly(75.0), _roughly(7384.0)
    ('1 s', '40 s', '2 min', '2 h 5 min')
    """
    if seconds < 10.0:
        return f"{seconds:.0f} s"
    if seconds < 55.0:
        return f"{5 * math.ceil(seconds / 5)} s"
    minutes = math.ceil(seconds / 60)
    if minutes < 60:
        return f"{minutes} min"
    return f"{minutes // 60} h {5 * math.ceil(minutes % 60 / 5)} min"


@contextlib.contextmanager
def progress_shown(*, quiet: bool, verbose: bool) -> Iterator[ProgressListener | None]:
    """Yield what a run should tell its progress; None if nobody wants to know.

    The log of the run goes to stderr meanwhile: its warnings, and with ``verbose`` a line
    for every task.

    Parameters
    ----------
    quiet : bool
        Show warnings only.
    verbose : bool
        Show the log.
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
            show()

        def show() -> None:
            bar.set_postfix_str(
                _line(latest[0], pace, _columns() - _BAR_COLUMNS), refresh=False
            )
            bar.update(latest[0].done / max(1, latest[0].total) - bar.n)

        def tell() -> None:
            if bar.disable and latest:
                elapsed = f"{duration(time.monotonic() - pace.start)}, "
                click.echo(elapsed + _line(latest[0], pace, _COLUMNS - len(elapsed)), err=True)
            elif latest:
                show()
                bar.refresh()

        with bar, _every(lambda: SECONDS_BETWEEN_LINES, tell):
            yield report


def first_kept(listener: ProgressListener, kept: list[Progress]) -> ProgressListener:
    """Return a listener that keeps the first news as well: what was there at the start."""

    def listen(news: Progress) -> None:
        if not kept:
            kept.append(news)
        listener(news)

    return listen


def _line(news: Progress, pace: _Pace, columns: int) -> str:
    """Return how far a run is, in so many columns: 100 % is when every state is there."""
    percent = 100 * news.done // max(1, news.total)
    text = f"{percent} %, {news.done}/{news.total} states{pace.left()}: {news.text}"
    return text if len(text) <= columns else text[: max(0, columns - 1)] + "…"


def _columns() -> int:
    """Return the width of the terminal; where none says it, that of the lines."""
    with contextlib.suppress(OSError, ValueError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or _COLUMNS
    return _COLUMNS


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
