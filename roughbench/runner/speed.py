"""How long models take on this machine: measured once for each, and kept.

The work of a cell (:attr:`roughbench.planning.cells.Cell.work`) says how the time grows with
points and pressures; a short computation of each model says how long that is here. It compiles
the loops on the way, if they are not yet compiled, which the run then need not. Another one,
in a process of its own, says what a process takes to start, and to load what the model needs.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import pickle
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from roughbench.engines.compute import compute
from roughbench.errors import RoughbenchError, StoreError
from roughbench.models.base import Model
from roughbench.planning.cells import Cell
from roughbench.planning.tasks import Task
from roughbench.publish import commit
from roughbench.rundir.identity import code_digest, transforms
from roughbench.spec import SelfAffineSurface
from roughbench.transform import cache_folder, fft_backend

_POINTS = {1: 8192, 2: 256}
"""Points per side of what is computed to measure."""
_PRESSURES = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.5)
"""To full contact, which has loops of its own."""
_START, _LOADING = "start", "loading"
_PATIENCE = 120.0
"""Seconds for a process that only starts and computes little."""
_SECONDS, _TIMES = 0.5, 20
"""Repeated until it has taken so long, or so often; the shortest time counts."""


class Speeds:
    """The speed of this machine for each model, in a file of the cache folder."""

    def __init__(self) -> None:
        self.path = cache_folder() / "speed.json"
        self._slowness = _read(self.path)

    def slowness(self, model: Model) -> float:
        """Return how many times as long as by :attr:`Cell.work` a model takes; 1 if unknown."""
        return self._slowness.get(_key(model), 1.0)

    def loading(self, model: Model) -> float:
        """Return the seconds of a core that a process takes to load a model; 0 if unknown."""
        return self._slowness.get(f"{_LOADING} {_key(model)}", 0.0)

    def starting(self, models: Iterable[Model]) -> list[float]:
        """Return the seconds of a core that a process takes before it computes each of these.

        Of the first to start, of the first of each kind to load it; 0 where that is unknown.
        """
        found, loaded, left = list[float](), set[str](), self._slowness.get(_START, 0.0)
        for model in models:
            loading = 0.0 if model.kind in loaded else self.loading(model)
            found.append(left + loading)
            loaded.add(model.kind)
            left = 0.0
        return found

    def measure(self, models: Iterable[Model], say: Callable[[str], None]) -> None:
        """Measure the models that have not been measured yet.

        Parameters
        ----------
        models : iterable of Model
        say : callable
            Told before it begins what is measured, and in the end where it is kept.
        """
        missing = {_key(model): model for model in models if _key(model) not in self._slowness}
        if not missing:
            return
        kinds = ", ".join(dict.fromkeys(_kind(model) for model in missing.values()))
        say(f"measuring how fast this machine is, once for each model: {kinds}")
        start = time.monotonic()
        for key, model in missing.items():
            with contextlib.suppress(RoughbenchError, ArithmeticError, ValueError):
                self._slowness[key] = _measured(model)
                found = _started(model)
                self._slowness |= {_START: found[0], f"{_LOADING} {key}": found[1]}
        where = "not kept: the cache folder cannot be written"
        with contextlib.suppress(StoreError, OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            kept = _read(self.path) | self._slowness  # others may have measured meanwhile
            commit(json.dumps(kept, indent=1).encode(), self.path)
            where = f"kept in {self.path}"
        say(f"measured in {time.monotonic() - start:.0f} s, {where}")


def _read(path: Path) -> dict[str, float]:
    with contextlib.suppress(OSError, ValueError):
        found = json.loads(path.read_bytes())
        if isinstance(found, dict):
            return {
                str(key): value
                for key, value in found.items()
                if isinstance(value, float) and math.isfinite(value) and value > 0.0
            }
    return {}


def _kind(model: Model) -> str:
    return model.kind


def _key(model: Model) -> str:
    """Return what the speed depends on: options, code, transforms, machine; not the points."""
    no_matter = {"label", "realizations", *model.sampling[:1]}
    options = model.model_dump(mode="json", exclude=no_matter)
    origin = [code_digest(type(model)), platform.node()]
    if transforms(type(model)):
        origin.append(fft_backend())
    content = json.dumps([options, *origin], sort_keys=True)
    return f"{_kind(model)} {hashlib.sha256(content.encode()).hexdigest()[:12]}"


def _measured(model: Model) -> float:
    """Compute a small cell several times: the first compiles, and plans the transforms."""
    cell = _small_cell(model)
    if "precision" in type(model).model_fields:  # falls back to double where it has to
        double = cell.model.model_copy(update={"precision": "double"})
        _seconds(replace(cell, model=double))
    _seconds(cell)
    return _shortest(cell) / (1e-6 * cell.work)


def _started(model: Model) -> tuple[float, float]:
    """Return the seconds of a core for a new process, and for what it loads for a model.

    Once the loops are compiled and kept. Where no process can be started it takes no time.
    """
    program = "from roughbench.runner import speed; speed.tell_start()"
    refused = (pickle.PicklingError, AttributeError, TypeError)  # of a model from outside
    with contextlib.suppress(OSError, subprocess.SubprocessError, ValueError, *refused):
        done = subprocess.run(  # noqa: S603  (this program)
            [sys.executable, "-c", program],
            input=pickle.dumps(model),
            capture_output=True,
            check=True,
            timeout=_PATIENCE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        start, loading = json.loads(done.stdout)
        return max(float(start), 1e-3), max(float(loading), 1e-3)
    return 1e-3, 1e-3


def tell_start() -> None:
    """In a new process: read a model from standard input, print what it takes, as JSON."""
    model = pickle.loads(sys.stdin.buffer.read())  # noqa: S301  (of the process that asks)
    start = time.process_time()
    cell = _small_cell(model)
    first = _seconds(cell)
    sys.stdout.write(json.dumps([start, first - _shortest(cell)]))


def _small_cell(model: Model) -> Cell:
    n_points = _POINTS.get(model.dimension, 256)
    sizes = dict.fromkeys(model.sampling[:1], n_points)
    surface = SelfAffineSurface.model_validate(
        {"H": 0.7, "q0": 1.0, "qr": 4.0, "q1": n_points / 8, "slope": 0.1}
    )
    return Cell("main", model.model_copy(update=sizes), surface, _PRESSURES, 1, 0)


def _shortest(cell: Cell) -> float:
    """Return the shortest of some times that a cell takes, seconds."""
    times = [_seconds(cell)]
    while sum(times) < _SECONDS and len(times) < _TIMES:
        times.append(_seconds(cell))
    return min(times)


def _seconds(cell: Cell) -> float:
    start = time.process_time()
    compute(Task(cell, range(1), cell.pressures))
    return time.process_time() - start
