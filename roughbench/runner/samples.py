"""One realization of the roughness for one model, from the spec's surface."""

from __future__ import annotations

import functools
import hashlib

import numpy as np

from roughbench.errors import SurfaceError
from roughbench.heights_file import load_heights
from roughbench.models.base import FloatArray, Model, Sample
from roughbench.models.foundation import Foundation
from roughbench.results import Attribute
from roughbench.spec import FileSurface, SelfAffineSurface
from roughbench.spectrum import measured_spectrum
from roughbench.surface import (
    make_profile,
    make_surface,
    realization_generator,
    rms_height_and_slope,
)

Surface = SelfAffineSurface | FileSurface


def make_sample(
    surface: Surface, model: Model, seed: int, realization: int, digest: str = ""
) -> Sample:
    """Return what ``model`` needs of one realization: a line, a surface, or the spectrum.

    Parameters
    ----------
    surface : SelfAffineSurface or FileSurface
        Heights from a file are the same in every realization; their mean is removed.
    model : Model
        Its ``dimension`` and its grid choose the sample.
    seed, realization : int
        Choose the random stream; the same one for every model.
    digest : str
        What :func:`heights_digest` must say of the heights of a file; "" accepts any.

    Returns
    -------
    Sample

    Raises
    ------
    SurfaceError
        If the grid is too coarse for the spectrum, or the heights of the file have
        another dimension than the model needs or are not those of ``digest``.
    """
    if isinstance(surface, FileSurface):
        if digest and digest != heights_digest(surface):
            raise SurfaceError(
                f"{surface.path}: changed since the run began; run it again for the new heights"
            )
        return _from_file(surface, model)
    spectrum, length = surface.spectrum(), surface.length
    if model.dimension == 0:
        return Sample(None, length, spectrum)
    n_points = model.grid_points(spectrum, length)
    generator = realization_generator(seed, realization)
    if model.dimension == 2:
        heights = make_surface(spectrum, n_points, length, generator, surface.amplitude)
    else:
        heights = make_profile(
            spectrum,
            n_points,
            length,
            generator,
            surface.amplitude,
            model.undersampled if isinstance(model, Foundation) else "error",
        )
    return Sample(heights, length, spectrum)


def check_sample(surface: Surface, model: Model) -> None:
    """Refuse a surface that the model cannot use, before anything is computed.

    Raises
    ------
    SurfaceError
        As :func:`make_sample`, at the cost of reading heights from a file.
    """
    if isinstance(surface, FileSurface):
        _from_file(surface, model)
    elif model.dimension > 0:
        model.grid_points(surface.spectrum(), surface.length)


def heights_digest(surface: FileSurface) -> str:
    """Return a digest of the heights in a file: of their values, not of their file."""
    heights = load_heights(surface.path, surface.folder)
    content = hashlib.sha256(repr(heights.shape).encode())
    content.update(np.ascontiguousarray(heights).data)
    return content.hexdigest()[:20]


def n_heights(surface: FileSurface) -> int:
    """Return the number of heights in a file."""
    stat = surface.file.stat() if surface.file.exists() else None
    return _n_heights(
        surface.path, str(surface.folder), stat and (stat.st_mtime_ns, stat.st_size)
    )


@functools.lru_cache(maxsize=64)
def _n_heights(path: str, folder: str, stat: object) -> int:
    del stat  # a changed file is read again
    return int(load_heights(path, folder).size)


def rms_of(sample: Sample) -> tuple[float, float]:
    """Return rms height and rms slope of the realized heights, else of the spectrum."""
    if sample.heights is not None:
        return rms_height_and_slope(sample.heights, sample.length)
    if sample.spectrum is None:
        raise SurfaceError("a sample needs heights or a spectrum")
    return sample.spectrum.rms_height, sample.spectrum.rms_slope


def describe(surface: Surface, model: Model) -> dict[str, Attribute]:
    """Return the attributes of a group of results: the surface's and the model's parameters.

    ``rms_height`` and ``rms_slope`` are those of the spectrum (continuum), for heights
    from a file those of the heights. ``grid_points`` is the resolved number of points
    per side.
    """
    options = model.model_dump(exclude={"kind", "label", "realizations"}, exclude_none=True)
    attributes: dict[str, Attribute] = {"surface": surface.kind, "length": surface.length}
    if isinstance(surface, FileSurface):
        heights = _heights(surface)
        attributes["heights"] = surface.path
        attributes["rms_height"], attributes["rms_slope"] = rms_height_and_slope(
            heights, surface.length
        )
        n_points = heights.shape[0]
        options.pop("undersampled", None)
    else:
        spectrum = surface.spectrum()
        parameters = surface.model_dump(exclude={"kind", "length", "rms_height", "rms_slope"})
        attributes |= parameters
        attributes["rms_height"] = spectrum.rms_height
        attributes["rms_slope"] = spectrum.rms_slope
        n_points = model.grid_points(spectrum, surface.length) if model.dimension else 0
    if model.dimension:
        attributes["grid_points"] = n_points
        options |= {
            name: n_points
            for name in ("grid", "points", "springs")
            if name in type(model).model_fields
        }
    return attributes | {name: _plain(value) for name, value in options.items()}


def _plain(value: object) -> Attribute:
    """Return an option as an attribute that HDF5 and netCDF both know."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str | int | float) else str(value)


def _heights(surface: FileSurface) -> FloatArray:
    heights = load_heights(surface.path, surface.folder)
    return heights - heights.mean()


def _from_file(surface: FileSurface, model: Model) -> Sample:
    heights = _heights(surface)
    if model.dimension == 0:
        return Sample(None, surface.length, measured_spectrum(heights, surface.length))
    if heights.ndim != model.dimension:
        remedy = (
            "give a two-dimensional array"
            if model.dimension == 2
            else "give one line of it, as heights[0]"
        )
        raise SurfaceError(
            f"{surface.path}: its shape is {heights.shape}, but {model.name} needs "
            f"{model.dimension} dimension{'s' * (model.dimension > 1)}; {remedy}, "
            f"or remove {model.name} from the models"
        )
    return Sample(heights, surface.length)
