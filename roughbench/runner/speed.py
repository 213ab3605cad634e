"""How long models take on this machine: measured once for each, and kept.

The work of a cell (:attr:`roughbench.planning.cells.Cell.work`) says how the time grows with
points and pressures; a short computation of each model says how long that is here. It compiles
the loops on the way, if they are not yet compiled, which the run then need not.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import platform
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
    """Compute a small cell several times: the first compiles, and plans the transforms.

    What iterates in single precision falls back to double where it has to: loops for both.
    """
    n_points = _POINTS.get(model.dimension, 256)
    sizes = dict.fromkeys(model.sampling[:1], n_points)
    surface = SelfAffineSurface.model_validate(
        {"H": 0.7, "q0": 1.0, "qr": 4.0, "q1": n_points / 8, "slope": 0.1}
    )
    small = model.model_copy(update=sizes)
    cell = Cell("main", small, surface, _PRESSURES, 1, 0)
    if "precision" in type(model).model_fields:
        _seconds(replace(cell, model=small.model_copy(update={"precision": "double"})))
    _seconds(cell)
    times = [_seconds(cell)]
    while sum(times) < _SECONDS and len(times) < _TIMES:
        times.append(_seconds(cell))
    return min(times) / (1e-6 * cell.work)


def _seconds(cell: Cell) -> float:
    start = time.process_time()
    compute(Task(cell, range(1), cell.pressures))
    return time.process_time() - start
