"""How long the rest of a run takes."""

from __future__ import annotations

import math
import time

from roughbench.runner.progress import Progress

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
        return f", {roughly(max(1.0, self._end - now))} left"


def roughly(seconds: float) -> str:
    """Return a time to two digits or so: nobody knows it better.

    Examples
    --------
    >>> roughly(1.2), roughly(38.4), roughly(75.0), roughly(7384.0)
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
