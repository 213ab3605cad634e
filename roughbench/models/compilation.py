"""Who wants to know that loops are being compiled: it takes seconds, and happens once."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

_listeners: list[Callable[[], None]] = []


@contextlib.contextmanager
def compiling_told(listener: Callable[[], None]) -> Iterator[None]:
    """Call ``listener`` whenever a loop is about to be compiled."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def tell_compiling() -> None:
    """Tell everybody who listens."""
    for listener in _listeners:
        listener()
