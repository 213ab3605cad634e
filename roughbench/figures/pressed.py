"""The springs of a line in the states whose fields a run kept, and what to show of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.models.registry import is_modified
from roughbench.results import ModelResult, Results

FloatArray = NDArray[np.float64]
WINDOW = 48
"""Springs drawn one by one: as many as a column holds."""
SHARES = (0.05, 0.35)
"""Shares of springs in contact, least and most, that make a good picture."""


@dataclass(frozen=True, slots=True)
class Pressed:
    """A line in contact with its springs.

    Attributes
    ----------
    experiment : str
        Where it comes from.
    clearance : ndarray of float64, shape (N,)
        d - h_i, length: the punch over the unloaded springs; negative where it
        compresses them.
    rms_height : float
        h_rms of the spectrum, length.
    pressure : float
        p/E*; of results with units p, Pa.
    separation : float
        ū, length.
    has_units : bool
        Whether lengths are in m.
    """

    experiment: str
    clearance: FloatArray
    rms_height: float
    pressure: float
    separation: float
    has_units: bool = False

    @property
    def share(self) -> float:
        """Share of the springs in contact."""
        return float(np.mean(self.clearance < 0.0))

    @property
    def regions(self) -> int:
        """Number of contact regions; one that runs through the ends counts as two."""
        touching = self.clearance < 0.0
        return int(touching[0]) + int(np.count_nonzero(touching[1:] & ~touching[:-1]))


def pressed_lines(results: Results) -> Iterator[Pressed]:
    """Yield the states of foundations as published whose fields are kept, short of full."""
    for experiment, result in results.models():
        if is_modified(result.kind, result.attributes):
            continue
        if result.kind == "foundation" and "field_pressure" in result:
            yield from _states(experiment, result)


def _states(experiment: str, result: ModelResult) -> Iterator[Pressed]:
    """Yield the kept states of a foundation; a pressure is (4/π) E*δ/L per nominal area."""
    length = float(result.attributes["length"])
    height = float(result.attributes["rms_height"])
    for pressure, gap, nominal, status in zip(
        result["field_pressure"],
        result["field_gap"],
        result["field_nominal_pressure"].tolist(),
        result["field_status"].tolist(),
        strict=True,
    ):
        compression = math.pi / 4.0 * length * pressure / (result.modulus or 1.0)
        if status == 0 and (gap > 0.0).any():
            clearance = np.where(pressure > 0.0, -compression, gap)
            separation = float(gap.mean())
            yield Pressed(experiment, clearance, height, nominal, separation, result.has_units)


def most_telling(results: Results) -> Pressed:
    """Return the state that the figure shows.

    Of those with a share of springs in contact within :data:`SHARES` it is the one with the
    most contact regions, the first of several; if there is none, the one whose share comes
    nearest.

    Raises
    ------
    StoreError
        If the results hold no such state.
    """

    def merit(state: Pressed) -> tuple[float, int]:
        least, most = SHARES
        return -max(least - state.share, state.share - most, 0.0), state.regions

    states = list(pressed_lines(results))
    if not states:
        raise StoreError("figure 'foundation' needs the fields of a foundation")
    return max(states, key=merit)


@dataclass(frozen=True, slots=True)
class Window:
    """Springs ``start``, ``start + step``, …, ``count`` of them."""

    start: int
    step: int
    count: int

    @property
    def stop(self) -> int:
        """The last spring and one."""
        return self.start + self.step * (self.count - 1) + 1


def choose_window(in_contact: NDArray[np.bool_]) -> Window:
    """Return a window with several contact regions and 30 % to 60 % in contact.

    Of every 1, 2, 4, … springs it takes the first choice by which some :data:`WINDOW`
    springs in a row show three regions, and of these windows the first of those with the
    most; if there is none on the line, two regions must do, or one, or none.

    Parameters
    ----------
    in_contact : ndarray of bool, shape (N,)
    """
    steps = [1]
    while in_contact.size > 2 * WINDOW * steps[-1]:
        steps.append(2 * steps[-1])
    counted = [_regions_in_windows(in_contact[::step]) for step in steps]
    for wanted in (3, 2, 1, 0):
        for step, regions in zip(steps, counted, strict=True):
            if regions.max() >= wanted:
                count = min(WINDOW, len(in_contact[::step]))
                return Window(int(np.argmax(regions)) * step, step, count)
    raise AssertionError("a count is at least 0")


def _regions_in_windows(seen: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of regions in every window, 0 where too many or few touch."""
    count = min(WINDOW, seen.size)
    touching = np.concatenate([[0], np.cumsum(seen)])
    share = (touching[count:] - touching[:-count]) / count
    begins = np.concatenate([[0], np.cumsum(seen[1:] & ~seen[:-1])])
    regions = begins[count - 1 :] - begins[: begins.size - count + 1]
    regions += seen[: regions.size]
    return np.where((share >= 0.3) & (share <= 0.6), regions, 0)
