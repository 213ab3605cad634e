"""One realization of the roughness for one model, from the spec's surface."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from roughbench.errors import SurfaceError
from roughbench.heights_file import load_heights
from roughbench.models.base import FloatArray, Model, Sample
from roughbench.models.registry import source_of
from roughbench.models.style import Style
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


@dataclass(frozen=True, slots=True)
class Heights:
    """What a plan knows of the heights in a file, all of it from one read.

    Attributes
    ----------
    digest : str
        Of their values, not of their file; what a task computes with must have the same.
    shape : tuple of int
    rms_height, rms_slope : float
    fault : str
        Why they have no spectrum, where one was asked for; else empty.
    """

    digest: str
    shape: tuple[int, ...]
    rms_height: float
    rms_slope: float
    fault: str = ""


def read_heights(surface: FileSurface, *, spectrum: bool = True) -> Heights:
    """Read the heights of a file once, and return what a plan has to know of them.

    Parameters
    ----------
    surface : FileSurface
    spectrum : bool
        Whether a model needs their spectrum.

    Raises
    ------
    SurfaceError
        If they cannot be read.
    """
    heights, digest = _load(surface)
    fault = ""
    if spectrum:
        try:
            measured_spectrum(heights, surface.length)
        except SurfaceError as error:
            fault = f"{surface.path}: {error}"
    return Heights(digest, heights.shape, *rms_height_and_slope(heights, surface.length), fault)


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
        What :attr:`Heights.digest` must be of heights from a file; "" accepts any.

    Raises
    ------
    SurfaceError
        If the grid is too coarse for the spectrum, or the heights of the file have
        another dimension than the model needs or are not those of ``digest``.
    """
    if isinstance(surface, FileSurface):
        heights, found = _load(surface)
        if digest not in ("", found):
            raise SurfaceError(
                f"{surface.path}: changed since the run began; run it again for the new heights"
            )
        _check_dimension(surface, model, heights.shape)
        if model.dimension == 0:
            return Sample(None, surface.length, measured_spectrum(heights, surface.length))
        return Sample(heights, surface.length)
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
            model.undersampling,
        )
    return Sample(heights, length, spectrum)


def check_sample(surface: Surface, model: Model, heights: Heights | None = None) -> None:
    """Refuse a surface that the model cannot use, before anything is computed.

    Parameters
    ----------
    surface, model
    heights : Heights, optional
        Of a file.

    Raises
    ------
    SurfaceError
        As :func:`make_sample`.
    """
    if isinstance(surface, FileSurface):
        heights = heights or read_heights(surface)
        _check_dimension(surface, model, heights.shape)
        if model.dimension == 0 and heights.fault:
            raise SurfaceError(heights.fault)
    elif model.dimension > 0:
        model.grid_points(surface.spectrum(), surface.length)


def rms_of(sample: Sample) -> tuple[float, float]:
    """Return rms height and rms slope of the realized heights, else of the spectrum."""
    if sample.heights is not None:
        return rms_height_and_slope(sample.heights, sample.length)
    if sample.spectrum is None:
        raise SurfaceError("a sample needs heights or a spectrum")
    return sample.spectrum.rms_height, sample.spectrum.rms_slope


def describe(
    surface: Surface, model: Model, heights: Heights | None = None
) -> dict[str, Attribute]:
    """Return the attributes of a group of results: the surface's and the model's parameters.

    ``rms_height`` and ``rms_slope`` are those of the spectrum (continuum), for heights
    from a file those of the heights. ``grid_points`` is the resolved number of points
    per side.
    """
    options = model.model_dump(exclude={"kind", "label", "realizations"}, exclude_none=True)
    attributes: dict[str, Attribute] = {"surface": surface.kind, "length": surface.length}
    if isinstance(surface, FileSurface):
        heights = heights or read_heights(surface)
        attributes["heights"] = surface.path
        attributes["rms_height"] = heights.rms_height
        attributes["rms_slope"] = heights.rms_slope
        n_points = heights.shape[0]
        for name in model.sampling[1:]:
            options.pop(name, None)
    else:
        spectrum = surface.spectrum()
        parameters = surface.model_dump(exclude={"kind", "length", "rms_height", "rms_slope"})
        attributes |= parameters
        attributes["rms_height"] = spectrum.rms_height
        attributes["rms_slope"] = spectrum.rms_slope
        n_points = model.grid_points(spectrum, surface.length) if model.dimension else 0
    if model.dimension:
        attributes["grid_points"] = n_points
        options |= dict.fromkeys(model.sampling[:1], n_points)
    if source := source_of(model):
        attributes["source"] = source
        if model.style != Style():
            attributes["style"] = model.style.as_text()
    return attributes | {name: _plain(value) for name, value in options.items()}


def _plain(value: object) -> Attribute:
    """Return an option as an attribute that HDF5 and netCDF both know."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str | int | float) else str(value)


def _load(surface: FileSurface) -> tuple[FloatArray, str]:
    """Read heights; returns them without their mean, and the digest of what was read.

    Whoever computes with them compares this digest: a second read may find another file.
    """
    heights = load_heights(surface.path, surface.folder)
    content = hashlib.sha256(repr(heights.shape).encode())
    content.update(heights.data)
    if surface.unit is not None:
        heights *= surface.unit
    heights -= heights.mean()
    return heights, content.hexdigest()[:20]


def _check_dimension(surface: FileSurface, model: Model, shape: tuple[int, ...]) -> None:
    if model.dimension in (0, len(shape)):
        return
    remedy = (
        "give a two-dimensional array"
        if model.dimension == 2
        else "give one line of it, as heights[0]"
    )
    raise SurfaceError(
        f"{surface.path}: its shape is {shape}, but {model.name} needs "
        f"{model.dimension} dimension{'s' * (model.dimension > 1)}; {remedy}, "
        f"or remove {model.name} from the models"
    )
