"""Signals that wait until what must not be disturbed is done."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator

from roughbench.system import ALARM, ENDING_SIGNALS, blocked


@contextlib.contextmanager
def signals_held_back() -> Iterator[None]:
    """Hold signals back; processes started meanwhile inherit that for good.

    One that comes meanwhile is answered here afterwards. To block it in this thread is not
    enough for that: any other thread may take it, and have this one raise the exception.
    """
    came: list[int] = []
    handlers = {}
    if threading.current_thread() is threading.main_thread():
        for number in ENDING_SIGNALS | {ALARM}:  # an answer may be put off by an alarm
            if callable(signal.getsignal(number)):
                handlers[number] = signal.signal(number, lambda number, _: came.append(number))
    try:
        with blocked(ENDING_SIGNALS):
            yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in dict.fromkeys(came):
            signal.raise_signal(late)
