"""Ctrl-C that gets through.

Python raises KeyboardInterrupt wherever the program happens to be, and some places lose
it: the callbacks and destructors of Numba's compiler print "Exception ignored" and go on
(3 of 180 interrupts sent while it compiled were lost). Here it waits until they are left.
"""

from __future__ import annotations

import contextlib
import math
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType

from roughbench.system import ALARM, ENDING_SIGNALS, HANG_UP, set_alarm

_PAUSE = 0.02
"""Seconds until the next try."""
_ANSWER = 3.0
"""Seconds that the answer to a signal may take undisturbed."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C; of KeyboardInterrupt itself Python may die by the signal, without our code."""


class Terminated(Interrupted):
    """SIGTERM, as batch systems and shutdowns send it."""

    name = "SIGTERM"


class HungUp(Terminated):
    """SIGHUP, as a terminal sends it that is closed, or lost."""

    name = "SIGHUP"


_ERRORS: dict[int | None, type[Interrupted]] = {signal.SIGTERM: Terminated, HANG_UP: HungUp}


@contextlib.contextmanager
def interrupts_get_through() -> Iterator[None]:
    """Raise :class:`Interrupted` on SIGINT, or :class:`Terminated` on SIGTERM and SIGHUP.

    As soon as it would not be lost. A second signal within three seconds changes nothing:
    the first is being answered. A hang-up that is ignored (``nohup``) stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are the main thread's business
        return

    pending: type[Interrupted] | None = None
    raised = -math.inf

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal pending, raised
        pending = pending or _ERRORS.get(number, Interrupted)
        if time.monotonic() - raised < _ANSWER:
            return
        if _loses_exceptions(frame):
            set_alarm(_PAUSE)
        else:
            raised = time.monotonic()
            raise pending

    before = {
        number: signal.signal(number, handle)
        for number in ENDING_SIGNALS | {ALARM}
        if number != HANG_UP or signal.getsignal(number) != signal.SIG_IGN
    }
    try:
        yield
    finally:
        set_alarm(0.0)
        for number, handler in before.items():
            signal.signal(number, handler)


def _loses_exceptions(frame: FrameType | None) -> bool:
    """Whether a destructor or a callback of the compiler is running."""
    while frame is not None:
        module = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if module in {"llvmlite", "weakref"} or frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False
