"""One realization of the roughness for one model, from the spec's surface."""

from __future__ import annotations

import json

from roughbench.errors import SurfaceError
from roughbench.models.base import Model, Sample, cell_area
from roughbench.models.registry import source_of
from roughbench.models.style import Style
from roughbench.planning.measured import Heights, heights_of, read_heights
from roughbench.results import Attribute
from roughbench.spec import MeasuredSurface, SelfAffineSurface
from roughbench.surface import (
    make_profile,
    make_surface,
    make_twin,
    realization_generator,
    rms_height_and_slope,
)

Surface = SelfAffineSurface | MeasuredSurface


def make_sample(
    surface: Surface,
    model: Model,
    seed: int,
    realization: int,
    known: Heights | None = None,
) -> Sample:
    """Return what ``model`` needs of one realization: a line, a surface, or the spectrum.

    Parameters
    ----------
    surface : SelfAffineSurface or MeasuredSurface
        Measured heights are the same in every realization, with their mean removed; their
        twins have the same amplitude of every wave, and random phases. Models of lines get
        measured lines as they are, of measured surfaces lines with their spectrum.
    model : Model
        Its ``dimension`` and its grid choose the sample.
    seed, realization : int
        Choose the random stream; the same one for every model.
    known : Heights, optional
        What the plan found in the file; other heights are refused. By default it is read.

    Raises
    ------
    SurfaceError
        If the grid is too coarse for the spectrum, or the heights of the file have
        another dimension than the model needs or are not those of the plan.
    """
    if isinstance(surface, MeasuredSurface):
        return _sample_of_heights(surface, model, seed, realization, known)
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


def _sample_of_heights(
    surface: MeasuredSurface, model: Model, seed: int, realization: int, known: Heights | None
) -> Sample:
    known = known or read_heights(surface)
    _check_dimension(surface, model, known)
    if model.dimension == 0:
        is_square = len(set(known.shape)) == 1
        area = None if is_square else cell_area(known.shape, known.length)
        return Sample(None, known.length, known.spectrum, area)
    generator = realization_generator(seed, realization)
    if draws_lines(model, known):
        spectrum, period = known.needed_spectrum(), known.longest_side
        n_points = model.grid_points(spectrum, period)
        line = make_profile(
            spectrum, n_points, period, generator, undersampled=model.undersampling
        )
        return Sample(line, period, spectrum)
    heights = heights_of(surface, known)
    if surface.is_twins:
        heights = make_twin(heights, generator)
    return Sample(heights, known.length)


def draws_lines(model: Model, known: Heights) -> bool:
    """Whether a model of lines gets lines with the spectrum of a measured surface."""
    return model.dimension == 1 and len(known.shape) == 2


def is_drawn(surface: MeasuredSurface, model: Model, known: Heights) -> bool:
    """Whether a model's heights are drawn at random, with the spectrum of measured ones."""
    return draws_lines(model, known) or (surface.is_twins and model.dimension > 0)


def check_sample(surface: Surface, model: Model, known: Heights | None = None) -> None:
    """Refuse a surface that the model cannot use, before anything is computed.

    Parameters
    ----------
    surface, model
    known : Heights, optional
        Of a file.

    Raises
    ------
    SurfaceError
        As :func:`make_sample`.
    """
    if isinstance(surface, MeasuredSurface):
        known = known or read_heights(surface)
        _check_dimension(surface, model, known)
        if model.dimension == 0:
            known.needed_spectrum()
        elif draws_lines(model, known):
            model.grid_points(known.needed_spectrum(), known.longest_side)
        else:
            _check_options(model)
    elif model.dimension > 0:
        model.grid_points(surface.spectrum(), surface.length)


def _check_options(model: Model) -> None:
    """Refuse what has no meaning for heights that are there already."""
    for option in model.sampling:
        if option in model.model_fields_set:
            raise SurfaceError(
                f"{option} of {model.name} has no meaning for measured heights, which bring "
                "their grid; remove it"
            )


def rms_of(sample: Sample) -> tuple[float, float]:
    """Return rms height and rms slope of the realized heights, else of the spectrum."""
    if sample.heights is not None:
        return rms_height_and_slope(sample.heights, sample.length)
    if sample.spectrum is None:
        raise SurfaceError("a sample needs heights or a spectrum")
    return sample.spectrum.rms_height, sample.spectrum.rms_slope


def describe(
    surface: Surface, model: Model, known: Heights | None = None
) -> dict[str, Attribute]:
    """Return the attributes of a group of results: the surface's and the model's parameters.

    ``rms_height`` and ``rms_slope`` are those of the spectrum (continuum), for measured
    heights those of the heights. ``grid_points`` is the resolved number of points
    per side; of heights that are no square it is that along the first axis, and
    ``grid_columns`` that along the second. ``drawn`` says what is drawn at random with the
    spectrum of measured heights, and ``warnings`` what makes answers on them doubtful, as JSON.
    """
    options = model.model_dump(exclude={"kind", "label", "realizations"}, exclude_none=True)
    attributes: dict[str, Attribute] = {"surface": surface.kind}
    if isinstance(surface, MeasuredSurface):
        known = known or read_heights(surface)
        attributes["length"] = known.length
        attributes["heights"] = surface.path
        attributes["rms_height"] = known.rms_height
        attributes["rms_slope"] = known.rms_slope
        if known.doubts:
            attributes["warnings"] = json.dumps(
                [doubt.text for doubt in known.doubts], ensure_ascii=False
            )
        n_points = known.shape[0]
        if is_drawn(surface, model, known):
            attributes["drawn"] = "twins" if model.dimension == 2 else "lines"
        if draws_lines(model, known):
            attributes["length"] = known.longest_side
            n_points = model.grid_points(known.needed_spectrum(), known.longest_side)
        else:
            for name in model.sampling[1:]:
                options.pop(name, None)
    else:
        spectrum = surface.spectrum()
        parameters = surface.model_dump(exclude={"kind", "length", "rms_height", "rms_slope"})
        attributes["length"] = surface.length
        attributes |= parameters
        attributes["rms_height"] = spectrum.rms_height
        attributes["rms_slope"] = spectrum.rms_slope
        n_points = model.grid_points(spectrum, surface.length) if model.dimension else 0
    if model.dimension:
        attributes["grid_points"] = n_points
        if known is not None and not draws_lines(model, known) and known.shape[-1] != n_points:
            attributes["grid_columns"] = known.shape[-1]
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


def _check_dimension(surface: MeasuredSurface, model: Model, known: Heights) -> None:
    if model.dimension < 2 or len(known.shape) == 2:
        return
    raise SurfaceError(
        f"{surface.path}: its shape is {known.shape}, but {model.name} needs 2 dimensions; "
        f"give a two-dimensional array, or remove {model.name} from the models"
    )
