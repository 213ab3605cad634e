"""Ctrl-C: raised at once where it gets through, later where it would be lost."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

import pytest

from roughbench.cli.interrupts import Interrupted, interrupts_get_through


def interrupt_and_wait(seconds: float) -> None:
    os.kill(os.getpid(), signal.SIGINT)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.001)


class Loses:
    """Prints and forgets what is raised in its destructor, as Python does."""

    done = False

    def __del__(self) -> None:
        interrupt_and_wait(0.1)
        type(self).done = True


def test_raised_at_once() -> None:
    start = time.monotonic()
    with pytest.raises(Interrupted), interrupts_get_through():
        interrupt_and_wait(5.0)
    assert time.monotonic() - start < 4.0


def test_raised_after_a_destructor_and_not_in_it() -> None:
    def work() -> None:
        victim = Loses()
        del victim
        assert Loses.done
        time.sleep(5.0)

    with pytest.raises(Interrupted), interrupts_get_through():
        work()


def test_the_negative_control_loses_it(monkeypatch: pytest.MonkeyPatch) -> None:
    lost: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda what: lost.append(what.exc_type))
    victim = Loses()
    del victim
    time.sleep(0.1)  # nothing comes
    assert lost == [KeyboardInterrupt]


def test_former_handlers_return() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM)
    with interrupts_get_through():
        assert signal.getsignal(signal.SIGINT) != before[0]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM)) == before


def test_other_threads_leave_signals_alone() -> None:
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def work() -> None:
        with interrupts_get_through():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [before]
