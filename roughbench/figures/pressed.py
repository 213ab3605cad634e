"""A line of the results, pressed into its springs again, and what to show of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.figures.rebuild import Experiment, self_affine_experiments
from roughbench.planning.samples import make_sample
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
        p/E*.
    separation : float
        ū, length.
    """

    experiment: str
    clearance: FloatArray
    rms_height: float
    pressure: float
    separation: float

    @property
    def share(self) -> float:
        """Share of the springs in contact."""
        return float(np.mean(self.clearance < 0.0))

    @property
    def regions(self) -> int:
        """Number of contact regions; one that runs through the ends counts as two."""
        touching = self.clearance < 0.0
        return int(touching[0]) + int(np.count_nonzero(touching[1:] & ~touching[:-1]))


def sources(results: Results) -> Iterator[tuple[Experiment, ModelResult]]:
    """Yield the foundations whose realization 0 has a state short of full contact."""
    for experiment in self_affine_experiments(results):
        for result in results[experiment[0]].values():
            if result.kind == "foundation" and _partial(result).any():
                yield experiment, result


def _partial(result: ModelResult) -> NDArray[np.bool_]:
    """Pressures at which realization 0 converged short of full contact."""
    return (result["status"][0] == 0) & (result["separation"][0] > 0.0)


def press(results: Results) -> Pressed:
    """Return the line of realization 0 of a foundation, pressed for the figure.

    Of all experiments and pressures with a share of springs in contact within
    :data:`SHARES` it takes the one with the most contact regions, or the lowest of
    several; if there is none, the one whose share comes nearest.

    Returns
    -------
    Pressed

    Raises
    ------
    StoreError
        If there is no foundation, or the line made again from the spec is not the one
        that the results were computed with.
    """
    states = [state for source in sources(results) for state in _states(*source)]
    if not states:
        raise StoreError("figure 'foundation' needs a foundation")

    def merit(state: Pressed) -> tuple[float, int]:
        least, most = SHARES
        return -max(least - state.share, state.share - most, 0.0), state.regions

    return max(states, key=merit)


def _states(experiment: Experiment, result: ModelResult) -> Iterator[Pressed]:
    """Yield the states of realization 0; its plane is at d = ū - (π/4) L p/E*."""
    name, surface, spec = experiment
    model = next(model for model in spec.models if model.name == result.label)
    heights = make_sample(surface, model, spec.seed, 0).heights
    if heights is None:
        raise StoreError(f"figure 'foundation' needs a line, which {result.label} has not")
    heights = heights - heights.mean()
    for chosen in np.flatnonzero(_partial(result)):
        pressure = float(result["pressure"][chosen])
        separation = float(result["separation"][0, chosen])
        compression = math.pi / 4.0 * surface.length * pressure
        clearance = separation - compression - heights
        found = float(np.maximum(-clearance, 0.0).mean())
        if abs(found - compression) > 1e-6 * compression:
            raise StoreError(
                "figure 'foundation' needs the line of realization 0, but the one made from "
                f"the spec carries p/E* = {pressure * found / compression:.6g} where the "
                f"results say {pressure:.6g}; run the spec again with this version"
            )
        yield Pressed(
            name, clearance, float(result.attributes["rms_height"]), pressure, separation
        )


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

    Returns
    -------
    Window
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
