"""Models that misbehave on demand; workers import them from here."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

import roughbench as rb
from roughbench.models.base import Curve, FloatArray, Model, Needs, Sample, State, Status

Misdeed = Literal[
    "none",
    "unconverged",
    "nan area",
    "nan stiffness",
    "refuse",
    "crash",
    "die",
    "die once",
    "wait",
    "strange",
]


class StrangeError(Exception):
    """Cannot be made again from its message, as many foreign ones."""

    def __init__(self, one: int, other: int) -> None:
        super().__init__(f"{one} and {other}")


class Fake(Model):
    """Area r + p, separation 1, stiffness inf at the last pressure; misbehaves on demand."""

    needs: ClassVar[Needs] = "line"
    title: ClassVar[str] = "Fake"

    kind: Literal["fake"] = "fake"
    misdeed: Misdeed = "none"
    flag: bool = True
    marker: str = ""

    def grid_points(self, spectrum: object, length: float) -> int:
        del spectrum, length
        return 128

    def states(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        finished: Mapping[str, NDArray[Any]] | None = None,
    ) -> Iterator[State]:
        assert finished is None
        yield from self._curve(sample, pressures, threads).states()

    def _curve(self, sample: Sample, pressures: FloatArray, threads: int) -> Curve:
        assert sample.heights is not None
        index = float(np.argmax(sample.heights))
        shape = pressures.shape
        if self.misdeed == "refuse":
            raise rb.SolverError("refused")
        if self.misdeed == "crash":
            raise ZeroDivisionError("a fault of the model")
        if self.misdeed == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.misdeed == "die once" and not Path(self.marker).exists():
            Path(self.marker).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if self.misdeed == "wait":
            time.sleep(0.3)
        if self.misdeed == "strange":
            raise StrangeError(1, 2)
        stiffness = np.where(pressures == pressures.max(), np.inf, pressures)
        curve = Curve(
            pressure=pressures,
            area=index + pressures,
            separation=np.ones(shape),
            stiffness=stiffness,
            energy=np.full(shape, np.nan),
            status=np.zeros(shape, np.int32),
            area_raw=np.full(shape, 0.5),
            diagnostics={"threads": np.full(shape, threads), "even": pressures > 1e-3},
        )
        if self.misdeed == "unconverged" and index % 2:
            status = np.array([0, Status.STAGNATED, Status.MAX_ITERATIONS], np.int32)
            return replace(curve, status=status, area=np.array([index, 1e9, np.nan]))
        if self.misdeed == "nan area":
            return replace(curve, area=np.array([np.nan, 0.0, np.inf]))
        if self.misdeed == "nan stiffness":
            return replace(curve, stiffness=np.full(shape, np.nan))
        return curve


class Steps(Fake):
    """Solves pressure by pressure, each from the one before; can be resumed.

    Stops after ``stop`` pressures: a kill, as seen from the file system.
    """

    stop: int = 10**9

    def states(
        self,
        sample: Sample,
        pressures: FloatArray,
        *,
        threads: int = 1,
        finished: Mapping[str, NDArray[Any]] | None = None,
    ) -> Iterator[State]:
        del threads
        assert sample.heights is not None
        done, value = 0, float(sample.heights.max())
        if finished is not None:
            done, value = int(finished["done"]), float(finished["value"])
        for pressure in pressures[done:].tolist():
            if done == self.stop:
                raise rb.SolverError("killed")
            value = float(np.sin(value) + pressure)
            done += 1
            arrays = {"done": np.array(done), "value": np.array(value)}
            yield State(pressure, value, value, value, value, snapshot=arrays.copy)


class AtOnce(Model):
    """Area r + p of all pressures at once and, by ``misdeed``, no more, or what is wrong."""

    needs: ClassVar[Needs] = "line"
    title: ClassVar[str] = "Area only"

    kind: Literal["at_once"] = "at_once"
    misdeed: Literal["none", "shape", "pressures", "fickle"] = "none"

    def grid_points(self, spectrum: object, length: float) -> int:
        del spectrum, length
        return 128

    def curve(self, sample: Sample, pressures: FloatArray) -> Curve:
        assert sample.heights is not None
        index = float(np.argmax(sample.heights))
        curve = Curve(pressure=pressures, area=index / 128.0 + pressures)
        if self.misdeed == "shape":
            return replace(curve, energy=np.zeros(2))
        if self.misdeed == "pressures":
            return replace(curve, pressure=2.0 * pressures)
        if self.misdeed == "fickle" and index % 2:
            return replace(curve, energy=pressures)
        return curve
