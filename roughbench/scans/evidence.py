"""What heights show of themselves: steps between lines, waves, steps of the instrument."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

FloatArray = NDArray[np.float64]

_ROWS = 64
_SAMPLE = 1 << 18
"""Heights that are looked at for the steps of the instrument."""


@dataclass(frozen=True, slots=True)
class Steps:
    """Differences between neighbouring lines across one axis, and across the border.

    Attributes
    ----------
    mean, square : ndarray of float64, shape (n - 1,)
        Mean and mean square, along the line, of the step from each line to the next.
    border_mean, border_square : float
        The same of the step from the last line to the first.
    """

    mean: FloatArray
    square: FloatArray
    border_mean: float
    border_square: float

    @property
    def tilt(self) -> float:
        """Mean step across the border over the rms one between neighbours."""
        return _ratio(abs(self.border_mean), math.sqrt(float(np.mean(self.mean**2))))

    @property
    def jump(self) -> float:
        """Rms step across the border over that between all neighbours."""
        return _ratio(math.sqrt(self.border_square), math.sqrt(float(self.square.mean())))

    @property
    def jump_over_largest(self) -> float:
        """Rms step across the border over that between the two lines that differ most."""
        return _ratio(math.sqrt(self.border_square), math.sqrt(float(self.square.max())))

    @property
    def largest(self) -> tuple[int, float, float]:
        """The largest step within: its line, its mean, and its rms value over that of all."""
        line = int(self.square.argmax())
        ratio = _ratio(math.sqrt(self.square[line]), math.sqrt(float(self.square.mean())))
        return line, float(self.mean[line]), ratio

    @property
    def added_slope(self) -> float:
        """Share by which the border raises the squared slope across this axis."""
        return self.border_square / max(float(self.square.sum()), 1e-300)


def steps_between(heights: FloatArray) -> tuple[Steps, ...]:
    """Return the steps across each axis, of the points that are there.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        nan where missing. Lines at the border of which nothing is there are left out.

    Examples
    --------
    >>> steps, = steps_between(np.array([0.0, 1.0, 2.0, 3.0]))
    >>> steps.tilt, steps.jump, steps.added_slope
    (3.0, 3.0, 3.0)
    """
    if heights.ndim == 1:
        return (_across_rows(heights[:, None]),)
    return _across_rows(heights), _across_rows(heights.T)


def _across_rows(h: FloatArray) -> Steps:
    first, last = 0, h.shape[0]
    while first < last - 2 and np.isnan(h[first]).all():
        first += 1
    while first < last - 2 and np.isnan(h[last - 1]).all():
        last -= 1
    h = h[first:last]
    mean, square = np.zeros(h.shape[0] - 1), np.zeros(h.shape[0] - 1)
    for first in range(0, mean.size, _ROWS):
        part = slice(first, min(first + _ROWS, mean.size))
        mean[part], square[part] = _means(np.diff(h[first : part.stop + 1], axis=0))
    around = _means(h[:1] - h[-1:])
    return Steps(mean, square, float(around[0][0]), float(around[1][0]))


def _means(steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and mean square of each row, of what is there; 0 where nothing is."""
    count: FloatArray | int = steps.shape[1]
    if np.isnan(steps.sum()):
        there = np.isfinite(steps)
        count = np.maximum(np.count_nonzero(there, axis=1), 1).astype(np.float64)
        steps = np.where(there, steps, 0.0)
    return steps.sum(axis=1) / count, np.einsum("ij,ij->i", steps, steps) / count


@dataclass(frozen=True, slots=True)
class Waves:
    """What the spectrum says of resolution and of the number of bumps.

    Attributes
    ----------
    last_octave : float
        Share of the squared slope in waves shorter than four points.
    wavelength : float
        2π over the mean wavevector, weighted with the squared height; in points.
    bumps : float
        How many squares of this wavelength fit into the cell (wavelengths into a line).
    """

    last_octave: float
    wavelength: float
    bumps: float


def waves_of(heights: FloatArray) -> Waves:
    """Analyse heights by their cosines (DCT-II), for which borders need not meet.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        Without missing points, on square pixels. Not constant.

    Examples
    --------
    >>> x = (np.arange(64) + 0.5) / 64
    >>> waves = waves_of(np.cos(2 * np.pi * 4 * x))
    >>> round(waves.last_octave, 12), round(waves.wavelength, 12), round(waves.bumps, 12)
    (0.0, 16.0, 4.0)
    """
    lines = heights.reshape(heights.shape[0], -1)
    power = lines - lines.mean()
    for axis, points in enumerate(power.shape):
        if points > 1:
            power = fft.dct(power, type=2, axis=axis, norm="ortho", overwrite_x=True)
    np.square(power, out=power)
    # Wavevectors over π/d, the largest of each direction.
    across = (np.arange(lines.shape[1]) / lines.shape[1]) ** 2
    height = centre = slope = short = 0.0
    for row, values in enumerate(power):
        q_squared = (row / lines.shape[0]) ** 2 + across
        height += float(values.sum())
        centre += float(values @ np.sqrt(q_squared))
        values *= q_squared
        slope += float(values.sum())
        short += float(values[q_squared > _HALF].sum())
    wavelength = 2.0 * height / centre
    bumps = math.prod(n / wavelength for n in heights.shape)
    return Waves(short / slope, wavelength, bumps)


_HALF = 0.25 * (1.0 + 1e-6)
"""Square of half of the largest wavevector; waves of four points are not among the shorter."""


def height_step(heights: FloatArray) -> float:
    """Return the step between the heights that an instrument can tell apart; 0 if none shows.

    There is one if most gaps between the values that occur are multiples of the usual gap.

    Parameters
    ----------
    heights : ndarray of float64
        As read: a trend that was subtracted blurs the steps.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> height_step(np.round(rng.normal(size=(64, 64)), 1)).__round__(6)
    0.1
    >>> height_step(rng.normal(size=(64, 64)))
    0.0
    """
    flat = heights.ravel()
    values = flat[:: max(1, flat.size // _SAMPLE)]
    values = np.unique(values[np.isfinite(values)])
    if values.size < _FEWEST_LEVELS:
        return 0.0
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-7 * (values[-1] - values[0])]  # not those of rounding
    if gaps.size < _FEWEST_LEVELS - 1:
        return 0.0
    multiples = gaps / float(np.median(gaps))
    regular = np.abs(multiples - np.round(multiples)) < 0.05
    if np.count_nonzero(regular & (multiples > 0.5)) < 0.9 * gaps.size:
        return 0.0
    # Of gaps of one step each: more digits than the median of them.
    return float(np.median(gaps))


_FEWEST_LEVELS = 4
"""Fewer may be a pattern that someone made."""


def _ratio(above: float, below: float) -> float:
    """Return above/below; 0 of nothing, and infinity of something over nothing."""
    if above == 0.0:
        return 0.0
    return above / below if below > 0.0 else math.inf
