"""What results remember of a measured scan: a map, its spectrum, the steps that it took."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict

import numpy as np

from roughbench.planning.cells import Cell
from roughbench.planning.measured import Heights, prepared_scan
from roughbench.spec import ScanSurface
from roughbench.surface_record import MOST_POINTS, RecordedStep, SurfaceRecord

_BINS = 64
_NUMBERS = ("Sa", "Sq", "Ssk", "Sku", "Sdq", "Sdr", "peak_to_valley", "m0", "m2", "m4", "nayak")


def records(cells: Iterable[Cell]) -> dict[str, SurfaceRecord]:
    """Return the record of the scan that each experiment presses; twins are none.

    Raises
    ------
    SurfaceError
        If a file holds other heights than when the run was planned.
    """
    found: dict[str, SurfaceRecord] = {}
    made: dict[ScanSurface, SurfaceRecord] = {}
    for cell in cells:
        surface, known = cell.surface, cell.heights
        if not isinstance(surface, ScanSurface) or surface.is_twins or known is None:
            continue
        if surface not in made:
            made[surface] = record(surface, known)
        found.setdefault(cell.experiment, made[surface])
    return found


def record(surface: ScanSurface, known: Heights) -> SurfaceRecord:
    """Return the record of one scan, as it is pressed.

    The spectrum and its fit are those of :func:`~roughbench.scans.characterize`: of the scan
    before its borders were made to meet.
    """
    from roughbench.scans.characterization import characterize  # SciPy is slow to import

    prepared = prepared_scan(surface, known)
    heights, said = prepared.heights, surface.preparation()
    rows, columns = heights.shape
    stride = -(-max(rows, columns) // MOST_POINTS)
    found = characterize(
        prepared.raw,
        detrend=said.detrend or "mean",
        fill=said.fill,
        edges=said.edges,
        outliers=said.outliers,
        resample=said.resample,
        accept=[*(surface.accept or ()), *(doubt.check for doubt in known.doubts)],
    )
    spectrum = found.surface.binned()
    density, ends = np.histogram(heights, bins=_BINS, density=True)
    numbers = asdict(found.prepared)
    return SurfaceRecord(
        heights=np.ascontiguousarray(heights[::stride, ::stride]),
        size=(prepared.length, prepared.length * columns / rows),
        spectrum=(spectrum.q, spectrum.power),
        fit=None if found.fit is None else found.fit.to_dict(),
        height_density=((ends[1:] + ends[:-1]) / 2.0, density),
        steps=tuple(
            RecordedStep(step.name, step.text, step.points, step.Sq, step.Sdq)
            for step in prepared.steps
        ),
        parameters={name: float(numbers[name]) for name in _NUMBERS},
        warnings=(*(doubt.text for doubt in known.doubts), *found.warnings),
        source=surface.path,
    )
