"""From a scan to heights that the models can work with, each step on record.

The order, and why:

1. *outliers* (on request) become missing points. First, because one spike tilts a plane and
   is a rim of nothing.
2. *crop* cuts off borders that are missing, so that nothing has to be made up there.
3. *detrend*, fitted to the points that are there: heights that were filled are no
   measurements. Before the filling, because a hole at the border is filled without a slope
   across it, which is right for roughness and wrong for a tilt, and because the curvature of
   a paraboloid is not harmonic.
4. *fill*, as long as no more is missing than allowed.
5. *square pixels* and *resample*, which need every point.
6. *edges*: the periodic cell. Last, because the others would break it.
7. The mean is removed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.errors import SurfaceError
from roughbench.scans.detrending import DETREND, Detrend
from roughbench.scans.edges import EDGES, Edges
from roughbench.scans.steps import Preparing, as_read_in_words, points_in_words, source_of
from roughbench.scans.steps import Step as Step  # others import it from here
from roughbench.scans.topography import Scan

FloatArray = NDArray[np.float64]

FEWEST_POINTS = 4
"""Per side: fewer carry no wave but the one that alternates from point to point."""


@dataclass(frozen=True, slots=True)
class Preparation:
    """What is to be done with a scan; see the head of this module for the order.

    Parameters
    ----------
    detrend : {"none", "mean", "plane", "quadratic"}, optional
        What is subtracted; None (not said) is taken as mean.
    fill : float
        Largest share of missing points that is filled, 0 ≤ fill < 1.
    edges : {"periodic", "mirror", "taper", "crop"}, optional
        How the scan becomes a periodic cell; None (not said) is taken as periodic.
    outliers : float, optional
        Points further than so many robust deviations from the median of their neighbours
        count as missing.
    resample : int, optional
        Points along the longer side of the scan.

    Raises
    ------
    SurfaceError
        If a value is none of these.
    """

    detrend: Detrend | None = None
    fill: float = 0.0
    edges: Edges | None = None
    outliers: float | None = None
    resample: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be done."""
        for name, value, allowed in (
            ("detrend", self.detrend, DETREND),
            ("edges", self.edges, EDGES),
        ):
            if value is not None and value not in allowed:
                raise SurfaceError(f"{name} must be one of {', '.join(allowed)}, got {value!r}")
        if not 0.0 <= self.fill < 1.0:
            raise SurfaceError(
                f"fill must be a share from 0 to less than 1 (100 %), got {self.fill}"
            )
        if self.outliers is not None and not 0.0 < self.outliers < math.inf:
            raise SurfaceError(
                f"outliers must be a positive number of deviations, got {self.outliers}"
            )
        if self.resample is not None and self.resample < FEWEST_POINTS:
            raise SurfaceError(
                f"resample must be at least {FEWEST_POINTS}, got {self.resample}"
            )


@dataclass(frozen=True, slots=True)
class Prepared:
    """Heights for the models, and how they came about.

    Attributes
    ----------
    heights : ndarray of float64, shape (n, m)
        One periodic cell of square pixels, zero mean, nothing missing; m.
    length : float
        Period along the first axis, m.
    raw : Scan
    steps : tuple of Step
        The first is "as read".
    """

    heights: FloatArray
    length: float
    raw: Scan
    steps: tuple[Step, ...]


def prepare(scan: Scan, preparation: Preparation) -> Prepared:
    """Prepare a scan as asked.

    Parameters
    ----------
    scan : Scan
    preparation : Preparation

    Raises
    ------
    SurfaceError
        If more points are missing than may be filled; with the share, the largest hole and
        its place. If too few points are left for a surface.

    Examples
    --------
    >>> heights = 1e-9 * np.add.outer(np.arange(8.0), np.cos(np.arange(8.0)))
    >>> heights[3, 4] = np.nan
    >>> scan = Scan(heights, size=(1e-6, 1e-6))
    >>> prepared = prepare(scan, Preparation(detrend="plane", fill=0.05, edges="mirror"))
    >>> [step.name for step in prepared.steps], prepared.heights.shape
    (['as read', 'detrend', 'fill', 'edges'], (16, 16))
    >>> print(prepared.steps[1].text)
    plane subtracted: a slope of 7.99 nm/µm along y and 0.278 nm/µm along x
    """
    if not np.isfinite(scan.heights).any():
        raise SurfaceError(f"{source_of(scan)}no point has a height")
    if np.isinf(scan.heights).any():
        raise SurfaceError(f"{source_of(scan)}heights must be finite, or nan where missing")
    work = Preparing(scan)
    work.record("as read", as_read_in_words(scan))
    if preparation.outliers is not None:
        work.remove_outliers(preparation.outliers)
    if preparation.edges == "crop":
        work.cut_missing_border()
    work.detrend(preparation.detrend or "mean")
    work.fill(preparation.fill, periodic=preparation.edges == "periodic")
    periodic = preparation.edges in (None, "periodic")
    work.resample(preparation.resample, periodic=periodic)
    if min(work.heights.shape) < FEWEST_POINTS:
        raise SurfaceError(
            f"{source_of(scan)}{points_in_words(work.heights.shape)} are left, and a surface "
            f"needs at least {FEWEST_POINTS} per side"
        )
    work.heights -= work.heights.mean()
    work.make_periodic(preparation.edges)
    return Prepared(work.heights, work.size[0], scan, tuple(work.steps))
