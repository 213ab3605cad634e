"""A scan in the field's terms: roughness, spectra, a self-affine law, and what to doubt.

>>> from roughbench.spectrum import self_affine
>>> from roughbench.surface import make_surface, realization_generator
>>> law = self_affine(hurst=0.7, q_min=1e6, q_rolloff=4e6, q_max=64e6, rms_slope=0.1)
>>> side = 2e-6 * np.pi
>>> heights = make_surface(law, 256, side, realization_generator(1, 0))
>>> found = characterize(heights, size=side, edges="periodic")
>>> f"Sq = {1e9 * found.prepared.Sq:.1f} nm, H = {found.fit.hurst:.2f}"
'Sq = 9.9 nm, H = 0.70'
>>> found.to_dict()["points"], round(found.to_dict()["fit"]["slope"], 2)
([256, 256], 0.1)
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughbench.errors import SurfaceError, UnitError
from roughbench.inputs import float_array, positive_number
from roughbench.scans.checks import doubts_of
from roughbench.scans.detrending import Detrend
from roughbench.scans.edges import Edges
from roughbench.scans.levelling import level
from roughbench.scans.measured_spectrum import MeasuredSpectrum
from roughbench.scans.preparation import Preparation, Step, prepare
from roughbench.scans.profile_fit import ProfileFit, fit_profiles
from roughbench.scans.roughness import Roughness, roughness
from roughbench.scans.self_affine_fit import SelfAffineFit, fit_self_affine
from roughbench.scans.topography import Scan, read_scan
from roughbench.scans.words import per_cent
from roughbench.units import to_si

FloatArray = NDArray[np.float64]

LARGEST_FILL = 0.5
"""Share of missing points that is filled for the spectrum where nothing is said."""
ANISOTROPIC = 1.2
"""Ratio of rms slopes that is worth a warning."""

Size = str | float | Sequence[str] | Sequence[float]


@dataclass(frozen=True, slots=True)
class Characterization:
    """What a scan is like.

    Attributes
    ----------
    scan : Scan
        As it was read.
    preparation : Preparation
        What was done to it, explicitly.
    steps : tuple of Step
        With the numbers after each.
    levelled : ndarray of float64, shape (rows, columns)
        The scan's heights without trend, in m; nan where missing.
    raw, prepared : Roughness
        Before and after; m.
    surface, along_y, along_x : MeasuredSpectrum
        Of the surface and of its profiles, after the trend was subtracted and holes were
        filled, before anything else: C2D in m⁴, profiles' in m³.
    fit : SelfAffineFit or None
        Of the surface's spectrum.
    profiles : tuple of (ProfileFit or None)
        Of profiles along (y, x).
    remarks : tuple of str
        On the fit: why there is none, or what was left out.
    warnings : tuple of str
        All that should be known before one of these numbers is used; the remarks too.
    """

    scan: Scan
    preparation: Preparation
    steps: tuple[Step, ...]
    levelled: FloatArray
    raw: Roughness
    prepared: Roughness
    surface: MeasuredSpectrum
    along_y: MeasuredSpectrum
    along_x: MeasuredSpectrum
    fit: SelfAffineFit | None
    profiles: tuple[ProfileFit | None, ProfileFit | None]
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers, SI, as ``roughbench characterize --json`` prints them."""
        moments = {
            "differences": (self.prepared.m0, self.prepared.m2, self.prepared.m4),
            "surface": self.surface.profile_moments,
            "along_y": self.along_y.profile_moments,
            "along_x": self.along_x.profile_moments,
        }
        bands = {
            "differences": self.prepared.band,
            "surface": self.surface.band,
            "along_y": self.along_y.band,
            "along_x": self.along_x.band,
        }
        return {
            **_numbers(self.prepared),
            "raw": _numbers(self.raw),
            "fit": None if self.fit is None else self.fit.to_dict(),
            "profiles": {
                axis: None
                if one is None
                else {"H": one.hurst, "H_error": one.hurst_error, "level": one.level}
                for axis, one in zip(("along_y", "along_x"), self.profiles, strict=True)
            },
            "moments": {
                name: {
                    "m0": m0,
                    "m2": m2,
                    "m4": m4,
                    "nayak": m0 * m4 / m2**2 if m2 else None,
                    "band": list(bands[name]),
                }
                for name, (m0, m2, m4) in moments.items()
            },
            "anisotropy": _finite(self.prepared.anisotropy),
            "direction": self.prepared.direction,
            "steps": [step.text for step in self.steps],
            "warnings": list(self.warnings),
        }


