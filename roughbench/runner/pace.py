"""How far a run is, in words: counts, their percentage, and the time that is left."""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time

from roughbench.runner.progress import COMPILING, Progress

COLUMNS = 60
"""Of a line where no terminal says how many there are."""
_NEWS_TO_SETTLE = 3
_SECONDS_TO_SETTLE = 2.0


class Pace:
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
        if not self._started or news.text.startswith(COMPILING):
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
    >>> _roughly(1.2), _roughly(38.4), _roughly(75.0), _roughly(7384.0), _roughly(7080.0)
    ('1 s', '40 s', '2 min', '2 h 5 min', '2 h 0 min')
    """
    if seconds < 10.0:
        return f"{seconds:.0f} s"
    if seconds <= 55.0:
        return f"{5 * math.ceil(seconds / 5)} s"
    minutes = math.ceil(seconds / 60)
    if minutes < 60:
        return f"{minutes} min"
    hours, rest = divmod(5 * math.ceil(minutes / 5), 60)
    return f"{hours} h {rest} min"


def line_of(news: Progress, pace: Pace, columns: int) -> str:
    """Return how far a run is, in so many columns: 100 % is when every state is there."""
    percent = f"{percent_of(news)} %, "
    return percent + counts_of(news, pace, columns - len(percent))


def counts_of(news: Progress, pace: Pace, columns: int) -> str:
    """Return how far a run is without its percentage, in so many columns."""
    left = pace.left() if news.done < news.total else ""
    text = f"{news.done}/{news.total} states{left}: {news.text}"
    return text if len(text) <= columns else text[: max(0, columns - 1)] + "…"


def percent_of(news: Progress) -> int:
    """Return the share of the states that are there, rounded down.

    Examples
    --------
    >>> percent_of(Progress(62999, 63000, 0.5, "")), percent_of(Progress(0, 0, 1.0, ""))
    (99, 0)
    """
    return 100 * news.done // max(1, news.total)


def columns_of_terminal() -> int:
    """Return the width of the terminal; where none says it, that of the lines."""
    with contextlib.suppress(OSError, ValueError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or COLUMNS
    return COLUMNS
