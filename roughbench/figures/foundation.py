"""Fig. 1 of the paper: the rough punch on its foundation of independent springs.

The line of realization 0 is made again from the spec, and pressed to the depth that the
results hold for it, in the experiment and at the pressure that show the most contact
regions (:func:`press`). Above the whole line: the rigid punch, its lower side at the
height d - h_i over the unloaded springs, which it compresses by h_i - d where that is
negative. Below :data:`WINDOW` springs of a window that shows contact and gaps
(:func:`choose_window`), every one or every few of them. Heights are in h_rms and drawn
much exaggerated; the length of a spring has no meaning in the model and is chosen for
the eye.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import StoreError
from roughbench.figures.curves import MODULUS, experiment_label, height_label, number_text
from roughbench.figures.rebuild import Experiment, self_affine_experiments, spec_fault
from roughbench.figures.style import BACKGROUND, COLOURS, SMALL, letter, new_figure
from roughbench.results import ModelResult, Results
from roughbench.runner.samples import make_sample

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

WINDOW = 48
"""Springs drawn one by one: as many as a column holds."""
SHARES = (0.05, 0.35)
"""Shares of springs in contact, least and most, that make a good picture."""
_PUNCH, _PUNCH_EDGE = "0.85", "0.2"
_FREE, _COMPRESSED = "0.45", COLOURS[1]


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


def missing(results: Results) -> str | None:
    """Return what the results lack for this figure, or None."""
    if fault := spec_fault(results):
        return fault
    if not any(True for _ in _sources(results)):
        return "a foundation on a surface given by its spectrum, not yet in full contact"
    return None


def _sources(results: Results) -> Iterator[tuple[Experiment, ModelResult]]:
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
    states = [state for source in _sources(results) for state in _states(*source)]
    if not states:
        raise StoreError(f"figure 'foundation' needs {missing(results)}")

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


def draw(results: Results) -> Figure:
    """Return the figure."""
    pressed = press(results)
    figure, (whole, zoom) = new_figure(2, 1.75)
    window = choose_window(pressed.clearance < 0.0)
    _draw_whole(whole, pressed, window)
    _draw_springs(zoom, pressed, window)
    state = (
        rf"$p/{MODULUS} = {number_text(pressed.pressure).strip('$')}$, "
        rf"$\bar u = {pressed.separation / pressed.rms_height:.2g}\,h_\mathrm{{rms}}$"
    )
    letter(whole, 0, ", ".join(filter(None, [experiment_label(pressed.experiment), state])))
    shown = "" if window.step == 1 else f", one in {window.step} drawn"
    letter(zoom, 1, f"some of the {pressed.clearance.size} springs{shown}")
    figure.supylabel(f"height/$h_\\mathrm{{rms}}$ {height_label(results)}", fontsize=9)
    return figure


def _draw_whole(axes: Axes, pressed: Pressed, window: Window) -> None:
    n = pressed.clearance.size
    x = (np.arange(n) + 0.5) / n
    z = pressed.clearance / pressed.rms_height
    bottom, top = z.min() - 0.15 * np.ptp(z), z.max() + 0.3 * np.ptp(z)
    axes.fill_between(x, z, top, color=_PUNCH, linewidth=0)
    axes.plot(x, z, color=_PUNCH_EDGE, linewidth=0.4, gid="punch")
    axes.fill_between(x, z, 0.0, where=(z < 0.0).tolist(), color=_COMPRESSED, linewidth=0.3)
    axes.axhline(0.0, color=_COMPRESSED, linewidth=0.7)
    window_ends = [window.start / n, window.stop / n]
    for end in window_ends:
        axes.axvline(end, color=COLOURS[0], linewidth=0.6)
    axes.plot(
        window_ends,
        [0.0, 0.0],
        color=COLOURS[0],
        linewidth=4,
        solid_capstyle="butt",
        transform=axes.get_xaxis_transform(),
    )
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("position $x/L$")
    for y, align, word, ground in (
        (0.95, "top", "rigid punch", _PUNCH),
        (0.06, "bottom", "springs", "white"),
    ):
        axes.text(
            0.02,
            y,
            word,
            transform=axes.transAxes,
            va=align,
            fontsize=SMALL + 1.0,
            bbox=BACKGROUND | {"facecolor": ground},
            zorder=5,
        )


def _draw_springs(axes: Axes, pressed: Pressed, window: Window) -> None:
    from matplotlib.collections import LineCollection

    start = window.start
    margin = max(window.step // 2, 1)
    x = np.arange(start - margin, window.stop + margin)
    z = np.take(pressed.clearance, x, mode="wrap") / pressed.rms_height
    deepest, highest = -min(float(z.min()), 0.0), max(float(z.max()), 0.0)
    span = deepest + highest
    base = -(deepest + 0.9 * span)
    ends = np.minimum(z[margin : -margin : window.step], 0.0)
    springs = [
        spring(start + window.step * i, base, end, 0.3 * window.step)
        for i, end in enumerate(ends)
    ]
    colours = [_COMPRESSED if end < 0.0 else _FREE for end in ends]
    axes.add_collection(LineCollection(springs, colors=colours, linewidths=0.55, gid="springs"))
    axes.fill_between(x, z, highest + 0.3 * span, color=_PUNCH, linewidth=0)
    axes.plot(x, z, color=_PUNCH_EDGE, linewidth=0.8, gid="window")
    axes.axhline(0.0, color=_FREE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
    axes.fill_between(
        [x[0], x[-1]],
        base - 0.12 * span,
        base,
        facecolor="white",
        edgecolor=_PUNCH_EDGE,
        hatch="//////",
        linewidth=0.6,
    )
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(base - 0.12 * span, highest + 0.3 * span)
    axes.set_xlabel("spring number")


def spring(x: float, bottom: float, top: float, swing: float, coils: int = 7) -> FloatArray:
    """Return the zigzag of a spring, straight at both ends.

    Parameters
    ----------
    x : float
        Its axis.
    bottom, top : float
        Its ends.
    swing : float
        How far it goes to either side.
    coils : int
        The same for every spring, so that a compressed one is denser.

    Returns
    -------
    ndarray of float64, shape (2 coils + 4, 2)
    """
    n = 2 * coils
    side = np.concatenate([[0.0, 0.0], swing * (-1.0) ** np.arange(n), [0.0, 0.0]])
    along = np.concatenate([[0.0, 0.06], 0.06 + 0.88 * (np.arange(n) + 0.5) / n, [0.94, 1.0]])
    return np.column_stack([x + side, bottom + (top - bottom) * along])