def _numbers(found: Roughness) -> dict[str, Any]:
    names = ("Sa", "Sq", "Ssk", "Sku", "Sdq", "Sdr")
    return {
        "points": list(found.points),
        "size": list(found.size),
        "missing": found.missing,
        **{name: getattr(found, name) for name in names},
        "Sz": found.peak_to_valley,
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def characterize(
    source: str | Path | Scan | ArrayLike,
    *,
    size: Size | None = None,
    unit: str | float | None = None,
    channel: str | None = None,
    detrend: Detrend | None = None,
    fill: float | None = None,
    edges: Edges | None = None,
    outliers: float | None = None,
    resample: int | None = None,
    folder: str | Path = ".",
    gap: float | None = None,
    accept: Collection[str] = (),
) -> Characterization:
    """Describe a measured surface.

    Parameters
    ----------
    source : path, Scan, or array_like of shape (rows, columns)
        A file that :func:`~roughbench.scans.topography.read_scan` reads, or heights with nan
        where they are missing.
    size : text, two texts, number or two numbers, optional
        Of the scan, where the source does not say it: texts as in a spec, "10 um" or
        "10 um, 5 um" along x (columns) and y (rows); numbers in m, one for a square or
        (y, x).
    unit : text or number, optional
        Of the heights: "nm", or m per unit. Arrays are in m if nothing is said.
    channel : str, optional
        Of a file with several.
    detrend : {"none", "mean", "plane", "quadratic"}, optional
        What is subtracted; by default a plane, since no instrument levels a sample well.
    fill : float, optional
        Largest share of missing points that is filled; by default one half, with a warning.
    edges : {"periodic", "mirror", "taper", "crop"}, optional
        How the scan would become periodic for contact. The spectra are of the scan before
        that; with Hann's window unless its borders meet, or it is said to be periodic.
    outliers : float, optional
        Points further from the median of their neighbours than so many robust deviations
        count as missing.
    resample : int, optional
        Points along the longer side.
    folder : path
        Where a relative path starts.
    gap : float, optional
        Mean gap at the lowest pressure of interest, m: what is said of steps in the heights.
    accept : collection of str
        Checks that are settled: they say nothing.

    Raises
    ------
    SurfaceError
        If the source cannot be read or prepared.
    UnitError
        If a size or unit cannot be read.
    """
    scan = _scan(source, folder, channel, _size_in_metres(size), _unit_in_metres(unit))
    said = Preparation(
        detrend=detrend or "plane",
        fill=LARGEST_FILL if fill is None else fill,
        edges=edges,
        outliers=outliers,
        resample=resample,
    )
    raw = roughness(scan.heights, scan.size)
    ready = prepare(scan, said)
    rows, columns = ready.heights.shape
    prepared = roughness(ready.heights, (ready.length, ready.length * columns / rows))
    steps = ready.steps
    part, length = ready.heights, ready.length
    del ready  # mirrored, it takes four times the scan's memory
    if said.edges == "mirror":
        part, length = part[: rows // 2, : columns // 2].copy(), length / 2.0
    doubts = [
        doubt.text
        for doubt in doubts_of(
            part,
            length,
            raw=scan,
            preparation=said,
            reflected=False,
            gap=gap,
            accept=accept,
        )
    ]
    del part
    levelled = level(scan, said)
    surface = levelled.surface_spectrum()
    along_y, along_x = (levelled.profile_spectrum(axis) for axis in (0, 1))
    outcome = fit_self_affine(surface, "m")
    profiles = tuple(
        None if outcome.fit is None else fit_profiles(one, outcome.fit)
        for one in (along_y, along_x)
    )
    spoken = [*scan.notes, *_gaps(raw, fill), *doubts, *directions(prepared), *outcome.remarks]
    return Characterization(
        scan=scan,
        preparation=said if fill is not None else replace(said, fill=_enough(raw.missing)),
        steps=steps,
        levelled=levelled.with_holes(),
        raw=raw,
        prepared=prepared,
        surface=surface,
        along_y=along_y,
        along_x=along_x,
        fit=outcome.fit,
        profiles=(profiles[0], profiles[1]),
        remarks=outcome.remarks,
        warnings=tuple(dict.fromkeys(spoken)),
    )


def _scan(
    source: str | Path | Scan | ArrayLike,
    folder: str | Path,
    channel: str | None,
    size: tuple[float, float] | None,
    unit: float | None,
) -> Scan:
    if isinstance(source, str | Path):
        return read_scan(source, folder, channel=channel, size=size, unit=unit)
    if isinstance(source, Scan):
        return source
    heights = float_array(source, "heights", SurfaceError)
    if heights.ndim != 2 or not heights.size:
        raise SurfaceError(f"heights must have rows and columns, got shape {heights.shape}")
    if size is None:
        raise SurfaceError("heights of an array need their size, as in size='10 um'")
    return Scan(heights * (1.0 if unit is None else unit), size, "array")


def _size_in_metres(size: Size | None) -> tuple[float, float] | None:
    """Return (y, x) in m."""
    if size is None:
        return None
    if isinstance(size, str):
        size = [part.strip() for part in size.split(",")]
    if isinstance(size, Sequence) and size and all(isinstance(one, str) for one in size):
        if len(size) > 2:
            raise UnitError(
                "must be one length or two, along x and y, as in 10 um, 5 um", "size"
            )
        sides = [to_si(str(one), "length", "size") for one in size]
        return _positive((sides[-1], sides[0]))
    numbers = np.atleast_1d(float_array(size, "size", SurfaceError))
    if numbers.size not in (1, 2):
        raise SurfaceError(f"size must be one length or two (y, x), got {numbers.size}")
    return _positive((float(numbers[0]), float(numbers[-1])))


def _positive(size: tuple[float, float]) -> tuple[float, float]:
    y, x = (positive_number(side, "size", SurfaceError) for side in size)
    return y, x


def _unit_in_metres(unit: str | float | None) -> float | None:
    if unit is None:
        return None
    value = to_si(f"1 {unit}", "length", "unit") if isinstance(unit, str) else unit
    return positive_number(value, "unit", SurfaceError)


def _enough(missing: float) -> float:
    """Return a share in whole percents that allows the missing points to be filled."""
    return float(np.ceil(100.0 * missing - 1e-9)) / 100.0


def _gaps(raw: Roughness, fill: float | None) -> Iterator[str]:
    if raw.missing and fill is None:
        yield (
            f"{per_cent(raw.missing)} of the points are missing, and were filled here from "
            f"the rims of the holes; a spec must say fill: {100.0 * _enough(raw.missing):.0f} %"
        )


def directions(found: Roughness) -> Iterator[str]:
    """Say that a surface is anisotropic, if it is."""
    if found.anisotropy > ANISOTROPIC:
        yield (
            f"the surface is anisotropic: its rms slope is {found.anisotropy:.2g} times as "
            f"large along {found.direction:.0f}° from the x axis (towards y) as across, and "
            "the law and the theories take it for isotropic"
        )
