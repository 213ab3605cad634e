"""How far a run is, on stderr: a bar on a terminal, else a line every 30 seconds."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import click

from roughbench.runner.pace import COLUMNS, Pace, columns_of_terminal, line_of
from roughbench.text import printable

if TYPE_CHECKING:
    from roughbench.runner import Progress, ProgressListener

SECONDS_BETWEEN_LINES = 30.0
_BAR = "{bar:8}| {elapsed}{postfix}"
_BAR_COLUMNS = 20
"""Of the bar, the time (up to an hour: 1:23:45), and what parts them from the text."""


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
        pace = Pace()
        latest: list[Progress] = []
        bar = tqdm(total=1.0, disable=None, dynamic_ncols=True, leave=False, bar_format=_BAR)

        def report(news: Progress) -> None:
            pace.note(news)
            latest[:] = [news]
            show()

        def show() -> None:
            bar.set_postfix_str(
                line_of(latest[0], pace, columns_of_terminal() - _BAR_COLUMNS), refresh=False
            )
            bar.update(latest[0].done / max(1, latest[0].total) - bar.n)

        def tell() -> None:
            if bar.disable and latest:
                elapsed = f"{duration(time.monotonic() - pace.start)}, "
                click.echo(elapsed + line_of(latest[0], pace, COLUMNS - len(elapsed)), err=True)
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
