"""Checks of what does not go on across the border of the cell: tilt, jump and steps.

The limits come from measurements on periodic self-affine surfaces and lines of known spectrum:
H = 0.2 to 0.95, roll-off at 1 to 8 q0, 64 to 256 points per side (lines: to 4096), 2 to 16
points per shortest wave, fixed and normal amplitudes; 4224 borders of surfaces and 8160 of
lines. Beside each limit stands what these good ones reach.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from roughbench.scans.detrending import fit_trend
from roughbench.scans.doubts import Case, Doubt
from roughbench.scans.evidence import steps_between
from roughbench.scans.rms import rms_height_and_gradient
from roughbench.scans.words import per_cent

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


def check_tilt(case: Case) -> Iterator[Doubt]:
    """Doubt a plane that goes on as a cliff at the border, unless a trend was said."""
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


def check_jump(case: Case) -> Iterator[Doubt]:
    """Doubt borders that meet worse than neighbouring lines do, unless edges were said."""
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


def check_steps(case: Case) -> Iterator[Doubt]:
    """Doubt a step within, along a whole row or column."""
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


def _mean(values: Iterator[float]) -> float:
    found = list(values)
    return sum(found) / len(found)
