"""What results remember of a measured scan: a map, its spectrum, the steps that it took."""

from __future__ import annotations

from collections.abc import Iterable

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
    before its borders were made to meet. The plan has prepared and checked the scan.
    """
    # SciPy is slow to import
    from roughbench.scans.characterization import directions
    from roughbench.scans.levelling import level
    from roughbench.scans.roughness import roughness
    from roughbench.scans.self_affine_fit import fit_self_affine

    prepared = prepared_scan(surface, known)
    heights = prepared.heights
    rows, columns = heights.shape
    size = prepared.length, prepared.length * columns / rows
    stride = -(-max(rows, columns) // MOST_POINTS)
    spectrum = level(prepared.raw, surface.preparation()).surface_spectrum()
    found = fit_self_affine(spectrum, "m")
    spectrum = spectrum.binned()
    density, ends = np.histogram(heights, bins=_BINS, density=True)
    numbers = roughness(heights, size)
    spoken = dict.fromkeys((*prepared.raw.notes, *directions(numbers), *found.remarks))
    return SurfaceRecord(
        heights=np.ascontiguousarray(heights[::stride, ::stride]),
        size=size,
        spectrum=(spectrum.q, spectrum.power),
        fit=None if found.fit is None else found.fit.to_dict(),
        height_density=((ends[1:] + ends[:-1]) / 2.0, density),
        steps=tuple(
            RecordedStep(step.name, step.text, step.points, step.Sq, step.Sdq)
            for step in prepared.steps
        ),
        parameters={name: float(getattr(numbers, name)) for name in _NUMBERS},
        warnings=(*(doubt.text for doubt in known.doubts), *spoken),
        source=surface.path,
    )
