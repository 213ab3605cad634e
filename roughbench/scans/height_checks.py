"""Checks of slopes, units, rounding and waves of heights.

The limits come from measurements on periodic self-affine surfaces and lines of known spectrum:
H = 0.2 to 0.95, roll-off at 1 to 8 q0, 64 to 256 points per side (lines: to 4096), 2 to 16
points per shortest wave, fixed and normal amplitudes; 4224 borders of surfaces and 8160 of
lines. Beside each limit stands what these good ones reach.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from roughbench.scans.doubts import Case, Doubt
from roughbench.scans.evidence import height_step, waves_of
from roughbench.scans.words import per_cent

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


def check_slope(case: Case) -> Iterator[Doubt]:
    """Doubt raw counts, slopes of another unit, and slopes too large for the models."""
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


def _counts(case: Case) -> str:
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


def check_quantization(case: Case) -> Iterator[Doubt]:
    """Doubt heights in coarse steps, beside the gap and beside what neighbours differ by."""
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


def check_waves(case: Case) -> Iterator[Doubt]:
    """Doubt roughness finer than the grid, and a cell with too few bumps."""
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
