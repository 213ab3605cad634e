"""What pydantic cannot see: whether the parts of a spec fit each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from roughbench.errors import SurfaceError, explained
from roughbench.models.base import Model
from roughbench.spec.fields import SavedFields
from roughbench.spec.measured import MeasuredSurface
from roughbench.spec.pressures import is_among, nearest
from roughbench.spec.surfaces import AnySurface, SelfAffineSurface
from roughbench.spec.tree import Finding, KeyPath, lookup
from roughbench.text import on_one_line
from roughbench.units import in_words

_MOST_WAVES = 1e9
"""Waves per side past which no grid is worth naming."""

Numbered = Sequence[tuple[int, Model]]


def check_fit(
    tree: Any,
    surface: AnySurface | None,
    models: Numbered,
    pressures: tuple[float, ...],
    saved: SavedFields | None,
    *,
    has_units: bool = False,
) -> Iterator[Finding]:
    """Yield every misfit between the valid parts of a spec.

    Parameters
    ----------
    tree : dict
        The spec's tree, for what was written and what is a default.
    surface : SelfAffineSurface, MeasuredSurface or None
        None if it is not valid by itself.
    models : sequence of (int, Model)
        The valid ones, with their places in the list.
    pressures : tuple of float
        Empty if they are not valid by themselves.
    saved : SavedFields or None
        None if nothing is to be kept, or it is not valid by itself.
    has_units : bool
        Whether the pressures are in Pa.
    """
    yield from _names(tree, models)
    yield from _deterministic(models)
    yield from _without_effect(models)
    yield from _bearable(models, pressures, has_units=has_units)
    if saved is not None:
        if pressures:
            yield from _saved_pressures(saved, pressures, has_units=has_units)
        if not isinstance(surface, MeasuredSurface):
            yield from _saved_realizations(tree, saved, models)
    if isinstance(surface, SelfAffineSurface):
        yield from _grids(surface, models)
    elif isinstance(surface, MeasuredSurface):
        yield from _given_heights(tree, models)


def check_file(surface: AnySurface | None) -> Iterator[Finding]:
    """Yield a finding if the file of heights is not there, which no spec can know."""
    if isinstance(surface, MeasuredSurface):
        name = on_one_line(str(surface.file))
        try:
            if not surface.file.is_file():
                yield Finding(("surface", "path"), f"no such file: {name}")
        except OSError as error:
            yield Finding(("surface", "path"), f"cannot read {name}: {explained(error)}")


def _names(tree: Any, models: Numbered) -> Iterator[Finding]:
    first: dict[str, int] = {}
    for number, model in models:
        if model.name in first:
            key = "kind" if lookup(tree, ("models", number, "label")) is None else "label"
            yield Finding(
                ("models", number, key),
                f"models[{first[model.name]}] is named {model.name!r} too; "
                "give each its own label",
            )
        first.setdefault(model.name, number)


def _deterministic(models: Numbered) -> Iterator[Finding]:
    for number, model in models:
        if model.dimension == 0 and (model.realizations or 1) > 1:
            yield Finding(
                ("models", number, "realizations"),
                f"{model.kind} works on the spectrum and has one realization; remove this",
            )


def _bearable(
    models: Numbered, pressures: tuple[float, ...], *, has_units: bool
) -> Iterator[Finding]:
    for number, model in models:
        bound, highest = model.highest_pressure, max(pressures, default=0.0)
        if bound is not None and highest > bound:
            shown = in_words(highest, "Pa", 6) if has_units else f"{highest:g}"
            yield Finding(
                ("models", number, "hardness"),
                f"bears no nominal pressure above it, and the highest is {shown}; lower that",
            )


def _without_effect(models: Numbered) -> Iterator[Finding]:
    for number, model in models:
        for option, message in model.unused_options().items():
            if option in model.model_fields_set:
                yield Finding(("models", number, option), message)


def _saved_pressures(
    saved: SavedFields, pressures: tuple[float, ...], *, has_units: bool
) -> Iterator[Finding]:
    def says(pressure: float) -> str:
        return in_words(pressure, "Pa", 9) if has_units else f"{pressure:.9g}"

    for number, pressure in enumerate(saved.pressures):
        if not is_among(pressure, pressures):
            yield Finding(
                ("save_fields", "pressures", number),
                f"{says(pressure)} is none of the spec's pressures; add it to them, or write "
                f"the nearest, {says(nearest(pressure, pressures))}",
            )


def _saved_realizations(tree: Any, saved: SavedFields, models: Numbered) -> Iterator[Finding]:
    common = lookup(tree, ("realizations",))
    for number, realization in enumerate(saved.realizations):
        for _, model in models:
            count = model.realizations or (common if isinstance(common, int) else 1)
            if model.has_fields and realization >= count:
                there = (
                    "the realization 0" if count == 1 else f"the realizations 0 to {count - 1}"
                )
                yield Finding(
                    ("save_fields", "realizations", number),
                    f"{model.name} has only {there}; remove {realization}, or raise "
                    "realizations",
                )


def _grids(surface: SelfAffineSurface, models: Numbered) -> Iterator[Finding]:
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            spectrum = surface.spectrum()
            sizes = (spectrum.rms_height, spectrum.rms_slope)
    except (ArithmeticError, SurfaceError):
        sizes = (math.nan, math.nan)
    if not all(0.0 < size < math.inf for size in sizes):
        yield Finding(
            ("surface",),
            "the spectrum leaves the range of float64; choose another length unit",
            "key",
        )
        return
    for number, model in models:
        if model.dimension == 0:
            continue
        if spectrum.q_max * surface.length > 2.0 * math.pi * _MOST_WAVES:
            message = f"over {_MOST_WAVES:g} waves per side are too many for any grid"
            yield Finding(("models", number), f"{message}; lower q1 or length")
            continue
        try:
            model.grid_points(spectrum, surface.length)
        except SurfaceError as error:
            yield Finding(_grid_option(number, model), str(error))


def _grid_option(number: int, model: Model) -> KeyPath:
    written = [option for option in model.sampling if option in model.model_fields_set]
    return ("models", number, *written[:1])


def _given_heights(tree: Any, models: Numbered) -> Iterator[Finding]:
    """Yield what has no meaning for measured heights, whatever their file holds."""
    kept = lookup(tree, ("save_fields", "realizations"))
    on_lines = any(model.dimension == 1 for _, model in models)
    if (lookup(tree, ("realizations",)) or 1) != 1 and not on_lines:
        message = "measured heights are one realization; remove this (twins: draws more)"
        yield Finding(("realizations",), message)
    if isinstance(kept, list) and any(number != 0 for number in kept):
        message = "measured heights are one realization, 0; remove this"
        yield Finding(("save_fields", "realizations"), message)
    for number, model in models:
        where = ("models", number)
        for option, message in model.refused_with_given_heights().items():
            yield Finding((*where, option), message)
        if model.dimension != 2:
            continue
        if (model.realizations or 1) != 1:
            message = "measured heights are one realization; remove this (twins: draws more)"
            yield Finding((*where, "realizations"), message)
        for option in model.sampling:
            if option in model.model_fields_set:
                message = "has no meaning for measured heights, which bring their grid"
                yield Finding((*where, option), f"{message}; remove this")


def check_twins(surface: AnySurface | None, twins: int | None) -> Iterator[Finding]:
    """Yield a finding if there is nothing measured to make twins of."""
    if twins is not None and isinstance(surface, SelfAffineSurface):
        yield Finding(
            ("twins",),
            "a surface given by a spectrum has random phases already; raise realizations",
            "key",
        )
