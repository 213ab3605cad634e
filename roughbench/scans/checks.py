"""What makes the answer on given heights wrong or doubtful, each in one line.

The thresholds come from measurements on periodic self-affine surfaces and lines of known
spectrum: H = 0.2 to 0.95, roll-off at 1 to 8 q0, 64 to 256 points per side (lines: to 4096),
2 to 16 points per shortest wave, fixed and normal amplitudes; 4224 borders of surfaces and
8160 of lines. Beside each stands what these good ones reach.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.detrending import fit_trend
from roughbench.scans.evidence import height_step, steps_between, waves_of
from roughbench.scans.preparation import Preparation
from roughbench.scans.rms import rms_height_and_gradient
from roughbench.scans.topography import Scan
from roughbench.scans.words import per_cent
from roughbench.units import in_words

FloatArray = NDArray[np.float64]

TILT = 6.0
"""Mean step across the border over the rms mean step between neighbouring lines. Good surfaces
and lines reach 3.7: the border is one line among many."""
TILT_MATTERS = 0.02
"""Relative change of Sq or of the slope by the plane; below it no quantity moves by more."""
JUMP, CLEAR_JUMP = 2.0, 2.5
"""Rms step across the border over that between neighbours. Good surfaces reach 1.83 (smooth
ones, whose steps come in waves), and there the border is no larger than the largest step
within: between the two limits that is asked for as well."""
JUMP_OVER_LARGEST = 1.3
"""Rms step across the border over the largest within. Good surfaces reach 1.13."""
LINE_JUMP = 6.0
"""As JUMP for a line, whose border is a single pair of points. Good lines reach 3.6."""
STEP, LINE_STEP = 3.0, 8.0
"""Largest rms step between two neighbouring lines over that of all, good ones reach 2.1; and
largest step between two points of a line over the rms one, good ones reach 5.2."""
STEP_TOGETHER = 0.7
"""Mean over rms value of that step along its line: it moves as a whole."""
SLOPE = 0.7
"""Rms slope from which on the half-space of small slopes is no longer one."""
ODD_SLOPES = 1e-6, 5.0
"""Rms slopes beyond which no measured surface is known: another unit is likelier."""
ROUNDING = 0.1
"""Rounding over rms difference of neighbours; the area moves by up to 1.5 %, at 0.3 by 8 %
(see roughbench.inputs.LARGEST_ROUNDING)."""
LAST_OCTAVE = 0.1
"""Share of the squared slope in waves of less than four points. Surfaces with four points per
shortest wave reach 0.01 (lines 0.05), with two 0.14 and more, with three 0.06 to 0.38."""
BUMPS = 9.0
"""Bumps in a cell. Sq of random surfaces scatters by about 1/(2√bumps), within a factor of 1.5:
17 % here. Good surfaces with a roll-off at 4 q0 or above have 13 and more, with one at q0 and
H = 0.8 about three."""

_LARGE_COUNT = 50.0


@dataclass(frozen=True, slots=True)
class Doubt:
    """One reason to mistrust the answer.

    Attributes
    ----------
    check : str
        tilt, jump, step, slope, unit, quantization, resolution or bumps.
    text : str
        One line: what is found, with a number, and the remedy.
    is_wrong : bool
        Whether the answer is wrong; else it is doubtful.
    """

    check: str
    text: str
    is_wrong: bool


def doubts_of(
    heights: FloatArray,
    length: float,
    *,
    raw: Scan | None = None,
    preparation: Preparation | None = None,
    gap: float | None = None,
    accept: Collection[str] = (),
) -> list[Doubt]:
    """Check heights that a model is to compute with.

    Parameters
    ----------
    heights : ndarray of float64, shape (n,) or (n, m)
        One periodic cell with square pixels; of a scan, as prepared.
    length : float
        Period along the first axis, in the unit of the heights.
    raw : Scan, optional
        What they were made of; without it the heights have no unit and were not prepared.
    preparation : Preparation, optional
        What was said about the scan.
    gap : float, optional
        Mean gap at the lowest pressure, for the steps of the instrument.
    accept : collection of str
        Checks that the user has settled: they say nothing.

    Returns
    -------
    list of Doubt
        Those that make the answer wrong first.

    Notes
    -----
    An explicit ``detrend`` or ``edges`` settles tilt and jump: what is left of them is doubtful
    and no longer wrong. Too large a slope makes an answer in pascals wrong; without units only
    the ratio of pressure and slope counts, and it is doubtful.

    Examples
    --------
    >>> tilted = 0.01 * np.cos(np.arange(64.0)[:, None] + np.arange(64.0) ** 2)
    >>> tilted += 0.02 * np.arange(64.0)
    >>> [doubt.check for doubt in doubts_of(tilted, 64.0) if doubt.is_wrong]
    ['tilt', 'jump']
    """
    case = _Case.of(heights, length, raw, preparation or Preparation(), gap)
    if float(np.ptp(case.part)) == 0.0:
        return []
    found: list[Doubt] = []
    for check in (_tilt, _jump, _step, _slope, _quantization, _waves):
        found += [doubt for doubt in check(case) if doubt.check not in accept]
    return sorted(found, key=lambda doubt: not doubt.is_wrong)


@dataclass(frozen=True, slots=True)
class _Case:
    """The heights of a check, and what is known of them.

    Attributes
    ----------
    part : ndarray
        The heights without their reflections.
    spacing : float
    as_read : ndarray
        Those of the raw scan.
    read_spacing : (float, float)
    unit : str
        "m", or "1" where there is none.
    """

    part: FloatArray
    spacing: float
    as_read: FloatArray
    read_spacing: tuple[float, float]
    unit: str
    preparation: Preparation
    gap: float | None

    @classmethod
    def of(
        cls,
        heights: FloatArray,
        length: float,
        raw: Scan | None,
        preparation: Preparation,
        gap: float | None,
    ) -> _Case:
        spacing = length / heights.shape[0]
        if raw is None:
            return cls(heights, spacing, heights, (spacing,) * 2, "1", preparation, gap)
        part = heights
        if preparation.edges == "mirror":
            part = heights[: heights.shape[0] // 2, : heights.shape[1] // 2]
        return cls(part, spacing, raw.heights, raw.spacing, "m", preparation, gap)

    def words(self, value: float) -> str:
        return in_words(value, self.unit)

    def remedy(self, key: str, check: str) -> str:
        """Return how to settle a check: by a key of a scan, or by accepting it."""
        scan = "" if self.unit == "m" else "take the file as kind: scan with "
        return f"{scan}{key}, or accept: [{check}]"

    def slope(self) -> float:
        """Rms slope within, without the border."""
        if self.part.ndim == 1:
            return math.sqrt(float(np.mean(np.diff(self.part) ** 2))) / self.spacing
        return rms_height_and_gradient(self.part, (self.spacing,) * 2, periodic=False)[1]


def _tilt(case: _Case) -> Iterator[Doubt]:
    said = case.preparation.detrend
    if said in ("plane", "quadratic"):
        return
    steps = steps_between(case.as_read)
    if max(step.tilt for step in steps) <= TILT:
        return
    level = case.as_read.reshape(case.as_read.shape[0], -1).copy()
    if level.shape[1] == 1:
        level = np.repeat(level, 3, axis=1)  # a plane needs a width
    trend = fit_trend(level, case.read_spacing, "plane")
    closed = case.preparation.edges in ("mirror", "taper")
    with_it = rms_height_and_gradient(level, case.read_spacing, periodic=not closed)
    trend.subtract_from(level)
    without = rms_height_and_gradient(level, case.read_spacing, periodic=not closed)
    if all(a <= (1.0 + TILT_MATTERS) * b for a, b in zip(with_it, without, strict=True)):
        return
    y, x = trend.tilt
    if case.unit == "m":
        each = f"{1e3 * y:.3g} nm/µm along y and {1e3 * x:.3g} nm/µm along x"
    else:
        each = f"{y:.3g} along y and {x:.3g} along x" if case.part.ndim == 2 else f"{y:.3g}"
    degrees = math.degrees(math.atan(math.hypot(y, x)))
    yield Doubt(
        "tilt",
        f"tilted by {each} ({degrees:.2g}°): with the tilt Sq is {case.words(with_it[0])} and "
        f"the slope of the cell {with_it[1]:.3g}, without it {case.words(without[0])} and "
        f"{without[1]:.3g}; {case.remedy('detrend: plane (none if it is real)', 'tilt')}",
        is_wrong=said is None,
    )


def _jump(case: _Case) -> Iterator[Doubt]:
    said = case.preparation.edges
    if said in ("mirror", "taper"):
        return
    steps = steps_between(case.part)
    over = [step.jump for step in steps]
    if case.part.ndim == 1:
        found = over[0] > LINE_JUMP
    else:
        found = any(
            step.jump > CLEAR_JUMP
            or (step.jump > JUMP and step.jump_over_largest > JUMP_OVER_LARGEST)
            for step in steps
        )
    if not found:
        return
    axis = int(np.argmax(over))
    where = f" along {'yx'[axis]}" if case.part.ndim == 2 else ""
    usual = math.sqrt(float(steps[axis].square.mean()))
    raised = math.sqrt(1.0 + _mean(step.added_slope for step in steps)) - 1.0
    remedy = {
        None: case.remedy("edges: mirror (periodic if it is)", "jump"),
        "periodic": "edges: mirror has no jump",
        "crop": "no part of the scan fits; edges: mirror has no jump",
    }[said]
    yield Doubt(
        "jump",
        f"the borders do not meet: the step across them{where} is "
        f"{case.words(math.sqrt(steps[axis].border_square))} (rms), {over[axis]:.2g} times "
        f"that between neighbouring points ({case.words(usual)}), and raises the slope by "
        f"{per_cent(raised)}; {remedy}",
        is_wrong=said is None,
    )


def _step(case: _Case) -> Iterator[Doubt]:
    limit = STEP if case.part.ndim == 2 else LINE_STEP
    for name, steps in zip(("rows", "columns"), steps_between(case.part), strict=False):
        line, mean, ratio = steps.largest
        together = abs(mean) >= STEP_TOGETHER * math.sqrt(steps.square[line])
        if ratio <= limit or not together:
            continue
        what = name if case.part.ndim == 2 else "points"
        yield Doubt(
            "step",
            f"a step of {case.words(abs(mean))} between {what} {line} and {line + 1}, "
            f"{ratio:.2g} times the usual difference: the edge of a part that is higher, or a "
            "slip of the instrument; cut the better part out of the file, or accept: [step]",
            is_wrong=False,
        )


def _slope(case: _Case) -> Iterator[Doubt]:
    slope = case.slope()
    least, most = ODD_SLOPES
    if slope > SLOPE and (levels := _counts(case)):
        yield Doubt(
            "unit",
            f"heights are whole numbers {levels} and their rms slope is {slope:.3g}: they look "
            "like raw counts of the instrument; convert them to lengths, or give the unit of "
            "one count, or accept: [unit]",
            is_wrong=True,
        )
    elif slope > most or 0.0 < slope < least:
        factor, example = (1e-3, "nm over µm") if slope > most else (1e6, "m over µm")
        yield Doubt(
            "unit",
            f"an rms slope of {slope:.3g} is that of no known surface: heights look like "
            f"another unit than the size ({example} would make it {factor * slope:.3g}); "
            "correct the unit of one of them, or accept: [unit]",
            is_wrong=slope > most,
        )
    elif slope > SLOPE:
        yield Doubt(
            "slope",
            f"an rms slope of {slope:.3g} is above {SLOPE:g}: all models here take slopes as "
            "small; resample: to the waves that count, or accept: [slope]",
            is_wrong=case.unit == "m",
        )


def _counts(case: _Case) -> str:
    """Say from where to where heights count, in their own unit; "" if they do not."""
    for scale in (1.0,) if case.unit == "1" else (1.0, 1e-3, 1e-6, 1e-9, 1e-10, 1e-12):
        flat = case.as_read.ravel()
        some = flat[:: max(1, flat.size >> 18)]
        some = some[np.isfinite(some)] / scale
        low, high = float(some.min()), float(some.max())
        rounding = 1e-6 + 1e-9 * max(-low, high)
        near = np.abs(some - np.round(some)) <= rounding
        if rounding < 0.01 and near.all() and high - low >= _LARGE_COUNT:
            return f"from {low:.0f} to {high:.0f}"
    return ""


def _quantization(case: _Case) -> Iterator[Doubt]:
    step = height_step(case.as_read)
    if step == 0.0:
        return
    if case.gap is not None and step > case.gap:
        yield Doubt(
            "quantization",
            f"heights come in steps of {case.words(step)}, more than the mean gap at the "
            f"lowest pressure, {case.words(case.gap)}; measure with more digits or a smaller "
            "range, compute lower pressures, or accept: [quantization]",
            is_wrong=True,
        )
        return
    difference = case.slope() * case.spacing / math.sqrt(case.part.ndim)
    share = step / math.sqrt(6.0) / difference
    if share > ROUNDING:
        yield Doubt(
            "quantization",
            f"heights come in steps of {case.words(step)}, and neighbours differ by "
            f"{case.words(difference)} (rms), {per_cent(min(share, 1.0))} of it by rounding: "
            "that raises the slope and moves the area (1.5 % at 10 %, 8 % at 30 %); "
            "measure with more digits or a smaller range, or resample: to fewer points",
            is_wrong=False,
        )


def _waves(case: _Case) -> Iterator[Doubt]:
    waves = waves_of(case.part)
    if waves.last_octave > LAST_OCTAVE:
        yield Doubt(
            "resolution",
            f"roughness is not resolved: {per_cent(waves.last_octave)} of the squared slope "
            "sits in the last octave of the spectrum, in waves of 2 to 4 points; finer pixels "
            "would find more slope and less contact, and the grid is too coarse for contacts "
            "on these waves: resample: to twice the points for the grid, a finer scan for the "
            "slope",
            is_wrong=False,
        )
    if waves.bumps < BUMPS:
        bumps = max(waves.bumps, 1.0)  # of a single slope less than one
        scatter = 0.5 / math.sqrt(bumps)
        yield Doubt(
            "bumps",
            f"only about {bumps:.2g} bump{'s' * (bumps >= 1.05)} in the cell (mean wavelength "
            f"{case.words(waves.wavelength * case.spacing)}): Sq of another such piece differs "
            f"by {per_cent(scatter)}, and the gap with it; measure a larger piece, or average "
            "over several",
            is_wrong=False,
        )


def _mean(values: Iterator[float]) -> float:
    found = list(values)
    return sum(found) / len(found)
