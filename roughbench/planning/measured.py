"""Measured heights: read and prepared once for a plan, and again by whoever computes."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from roughbench.errors import SurfaceError
from roughbench.heights_file import load_heights
from roughbench.models.base import FloatArray
from roughbench.spec import FileSurface, MeasuredSurface, ScanSurface
from roughbench.spectrum import Spectrum, measured_spectrum
from roughbench.surface import rms_height_and_slope

if TYPE_CHECKING:  # SciPy is slow to import
    from roughbench.scans.checks import Doubt
    from roughbench.scans.preparation import Prepared


@dataclass(frozen=True, slots=True)
class Heights:
    """What a plan knows of measured heights, all of it from one read.

    Attributes
    ----------
    digest : str
        Of their values, not of their file; what a task computes with must have the same.
    shape : tuple of int
    rms_height, rms_slope : float
    length : float
        Period along the first axis, length.
    spectrum : Spectrum or None
        The radially averaged one; None where there is none.
    fault : str
        Why there is none; else empty.
    doubts : tuple of Doubt
        What makes an answer on them wrong or doubtful.
    """

    digest: str
    shape: tuple[int, ...]
    rms_height: float
    rms_slope: float
    length: float
    spectrum: Spectrum | None = None
    fault: str = ""
    doubts: tuple[Doubt, ...] = ()

    @property
    def longest_side(self) -> float:
        """Of the cell, length: the period of lines with its spectrum."""
        return self.length * max(self.shape) / self.shape[0]

    def needed_spectrum(self) -> Spectrum:
        """Return the spectrum, or raise a SurfaceError that says why there is none."""
        if self.spectrum is None:
            raise SurfaceError(self.fault)
        return self.spectrum


_latest: dict[MeasuredSurface, tuple[str, Prepared]] = {}
"""The scan that was prepared last, for tasks of the same process: it takes seconds."""


def read_heights(surface: MeasuredSurface, *, pressure: float | None = None) -> Heights:
    """Read measured heights, prepare them, and return what a plan has to know of them.

    Parameters
    ----------
    surface : MeasuredSurface
    pressure : float, optional
        Lowest p/E* that is asked for: steps of an instrument are compared with the mean gap
        that Persson's theory gives there.

    Raises
    ------
    SurfaceError
        If they cannot be read or prepared.
    """
    from roughbench.scans.checks import doubts_of

    heights, length, digest, prepared = _read(surface.original())
    found, fault = None, ""
    try:
        found = measured_spectrum(heights, length)
    except SurfaceError as error:
        fault = f"{surface.path}: {error}"
    rms_height, rms_slope = rms_height_and_slope(heights, length)
    return Heights(
        digest=digest,
        shape=heights.shape,
        rms_height=rms_height,
        rms_slope=rms_slope,
        length=length,
        spectrum=found,
        fault=fault,
        doubts=tuple(
            doubts_of(
                heights,
                length,
                raw=None if prepared is None else prepared.raw,
                preparation=(
                    surface.preparation() if isinstance(surface, ScanSurface) else None
                ),
                gap=None if found is None or pressure is None else _gap(found, pressure),
                accept=surface.accept or (),
            )
        ),
    )


def _gap(spectrum: Spectrum, pressure: float) -> float:
    """Return the mean gap by Persson's theory, length."""
    from roughbench.models.persson import persson_curve

    return float(persson_curve(spectrum, np.array([pressure])).separation[0])


def prepared_scan(surface: ScanSurface, known: Heights) -> Prepared:
    """Return the scan of a plan, with all that was done to it.

    Raises
    ------
    SurfaceError
        If the file holds other heights by now.
    """
    heights_of(surface, known)
    return _latest[surface.original()][1]


def heights_of(surface: MeasuredSurface, known: Heights) -> FloatArray:
    """Return the heights of a plan, without their mean.

    Raises
    ------
    SurfaceError
        If the file holds other heights by now.
    """
    original = surface.original()
    digest, prepared = _latest.get(original, ("", None))
    if prepared is not None and digest == known.digest:
        return prepared.heights
    heights, _, found, _ = _read(original)
    if found != known.digest:
        raise SurfaceError(
            f"{surface.path}: changed since the run began; run it again for the new heights"
        )
    return heights


def _read(surface: MeasuredSurface) -> tuple[FloatArray, float, str, Prepared | None]:
    """Return heights without their mean, their period, the digest of what was read.

    And of a scan how it was prepared.

    Whoever computes with them compares this digest: a second read may find another file.
    """
    if isinstance(surface, FileSurface):
        heights = load_heights(surface.path, surface.folder)
        if surface.unit is not None:
            heights *= surface.unit
        digest = _digest(heights)
        heights -= heights.mean()
        return heights, surface.length, digest, None
    if not isinstance(surface, ScanSurface):
        raise TypeError(f"a surface of kind {surface.kind}")
    from roughbench.scans.preparation import prepare
    from roughbench.scans.topography import read_scan

    scan = read_scan(
        surface.path,
        surface.folder,
        channel=surface.channel,
        size=surface.size_si,
        unit=surface.unit,
    )
    prepared = prepare(scan, surface.preparation())
    digest = _digest(prepared.heights)
    _latest.clear()
    _latest[surface] = digest, prepared
    return prepared.heights, prepared.length, digest, prepared


def _digest(heights: FloatArray) -> str:
    content = hashlib.sha256(repr(heights.shape).encode())
    content.update(heights.data)
    return content.hexdigest()[:20]
