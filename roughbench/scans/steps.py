"""The steps of a preparation, carried out and recorded one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.scans.detrending import Detrend, Trend, fit_trend
from roughbench.scans.edges import (
    Edges,
    border_jump,
    crop,
    mirror,
    taper,
    without_missing_border,
)
from roughbench.scans.filling import Holes, fill_holes, find_holes
from roughbench.scans.outliers import find_outliers
from roughbench.scans.resampling import resample, square_grid
from roughbench.scans.rms import NO_SLOPE, rms_height_and_gradient
from roughbench.scans.topography import Scan
from roughbench.scans.words import per_cent
from roughbench.units import in_words

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the preparation, and the heights after it.

    Attributes
    ----------
    name : str
        as read, outliers, crop, detrend, fill, resample or edges.
    text : str
        What was done, with its numbers, on one line.
    points : (int, int)
        Rows and columns.
    size : (float, float)
        Along (y, x), m.
    Sq, Sdq : float
        Rms height, m, and rms gradient by differences of neighbouring points; after *edges*
        across the border of the cell, too.
    """

    name: str
    text: str
    points: tuple[int, int]
    size: tuple[float, float]
    Sq: float
    Sdq: float


class Preparing:
    """Heights while they are prepared; each step changes or replaces them, and is recorded."""

    def __init__(self, scan: Scan) -> None:
        self.scan = scan
        self.heights = scan.heights.astype(np.float64)  # a copy: the scan stays as it is
        self.size = scan.size
        self.steps: list[Step] = []

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance between points along (y, x), m."""
        rows, columns = self.heights.shape
        return self.size[0] / rows, self.size[1] / columns

    def record(self, name: str, text: str, *, periodic: bool = False) -> None:
        """Note what was done and what came of it."""
        rms = rms_height_and_gradient(self.heights, self.spacing, periodic=periodic)
        rows, columns = self.heights.shape
        self.steps.append(Step(name, text, (rows, columns), self.size, *rms))

    def keep(self, rows: slice, columns: slice) -> None:
        """Cut a part out."""
        dy, dx = self.spacing
        self.heights = np.ascontiguousarray(self.heights[rows, columns])
        self.size = dy * self.heights.shape[0], dx * self.heights.shape[1]

    def remove_outliers(self, limit: float) -> None:
        """Take points out that stand out of their neighbourhood by this many deviations."""
        found, deviation = find_outliers(self.heights, limit)
        count = int(np.count_nonzero(found))
        self.heights[found] = np.nan
        self.record(
            "outliers",
            f"{_count(count, 'point')} ({per_cent(count / found.size)}) further than {limit:g} "
            f"robust deviations ({in_words(deviation, 'm')} each) from the median of their "
            "neighbours taken out",
        )

    def cut_missing_border(self) -> None:
        """Cut rows and columns off that are mostly missing."""
        before = self.heights.shape
        part = without_missing_border(self.heights)
        if part == (slice(0, before[0]), slice(0, before[1])):
            return
        self.keep(*part)
        self.record("crop", f"borders that are missing cut off: {_part(part, before)}")

    def detrend(self, kind: Detrend) -> None:
        """Subtract a trend fitted to the points that are there."""
        if kind == "none":
            self.record("detrend", "no trend subtracted")
            return
        trend = fit_trend(self.heights, self.spacing, kind)
        trend.subtract_from(self.heights)
        self.record("detrend", _trend_in_words(trend, kind))

    def fill(self, allowed: float, *, periodic: bool) -> None:
        """Fill holes, if no larger share is missing than allowed; else a SurfaceError."""
        missing = np.isnan(self.heights)
        holes = find_holes(missing)
        if not holes.points:
            return
        share = holes.points / missing.size
        if share > allowed:
            raise SurfaceError(self._too_much_missing(missing, holes, allowed))
        if any(math.isnan(step.Sdq) for step in self.steps):
            raise SurfaceError(
                f"{source_of(self.scan)}{NO_SLOPE}, and there is nothing to judge the filled "
                "ones by; leave rows and columns that are missing out of the file, or measure "
                "again"
            )
        del missing
        fill_holes(self.heights, self.spacing, periodic=periodic)
        self.record(
            "fill",
            f"{_count(holes.points, 'missing point')} ({per_cent(share)}) in "
            f"{_count(holes.count, 'hole')} filled from the rims (harmonic)"
            + (f"; {self._largest(holes)}" if holes.largest > 1 else ""),
        )

    def resample(self, points: int | None, *, periodic: bool) -> None:
        """Make pixels square, and as many as wanted along the longer side."""
        before = self.heights.shape
        dy, dx = self.spacing
        if points is None and abs(dy / dx - 1.0) < _ROUNDING:
            return
        rows, columns = square_grid((before[0], before[1]), self.size, points)
        slope = self.steps[-1].Sdq
        self.heights = resample(self.heights, (rows, columns), periodic=periodic)
        stretch = self.size[0] / rows * columns / self.size[1] - 1.0
        self.size = self.size[0], self.size[0] / rows * columns
        text = f"from {points_in_words(before)} to {rows} × {columns}"
        if abs(dy / dx - 1.0) >= _ROUNDING:
            text += (
                f", of pixels of {in_words(dy, 'm')} along y and {in_words(dx, 'm')} along "
                f"x, now square: {in_words(self.size[0] / rows, 'm')}"
            )
        if abs(stretch) >= _ROUNDING:
            text += f"; x stretched by {100 * stretch:+.2g} % for a whole number of them"
        self.record("resample", text)
        done, now = self.steps[-1], self.steps[-1].Sdq
        if slope > 0.0 and now < slope:
            text += f"; that took away {per_cent(1.0 - now / slope)} of the slope"
            self.steps[-1] = Step(done.name, text, done.points, done.size, done.Sq, done.Sdq)

    def make_periodic(self, edges: Edges | None) -> None:
        """Make one cell of a periodic surface of the scan, without its mean."""
        before = self.heights.shape
        if edges == "mirror":
            self.heights = mirror(self.heights)
            self.size = 2.0 * self.size[0], 2.0 * self.size[1]
            text = "mirrored: the scan and its three reflections, a cell of twice the size"
        elif edges == "taper":
            dy, dx = self.spacing
            self.heights = taper(self.heights)
            after = self.heights.shape
            self.size = dy * after[0], dx * after[1]
            text = (
                f"tapered: the last {before[0] - after[0]} rows and {before[1] - after[1]} "
                f"columns faded into the first, Sq {in_words(self.steps[-1].Sq, 'm')} → "
                f"{in_words(float(self.heights.std()), 'm')}"
            )
        elif edges == "crop":
            jumps = self._jumps()
            part = crop(self.heights)
            self.keep(*part)
            text = (
                f"cropped to the part whose borders meet best: {_part(part, before)}; step at "
                f"the border {jumps} before, {self._jumps()} after"
            )
        else:
            said = "" if edges else " (nothing else was said)"
            text = f"taken as periodic as it is{said}; step at the border {self._jumps()}"
        self.heights -= self.heights.mean()
        self.record("edges", text, periodic=True)

    def _jumps(self) -> str:
        jumps = (in_words(border_jump(self.heights, axis)[0], "m") for axis in (0, 1))
        return "{} along y and {} along x".format(*jumps)

    def _largest(self, holes: Holes) -> str:
        (row, column), (dy, dx) = holes.place, self.spacing
        return (
            f"the largest, {_count(holes.largest, 'point')}, lies about row {row:.0f}, column "
            f"{column:.0f} (y = {in_words(row * dy, 'm')}, "
            f"x = {in_words(column * dx, 'm')})"
        )

    def _too_much_missing(
        self, missing: NDArray[np.bool_], holes: Holes, allowed: float
    ) -> str:
        share = holes.points / missing.size
        enough = math.ceil(1000.0 * share) / 10.0
        text = (
            f"{source_of(self.scan)}{per_cent(share)} of the points are missing "
            f"({_count(holes.points, 'point')} in {_count(holes.count, 'hole')}), and fill "
            f"allows {per_cent(allowed)}; {self._largest(holes)}"
        )
        part = without_missing_border(self.heights)
        rest = missing[part]
        if rest.size < missing.size:
            left = float(rest.mean()) if rest.size else 1.0
            text += (
                f"; its borders are missing: edges: crop would cut to "
                f"{_part(part, missing.shape)}, with {per_cent(left)} missing"
            )
        remedy = "or measure again" if share > _MUCH else "to fill them from their rims"
        return f"{text}; say fill: {enough:g} % {remedy}"


_ROUNDING = 1e-6
"""Relative difference of two sizes that counts as rounding."""
_MUCH = 0.1
"""Share of filled points at which the answer is off by more than a few percent; see
docs/scans.md, from scripts/preparation_effects.py."""


def source_of(scan: Scan) -> str:
    """Return the beginning of a message about a scan."""
    return f"{scan.source}: " if scan.source else ""


def as_read_in_words(scan: Scan) -> str:
    """Return points and size of a scan, and what it misses."""
    dy, dx = scan.spacing
    text = f"{points_in_words(scan.shape)}, " + " × ".join(in_words(s, "m") for s in scan.size)
    if abs(dy / dx - 1.0) >= _ROUNDING:
        text += f", pixels of {in_words(dy, 'm')} × {in_words(dx, 'm')}"
    return text + (f", {per_cent(scan.missing)} missing" if scan.missing else "")


def _trend_in_words(trend: Trend, kind: Detrend) -> str:
    if kind == "mean":
        return f"mean of {in_words(float(trend.coefficients[0, 0]), 'm')} subtracted"
    y, x = (f"{1e3 * slope:.3g} nm/µm" for slope in trend.tilt)
    text = f"{kind} subtracted: a slope of {y} along y and {x} along x"
    if kind == "quadratic":
        y, x = (in_words(sag, "m") for sag in trend.sag)
        text += f", the borders {y} and {x} above the middle by the curvature"
    return text


def points_in_words(shape: tuple[int, ...]) -> str:
    """Return rows × columns."""
    return " × ".join(str(n) for n in shape) + " points"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _part(part: tuple[slice, slice], before: tuple[int, ...]) -> str:
    rows, columns = part
    return (
        f"rows {rows.start}:{rows.stop} of {before[0]} and columns "
        f"{columns.start}:{columns.stop} of {before[1]}"
    )
