"""What makes the answer on given heights wrong or doubtful, each in one line."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from roughbench.scans.border_checks import check_jump, check_steps, check_tilt
from roughbench.scans.doubts import Case
from roughbench.scans.doubts import Doubt as Doubt  # others import it from here
from roughbench.scans.height_checks import check_quantization, check_slope, check_waves
from roughbench.scans.preparation import Preparation
from roughbench.scans.topography import Scan

FloatArray = NDArray[np.float64]

CHECKS: tuple[Callable[[Case], Iterator[Doubt]], ...] = (
    check_tilt,
    check_jump,
    check_steps,
    check_slope,
    check_quantization,
    check_waves,
)


def doubts_of(
    heights: FloatArray,
    length: float,
    *,
    raw: Scan | None = None,
    preparation: Preparation | None = None,
    reflected: bool | None = None,
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
    reflected : bool, optional
        Whether the heights hold the scan's reflections; default: where ``preparation`` says
        mirror.
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
    case = Case.of(heights, length, raw, preparation or Preparation(), gap, reflected=reflected)
    if float(np.ptp(case.part)) == 0.0:
        return []
    found: list[Doubt] = []
    for check in CHECKS:
        found += [doubt for doubt in check(case) if doubt.check not in accept]
    return sorted(found, key=lambda doubt: not doubt.is_wrong)
