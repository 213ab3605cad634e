"""Numerical hygiene for all tests, and the small inputs that several of them share."""

from __future__ import annotations

import functools
import hashlib
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

# No test fails because the machine is busy.
settings.register_profile("roughbench", deadline=None)
settings.load_profile("roughbench")


collect_ignore = ["elsewhere/sitecustomize.py"]
"""To import it is to lose what it takes away: doctests must not."""


@pytest.fixture(autouse=True)
def floating_point_errors_raise() -> Iterator[None]:
    """Make every overflow, division by zero and invalid operation an error.

    Underflow to zero is right wherever a tail vanishes, and stays silent.
    """
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what the tests plan and measure out of the user's cache, and that out of them.

    All workers of pytest-xdist share one: to plan the transforms of long lines takes minutes.
    Processes that tests start keep roughbench's bytecode even where Python shall write none,
    as Numba keeps its own beside it: hundreds of them would compile the package again.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROUGHBENCH_CACHE", str(folder / "own-cache"))
        patch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
        yield


@pytest.fixture(scope="session", autouse=True)
def compiled_by_one(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Let the workers of pytest-xdist wait where another one compiles the same loop.

    Each loop takes seconds; begun at the same time, the first tests would compile most of them
    as many times as there are workers.
    """
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    import fcntl

    from numba.core.dispatcher import Dispatcher

    folder = tmp_path_factory.getbasetemp().parent / "compiling"
    folder.mkdir(exist_ok=True)
    compile_or_load = Dispatcher.compile

    def one_by_one(dispatcher: Any, types: Any) -> Any:
        function = dispatcher.py_func
        if not function.__module__.startswith("roughbench."):
            return compile_or_load(dispatcher, types)
        what = f"{function.__module__}.{function.__qualname__} {types}"
        with (folder / hashlib.sha256(what.encode()).hexdigest()).open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compile_or_load(dispatcher, types)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dispatcher, "compile", one_by_one)
        yield


@pytest.fixture(scope="session", autouse=True)
def formulas_parsed_once() -> Iterator[None]:
    """Keep all typeset formulas; Matplotlib keeps fifty, fewer than two figures have."""
    if "matplotlib" not in sys.modules:  # by the tests that are to run
        yield
        return
    from matplotlib.mathtext import MathTextParser

    parse = MathTextParser._parse_cached  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MathTextParser, "_parse_cached", functools.cache(parse.__wrapped__))
        yield


@pytest.fixture
def no_bytecode(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let processes write no bytecode: with a limit on files Python would keep half of it."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")


@pytest.fixture(scope="session", autouse=True)
def usual_signals() -> Iterator[None]:
    """Let Ctrl-C through, and hang-ups: a shell's background jobs inherit them ignored."""
    usual: dict[signal.Signals, Any] = {
        signal.SIGINT: signal.default_int_handler,
        signal.SIGHUP: signal.SIG_DFL,
    }
    before = {number: signal.signal(number, handler) for number, handler in usual.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let figures be drawn, but their files be empty pages: for tests of the files alone."""
    from matplotlib.figure import Figure

    from roughbench import figures
    from roughbench.figures.files import save

    def blank(_: Figure, *where: Any) -> list[Path]:
        return save(Figure((0.5, 0.5)), *where)

    monkeypatch.setattr(figures, "save", blank)


@pytest.fixture
def rng() -> np.random.Generator:
    """Return a seeded random stream."""
    return np.random.default_rng(20130)


@pytest.fixture
def small_spec() -> dict[str, Any]:
    """Return a spec that computes in milliseconds: a foundation and Persson's theory."""
    return {
        "name": "small",
        "surface": {"H": 0.7, "q0": 1.0, "qr": 4.0, "q1": 32.0, "slope": 0.1},
        "pressures": [1e-4, 1e-3, 1e-2],
        "realizations": 20,
        "seed": 7,
        "models": [{"kind": "foundation", "springs": 128}, {"kind": "persson"}],
    }
